"""Section of the study of accuracy and its cost."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, StringConstraints, Tag

from jointclosure.parameters import Rock
from studies.frame.config.section import Name, Section, Several, StudySection, entry

SectionKey = Annotated[str, StringConstraints(pattern=r"^[a-z]+[.][A-Za-z_]+$")]


class Point(Section):
    """A knob and its value."""

    knob: str = entry("Its name.")
    value: float | str = entry("Its value.")


class Scene(Section):
    """A variant of the model in an accuracy study: sections that are merged over the study's."""

    study: dict[str, Any] = entry("Merged over study.", {})
    effects: dict[str, Any] = entry("Merged over effects.", {})
    choices: dict[str, Any] = entry("Merged over choices.", {})
    numerics: dict[str, Any] = entry("Merged over numerics.", {})
    grid: dict[str, Any] = entry("Merged over grid.", {})
    surface: dict[str, Any] = entry("Merged over surface.", {})
    rocks: dict[str, Any] = entry("Merged over rocks.", {})
    finest: Point = entry(
        "Knob and value of the reference of all settings of the variant; knob `base` for "
        "none turned."
    )


class NamedValue(Section):
    """A value of a knob that stands for settings."""

    value: str = entry("Its name.")
    set: dict[str, Any] = entry("Settings that it stands for.")


KnobValue = Annotated[
    Annotated[NamedValue, Tag("named")] | Annotated[float | str, Tag("plain")],
    Discriminator(lambda value: "named" if isinstance(value, dict) else "plain"),
]


class Knob(Section):
    """A knob: ``key`` is set to each value, or ``scale`` multiplied, or a value brings its own."""

    scenes: Several[str] = entry("Variants of the model in which it is turned.", min_length=1)
    other_joints: bool = entry(
        "Whether it changes the joints themselves: a difference there is no numerical error.",
        False,
    )
    set: dict[str, Any] = entry("Settings that hold at all values.", {})
    path: SectionKey | None = entry("What is set, as section.key.", None, alias="key")
    scale: Several[SectionKey] | None = entry(
        "What is multiplied, as section.key.", None, min_length=1
    )
    values: Several[KnobValue] = entry(
        "Numbers or words; or, without key and scale, a name (`value`) and settings (`set`) each.",
        min_length=1,
    )


class Accuracy(StudySection):
    """Design of a study of what accuracy costs (accuracy.yaml): variants of the model, and
    the knobs that are turned in each."""

    name = "accuracy"
    separate = True
    parameter: Literal[Rock._fields] = entry(  # type: ignore[valid-type]
        "Rock property at whose levels every run closes the surfaces, and whose indifference "
        "interval is followed."
    )
    resamples: int = entry("Resamples of the surfaces for confidence intervals.", ge=10, le=100_000)
    confidence: float = entry("Confidence of these intervals.", gt=0, lt=1)
    scenes: dict[Name, Scene] = entry(
        "Variants of the model by name: sections of a configuration that are merged over the "
        "study's, and `finest`, the knob and value of the reference.",
        min_length=1,
    )
    knobs: dict[Name, Knob] = entry(
        "Knobs by name: either `key` (section.key) is set to each value, or each key of `scale` is "
        "multiplied by it, or each value brings the settings that it stands for.",
        min_length=1,
    )


SECTION = Accuracy

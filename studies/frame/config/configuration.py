"""The configuration of a study: merged, checked and in SI, once and in one place."""

import copy
import difflib
import functools
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Annotated, NamedTuple, Self, TypeVar

import pandas as pd
from pydantic import ValidationError, create_model, model_validator

from jointclosure.engine.settings import Grid, Surface
from jointclosure.inputs import InputError
from jointclosure.parameters import AUTO_TOLERANCE, Choices, Effects, Numerics
from studies.frame.config.contradictions import contradictions
from studies.frame.config.files import DEFAULT, MEASURED, METHODS, ConfigurationError, read_plain
from studies.frame.config.presets import anything_breaks, chosen_numerics, numerics_in_full
from studies.frame.config.rocks import StudyRock
from studies.frame.config.schema import explained
from studies.frame.config.section import Made, Name, Section, StudySection, entry
from studies.frame.config.sections import (
    ChoiceKeys,
    GridKeys,
    NumericsKeys,
    Output,
    Statistics,
    Study,
    StudyEffects,
    SurfaceKeys,
)
from studies.frame.config.wanted import (
    check_left_out,
    describe_grant,
    grant,
    measured_rocks,
    methods_of,
    wanted_of,
    with_granted,
)

_Section = TypeVar("_Section", bound=StudySection)


class Configuration(Section):
    """Configuration of a study."""

    study: Study
    rocks: dict[Name, StudyRock] = entry(
        "Rocks by name; a study's own file may add some.", min_length=1
    )
    grid: Annotated[Grid, Made(GridKeys)]
    surface: Annotated[Surface, Made(SurfaceKeys)]
    seating_stress: float = entry(
        "Stress from which seated closures count [MPa]; it changes what is read, never what "
        "happens.",
        alias="seating_stress_MPa",
        ge=0,
    )
    effects: StudyEffects
    flow: bool = entry(
        "Whether hydraulic apertures are found too, by Reynolds' equation at every step "
        "(docs/export.md#flow); it changes nothing else.",
        False,
    )
    choices: Annotated[Choices, Made(ChoiceKeys)]
    numerics: Annotated[Numerics, Made(NumericsKeys)]
    statistics: Statistics
    output: Output

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        """Take the rocks of the study in its order, and what other sections leave open."""
        if unknown := list(_unknown(self.study.rocks, self.rocks)):
            raise ValueError("\n".join(unknown))
        usual = self.effects.acting
        rocks = {name: self.rocks[name].with_effects(usual) for name in self.study.rocks}
        output, numerics = self.output, self.numerics
        if output.largest_stress is None:
            largest = max(rock.max_normal_stress for rock in rocks.values())
            output = output._replace(largest_stress=largest)
        if numerics.idle_interaction is None:
            numerics = numerics._replace(idle_interaction=self.effects.auto or 0.0)
        return self._replace(rocks=rocks, output=output, numerics=numerics)

    @property
    def effects_chosen_to(self) -> float | None:
        """Tolerance by which a pilot chooses effects; None where they are as configured."""
        return self.effects.auto

    @property
    def independent_walls(self) -> bool:
        """Whether no part of the walls mates, as far as the section ``surface`` says."""
        surface = self.surface
        given = (surface.mismatch_wavelength, surface.correlation, surface.shift_in_cells)
        return given == (None, 0.0, 0)

    @property
    def study_sections(self) -> dict[str, StudySection]:
        """Sections of experiments that are given, by name."""
        given = {section.name: getattr(self, section.name, None) for section in sections().values()}
        return {name: section for name, section in given.items() if section is not None}

    def section(self, kind: type[_Section]) -> _Section:
        """Return the section of an experiment; raise `InputError` if it is left out."""
        section = getattr(self, kind.name)
        if section is None:
            raise InputError(f"{kind.name} = null: must be given for this study")
        return section


def _unknown(names: Iterable[str], rocks: Iterable[str]) -> Iterator[str]:
    for name in names:
        if name not in rocks:
            close = difflib.get_close_matches(name, rocks, n=1)
            meant = f"; did you mean {close[0]}?" if close else ""
            yield f"study.rocks = {name!r}: must be one of rocks ({', '.join(rocks)}){meant}"


@functools.cache
def sections() -> dict[str, type[StudySection]]:
    """Return the sections of experiments by the folder of the experiment."""
    folders = sorted(path.parent.name for path in Path(__file__).parents[2].glob("*/section.py"))
    return {name: import_module(f"studies.{name}.section").SECTION for name in folders}


@functools.cache
def model() -> type[Configuration]:
    """Return the model of a whole configuration, with the sections of all experiments."""
    return create_model(
        "Configuration",
        __base__=Configuration,
        __doc__=Configuration.__doc__,
        **{section.name: (section | None, None) for section in sections().values()},  # type: ignore
    )


class Configured(NamedTuple):
    """A configuration as keys of a file; in SI; and what was chosen.

    ``remark`` is a sentence on numerics that a preset or accuracy stands for, or empty; ``granted``
    the preset that a result's accuracy chose, or None.
    """

    keys: dict
    typed: Configuration
    remark: str
    granted: str | None = None


def overlaid(keys: dict, changes: dict) -> dict:
    """Nested keys with others over them; what does not change is not copied."""
    return keys | {
        name: overlaid(keys[name], value)
        if isinstance(value, dict) and isinstance(keys.get(name), dict)
        else value
        for name, value in changes.items()
    }


def merged(*settings: dict) -> dict:
    """Nested settings, later ones over earlier ones, as a copy."""
    return copy.deepcopy(functools.reduce(overlaid, settings, {}))


def merged_study(*paths: Path) -> dict:
    """The default configuration and files over it, not yet checked."""
    return merged(*(written_out(read_plain(path)) for path in (DEFAULT, *paths)))


def written_out(keys: dict) -> dict:
    """Keys whose ``effects: auto`` is written out: those of the full model, chosen to 2 %."""
    if keys.get("effects") != "auto":
        return keys
    return keys | {"effects": Effects()._asdict() | {"auto": AUTO_TOLERANCE}}


def configured(keys: dict, read: Callable[[Path], pd.DataFrame]) -> Configured:
    """A configuration from merged keys: words turned into numbers, checked, and in SI.

    Parameters
    ----------
    keys : dict
        As from `merged_study`; complete, and not yet checked.
    read : callable
        Reads the table that ``numerics.preset`` and ``accuracy`` choose from, where one
        of them is given.

    Raises
    ------
    ConfigurationError
        Naming every key that is wrong, its value, what is allowed, and for
        an unknown key the one that was probably meant.
    """
    keys = written_out(keys)
    resolved(keys)
    try:
        keys, sentence, granted = _chosen(keys, read_plain(DEFAULT), read)
    except InputError as error:
        raise ConfigurationError(str(error)) from None
    configuration = resolved(keys)
    refuse(contradictions(configuration, keys))
    return Configured(keys, configuration, sentence, granted)


def resolved(keys: dict) -> Configuration:
    """The configuration of keys without contradictions, as those in the file of a study."""
    try:
        return model().model_validate(keys)
    except ValidationError as error:
        raise refusal(explained(model(), keys, error)) from None


def checked_with(keys: dict, *changes: dict) -> Configuration:
    """Check keys of `Configured` with changes; a preset or accuracy is written out before."""
    plain = keys | {"numerics": numerics_in_full(keys)}
    return configured(merged(plain, *changes), _no_table).typed


def _no_table(path: Path) -> pd.DataFrame:
    raise InputError("numerics.preset, numerics.accuracy: only for a study as a whole")


def _chosen(keys: dict, default: dict, read) -> tuple[dict, str, str | None]:
    """Keys with what a preset or an accuracy stands for, a sentence on it, and a granted preset."""
    wanted = wanted_of(keys)
    if wanted is None:
        chosen = chosen_numerics(keys, default["numerics"], lambda: read(MEASURED))
        return keys | {"numerics": chosen.numerics}, chosen.remark, None
    if not anything_breaks(keys):
        raise InputError("numerics.accuracy.of: known where contacts break, and nothing does here")
    if keys["numerics"].get("preset") is not None:
        raise InputError(
            f"numerics.preset = {keys['numerics']['preset']!r}: leave it out, "
            "numerics.accuracy.of chooses it"
        )
    check_left_out(keys, default)
    settings, cycles = read(MEASURED), keys["study"]["cycles"]
    methods = methods_of(read(METHODS), measured_rocks(keys, default).values())
    granted = grant(wanted, methods, settings.preset.dropna().unique(), cycles)
    named = {"preset": granted.preset, "accuracy": None}
    numerics = chosen_numerics(
        keys | {"numerics": keys["numerics"] | named},
        default["numerics"],
        lambda: settings,
        by="accuracy.of",
    ).numerics
    kept = {"preset": None, "accuracy": keys["numerics"]["accuracy"]}
    whole = with_granted(keys, wanted, granted) | {"numerics": numerics | kept}
    return whole, describe_grant(wanted, granted), granted.preset


def refuse(problems: Iterable[str]) -> None:
    """Raise `ConfigurationError` where there are problems, one line each."""
    if lines := list(dict.fromkeys(problems)):
        raise refusal(lines)


def refusal(problems: Iterable[str]) -> ConfigurationError:
    """Return the error that lists problems, one line each."""
    return ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in problems))


def problem_lines(error: InputError) -> list[str]:
    """The lines of an error of `refuse`, or of another one."""
    lines = str(error).removeprefix("configuration:").split("\n")
    return [line.strip() for line in lines if line.strip()]

"""Keys of the experiment on readings of the paper."""

from typing import Any, Literal

from jointclosure.config.keys.entries import Keys, Name, Text, entry


class ReadingKeys(Keys):
    """A reading of the paper: settings that are merged over the study's."""

    title: Text = entry("Its name in tables and figures.")
    set: dict[str, Any] = entry("Settings that it stands for, merged over the study's.", {})
    closure: Literal["max_closure", "max_closure_seated", "max_closure_net"] = entry(
        "Which closure is read: from first touch, from seating, or net of bulk indentation.",
        "max_closure",
    )
    allowed: bool = entry("Whether the paper's text allows it.", True)


class RoundKeys(Keys):
    """A round of a study of readings: who enters, and how much is spent on each."""

    name: Name = entry("Its name.")
    candidates: Literal["singles", "kept", "pairs"] = entry(
        "singles: all readings (first round); kept: those that the round before kept; pairs: these "
        "and their pairs."
    )
    rocks: list[str] | None = entry(
        "Rocks that are closed; the others are taken to change as these do. null: all.", None
    )
    realizations: int = entry("Surfaces of each case, with those of earlier rounds.", ge=3)
    most: int = entry("How many of those kept may enter, the best first.", 1000, ge=1)
    margin: float = entry(
        "Standard errors by which a reading may be behind the best and still be kept.", gt=0
    )


class ReadingsKeys(Keys):
    """Design of a study of which reading of the paper gives its Table 3
    (config/readings.yaml)."""

    reference_realizations: int = entry(
        "Surfaces of each case of the study as configured, in all rocks.", ge=3
    )
    draws: int = entry("Surfaces of each case in the paper's own study.", ge=2)
    repetitions: int = entry("Repetitions of the paper's study that are drawn.", ge=100)
    groups: int = entry("Groups of surfaces of the jackknife, at most.", ge=2)
    aspects: dict[Name, dict[Name, ReadingKeys]] = entry(
        "Readings by what they are a reading of, and by name; pairs are made of two aspects.",
        min_length=1,
    )
    rounds: list[RoundKeys] = entry("What is closed, in turn.", min_length=1)

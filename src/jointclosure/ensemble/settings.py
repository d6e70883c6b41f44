"""All that the files of a case depend on, so that a file of other settings is noticed.

A file bears its settings as JSON in its attribute ``settings``. Whoever reads it says
which it should have; `check_settings` names the first one that differs. They are made of a
configuration by `jointclosure.ensemble.slices`; what closes walls does not depend on how.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from jointclosure.config.plain import to_plain
from jointclosure.config.typed import Grid, Surface, Walls
from jointclosure.inputs import InputError
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
)


class OtherSettingsError(InputError):
    """A file that was made with other settings, or by other code."""


class Case(NamedTuple):
    """One rock with at most one parameter changed; values in SI.

    ``rock`` is its name and ``intact`` its properties; ``effects`` those of the study or
    the rock's own. ``surface`` is the label of the case whose surfaces this one closes: its
    own, or with common draws and an unchanged JRC its rock's base case. ``jrc`` is
    NaN where walls are scanned ones.
    """

    label: str
    rock: str
    parameter: str
    level: str
    value: float
    intact: Rock
    jrc: float
    max_normal_stress: float
    effects: Effects
    surface: str

    def property(self, name: str) -> float:
        """A property of `jointclosure.parameters.PROPERTIES` [SI]."""
        return self.jrc if name == "jrc" else getattr(self.intact, name)

    def changed(self, name: str, value: float) -> "Case":
        """The case with another value of a property [SI]."""
        if name == "jrc":
            return self._replace(jrc=value)
        return self._replace(intact=self.intact._replace(**{name: value}))


class SurfaceSettings(NamedTuple):
    """What the surface pairs of a case and a block of realisations depend on.

    ``seeds_named_by`` and ``root_seed`` give their seeds, ``code`` is a digest of the sources
    that make them; ``sha256`` are digests of the files of measured ``walls``, by side.
    """

    jrc: float
    walls: Walls | None
    sha256: dict[str, str]
    root_seed: int
    seeds_named_by: tuple[str, ...]
    first_realization: int
    realizations: int
    grid: Grid
    surface: Surface
    code: str


class Conditions(NamedTuple):
    """What a joint is told besides its walls: the arguments of `jointclosure.simulate`, in SI."""

    spacing: float
    rock: Rock | tuple[Rock, Rock]
    max_normal_stress: float | Sequence[float]
    cycles: int
    seating_stress: float
    effects: Effects
    choices: Choices
    numerics: Numerics
    flow: bool = False


class ClosureSettings(NamedTuple):
    """What the closures of a case and a block of realisations depend on, in SI.

    ``stress_points`` and ``largest_stress`` are those of the common stress axis;
    ``effects_chosen_to`` is the tolerance by which a pilot chooses among the case's effects.
    """

    case: Case
    surfaces: SurfaceSettings
    cycles: int
    seating_stress: float
    choices: Choices
    numerics: Numerics
    stress_points: int
    largest_stress: float
    effects_chosen_to: float | None
    flow: bool
    code: str

    def conditions(self) -> Conditions:
        """Those at which the walls of the case are closed."""
        return Conditions(
            self.surfaces.grid.spacing,
            self.case.intact,
            self.case.max_normal_stress,
            self.cycles,
            self.seating_stress,
            self.case.effects,
            self.choices,
            self.numerics,
            self.flow,
        )

    def with_effects(self, effects: Effects) -> "ClosureSettings":
        """The same with other effects."""
        return self._replace(case=self.case._replace(effects=effects))


def as_text(settings: SurfaceSettings | ClosureSettings) -> str:
    """Settings as JSON, the same text for the same settings."""
    return json.dumps(to_plain(settings), sort_keys=True)


def check_settings(
    path: str | Path, attributes: dict, expected: SurfaceSettings | ClosureSettings
) -> None:
    """Raise `OtherSettingsError` unless a file's attributes are of the expected settings."""
    text = attributes.get("settings")
    if text == as_text(expected):
        return
    if text is None:
        said = "it does not say which"
    else:
        said = _first_difference(json.loads(text), json.loads(as_text(expected)))
    raise OtherSettingsError(
        f"{path}: the file was made with other settings ({said}): "
        "delete it and start again, what is missing is made anew"
    )


def _first_difference(found: dict, expected: dict, prefix: str = "") -> str:
    for key in sorted({*found, *expected}):
        one, other = found.get(key), expected.get(key)
        if json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True):
            continue
        if isinstance(one, dict) and isinstance(other, dict):
            return _first_difference(one, other, f"{prefix}{key}.")
        return f"{prefix}{key} is {one!r} there, and should be {other!r}"
    return "in their order"

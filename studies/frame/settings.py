"""Settings that the joints of a case depend on, and walls that are made of them."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.statistics.randomness import seed_of
from jointclosure.walls import Walls
from jointclosure.walls.synthesis import wall_pair
from studies.frame.keys import Grid, Surface

SIDES = ("upper", "lower")
BASE = "base"
"""Parameter and level of a case in which no parameter is changed."""


class Case(NamedTuple):
    """A ``rock`` (its name) with at most one parameter changed [SI]; scanned walls have no JRC."""

    label: str
    rock: str
    parameter: str
    level: str
    value: float
    jrc: float
    conditions: Conditions

    @property
    def max_normal_stress(self) -> float:
        """Maximum stress of every cycle [Pa]."""
        return self.conditions.largest_stress

    def number(self, name: str) -> float:
        """Return a property of the rock or a number of the case by its name [SI]."""
        return getattr(self if hasattr(self, name) else self.conditions.rock, name)

    def changed(self, name: str, value: float) -> "Case":
        """Return the case with another value of a property [SI]."""
        if name == "jrc":
            return self._replace(jrc=value)
        return self.under(rock=self.conditions.rock._replace(**{name: value}))

    def under(self, **changes: Any) -> "Case":
        """Return the case under changed conditions."""
        return self._replace(conditions=self.conditions._replace(**changes))


class ClosureSettings(NamedTuple):
    """Settings [SI] that the joints of a case and a block of realisations depend on.

    ``sha256`` has the digests of the files of scanned ``walls``; others are made from seeds, which
    ``root_seed`` and ``seeds_named_by`` determine. The common axis has ``stress_points`` up to
    ``largest_stress``. A pilot chooses the effects to the tolerance ``effects_chosen_to``.
    """

    case: Case
    walls: object | None
    sha256: dict[str, str]
    root_seed: int
    seeds_named_by: tuple[str, ...]
    first_realization: int
    realizations: int
    grid: Grid
    surface: Surface
    stress_points: int
    largest_stress: float
    effects_chosen_to: float | None

    @property
    def conditions(self) -> Conditions:
        """Conditions at which the walls of the case are closed."""
        return self.case.conditions

    def under(self, **changes: Any) -> "ClosureSettings":
        """Return the settings with changed conditions."""
        return self._replace(case=self.case.under(**changes))


def seeds_of(settings: ClosureSettings) -> list[int]:
    """Return the seeds of the walls of a block."""
    first, last = settings.first_realization, settings.first_realization + settings.realizations
    named = settings.seeds_named_by
    return [seed_of(settings.root_seed, *named, number) for number in range(first, last)]


def walls_of_seed(seed: int, jrc: float, grid: Grid, surface: Surface) -> Walls:
    """Make the walls of one realisation; unusual values were checked."""
    return wall_pair(jrc, grid.shape, grid.spacing, seed, **dict(surface), unusual_values=True)


def walls_of(settings: ClosureSettings) -> Iterator[Walls]:
    """Generate the walls of a block, from a JRC."""
    if settings.walls:
        raise InputError("walls that were scanned are cut out of the scans, not made from a seed")
    for seed in seeds_of(settings):
        yield walls_of_seed(seed, settings.case.jrc, settings.grid, settings.surface)

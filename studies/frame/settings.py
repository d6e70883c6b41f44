"""Settings on which joints depend (`Case` among them), their walls, and points of simulation.

Which cases a study has is decided in `cases.py`, which imports this module. Every job that
simulates joints imports it too, and it therefore imports nothing that is slow to load, such as the
models of the configuration.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.load import stated_load
from jointclosure.statistics.randomness import seed_of
from jointclosure.storage.files import MAKE_AGAIN, digest
from jointclosure.walls import CrushedWalls, Walls
from studies.frame.checked_files import ForeignFileError, read_checked

SIDES = ("upper", "lower")
BASE = "base"
"""Parameter and level of a case in which no parameter is changed."""


class JointGrid(NamedTuple):
    """Regular grid of both walls: cells along x and y, and their spacing [m]."""

    cells_x: int
    cells_y: int
    spacing: float

    @property
    def shape(self) -> tuple[int, int]:
        """Cells (y, x)."""
        return self.cells_y, self.cells_x


class Synthesis(NamedTuple):
    """How walls are made from a JRC: the arguments of `jointclosure.wall_pair` [SI] so named."""

    hurst: float
    jrc_relation: str
    normalise: str
    correlation: float
    shift_in_cells: int
    mismatch_wavelength: float | None
    rule: str
    roll_off: float | None


class Case(NamedTuple):
    """Case of a study: a rock under conditions, with at most one ``parameter`` changed.

    ``rock``, ``parameter`` and ``level`` are names, ``value`` [SI] is that of the changed
    parameter. A base case has no changed parameter: `BASE` stands for its parameter and level, and
    its value is NaN. ``jrc`` is NaN for scanned walls.
    """

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
        return stated_load(self.conditions.max_normal_stress).largest

    @property
    def checked_conditions(self) -> CheckedConditions:
        """Conditions under which the joints of the case are simulated.

        Values that are unusual for rock are accepted, as the configuration was checked for them.
        """
        return self.conditions._replace(unusual_values=True).checked()

    def number(self, name: str) -> float:
        """Return a number [SI] of the case, such as "jrc", or a property of its rock, by name."""
        return getattr(self if hasattr(self, name) else self.conditions.rock, name)

    def changed(self, name: str, value: float) -> "Case":
        """Return the case with another ``value`` [SI] of the property ``name``.

        Its label, parameter and level stay; the caller changes them.
        """
        if name == "jrc":
            return self._replace(jrc=value)
        return self.under(rock=self.conditions.rock._replace(**{name: value}))

    def under(self, **changes: Any) -> "Case":
        """Return the case with ``changes`` of fields of its conditions [SI]."""
        return self._replace(conditions=self.conditions._replace(**changes))


class ClosureSettings(NamedTuple):
    """Settings [SI] on which the joints of a case, for a block of realisations, depend.

    ``walls`` are the configuration's `ScannedWalls`, and ``sha256`` has the digests of their files
    by side. If ``walls`` is None, walls are made from seeds, which follow from ``root_seed``,
    ``seeds_named_by`` and the number of the realisation. Curves are read at ``stress_points``
    stresses from 0 to ``largest_stress``. ``effects_chosen_to`` is the tolerance to which effects
    are left out (`choose_rock_effects`); None: all effects of the case are simulated.
    """

    case: Case
    walls: object | None
    sha256: dict[str, str]
    root_seed: int
    seeds_named_by: tuple[str, ...]
    first_realization: int
    realizations: int
    grid: JointGrid
    surface: Synthesis
    stress_points: int
    largest_stress: float
    effects_chosen_to: float | None

    @property
    def conditions(self) -> CheckedConditions:
        """Conditions under which the joints of the case are simulated."""
        return self.case.checked_conditions

    @property
    def jrc(self) -> float:
        """Joint roughness coefficient of the walls of the case, NaN where they were scanned."""
        return self.case.jrc

    def under(self, **changes: Any) -> "ClosureSettings":
        """Return the settings with ``changes`` of fields of the case's conditions [SI]."""
        return self._replace(case=self.case.under(**changes))


class SurfaceSettings(NamedTuple):
    """Settings [SI] on which the surfaces (walls) of a case, for a block of realisations, depend.

    Cases with equal surface settings have the same surfaces.
    """

    root_seed: int
    seeds_named_by: tuple[str, ...]
    first_realization: int
    realizations: int
    jrc: float
    grid: JointGrid
    surface: Synthesis


def surface_settings(settings: ClosureSettings | SurfaceSettings) -> SurfaceSettings:
    """Return the part of the settings of joints on which their surfaces depend."""
    return SurfaceSettings(*(getattr(settings, name) for name in SurfaceSettings._fields))


def seeds_of(settings: ClosureSettings | SurfaceSettings) -> list[int]:
    """Return the seed of the walls of each realisation of a block."""
    first = settings.first_realization
    last = settings.first_realization + settings.realizations
    named = settings.seeds_named_by
    return [seed_of(settings.root_seed, *named, number) for number in range(first, last)]


def walls_of_seed(seed: int, jrc: float, grid: JointGrid, surface: Synthesis) -> Walls:
    """Return the random walls (y, x) [m] of one realisation by its seed.

    Values that are unusual for rock are accepted, as the configuration was checked for them.
    """
    from jointclosure.walls.synthesis import wall_pair  # Fourier transforms, which few jobs need

    return wall_pair(jrc, grid.shape, grid.spacing, seed, **surface._asdict(), unusual_values=True)


def walls_of(settings: ClosureSettings | SurfaceSettings) -> Iterator[Walls]:
    """Generate the random walls (y, x) [m] of each realisation of a block.

    Raise `InputError` if the walls of the case were scanned.
    """
    if math.isnan(settings.jrc):
        raise InputError("walls that were scanned are cut out of the scans, not made from a seed")
    for seed in seeds_of(settings):
        yield walls_of_seed(seed, settings.jrc, settings.grid, settings.surface)


def surfaces_dataset(pairs: Iterable[Walls], settings: SurfaceSettings) -> xr.Dataset:
    """Return the walls of a block as a dataset (realization, y, x) [m], with their seeds.

    ``pairs`` are the walls of each realisation. Its attribute ``key`` is `surfaces_key`.
    """
    heights = np.array(list(pairs))
    about = {"units": "m", "long_name": "height towards the other wall"}
    first = settings.first_realization
    seeds = np.array([f"{seed:032x}" for seed in seeds_of(settings)], dtype=object)
    return xr.Dataset(
        {side: (("realization", "y", "x"), heights[:, i], about) for i, side in enumerate(SIDES)},
        coords={
            "realization": first + np.arange(settings.realizations),
            "seed": ("realization", seeds, {"long_name": "seed of the walls"}),
        },
        attrs={"spacing_m": settings.grid.spacing, "key": surfaces_key(settings)},
    )


def surfaces_key(settings: ClosureSettings | SurfaceSettings) -> str:
    """Return the digest of all on which surfaces depend, except the block of realisations."""
    return digest(surface_settings(settings)._replace(first_realization=0, realizations=0))


def walls_in(files: Iterable[str], settings: ClosureSettings | SurfaceSettings) -> Iterator[Walls]:
    """Generate the walls (y, x) [m] in files of `surfaces_dataset`, one file at a time.

    Raises
    ------
    DamagedFileError
        If a file is not as it was written.
    ForeignFileError
        If a file has surfaces of other settings, or does not continue with the next realisation.
    """
    following = settings.first_realization
    for file in files:
        surfaces = read_checked(file, surfaces_key(settings))
        if int(surfaces.realization[0]) != following:
            raise ForeignFileError(
                f"{file}: begins with realisation {int(surfaces.realization[0])}, must begin "
                f"with {following}: {MAKE_AGAIN}"
            )
        following += surfaces.sizes["realization"]
        yield from zip(*(surfaces[side].values for side in SIDES), strict=True)


class Point(NamedTuple):
    """Point of a study or experiment: joints under the same conditions, one per realisation.

    ``coordinates`` [SI] are those of the joints in datasets and tables. ``maker`` names a function
    (``module:function``) that generates the walls from ``settings`` and ``options``. If it is "",
    walls are made from their seeds, or read from a file of surfaces.
    """

    coordinates: Mapping[str, Any]
    settings: ClosureSettings
    maker: str = ""
    options: Mapping[str, Any] = {}

    def walls(self) -> Iterator[Walls | CrushedWalls]:
        """Generate the walls of each realisation, by the ``maker`` or from seeds."""
        module, _, function = self.maker.partition(":")
        if not function:
            return walls_of(self.settings)
        return getattr(import_module(module), function)(self.settings, **self.options)


def joints_of(points: Iterable[Point]) -> int:
    """Return the number of joints at all of the points."""
    return sum(point.settings.realizations for point in points)

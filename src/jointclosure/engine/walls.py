"""Walls of the joints of a case or an experiment, made from their seeds."""

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module

import numpy as np

from jointclosure.engine.settings import ClosureSettings, Grid, Surface, SurfaceSettings
from jointclosure.inputs import InputError
from jointclosure.joint.simulation import close_walls
from jointclosure.statistics.randomness import seed_of
from jointclosure.walls.roughness import detrended, rms_slope, z2_of_jrc
from jointclosure.walls.synthesis import rotated_pair, spectrum_of, tilted, wall_pair

Walls = tuple[np.ndarray, np.ndarray]
"""Upper and lower wall (y, x), heights towards the other [m]."""

COPIES: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "as it is": lambda wall: wall,
    "last digits": lambda wall: wall * (1.0 + 1e-12),
    "mirrored": lambda wall: np.ascontiguousarray(wall[:, ::-1]),
    "transposed": lambda wall: np.ascontiguousarray(wall.T),
}
"""Copies of a wall that close alike but for rounding and the order of breakage."""


def seeds_of(settings: SurfaceSettings) -> list[int]:
    """Return the seeds of the walls of a block."""
    first = settings.first_realization
    return [
        seed_of(settings.root_seed, *settings.seeds_named_by, realization)
        for realization in range(first, first + settings.realizations)
    ]


def walls_of_seed(seed: int, jrc: float, grid: Grid, surface: Surface) -> Walls:
    """Make the walls of one realisation; unusual values were checked."""
    settings = surface._asdict()
    return wall_pair(jrc, grid.shape, grid.spacing, seed, **settings, unusual_values=True)


def walls_of(settings: SurfaceSettings) -> Iterator[Walls]:
    """Generate the walls of a block, from a JRC."""
    if settings.walls:
        raise InputError("walls that were scanned are cut out of the scans, not made from a seed")
    for seed in seeds_of(settings):
        yield walls_of_seed(seed, settings.jrc, settings.grid, settings.surface)


def misaligned(settings: SurfaceSettings, tilt: float, rotation: float) -> Iterator[Walls]:
    """Generate pairs with a tilted upper wall and a rotated lower wall [degrees]."""
    grid, surface = settings.grid, settings.surface
    wavelength = surface.mismatch_wavelength
    for seed in seeds_of(settings):
        upper, lower = rotated_pair(
            z2_of_jrc(settings.jrc, grid.spacing, surface.hurst, surface.jrc_relation),
            grid.shape,
            grid.spacing,
            spectrum_of(surface.hurst, surface.rule, surface.roll_off, grid.spacing),
            seed,
            np.inf if wavelength is None else wavelength,
            rotation,
        )
        yield tilted(upper, grid.spacing, tilt), lower


def nested(
    settings: SurfaceSettings, whole: tuple[int, float], base: float, position: int
) -> Iterator[Walls]:
    """Generate patches of larger walls: the patch at a position on the diagonal, less its plane.

    The walls of a realisation are the same for all patches and spacings. ``whole`` is the number of
    cells along a side of the walls, and their spacing [m]. They have the Z2 of their JRC at the
    spacing ``base`` [m]. A coarser grid has every second (or fourth) cell.
    """
    cells, finest = whole
    large = settings._replace(grid=Grid(cells, cells, finest))
    z2 = z2_of_jrc(settings.jrc, base, settings.surface.hurst, settings.surface.jrc_relation)
    coarse, step = round(base / finest), round(settings.grid.spacing / finest)
    side = settings.grid.cells_x * step
    part = slice(position * side, (position + 1) * side, step)
    for pair in walls_of(large):
        scaled = (wall * (z2 / rms_slope(wall[::coarse, ::coarse], base)) for wall in pair)
        upper, lower = (np.ascontiguousarray(detrended(wall[part, part])) for wall in scaled)
        yield upper, lower


def reseated(settings: ClosureSettings, shift: int) -> Iterator[Walls]:
    """Generate walls after a load cycle, the upper one shifted along x by a number of cells."""
    conditions = settings.conditions()._replace(cycles=1)
    for pair in walls_of(settings.surfaces):
        closed = close_walls(*pair, conditions)
        upper, lower = closed.upper_final.values, closed.lower_final.values
        yield upper[:, shift:], lower[:, : lower.shape[1] - shift]


def _of_surfaces(maker: Callable[..., Iterator[Walls]]) -> Callable[..., Iterator[Walls]]:
    """Make a maker of a function that depends on the settings of the surfaces only."""
    return lambda settings, **options: maker(settings.surfaces, **options)


MAKERS: dict[str, Callable[..., Iterator[Walls]]] = {
    "synthetic": _of_surfaces(walls_of),
    "misaligned": _of_surfaces(misaligned),
    "nested": _of_surfaces(nested),
    "reseated": reseated,
}
"""Makers by name. A maker generates the walls of each realisation from the `ClosureSettings` of a
point."""


def maker_of(name: str) -> Callable[..., Iterator[Walls]]:
    """Return a maker of `MAKERS`, or a function of a study, such as ``module:function``."""
    module, _, function = name.partition(":")
    return getattr(import_module(module), function) if function else MAKERS[name]

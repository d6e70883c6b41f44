"""Makers of the walls of an experiment's joints, from the settings of their surfaces."""

from collections.abc import Callable, Iterator

import numpy as np

from jointclosure.engine.joints import Walls
from jointclosure.engine.settings import ClosureSettings, Grid, SurfaceSettings
from jointclosure.engine.surfaces import seeds_of, walls_of
from jointclosure.joint.simulation import close_walls
from jointclosure.walls.roughness import detrended, rms_slope, z2_of_jrc
from jointclosure.walls.synthesis import rotated_pair, spectrum_of, tilted


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

"""Surface pairs of a case, made from their seeds."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from jointclosure.engine.settings import Grid, Surface, SurfaceSettings
from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import seed_of
from jointclosure.walls.synthesis import wall_pair


def make_surfaces(
    seeds: list[int],
    jrc: float,
    grid: Grid,
    surface: Surface,
    first: int = 0,
) -> Iterator[xr.Dataset]:
    """Generate surface pairs (realization, y, x) of seeds (`seeds_of`), one at a time.

    ``surface`` is as for `jointclosure.wall_pair`; ``first`` is the number of the first one.
    """
    for realization, seed in enumerate(seeds, start=first):
        pair = walls_of_seed(seed, jrc, grid, surface)
        yield surface_pair(pair, realization, seed, {"spacing_m": grid.spacing, "jrc": jrc})


def walls_of_seed(
    seed: int, jrc: float, grid: Grid, surface: Surface
) -> tuple[np.ndarray, np.ndarray]:
    """Make the upper and lower wall (y, x) [m] of one realisation; unusual values were checked."""
    settings = surface._asdict()
    return wall_pair(jrc, grid.shape, grid.spacing, seed, **settings, unusual_values=True)


def surface_pair(pair: tuple, realization: int, seed: int, attributes: dict) -> xr.Dataset:
    """Make a dataset of the walls (y, x) [m] of one realisation, as `close_surfaces` takes it."""
    return xr.Dataset(
        {
            name: (
                ("realization", "y", "x"),
                wall[np.newaxis],
                {"units": "m", "long_name": f"height of the {name} wall towards the other"},
            )
            for name, wall in zip(("upper", "lower"), pair, strict=True)
        },
        coords={
            "realization": [realization],
            "seed": ("realization", np.array([f"{seed:032x}"], dtype=object)),
        },
        attrs=attributes,
    )


def seeds_of(settings: SurfaceSettings) -> list[int]:
    """Return the seeds of the surface pairs of a block."""
    first = settings.first_realization
    return [
        seed_of(settings.root_seed, *settings.seeds_named_by, realization)
        for realization in range(first, first + settings.realizations)
    ]


def surfaces_of(settings: SurfaceSettings) -> Iterator[xr.Dataset]:
    """Generate the surface pairs of a block one by one."""
    if settings.walls:
        raise InputError(
            "surfaces of scanned walls are not made from a seed: run the study again, which cuts "
            "them out of the scans"
        )
    first = settings.first_realization
    return make_surfaces(seeds_of(settings), settings.jrc, settings.grid, settings.surface, first)


def walls_of(settings: SurfaceSettings) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Generate `surfaces_of` as pairs of walls (upper, lower), each (y, x) [m]."""
    for pair in surfaces_of(settings):
        yield pair.upper.values[0], pair.lower.values[0]

"""Surface pairs of a case, made from their seeds."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from jointclosure.config.units import to_si
from jointclosure.inputs import InputError
from jointclosure.randomness import seed_of
from jointclosure.surface.synthesis import wall_pair


def make_surfaces(
    seeds: list[int],
    jrc: float,
    shape: tuple[int, int],
    spacing: float,
    surface: dict,
    first: int = 0,
) -> Iterator[xr.Dataset]:
    """Surface pairs (realization, y, x) of a case, one by one: each has one realisation.

    Parameters
    ----------
    seeds : list of int
        One for each realisation, see `jointclosure.ensemble.cases.wall_seed`.
    jrc, shape, spacing
        As for `jointclosure.wall_pair`, spacing in [m].
    surface : dict
        Its other arguments.
    first : int
        Number of the first realisation.
    """
    for realization, seed in enumerate(seeds, start=first):
        pair = wall_pair(jrc, shape, spacing, seed, **surface)
        yield surface_pair(pair, realization, seed, {"spacing_m": spacing, "jrc": jrc})


def surface_pair(pair: tuple, realization: int, seed: int, attributes: dict) -> xr.Dataset:
    """Upper and lower wall (y, x) [m] of one realisation, as `close_surfaces` takes them."""
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


def seeds_of(settings: dict) -> list[int]:
    """Seeds of the surface pairs of `jointclosure.ensemble.settings.surface_settings`."""
    first = settings["first_realization"]
    return [
        seed_of(settings["root_seed"], *settings["seeds_named_by"], realization)
        for realization in range(first, first + settings["realizations"])
    ]


def surfaces_of(settings: dict) -> Iterator[xr.Dataset]:
    """Surface pairs of `jointclosure.ensemble.settings.surface_settings`, one by one."""
    if settings.get("walls"):
        raise InputError(
            "surfaces of measured walls are not made from a seed: run the study again, which cuts "
            "them out of their scans"
        )
    first = settings["first_realization"]
    seeds = seeds_of(settings)
    grid = to_si(settings["grid"])
    shape = (grid["cells_y"], grid["cells_x"])
    return make_surfaces(seeds, settings["jrc"], shape, grid["spacing"], settings["surface"], first)

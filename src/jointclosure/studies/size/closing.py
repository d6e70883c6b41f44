"""Nested patches of the same walls, closed at several sizes and spacings.

The walls of a realisation are made once, as large as the largest patch and as fine as the finest
spacing. A smaller patch is a square on their diagonal, a coarser grid has every second (or
fourth) cell. So patches of different sizes and spacings are the same joint.
"""

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.typed import Configuration, Grid, SizeDesign
from jointclosure.engineering.laws import fitted_laws, parameter
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.responses import responses_of
from jointclosure.ensemble.settings import ClosureSettings, Conditions
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.inputs import InputError
from jointclosure.protocol import FAILURE, LOADING
from jointclosure.surface.bearing import bearing_depths
from jointclosure.surface.roughness import detrended, rms_slope, z2_of_jrc

READ = {
    "closure": ("m", "largest closure of the cycle, from its start"),
    "closure_net": ("m", "the same net of bulk indentation"),
    "closure_seated_net": ("m", "the same since seating"),
    "residual_seated_net": ("m", "net residual closure at seating"),
    "stiffness_net": (
        "Pa/m",
        "net stiffness of loading, from half of the maximum stress to the landing on it",
    ),
    "kni_net": ("Pa/m", "initial stiffness of the hyperbolic law of net loading since seating"),
    "vm_net": ("m", "largest closure of that law"),
}
"""What is read of each cycle. Only first loadings land (`ensemble.responses.responses_of`)."""
GEOMETRY = {
    "rms_height": ("m", "of the summed heights, less their plane"),
    "rms_slope": ("1", "of the summed heights at the spacing"),
    "depth_5": ("m", "depth of the highest 5 % of the summed heights"),
}
"""What is read of the pristine walls."""


class SizeSettings(NamedTuple):
    """What the joints of a rock and spectrum depend on.

    ``walls`` are those that all patches are cut out of, ``base`` is the spacing [m] at which they
    have the Z2 of their JRC; ``patch``, ``spacing`` and ``most_cells`` as in the design.
    """

    walls: ClosureSettings
    base: float
    patch: tuple[float, ...]
    spacing: tuple[float, ...]
    most_cells: int


def check_asked(configuration: Configuration) -> SizeDesign:
    """The design; `InputError` where the study has none."""
    if configuration.size is None:
        raise InputError("size = null: the study is none of the scale effect (config/size.yaml)")
    return configuration.size


def settings_of(configuration: Configuration, rock: str, spectrum: str) -> SizeSettings:
    """Settings of a rock's joints of one spectrum."""
    design = check_asked(configuration)
    finest = design.spacing[0]
    cells = round(design.patch[-1] / finest)
    large = configuration._replace(
        grid=Grid(cells, cells, finest),
        surface=configuration.surface._replace(**design.spectra[spectrum]._asdict()),
    )
    case = base_case(rock, configuration.rocks[rock])
    surfaces = surface_settings(large, case, range(configuration.study.realizations))
    return SizeSettings(
        closure_settings(large, case, surfaces),
        configuration.grid.spacing,
        design.patch,
        design.spacing,
        design.most_cells,
    )


def joints_of(settings: SizeSettings) -> Iterator[tuple[int, int]]:
    """Places of patch and spacing of all joints that are closed."""
    for i, patch in enumerate(settings.patch):
        for j, spacing in enumerate(settings.spacing):
            if round(patch / spacing) <= settings.most_cells or spacing == settings.base:
                yield i, j


def positions_of(settings: SizeSettings, i: int) -> int:
    """How many patches of the i-th length the diagonal of the walls has."""
    return round(settings.patch[-1] / settings.patch[i])


def nested_walls(settings: SizeSettings) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Walls (y, x) [m] of each realisation, which have the Z2 of their JRC at one spacing."""
    told = settings.walls.surfaces
    grid, surface = told.grid, told.surface
    z2 = z2_of_jrc(told.jrc, settings.base, surface.hurst, surface.jrc_relation)
    step = round(settings.base / grid.spacing)
    for upper, lower in walls_of(told):
        first, second = (
            wall * (z2 / rms_slope(wall[::step, ::step], settings.base)) for wall in (upper, lower)
        )
        yield first, second


def patch_of(wall: np.ndarray, finest: float, patch: float, spacing: float, at: int) -> np.ndarray:
    """The ``at``-th patch on the diagonal of a wall (y, x) [m], at a spacing, less its plane."""
    cells, step = round(patch / finest), round(spacing / finest)
    part = slice(at * cells, (at + 1) * cells, step)
    return np.ascontiguousarray(detrended(wall[part, part]))


def close_nested(
    settings: SizeSettings, report: Callable[[str], None] = lambda line: None
) -> xr.Dataset:
    """Close all patches of all walls at all spacings.

    Parameters
    ----------
    settings : SizeSettings
        As from `settings_of`.
    report : callable
        Receives a line for each realisation.

    Returns
    -------
    Dataset
        Over (patch, spacing, position, realization): `GEOMETRY`, ``status`` and the processor's
        ``seconds``; and over the cycle too, `READ`. NaN where nothing was closed, or it failed.
    """
    told = settings.walls
    sizes = len(settings.patch), len(settings.spacing)
    shape = (*sizes, positions_of(settings, 0), told.surfaces.realizations)
    alone = {name: np.full(shape, np.nan) for name in (*GEOMETRY, "status", "seconds")}
    values = {name: np.full((*shape, told.cycles), np.nan) for name in READ}
    for realization, walls in enumerate(nested_walls(settings)):
        for i, j in joints_of(settings):
            for at in range(positions_of(settings, i)):
                place = i, j, at, realization
                found, read = _closed(settings, walls, (i, j, at))
                for name, value in found.items():
                    alone[name][place] = value
                for name, value in read.items():
                    values[name][place] = value
        spent = np.nansum(alone["seconds"][..., realization])
        report(f"realisation {realization}: {spent:.1f} s")
    return _labelled(settings, alone, values)


def _closed(
    settings: SizeSettings, walls: tuple[np.ndarray, np.ndarray], place: tuple[int, int, int]
) -> tuple[dict, dict]:
    """Geometry, status and time of a joint, and `READ` over its cycles.

    ``place``: of patch and spacing, and the patch's number on the diagonal.
    """
    patch, spacing = settings.patch[place[0]], settings.spacing[place[1]]
    finest = settings.spacing[0]
    upper, lower = (patch_of(wall, finest, patch, spacing, place[2]) for wall in walls)
    summed = upper + lower
    start = time.process_time()
    conditions = settings.walls.conditions()._replace(spacing=spacing)
    closed = close_walls(upper, lower, conditions)
    found = {
        "rms_height": float(np.std(summed)),
        "rms_slope": rms_slope(summed, spacing),
        "depth_5": float(bearing_depths(summed, 0.05)),
        "status": int(closed.status),
        "seconds": time.process_time() - start,
    }
    return found, _read(closed, conditions) if closed.status < FAILURE else {}


def _read(closed: xr.Dataset, conditions: Conditions) -> dict[str, np.ndarray]:
    """`READ` over the cycles (cycles,)."""
    laws = fitted_laws(closed)

    def of_law(name: str) -> np.ndarray:
        cycles = range(1, closed.max_closure.size + 1)
        return np.array([parameter(laws, cycle, LOADING, name) for cycle in cycles])

    read = responses_of(closed, conditions)
    fitted = {"kni_net": 1e9 * of_law("kni_MPa_per_mm"), "vm_net": 1e-3 * of_law("vm_mm")}
    return {name: read[name] for name in READ if name in read} | fitted


def _labelled(settings: SizeSettings, alone: dict, values: dict) -> xr.Dataset:
    """Readings with their coordinates and units."""
    over = ("patch", "spacing", "position", "realization")
    about = GEOMETRY | {"status": ("1", "see docs/statuses.md"), "seconds": ("s", "processor")}
    found = {
        name: (over, each, {"units": about[name][0], "long_name": about[name][1]})
        for name, each in alone.items()
    } | {
        name: ((*over, "cycle"), each, {"units": READ[name][0], "long_name": READ[name][1]})
        for name, each in values.items()
    }
    return xr.Dataset(
        found,
        coords={
            "patch": ("patch", list(settings.patch), {"units": "m"}),
            "spacing": ("spacing", list(settings.spacing), {"units": "m"}),
            "cycle": np.arange(1, settings.walls.cycles + 1),
        },
    )


def costs(settings: dict[str, SizeSettings]) -> pd.DataFrame:
    """Processor seconds of each spectrum of a rock, from one joint of each size of the first.

    A joint of another spectrum takes in all sizes as much longer as it does at the base's spacing
    and the smallest patch. Columns ``spectrum``, ``joints``, ``seconds``.
    """
    first = next(iter(settings.values()))
    realizations = first.walls.surfaces.realizations
    own = {place: _seconds(first, place) for place in [(0, 0), *joints_of(first)]}
    count = {place: positions_of(first, place[0]) * realizations for place in own}
    seconds = sum(own[place] * count[place] for place in own)
    small = (0, first.spacing.index(first.base))
    rows = []
    for name, each in settings.items():
        times = 1.0 if each is first else _seconds(each, small) / own[small]
        rows.append({"spectrum": name, "joints": sum(count.values()), "seconds": times * seconds})
    return pd.DataFrame(rows)


def _seconds(settings: SizeSettings, place: tuple[int, int]) -> float:
    """Processor time [s] of the first patch of a size and spacing."""
    return _closed(settings, next(nested_walls(settings)), (*place, 0))[0]["seconds"]

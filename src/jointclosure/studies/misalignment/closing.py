"""Walls out of alignment, closed and read."""

import time
from collections.abc import Callable

import numpy as np
import xarray as xr

from jointclosure.ensemble.responses import cycle_responses
from jointclosure.ensemble.surfaces import seeds_of
from jointclosure.ensemble.wavelengths import wavelength_coordinate
from jointclosure.studies.misalignment.design import MisalignedSettings
from jointclosure.surface.misalignment import rotated_pair, tilted
from jointclosure.surface.roughness import z2_of_jrc
from jointclosure.surface.synthesis import spectrum_of

RESPONSES = {
    "closure": ("m", "maximum closure, from the cycle's start"),
    "closure_seated_net": ("m", "net closure since seating"),
    "residual_seated_net": ("m", "net residual closure at seating"),
    "stiffness_net": (
        "Pa/m",
        "net normal stiffness of loading from half of the maximum stress to the landing on it",
    ),
}
"""Unit and name of what is read of each cycle (`jointclosure.ensemble.responses`)."""


def walls_at(
    settings: MisalignedSettings, seed: int, tilt: float, rotation: float
) -> tuple[np.ndarray, np.ndarray]:
    """Upper and lower wall (y, x) [m] of a seed, the one tilted, the other rotated [degrees]."""
    told = settings.closures.surfaces
    grid, surface = told.grid, told.surface
    wavelength = settings.mismatch_wavelength
    upper, lower = rotated_pair(
        z2_of_jrc(told.jrc, grid.spacing, surface.hurst, surface.jrc_relation),
        grid.shape,
        grid.spacing,
        spectrum_of(surface.hurst, surface.rule, surface.roll_off, grid.spacing),
        seed,
        np.inf if wavelength is None else wavelength,
        rotation,
    )
    return tilted(upper, grid.spacing, tilt), lower


def close_misaligned(
    settings: MisalignedSettings, report: Callable[[str], None] = lambda line: None
) -> xr.Dataset:
    """Close a rock's walls of one mismatch wavelength at every condition.

    Parameters
    ----------
    settings : MisalignedSettings
    report : callable
        Receives a line for each condition.

    Returns
    -------
    Dataset
        `RESPONSES` over (wavelength, condition, realization, cycle), NaN where a simulation
        failed; ``status`` and the processor's ``seconds`` without the cycle. Coordinates
        ``tilt`` and ``rotation`` [degrees] of each condition; independent walls have an infinite
        wavelength.
    """
    seeds, conditions = seeds_of(settings.closures.surfaces), settings.closures.conditions()
    shape = (len(settings.conditions), len(seeds))
    values = {name: np.full((*shape, conditions.cycles), np.nan) for name in RESPONSES}
    status, seconds = np.zeros(shape, np.int16), np.zeros(shape)
    for place, (tilt, rotation) in enumerate(settings.conditions):
        for realization, seed in enumerate(seeds):
            start = time.process_time()
            walls = walls_at(settings, seed, tilt, rotation)
            status[place, realization], found = cycle_responses(walls, conditions)
            seconds[place, realization] = time.process_time() - start
            for name, own in values.items():
                own[place, realization] = found[name]
        report(
            f"tilt {tilt:g}, rotation {rotation:g} degrees: {seconds[place].mean():.2f} s a "
            f"simulation, statuses {np.unique(status[place]).tolist()}"
        )
    return _labelled(settings, values, status, seconds)


def _labelled(settings: MisalignedSettings, values: dict, status, seconds) -> xr.Dataset:
    """Readings with their coordinates and units."""
    over = ("wavelength", "condition", "realization")
    tilts, rotations = zip(*settings.conditions, strict=True)
    found: dict = {
        name: (
            (*over, "cycle"),
            own[np.newaxis],
            dict(zip(("units", "long_name"), RESPONSES[name], strict=True)),
        )
        for name, own in values.items()
    }
    found["status"] = (over, status[np.newaxis])
    found["seconds"] = (over, seconds[np.newaxis], {"units": "s"})
    return xr.Dataset(
        found,
        coords={
            "wavelength": wavelength_coordinate(settings.mismatch_wavelength),
            "tilt": ("condition", list(tilts), {"units": "degree"}),
            "rotation": ("condition", list(rotations), {"units": "degree"}),
            "cycle": np.arange(1, settings.closures.cycles + 1),
        },
        attrs={"max_normal_stress_Pa": settings.closures.case.max_normal_stress},
    )

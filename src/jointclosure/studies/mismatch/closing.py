"""Joints between mates and independent walls, closed and read as engineers read them.

Each job closes the walls of one rock and one mismatch wavelength at all shifts of the design.
Without a shift all wavelengths have the same upper walls but for their scale; a shift makes
others, as a longer field is drawn for it.
"""

import time
from collections.abc import Callable

import numpy as np
import xarray as xr

from jointclosure.config.typed import Configuration
from jointclosure.engineering.curves import hysteresis, seat_of
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.responses import responses_of
from jointclosure.ensemble.settings import ClosureSettings, Conditions
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.ensemble.wavelengths import labelled_wavelengths, wavelength_coordinate
from jointclosure.inputs import InputError
from jointclosure.protocol import FAILURE, LOADING

READ = {
    "closure": ("m", "largest closure of the cycle, from its start"),
    "closure_seated_net": ("m", "net closure since seating"),
    "residual_seated_net": ("m", "net residual closure at seating"),
    "stiffness_net": (
        "Pa/m",
        "net normal stiffness of loading from half of the maximum stress to the landing on it",
    ),
    "aperture_at_seating": ("m", "mean aperture at seating"),
    "hysteresis": ("1", "share of the work of loading that unloading does not give back"),
}
"""Unit and name of what is read of each cycle (`jointclosure.ensemble.responses`)."""


def labels_of(configuration: Configuration) -> dict[str, float | None]:
    """Mismatch wavelengths [m] of a study's jobs by label; None for independent walls, the last.

    Raises
    ------
    InputError
        The study has no ``mismatch``.
    """
    if configuration.mismatch is None:
        raise InputError("mismatch = null: the study is none of mismatch (config/mismatch.yaml)")
    return labelled_wavelengths(configuration.mismatch.wavelength)


def settings_of(
    configuration: Configuration, rock: str, wavelength: float | None
) -> list[ClosureSettings]:
    """Settings of a rock's closures at a mismatch wavelength [m], one for each shift.

    Independent walls (None) are not shifted.
    """
    design, study = configuration.mismatch, configuration.study
    assert design is not None  # `labels_of` was asked for the wavelengths
    case = base_case(rock, configuration.rocks[rock])
    found = []
    for shift in (0,) if wavelength is None else design.shift_in_cells:
        surface = configuration.surface._replace(
            mismatch_wavelength=wavelength, shift_in_cells=shift
        )
        surfaces = surface_settings(
            configuration._replace(surface=surface), case, range(study.realizations)
        )
        found.append(closure_settings(configuration, case, surfaces))
    return found


def close_mismatched(
    settings: list[ClosureSettings],
    report: Callable[[str], None] = lambda line: None,
) -> xr.Dataset:
    """Close the walls of one mismatch wavelength at its shifts.

    Parameters
    ----------
    settings : list of ClosureSettings
        As from `settings_of`.
    report : callable
        Receives a line for each shift.

    Returns
    -------
    Dataset
        Over (wavelength, shift, realization, cycle): what `READ` says;
        ``initial_aperture`` (mean aperture at first touch) and ``status`` without the cycle, and
        the processor's ``seconds``. NaN where a simulation failed.
    """
    first = settings[0]
    shape = (len(settings), first.surfaces.realizations)
    values = {name: np.full((*shape, first.cycles), np.nan) for name in READ}
    alone = {name: np.full(shape, np.nan) for name in ("initial_aperture", "seconds")}
    status = np.zeros(shape, np.int16)
    for row, told in enumerate(settings):
        for realization, (upper, lower) in enumerate(walls_of(told.surfaces)):
            at = row, realization
            together = upper + lower
            alone["initial_aperture"][at] = float((together.max() - together).mean())
            start = time.process_time()
            closed = close_walls(upper, lower, told.conditions())
            alone["seconds"][at] = time.process_time() - start
            status[at] = closed.status
            if closed.status < FAILURE:
                found = _read(closed, told.conditions())
                for name in READ:
                    values[name][at] = found[name]
        report(
            f"shift {told.surfaces.surface.shift_in_cells} cells: "
            f"{alone['seconds'][row].mean():.2f} s a simulation, "
            f"statuses {np.unique(status[row]).tolist()}"
        )
    return _labelled(values, alone, status, settings)


def _read(closed: xr.Dataset, conditions: Conditions) -> dict[str, np.ndarray]:
    """Read `READ` of a history, over its cycles [SI]."""
    cycles = range(1, conditions.cycles + 1)
    aperture = np.array([seat_of(closed, each, LOADING, "mean_aperture") for each in cycles])
    more = {"aperture_at_seating": aperture, "hysteresis": hysteresis(closed)}
    return responses_of(closed, conditions) | more


def _labelled(
    values: dict, alone: dict, status: np.ndarray, settings: list[ClosureSettings]
) -> xr.Dataset:
    """Readings with their coordinates and units."""
    told = settings[0]
    shifts = [each.surfaces.surface.shift_in_cells for each in settings]
    over = ("wavelength", "shift", "realization")
    found: dict = {
        name: (
            (*over, "cycle"),
            values[name][np.newaxis],
            {"units": unit, "long_name": text},
        )
        for name, (unit, text) in READ.items()
    }
    for name, unit in (("initial_aperture", "m"), ("seconds", "s")):
        found[name] = (over, alone[name][np.newaxis], {"units": unit})
    found["status"] = (over, status[np.newaxis])
    spacing = told.surfaces.grid.spacing
    return xr.Dataset(
        found,
        coords={
            "wavelength": wavelength_coordinate(told.surfaces.surface.mismatch_wavelength),
            "shift": ("shift", [spacing * shift for shift in shifts], {"units": "m"}),
            "cycle": np.arange(1, told.cycles + 1),
        },
        attrs={"max_normal_stress_Pa": told.case.max_normal_stress},
    )

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
from jointclosure.engineering.curves import cycle_table, hysteresis
from jointclosure.engineering.stiffness import secant_stiffness
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.ensemble.wavelengths import labelled_wavelengths, wavelength_coordinate
from jointclosure.history import GROSS
from jointclosure.inputs import InputError
from jointclosure.protocol import FAILURE

READ = {
    "max_closure": ("max_closure_gross_mm", "m", "largest closure of the cycle, from its start"),
    "closure_since_seating": ("closure_gross_since_seating_mm", "m", "the same since seating"),
    "residual_closure": ("residual_gross_at_seating_mm", "m", "what stays at the seating stress"),
    "aperture_at_seating": ("mean_aperture_at_seating_mm", "m", "mean aperture at seating"),
}
"""What is read of `cycle_table`: its column, unit and name."""
READ_ALONG = {
    "hysteresis": ("1", "share of the work of loading that unloading does not give back"),
    "closure_above_half": (
        "m",
        "half of the maximum stress over the normal stiffness of loading there",
    ),
}


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
        Over (wavelength, shift, realization, cycle): what `READ` and `READ_ALONG` say;
        ``initial_aperture`` (mean aperture at first touch) and ``status`` without the cycle, and
        the processor's ``seconds``. NaN where a simulation failed.
    """
    first = settings[0]
    shape = (len(settings), first.surfaces.realizations)
    values = {name: np.full((*shape, first.cycles), np.nan) for name in (*READ, *READ_ALONG)}
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
                for name, reading in _read(closed).items():
                    values[name][at] = reading
        report(
            f"shift {told.surfaces.surface.shift_in_cells} cells: "
            f"{alone['seconds'][row].mean():.2f} s a simulation, "
            f"statuses {np.unique(status[row]).tolist()}"
        )
    return _labelled(values, alone, status, settings)


def _read(closed: xr.Dataset) -> dict[str, np.ndarray]:
    """What is read of a history, over its cycles [SI]."""
    table = cycle_table(closed)
    found = {name: 1e-3 * table[column].to_numpy() for name, (column, *_) in READ.items()}
    largest = float(closed.normal_stress.max())
    stiffness = [
        secant_stiffness(closed, cycle, 0.5 * largest, largest, GROSS) for cycle in table.cycle
    ]
    above = 0.5 * largest / np.array(stiffness)
    return found | {"hysteresis": hysteresis(closed), "closure_above_half": above}


def _labelled(
    values: dict, alone: dict, status: np.ndarray, settings: list[ClosureSettings]
) -> xr.Dataset:
    """Readings with their coordinates and units."""
    told = settings[0]
    shifts = [each.surfaces.surface.shift_in_cells for each in settings]
    over = ("wavelength", "shift", "realization")
    about = {name: (unit, text) for name, (_, unit, text) in READ.items()} | READ_ALONG
    found: dict = {
        name: (
            (*over, "cycle"),
            values[name][np.newaxis],
            {"units": unit, "long_name": text},
        )
        for name, (unit, text) in about.items()
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

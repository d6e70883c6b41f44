"""Mated, natural and non-mated walls: what mismatch and shift do to a joint.

Without a shift all mismatch wavelengths have the same upper walls but for their scale; a shift
makes others, as a longer field is drawn for it. Walls that are shifted behave as independent ones
from the shift on at which the mean closure since seating of the first cycle is no more than a
declared share below theirs.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import scipy

from jointclosure.config.configuration import Configured
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.points import Point
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.wavelengths import labelled_wavelengths
from jointclosure.experiments import Design, Experiment, Tables
from jointclosure.joint.protocol import FAILURE
from jointclosure.plotting.mismatch import mismatch_figure
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.ratios import harmonic_mean, ratio_of_means
from jointclosure.statistics.standard_errors import mean_of

MEANS = {
    "closure": ("max_closure_gross_mm", 1e3),
    "closure_seated_net": ("closure_net_since_seating_mm", 1e3),
    "residual_seated_net": ("residual_net_at_seating_mm", 1e3),
    "hysteresis": ("hysteresis", 1.0),
    "aperture_at_seating": ("aperture_at_seating_mm", 1e3),
}
"""Columns of the table that are means over surfaces, and their scale."""
CLOSURE = "closure_seated_net"
"""Of the first cycle: what walls are compared by."""
CONFIDENCE = 0.95
RESAMPLES = 2000


def mismatch_design(configured: Configured) -> Design:
    """A job for each rock and mismatch wavelength: all shifts, of independent walls none."""
    configuration = configured.typed
    design, study = configuration.mismatch, configuration.study
    assert design is not None  # the section is there
    jobs = {}
    for rock, of_rock in configuration.rocks.items():
        case = base_case(rock, of_rock)
        for label, wavelength in labelled_wavelengths(design.wavelength).items():
            points = []
            for shift in (0,) if wavelength is None else design.shift_in_cells:
                surface = configuration.surface._replace(
                    mismatch_wavelength=wavelength, shift_in_cells=shift
                )
                surfaces = surface_settings(
                    configuration._replace(surface=surface), case, range(study.realizations)
                )
                at = {
                    "rock": rock,
                    "wavelength": np.inf if wavelength is None else wavelength,
                    "shift": configuration.grid.spacing * shift,
                }
                points.append(Point(at, closure_settings(configuration, case, surfaces)))
            jobs[f"{rock}.{label}"] = points
    parameters = {"tolerance": design.tolerance, "root_seed": study.root_seed}
    return Design(jobs, ("mismatch", "mismatch_shifts"), ("mismatch",), parameters)


def mismatch_table(joints: pd.DataFrame) -> pd.DataFrame:
    """Means and standard errors over surfaces, for each mismatch wavelength, shift and cycle.

    Parameters
    ----------
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, with the columns ``rock``,
        ``wavelength`` and ``shift`` [m].

    Returns
    -------
    DataFrame
        ``rock``, ``wavelength_mm`` (infinite: independent walls), ``shift_mm``, ``cycle``,
        ``samples`` that were closed, ``MEANS``; ``normal_stiffness_net_MPa_per_mm`` from half of
        the maximum stress to the landing on all of it, and ``residual_share_net`` of the closure
        since seating, both of the mean curve; and each with its ``..._error``.
    """
    return pd.DataFrame(
        {
            "rock": rock,
            "wavelength_mm": 1e3 * wavelength,
            "shift_mm": 1e3 * shift,
            "cycle": cycle,
            "samples": int((part.status < FAILURE).sum()),
        }
        | _row(part[part.status < FAILURE])
        for (rock, wavelength, shift, cycle), part in joints.groupby(
            ["rock", "wavelength", "shift", "cycle"], sort=False
        )
    )


def _row(part: pd.DataFrame) -> dict[str, float]:
    """Means of one condition and cycle, and what is made of them.

    A joint that is too stiff for its steps may lack a reading, and is left out of its mean.
    """
    row = {}
    for name, (column, scale) in MEANS.items():
        values = part[name].values
        known = values[np.isfinite(values)]
        row[column] = scale * (float(known.mean()) if known.size else np.nan)
        row[f"{column}_error"] = scale * _error(known)
    for name, (value, error) in {
        "normal_stiffness_net_MPa_per_mm": harmonic_mean(1e-9 * part.stiffness_net.values),
        "residual_share_net": ratio_of_means(part.residual_seated_net.values, part[CLOSURE].values),
    }.items():
        row |= {name: value, f"{name}_error": error}
    return row


def _error(values: np.ndarray) -> float:
    """Standard error of a mean; NaN of a single value."""
    return mean_of(values).standard_error if values.size > 1 else np.nan


def independence_table(joints: pd.DataFrame, tolerance: float, root_seed: int) -> pd.DataFrame:
    """The shift from which on walls behave as independent ones, for each mismatch wavelength.

    Parameters
    ----------
    joints : DataFrame
        As for `mismatch_table`.
    tolerance : float
        Share by which the mean closure may be below that of independent walls.
    root_seed : int
        Of the study, for the resamples.

    Returns
    -------
    DataFrame
        ``rock``, ``wavelength_mm``, ``shift_mm`` with the ends ``low`` and ``high`` of a 95 %
        interval (bootstrap over surfaces), infinite where no shift of the design is enough; and
        ``apertures``: that shift over the mean aperture of independent walls at seating.

    Notes
    -----
    Means over shifts are their isotonic regression (closure does not fall with the shift), with
    straight lines between.
    """
    rows = []
    first = joints[joints.cycle == joints.cycle.min()]
    for rock, run in first.groupby("rock", sort=False):
        independent = np.isinf(run.wavelength)
        aperture = float(run.aperture_at_seating[independent].mean())
        _, (free, *_) = _closures(run[independent])
        for wavelength, part in run[~independent].groupby("wavelength"):
            shifts, samples = _closures(part)
            random = generator(seed_of(root_seed, "mismatch", rock, f"{wavelength:.9g}"))
            drawn = [
                _reached(
                    shifts,
                    *(_resampled(each, random).mean() for each in (free, *samples)),
                    tolerance=tolerance,
                )
                for _ in range(RESAMPLES)
            ]
            found = _reached(
                shifts, free.mean(), *(each.mean() for each in samples), tolerance=tolerance
            )
            tail = 0.5 - 0.5 * CONFIDENCE
            low, high = np.quantile(drawn, [tail, 1.0 - tail], method="nearest")
            rows.append(
                {
                    "rock": rock,
                    "wavelength_mm": 1e3 * wavelength,
                    "shift_mm": 1e3 * found,
                    "low": 1e3 * low,
                    "high": 1e3 * high,
                    "apertures": found / aperture,
                }
            )
    return pd.DataFrame(rows)


def _closures(joints: pd.DataFrame) -> tuple[np.ndarray, list[np.ndarray]]:
    """Shifts of which there are closures, and those of the surfaces for each."""
    known = joints[np.isfinite(joints[CLOSURE])].groupby("shift")[CLOSURE]
    return np.array(list(known.groups)), [values.to_numpy() for _, values in known]


def _resampled(values: np.ndarray, random: np.random.Generator) -> np.ndarray:
    return values[random.integers(values.size, size=values.size)]


def _reached(shifts: np.ndarray, free: float, *means: float, tolerance: float) -> float:
    """The shift at which rising means come up to a share of those of independent walls."""
    fitted = scipy.optimize.isotonic_regression(np.array(means)).x
    level = (1.0 - tolerance) * free
    enough = np.flatnonzero(fitted >= level)
    if not enough.size:
        return np.inf
    after = int(enough[0])
    if after == 0:
        return float(shifts[0])
    part = (level - fitted[after - 1]) / (fitted[after] - fitted[after - 1])
    return float(shifts[after - 1] + part * (shifts[after] - shifts[after - 1]))


def mismatch_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Tables by name."""
    return {
        "mismatch": mismatch_table(joints),
        "mismatch_shifts": independence_table(joints, **parameters),
    }


EXPERIMENT = Experiment(
    title="what mismatch and a shift of the walls do",
    quantities=(*MEANS, "stiffness_net", "initial_aperture"),
    design=mismatch_design,
    tabulate=mismatch_tables,
    draw=lambda name, tables, parameters: mismatch_figure(tables[name]),
)

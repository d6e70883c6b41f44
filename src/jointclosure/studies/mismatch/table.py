"""What mismatch and shift do to a joint: means over surfaces, and the shift that makes it another.

Walls that are shifted behave as independent ones from the shift on at which the mean closure
since seating of the first cycle is no more than a declared share below theirs.
"""

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.protocol import FAILURE
from jointclosure.randomness import generator, seed_of
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


def mismatch_table(runs: dict[str, xr.Dataset]) -> pd.DataFrame:
    """Means and standard errors over surfaces, for each mismatch wavelength, shift and cycle.

    Parameters
    ----------
    runs : dict
        By rock, datasets over (wavelength, shift, realization, cycle) as of
        `jointclosure.studies.mismatch.closing.close_mismatched`.

    Returns
    -------
    DataFrame
        ``rock``, ``wavelength_mm`` (infinite: independent walls), ``shift_mm``, ``cycle``,
        ``samples`` that were closed, ``MEANS``; ``normal_stiffness_net_MPa_per_mm`` from half of
        the maximum stress to the landing on all of it, and ``residual_share_net`` of the closure
        since seating, both of the mean curve; and each with its ``..._error``.
    """
    rows = []
    for rock, run in runs.items():
        for wavelength, shift in _conditions(run):
            part = run.sel(wavelength=wavelength, shift=shift)
            part = part.isel(realization=np.flatnonzero(part.status < FAILURE))
            for cycle in part.cycle.values.tolist():
                rows.append(
                    {
                        "rock": rock,
                        "wavelength_mm": 1e3 * wavelength,
                        "shift_mm": 1e3 * shift,
                        "cycle": cycle,
                        "samples": part.sizes["realization"],
                    }
                    | _row(part.sel(cycle=cycle))
                )
    return pd.DataFrame(rows)


def _conditions(run: xr.Dataset) -> list[tuple[float, float]]:
    """Wavelengths and shifts [m] that were closed: independent walls at one shift only."""
    closed = np.isfinite(run.initial_aperture).any("realization")
    return [
        (float(wavelength), float(shift))
        for wavelength in run.wavelength.values
        for shift in run["shift"].values
        if bool(closed.sel(wavelength=wavelength, shift=shift))
    ]


def _row(part: xr.Dataset) -> dict[str, float]:
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


def independence_table(
    runs: dict[str, xr.Dataset], tolerance: float, root_seed: int
) -> pd.DataFrame:
    """The shift from which on walls behave as independent ones, for each mismatch wavelength.

    Parameters
    ----------
    runs : dict
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
    for rock, run in runs.items():
        first = run[CLOSURE].sel(cycle=run.cycle[0])
        aperture = float(run.aperture_at_seating.isel(cycle=0).sel(wavelength=np.inf).mean())
        _, (free, *_) = _closures(first.sel(wavelength=np.inf))
        for wavelength in run.wavelength.values[np.isfinite(run.wavelength.values)]:
            shifts, samples = _closures(first.sel(wavelength=wavelength))
            random = generator(seed_of(root_seed, "mismatch", rock, f"{wavelength:.9g}"))
            drawn = [
                _reached(
                    shifts,
                    *(_resampled(part, random).mean() for part in (free, *samples)),
                    tolerance=tolerance,
                )
                for _ in range(RESAMPLES)
            ]
            found = _reached(
                shifts, free.mean(), *(part.mean() for part in samples), tolerance=tolerance
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


def _closures(closure: xr.DataArray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Shifts of which there are closures, and those of the surfaces for each."""
    columns = [column[np.isfinite(column)] for column in closure.transpose("shift", ...).values]
    there = np.array([column.size > 0 for column in columns])
    return closure["shift"].values[there], [column for column in columns if column.size]


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

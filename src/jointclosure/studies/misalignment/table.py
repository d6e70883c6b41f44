"""What a tilt and a rotation change, on the same surfaces."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.statistics.ratios import harmonic_mean, ratio_of_means

READ = {
    "closure": "maximum closure (mm)",
    "closure_seated_net": "net closure since seating (mm)",
    "residual_seated_net": "net residual closure at seating (mm)",
    "stiffness_net": "net normal stiffness (MPa/mm)",
}
"""Names and units of the ``response`` column."""


def misalignment_table(runs: dict[str, xr.Dataset]) -> pd.DataFrame:
    """Means over surfaces, and their changes from aligned walls, at every condition.

    Parameters
    ----------
    runs : dict
        By rock, datasets over (wavelength, condition, realization, cycle) as of
        `jointclosure.studies.misalignment.closing.close_misaligned`.

    Returns
    -------
    DataFrame
        ``rock``, ``wavelength_mm`` (infinite: independent walls), ``tilt_degrees``,
        ``rotation_degrees``, ``cycle``, ``response`` (of `READ`), ``value`` with its ``error``;
        ``change_percent`` of the mean from that of aligned walls with its paired
        ``change_error``; ``samples`` of both. The residual closure is that of the first cycle.

    Notes
    -----
    The mean stiffness is the harmonic one, that of the mean curve.
    """
    return pd.DataFrame([row for rock, run in runs.items() for row in _rows(rock, run)])


def _rows(rock: str, run: xr.Dataset) -> Iterator[dict]:
    aligned = int(np.flatnonzero((run.tilt == 0.0) & (run.rotation == 0.0))[0])
    for wavelength in run.wavelength.values.tolist():
        for condition in range(run.sizes["condition"]):
            for cycle in run.cycle.values.tolist():
                part = run.sel(wavelength=wavelength, cycle=cycle)
                about = {
                    "rock": rock,
                    "wavelength_mm": 1e3 * wavelength,
                    "tilt_degrees": float(run.tilt[condition]),
                    "rotation_degrees": float(run.rotation[condition]),
                    "cycle": cycle,
                }
                for response in READ:
                    if response == "residual_seated_net" and cycle > 1:
                        continue
                    own, before = (part[response].values[place] for place in (condition, aligned))
                    yield about | {"response": response} | _row(response, own, before)


def _row(response: str, own: np.ndarray, before: np.ndarray) -> dict:
    both = np.isfinite(own) & np.isfinite(before)
    own, before = own[both], before[both]
    if response == "stiffness_net":
        mean = harmonic_mean(1e-9 * own)
        ratio = ratio_of_means(1.0 / before, 1.0 / own)
    else:
        mean = ratio_of_means(1e3 * own, np.ones(own.size))
        ratio = ratio_of_means(own, before)
    return {
        "value": mean.value,
        "error": mean.standard_error,
        "change_percent": 100.0 * (ratio.value - 1.0),
        "change_error": 100.0 * ratio.standard_error,
        "samples": int(both.sum()),
    }

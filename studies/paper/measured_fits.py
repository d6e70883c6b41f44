"""Realisations of a study that fit measured closure curves best."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.measured.curves import MeasuredCurve
from studies.frame.tables import since_seating, succeeded

FIT_COLUMNS = (
    "rock", "cycle", "points", "largest_closure_mm", "samples",
    "best_realization", "misfit_mm", "misfit_percent", "median_misfit_mm",
)  # fmt: skip
_READ = (
    *("closure", "bulk_indentation", "status"),
    *("max_closure_net", "max_closure_seated_net", "residual_closure"),
)


def fit_table(
    study: xr.Dataset, curves: dict[str, MeasuredCurve], seating_stress: float
) -> pd.DataFrame:
    """Tabulate the best-fitting realisation of each rock, for each measured cycle and for all."""
    rows = []
    for rock, curve in curves.items():
        case = np.flatnonzero((study.rock == rock).values & (study.parameter == "base").values)[0]
        base = study[list(_READ)].isel(case=int(case)).load()
        squares, largest = {}, {}
        for cycle in curve.cycles:
            branches = list(curve.since_seating(cycle, seating_stress))
            squares[cycle] = _squares(base, cycle, branches)
            largest[cycle] = max(closure.max() for _, _, closure in branches if closure.size)
        rows += [_fit(rock, cycle, squares[cycle], largest[cycle], base) for cycle in squares]
        if len(squares) > 1:
            together = np.concatenate(list(squares.values()), axis=1)
            rows.append(_fit(rock, "all", together, max(largest.values()), base))
    return pd.DataFrame(rows, columns=FIT_COLUMNS)


def _squares(base: xr.Dataset, cycle: int, branches: list) -> np.ndarray:
    """Compute squared differences (realization, points) [m2]; NaN where a realisation failed."""
    good, columns = succeeded(base).values, []
    for branch, stress, closure in branches:
        model = since_seating(base).sel(cycle=cycle, branch=branch)
        modelled = np.array([_at(model.stress.values, row, stress) for row in model.values])
        columns.append(np.square(modelled - closure).reshape(good.size, stress.size))
    return np.where(good[:, np.newaxis], np.concatenate(columns, axis=1), np.nan)


def _at(axis: np.ndarray, closure: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Return the closure at stresses, by a monotone cubic through the reached points."""
    reached = np.isfinite(closure)
    if reached.sum() < 2:
        return np.full(stress.shape, np.nan)
    cubic = scipy.interpolate.PchipInterpolator(axis[reached], closure[reached], extrapolate=False)
    return cubic(stress)


def _fit(rock: str, cycle, squares: np.ndarray, largest: float, base: xr.Dataset) -> dict:
    rms = 1e3 * np.sqrt(squares.mean(axis=1))
    usable = np.isfinite(rms)
    row = {"rock": rock, "cycle": str(cycle), "points": squares.shape[1]}
    row |= {"largest_closure_mm": 1e3 * largest, "samples": int(usable.sum())}
    if not usable.any():
        return row
    best = int(np.nanargmin(rms))
    return row | {
        "best_realization": int(base.realization.values[best]),
        "misfit_mm": rms[best],
        "misfit_percent": 100.0 * rms[best] / (1e3 * largest) if largest > 0.0 else np.nan,
        "median_misfit_mm": float(np.median(rms[usable])),
    }


def best_fits(table: pd.DataFrame, rock: str) -> Iterator[tuple[int, int, float, float]]:
    """Generate (cycle, realisation, misfit [mm], misfit [%]) of each fitted cycle of a rock."""
    part = table[(table.rock == rock) & (table.cycle.astype(str) != "all")]
    for row in part[part.best_realization.notna()].itertuples():
        yield int(row.cycle), int(row.best_realization), row.misfit_mm, row.misfit_percent

"""Elasticities and indifference intervals along the closure curve, from seating to the maximum.

They show whether the conclusions depend on the selected stress, the paper's limits (iii) and (v).
The closure of a cycle at a stress is that of its loading branch, from the start of the cycle, like
the maximum closure; the last point is the maximum closure itself.
"""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.findings import TARGET
from jointclosure.sensitivity.intervals import UNPAIRED
from jointclosure.sensitivity.responses import RockSample, rock_sample, rocks_of, sensitivities
from jointclosure.statistics.drawn_studies import Design, DrawnResponse, draw_studies
from jointclosure.statistics.predictive import length_distribution
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import elasticity, rounded, variation_of

POINTS = 10
"""Number of stresses for each rock, evenly spaced among those of the stored curves."""
COLUMNS = (
    "rock", "parameter", "cycle", "stress_MPa", "samples", "elasticity",
    "elasticity_standard_error", "elasticity_shown", "variation", "variation_standard_error",
    "percent_median", "percent_low_90", "percent_high_90", "share_without_root",
    "test",
)  # fmt: skip


def along_curve(
    ensemble: xr.Dataset,
    seating_stress: float,
    design: Design,
    repetitions: int,
    root_seed: int,
) -> pd.DataFrame:
    """Compute elasticity, scatter and published lengths at stresses of the closure curves.

    Parameters
    ----------
    ensemble : Dataset
        The pool, or the study itself if it has none.
    seating_stress : float
        Smallest stress [Pa].
    design : Design
        Design of a study with independent draws.

    Returns
    -------
    DataFrame
        By rock, parameter, cycle and stress: elasticity and S/mean (``variation``) with standard
        errors; median, 5 and 95 % quantiles of the published length in percent of the rock's
        value, infinite for no root, by the ``test``.
    """
    rows = []
    for rock in rocks_of(ensemble):
        stresses, sample = _curve_sample(ensemble, rock, seating_stress)
        if not sample.levels or sample.values.shape[-1] < 2:
            continue
        random = generator(seed_of(root_seed, "along the curve", rock))
        drawn = draw_studies(sensitivities([sample]), design, repetitions, random)
        for parameter in sample.levels:
            rows += _rows(sample, parameter, stresses, drawn[rock, parameter])
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    order = ["rock", "parameter", "cycle"]
    places = table.assign(**{name: pd.factorize(table[name])[0] for name in order})
    return table.loc[places.sort_values([*order, "stress_MPa"]).index].reset_index(drop=True)


def _rows(
    sample: RockSample, parameter: str, stresses: list[float], drawn: DrawnResponse
) -> list[dict]:
    rows = []
    levels = sample.levels[parameter]
    for i, (name, cycle) in enumerate(sample.names):
        values = sample.values[i, levels.cases]
        row = {"rock": sample.rock, "parameter": parameter, "cycle": cycle}
        row |= {"stress_MPa": 1e-6 * stresses[int(name)], "samples": values.shape[1]}
        if levels.base != 0.0:
            estimate = elasticity(levels.values, values, levels.base, sample.paired)
            row["elasticity"], row["elasticity_standard_error"] = estimate
            row["elasticity_shown"] = rounded(*estimate)
            lengths = length_distribution(100.0 * drawn.lengths[:, i] / abs(levels.base))
            row |= {"percent_median": lengths.median, "percent_low_90": lengths.low_90}
            row |= {"percent_high_90": lengths.high_90}
            row |= {"share_without_root": lengths.share_without_root, "test": UNPAIRED}
        at_base = values[levels.values == levels.base][0]
        row["variation"], row["variation_standard_error"] = variation_of(at_base)
        rows.append(row)
    return rows


def _curve_sample(
    ensemble: xr.Dataset, rock: str, seating_stress: float
) -> tuple[list[float], RockSample]:
    """Return stresses [Pa], and closures of a rock's cases at them as variables by index."""
    of_rock = (ensemble.rock == rock).values
    largest = float(ensemble.max_normal_stress.values[of_rock][0])
    axis = ensemble.stress.values
    between = np.flatnonzero((axis > 0.0) & (axis >= seating_stress) & (axis < largest))
    if between.size > POINTS - 1:
        places = np.linspace(0, between.size - 1, POINTS - 1).round().astype(int)
        between = between[np.unique(places)]
    start = ensemble.residual_closure.shift(cycle=1, fill_value=0.0)
    loading = ensemble.closure.sel(branch="loading").isel(stress=between)
    variables = {str(i): loading.isel(stress=i, drop=True) - start for i in range(between.size)} | {
        str(between.size): ensemble[TARGET]
    }
    return [*axis[between].tolist(), largest], rock_sample(ensemble, rock, variables)

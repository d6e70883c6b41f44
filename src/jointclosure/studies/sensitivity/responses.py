"""From a study's dataset to correlations and indifference intervals."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.properties import PARAMETERS, PROPERTIES
from jointclosure.config.typed import Statistics
from jointclosure.ensemble.aggregation import succeeded
from jointclosure.randomness import generator, seed_of
from jointclosure.statistics.bootstrap import bootstrap_length
from jointclosure.statistics.correlations import fit_quadratic, lack_of_fit
from jointclosure.statistics.indifference import indifference_interval

_ROW = ("rock", "parameter", "cycle", "unit", "base", "samples")
_CORRELATION = ("rock", "parameter", "unit", "cycle", "samples", "b", "c", "d", "b_s", "c_s", "d_s")
_CORRELATION += ("lack_of_fit_p",)
_FOUND = (
    "length",
    "percent",
    "root",
    "extrapolated",
    "status",
    "length_low",
    "length_high",
    "share_without_root",
    "linear_length",
)
"""Columns of an interval, with the suffix ``_net`` those net of bulk indentation."""


class Response(NamedTuple):
    """A target (level, realization) [m] against one parameter of one rock, in SI.

    Realisations that failed at any level are left out at all levels, so that
    every level has the same surfaces.
    """

    rock: str
    parameter: str
    cycle: int
    base: float
    levels: np.ndarray
    samples: np.ndarray

    @property
    def means(self) -> np.ndarray:
        return self.samples.mean(axis=1)

    @property
    def deviations(self) -> np.ndarray:
        return self.samples.std(axis=1, ddof=1)


def responses(study: xr.Dataset, target: str) -> Iterator[Response]:
    """All responses of a target (a variable over case, realization, cycle)."""
    good = succeeded(study).values
    rocks = list(dict.fromkeys(study.rock.values.tolist()))
    for rock in rocks:
        base_case = (study.rock == rock).values & (study.parameter == "base").values
        for parameter in PARAMETERS:
            varied = (study.rock == rock).values & (study.parameter == parameter).values
            if not varied.any():
                continue
            index = np.flatnonzero(base_case | varied)
            values = study[parameter].values[index]
            index = index[np.argsort(values)]
            kept = good[index].all(axis=0)
            for cycle in study.cycle.values.tolist():
                samples = study[target].sel(cycle=cycle).values[index][:, kept]
                yield Response(
                    rock,
                    parameter,
                    int(cycle),
                    float(study[parameter].values[base_case][0]),
                    np.sort(values),
                    samples,
                )


def max_closure_table(study: xr.Dataset) -> pd.DataFrame:
    """Mean, standard deviation and n of the maximum closures, per case and cycle."""
    good = succeeded(study)
    rows = []
    for i, case in enumerate(study.case.values):
        for cycle in study.cycle.values.tolist():
            row = {
                "case": case,
                "rock": study.rock.values[i],
                "parameter": study.parameter.values[i],
                "level": study.level.values[i],
                "cycle": cycle,
                "samples": int(good[i].sum()),
            }
            for target in (
                "max_closure",
                "max_closure_net",
                "max_closure_seated",
                "max_closure_seated_net",
                "residual_closure",
            ):
                values = study[target].sel(cycle=cycle).values[i][good.values[i]]
                row[f"{target}_mean_mm"] = 1e3 * values.mean() if values.size else np.nan
                row[f"{target}_standard_deviation_mm"] = (
                    1e3 * values.std(ddof=1) if values.size > 1 else np.nan
                )
            rows.append(row)
    return pd.DataFrame(rows)


def correlation_table(study: xr.Dataset) -> pd.DataFrame:
    """Coefficients of Eqs. (24) and (26): closures in mm, parameters as in Table 1."""
    rows = []
    for response in responses(study, "max_closure"):
        if response.samples.shape[1] < 2:
            continue
        unit, size = PROPERTIES[response.parameter].unit, PROPERTIES[response.parameter].size
        levels = response.levels / size
        mean = fit_quadratic(levels, 1e3 * response.means, response.base / size)
        deviation = fit_quadratic(levels, 1e3 * response.deviations, response.base / size)
        n = response.samples.shape[1]
        rows.append(
            {
                "rock": response.rock,
                "parameter": response.parameter,
                "unit": unit,
                "cycle": response.cycle,
                "samples": n,
                **dict(zip(("b", "c", "d"), mean.in_parameter(), strict=True)),
                **dict(zip(("b_s", "c_s", "d_s"), deviation.in_parameter(), strict=True)),
                "lack_of_fit_p": lack_of_fit(
                    levels, 1e3 * response.means, 1e3 * response.deviations, n, mean
                ),
            }
        )
    return pd.DataFrame(rows, columns=_CORRELATION)


def indifference_table(study: xr.Dataset, statistics: Statistics, root_seed: int, paired: bool):
    """Indifference intervals of all rocks, parameters and cycles, as a frame.

    Parameters
    ----------
    study : Dataset
        As from `jointclosure.ensemble.aggregation.join_cases`.
    statistics : Statistics
    root_seed : int
        Of the study; the bootstrap has a stream of its own.
    paired : bool
        Whether realisations are the same surfaces at all levels.
    """
    rows = []
    for gross, net in zip(
        responses(study, "max_closure"), responses(study, "max_closure_net"), strict=True
    ):
        unit, size = PROPERTIES[gross.parameter].unit, PROPERTIES[gross.parameter].size
        row = {
            "rock": gross.rock,
            "parameter": gross.parameter,
            "cycle": gross.cycle,
            "unit": unit,
            "base": gross.base / size,
            "samples": gross.samples.shape[1],
        }
        if gross.samples.shape[1] < 2:
            rows.append(row | {"status": "too few successful realisations"})
            continue
        for suffix, response in (("", gross), ("_net", net)):
            row |= _interval(response, size, statistics, root_seed, paired, suffix)
        rows.append(row)
    columns = [*_ROW, *(f"{name}{suffix}" for suffix in ("", "_net") for name in _FOUND)]
    return pd.DataFrame(rows, columns=columns)


def _interval(response, size, statistics, root_seed, paired, suffix) -> dict:
    samples = response.samples
    n = samples.shape[1]
    found = indifference_interval(
        response.levels,
        response.means,
        response.deviations,
        n,
        statistics.significance,
        response.base,
    )
    name = ("bootstrap", response.rock, response.parameter, response.cycle, suffix)
    interval = bootstrap_length(
        response.levels,
        samples,
        generator(seed_of(root_seed, *name)),
        base=response.base,
        resamples=statistics.bootstrap_resamples,
        confidence=statistics.bootstrap_confidence,
        significance=statistics.significance,
        paired=paired,
    )
    mean = fit_quadratic(response.levels, response.means, response.base)
    slope = mean.c / mean.half_range
    deviation = fit_quadratic(response.levels, response.deviations, response.base).d
    linear = found.critical_value * np.sqrt(2.0 / n) * deviation / abs(slope) if slope else np.inf
    status = "interval"
    if np.isnan(found.length):
        status = "no real root"
    elif found.negative_deviation:
        status = "fitted deviation is negative at the root"
    elif found.extrapolated:
        status = "extrapolated"
    return {
        f"length{suffix}": found.length / size,
        f"percent{suffix}": 100.0 * found.length / response.base,
        f"root{suffix}": found.root / size,
        f"extrapolated{suffix}": found.extrapolated,
        f"status{suffix}": status,
        f"length_low{suffix}": interval.low / size,
        f"length_high{suffix}": interval.high / size,
        f"share_without_root{suffix}": interval.share_without_root,
        f"linear_length{suffix}": linear / size,
    }

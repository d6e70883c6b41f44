"""Table 3 of a study: its indifference intervals, by the t test for its draws.

For independent draws this is the unpaired test of Eqs. (28) and (29), as published. With common
draws the same surfaces are closed at every level. Contributions equal at all levels then cancel in
the differences between levels; the paired test uses this, the unpaired one does not.
"""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.bootstrap import bootstrap_length, bootstrap_paired_length
from jointclosure.statistics.control_variates import adjusted_length
from jointclosure.statistics.correlations import fit_quadratic
from jointclosure.statistics.indifference import IndifferenceInterval, indifference_interval
from jointclosure.statistics.paired import (
    PairedInterval,
    p_of_difference,
    paired_indifference_interval,
)
from jointclosure.statistics.randomness import generator, seed_of
from studies.frame.config.typed import Statistics
from studies.frame.ensemble.covariates import Covariates
from studies.paper.claims.findings import NET, TARGET
from studies.paper.responses import Response, responses

PAIRED, UNPAIRED = "paired", "unpaired"

_ROW = ("rock", "parameter", "cycle", "unit", "base", "samples", "test")
_FOUND = (
    "length",
    "percent",
    "root",
    "extrapolated",
    "status",
    "length_low",
    "length_high",
    "standard_error",
    "share_without_root",
    "linear_length",
    "unpaired_length",
    "unpaired_percent",
)
"""Columns of an interval; those with the suffix ``_net`` are net of bulk indentation."""
_ENDS = ("p_of_ends", "unpaired_p_of_ends")
_ADJUSTED = tuple(
    f"adjusted_{name}" for name in ("length", "percent", "low", "high", "standard_error")
)


class _Tested(NamedTuple):
    """Interval by one of the tests [SI]."""

    length: float
    root: float
    extrapolated: bool
    status: str
    linear_length: float


def indifference_table(
    study: xr.Dataset,
    statistics: Statistics,
    root_seed: int,
    covariates: Covariates | None = None,
) -> pd.DataFrame:
    """Tabulate the indifference intervals of all rocks, parameters and cycles.

    Parameters
    ----------
    study : Dataset
        As from `jointclosure.engine.aggregation.join_cases`; its seeds show whether a
        realisation is the same surface in all cases of a rock.
    root_seed : int
        Root seed of the study; the bootstrap has a separate stream.
    covariates : Covariates, optional
        Covariates of the study.

    Returns
    -------
    DataFrame
        ``test`` is "paired" or "unpaired"; ``length`` and related columns are by this test, and
        ``unpaired_length`` by the published test for any draws. ``p_of_ends`` is the p value of the
        difference between the lowest and the highest level, by both tests.
        ``adjusted_length`` is by the published test for independent draws, from means and
        deviations adjusted by the covariates; NaN without covariates.
    """
    rows = []
    both = (responses(study, target, covariates) for target in (TARGET, NET))
    for gross, net in zip(*both, strict=True):
        unit = PROPERTIES[gross.parameter]
        row = {
            "rock": gross.rock,
            "parameter": gross.parameter,
            "cycle": gross.cycle,
            "unit": unit.unit,
            "base": gross.base / unit.size,
            "samples": gross.samples.shape[1],
            "test": PAIRED if gross.paired else UNPAIRED,
        }
        if gross.samples.shape[1] < 2:
            rows.append(row | {"status": "too few successful realisations"})
            continue
        for suffix, response in (("", gross), ("_net", net)):
            row |= _interval(response, unit.size, statistics, root_seed, suffix)
        ends = gross.samples[0], gross.samples[-1]
        row["p_of_ends"] = p_of_difference(*ends, paired=gross.paired)
        row["unpaired_p_of_ends"] = p_of_difference(*ends, paired=False)
        row |= _adjusted(gross, unit.size, statistics, root_seed)
        rows.append(row)
    columns = [*_ROW, *(f"{name}{suffix}" for suffix in ("", "_net") for name in _FOUND), *_ENDS]
    columns += _ADJUSTED
    return pd.DataFrame(rows, columns=columns)


def _interval(
    response: Response, size: float, statistics: Statistics, root_seed: int, suffix: str
) -> dict:
    unpaired = _tested(response, statistics.significance, False)
    interval = _tested(response, statistics.significance, True) if response.paired else unpaired
    resampled = _bootstrap(response, statistics, root_seed, suffix)
    row = {
        "length": interval.length / size,
        "percent": 100.0 * interval.length / response.base,
        "root": interval.root / size,
        "extrapolated": interval.extrapolated,
        "status": interval.status,
        "length_low": resampled.low / size,
        "length_high": resampled.high / size,
        "standard_error": resampled.standard_error / size,
        "share_without_root": resampled.share_without_root,
        "linear_length": interval.linear_length / size,
        "unpaired_length": unpaired.length / size,
        "unpaired_percent": 100.0 * unpaired.length / response.base,
    }
    return {f"{name}{suffix}": value for name, value in row.items()}


def _bootstrap(response: Response, statistics: Statistics, root_seed: int, suffix: str):
    """Compute the bootstrap interval of the length by the table's test."""
    name = ("bootstrap", response.rock, response.parameter, response.cycle, suffix)
    settings: dict[str, Any] = {
        "base": response.base,
        "resamples": statistics.bootstrap_resamples,
        "confidence": statistics.bootstrap_confidence,
        "significance": statistics.significance,
    }
    arguments = (response.levels, response.samples, generator(seed_of(root_seed, *name)))
    bootstrap = bootstrap_paired_length if response.paired else bootstrap_length
    return bootstrap(*arguments, **settings)


def _adjusted(response: Response, size: float, statistics: Statistics, root_seed: int) -> dict:
    """Compute the interval from adjusted means and deviations."""
    if response.covariates is None or response.paired:
        return {}
    values, known, tell_scatter = response.covariates
    name = ("adjusted", response.rock, response.parameter, response.cycle)
    interval = adjusted_length(
        response.levels,
        response.samples,
        values,
        known,
        generator(seed_of(root_seed, *name)),
        base=response.base,
        draws=statistics.bootstrap_resamples,
        confidence=statistics.bootstrap_confidence,
        significance=statistics.significance,
        tell_scatter=tell_scatter,
    )
    return {
        "adjusted_length": interval.length / size,
        "adjusted_percent": 100.0 * interval.length / response.base,
        "adjusted_low": interval.scatter.low / size,
        "adjusted_high": interval.scatter.high / size,
        "adjusted_standard_error": interval.scatter.standard_error / size,
    }


def _tested(response: Response, significance: float, paired: bool) -> _Tested:
    """Compute the interval by the paired or the unpaired test."""
    levels, samples, base = response.levels, response.samples, response.base
    interval: PairedInterval | IndifferenceInterval
    if paired:
        interval = paired_indifference_interval(levels, samples, significance, base)
        linear = interval.linear_length
    else:
        interval = indifference_interval(
            levels, response.means, response.deviations, samples.shape[1], significance, base
        )
        linear = _linear_length(response, interval)
    status = "interval"
    if np.isnan(interval.length):
        status = "no real root"
    elif getattr(interval, "negative_deviation", False):
        status = "fitted deviation is negative at the root"
    elif interval.extrapolated:
        status = "extrapolated"
    return _Tested(interval.length, interval.root, interval.extrapolated, status, linear)


def _linear_length(response: Response, interval: IndifferenceInterval) -> float:
    """Return t sqrt(2/n) S/|slope|: the length if mean and deviation are straight lines."""
    mean = fit_quadratic(response.levels, response.means, response.base)
    deviation = fit_quadratic(response.levels, response.deviations, response.base).d
    slope, n = mean.c / mean.half_range, response.samples.shape[1]
    return interval.critical_value * np.sqrt(2.0 / n) * deviation / abs(slope) if slope else np.inf

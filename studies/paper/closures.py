"""Tables of closures: means and scatter of every case, correlations, elasticities, with errors."""

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.aggregation import succeeded
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.bootstrap import bootstrap_length
from jointclosure.statistics.control_variates import (
    adjusted_deviations,
    adjusted_length,
    adjusted_means,
)
from jointclosure.statistics.correlations import fit_quadratic, lack_of_fit, paired_lack_of_fit
from jointclosure.statistics.indifference import IndifferenceInterval
from jointclosure.statistics.paired import PairedInterval, p_of_difference
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import (
    Estimate,
    deviation_covariance,
    deviation_of,
    elasticity,
    elasticity_of,
    mean_covariance,
    mean_of,
    quadratic_errors,
    rounded,
    variation_of,
)
from studies.frame.config.sections import Statistics
from studies.frame.ensemble.covariates import Covariates
from studies.paper.claims import NET, TARGET
from studies.paper.responses import Response, adjustment, responses

CLOSURES = (
    TARGET,
    NET,
    "max_closure_seated",
    "max_closure_seated_net",
    "residual_closure",
    "residual_closure_seated_net",
)
_MM = 1e3
_OF_MEAN, _OF_DEVIATION = ("b", "c", "d"), ("b_s", "c_s", "d_s")
_COEFFICIENTS = (*_OF_MEAN, *_OF_DEVIATION)
_CORRELATION: tuple[str, ...] = ("rock", "parameter", "unit", "cycle", "samples", *_COEFFICIENTS)
_CORRELATION += tuple(f"{name}_standard_error" for name in _COEFFICIENTS)
_CORRELATION += ("lack_of_fit_p",)
_UNKNOWN = Estimate(np.nan, np.nan)
_WHAT = ("", "_standard_error", "_shown")
_SUFFIXES = ("", "_net", "_adjusted")


def max_closure_table(study: xr.Dataset, covariates: Covariates | None = None) -> pd.DataFrame:
    """Tabulate mean, standard deviation and n of maximum closures by case and cycle, with errors.

    ``max_closure_shown`` is the mean rounded to its standard error [mm]; ``variation`` is S/mean of
    the maximum closure. Columns with ``adjusted`` are adjusted by the study's covariates, NaN
    without covariates.
    """
    good = succeeded(study).values
    rows = []
    for i, case in enumerate(study.case.values):
        about = {name: study[name].values[i] for name in ("rock", "parameter", "level")}
        for cycle in study.cycle.values.tolist():
            row = {"case": case} | about | {"cycle": cycle, "samples": int(good[i].sum())}
            for target in CLOSURES:
                values = _MM * study[target].sel(cycle=cycle).values[i][good[i]]
                row |= _scatter(target, values)
                if target == TARGET:
                    chosen = np.ix_(np.array([i]), np.flatnonzero(good[i]))
                    row |= _adjusted(values, adjustment(covariates, chosen, int(cycle)))
            shown = (row[f"{TARGET}_mean_mm"], row[f"{TARGET}_mean_mm_standard_error"])
            rows.append(row | {"max_closure_shown": rounded(*shown)})
    return pd.DataFrame(rows)


def _scatter(target: str, values: np.ndarray) -> dict[str, float]:
    """Return mean and standard deviation [mm] of a target, and their standard errors."""
    several = values.size > 1
    mean = Estimate(values.mean() if values.size else np.nan, np.nan)
    row = _columns(f"{target}_mean_mm", mean_of(values) if several else mean)
    deviation = deviation_of(values) if several else _UNKNOWN
    row |= _columns(f"{target}_standard_deviation_mm", deviation)
    if target == TARGET:
        varies = several and mean.value != 0.0
        row |= _columns("variation", variation_of(values) if varies else _UNKNOWN)
    return row


def _adjusted(values: np.ndarray, covariates: Covariates | None) -> dict[str, float]:
    """Return adjusted mean and standard deviation [mm] of maximum closure, with standard errors."""
    mean = deviation = _UNKNOWN
    if covariates is not None:
        of_surfaces, known, tell_scatter = covariates
        mean = adjusted_means(values[None], of_surfaces, known, paired=False).estimate(0)
        both = adjusted_deviations(values, of_surfaces[0], known, tell_scatter)
        deviation = Estimate(*map(float, both))
    return _columns(f"{TARGET}_adjusted_mean_mm", mean) | _columns(
        f"{TARGET}_adjusted_standard_deviation_mm", deviation
    )


def _columns(name: str, estimate: Estimate) -> dict[str, float]:
    return {name: estimate.value, f"{name}_standard_error": estimate.standard_error}


def correlation_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate coefficients of Eqs. (24) and (26) with standard errors.

    Closures are in mm, parameters in the units of Table 1. With more than three levels
    ``lack_of_fit_p`` tests the quadratic.
    """
    rows = []
    for response in responses(study, TARGET):
        if response.samples.shape[1] < 2:
            continue
        unit = PROPERTIES[response.parameter]
        about: dict[str, object] = {"rock": response.rock, "parameter": response.parameter}
        about |= {"unit": unit.unit}
        about |= {"cycle": response.cycle, "samples": response.samples.shape[1]}
        rows.append(about | _coefficients(response, unit.size))
    return pd.DataFrame(rows, columns=_CORRELATION)


def _coefficients(response: Response, size: float) -> dict:
    levels, base = response.levels / size, response.base / size
    samples, paired = _MM * response.samples, response.paired
    means, deviations = samples.mean(axis=1), samples.std(axis=1, ddof=1)
    row: dict[str, float] = {}
    for names, values, covariance in (
        (_OF_MEAN, means, mean_covariance(samples, paired)),
        (_OF_DEVIATION, deviations, deviation_covariance(samples, paired)),
    ):
        row |= dict(zip(names, fit_quadratic(levels, values, base).in_parameter(), strict=True))
        errors = quadratic_errors(levels, covariance, base).in_parameter
        row |= {f"{name}_standard_error": e for name, e in zip(names, errors, strict=True)}
    if paired:
        row["lack_of_fit_p"] = paired_lack_of_fit(levels, samples)
    else:
        fit = fit_quadratic(levels, means, base)
        row["lack_of_fit_p"] = lack_of_fit(levels, means, deviations, samples.shape[1], fit)
    return row


def elasticity_table(ensemble: xr.Dataset, covariates: Covariates | None = None) -> pd.DataFrame:
    """Tabulate d ln(mean maximum closure)/d ln(parameter) at each rock's value, with errors.

    There is one row per rock, parameter and cycle, with and without bulk indentation. In a pool the
    surfaces are the same at all levels, and errors are those of differences. Columns with
    ``adjusted`` are adjusted by the ensemble's covariates, NaN without covariates.
    """
    rows = []
    both = (responses(ensemble, target, covariates) for target in (TARGET, NET))
    for gross, net in zip(*both, strict=True):
        row = {"rock": gross.rock, "parameter": gross.parameter, "cycle": gross.cycle}
        row |= {"samples": gross.samples.shape[1], "paired": gross.paired}
        by_suffix = dict.fromkeys(_SUFFIXES, _UNKNOWN)
        for suffix, response in (("", gross), ("_net", net)):
            if response.samples.shape[1] > 1 and response.base != 0.0:
                by_suffix[suffix] = elasticity(
                    response.levels, response.samples, response.base, response.paired
                )
        if gross.covariates is not None and gross.base != 0.0:
            values, known, _ = gross.covariates
            means = adjusted_means(gross.samples, values, known, gross.paired)
            by_suffix["_adjusted"] = elasticity_of(gross.levels, *means, gross.base)
        for suffix, estimate in by_suffix.items():
            row |= _columns(f"elasticity{suffix}", estimate)
            row[f"elasticity{suffix}_shown"] = rounded(*estimate)
        rows.append(row)
    columns = ["rock", "parameter", "cycle", "samples", "paired"]
    columns += [f"elasticity{suffix}{what}" for suffix in _SUFFIXES for what in _WHAT]
    return pd.DataFrame(rows, columns=columns)


PAIRED, UNPAIRED = "paired", "unpaired"

_ROW = ("rock", "parameter", "cycle", "unit", "base", "samples", "test")
_FOUND = ["length", "percent", "root", "extrapolated", "status", "length_low", "length_high"]
_FOUND += ["standard_error", "share_without_root", "linear_length"]
_FOUND += ["unpaired_length", "unpaired_percent"]
"""Columns of an interval; those with the suffix ``_net`` are net of bulk indentation."""
_ENDS = ("p_of_ends", "unpaired_p_of_ends")
_ADJUSTED = tuple(
    f"adjusted_{name}" for name in ("length", "percent", "low", "high", "standard_error")
)


def indifference_table(
    study: xr.Dataset, statistics: Statistics, root_seed: int, covariates: Covariates | None = None
) -> pd.DataFrame:
    """Tabulate the indifference intervals of all rocks, parameters and cycles.

    ``test`` is that of ``length`` and related columns, ``unpaired_length`` is by the published test
    for any draws, ``p_of_ends`` the p value of the difference between the lowest and the highest
    level, and ``adjusted_length`` from means and deviations adjusted by the covariates.
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
        row |= _adjusted_interval(gross, unit.size, statistics, root_seed)
        rows.append(row)
    columns = [*_ROW, *(f"{name}{suffix}" for suffix in ("", "_net") for name in _FOUND), *_ENDS]
    columns += _ADJUSTED
    return pd.DataFrame(rows, columns=columns)


def _interval(
    response: Response, size: float, statistics: Statistics, root_seed: int, suffix: str
) -> dict:
    """Return the columns of an interval by the table's test, and by the unpaired test."""
    unpaired = _tested(response._replace(paired=False), size, statistics.significance)
    row = _tested(response, size, statistics.significance) if response.paired else unpaired
    resampled = _bootstrap(response, statistics, root_seed, suffix)
    row = row | {
        "length_low": resampled.low / size,
        "length_high": resampled.high / size,
        "standard_error": resampled.standard_error / size,
        "share_without_root": resampled.share_without_root,
        "unpaired_length": unpaired["length"],
        "unpaired_percent": unpaired["percent"],
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
        "paired": response.paired,
    }
    random = generator(seed_of(root_seed, *name))
    return bootstrap_length(response.levels, response.samples, random, **settings)


def _adjusted_interval(
    response: Response, size: float, statistics: Statistics, root_seed: int
) -> dict:
    """Compute the interval from adjusted means and deviations."""
    if response.covariates is None or response.paired:
        return {}
    values, known, tell_scatter = response.covariates
    name = ("adjusted", response.rock, response.parameter, response.cycle)
    length, scatter = adjusted_length(
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
        "adjusted_length": length / size,
        "adjusted_percent": 100.0 * length / response.base,
        "adjusted_low": scatter.low / size,
        "adjusted_high": scatter.high / size,
        "adjusted_standard_error": scatter.standard_error / size,
    }


def _tested(response: Response, size: float, significance: float) -> dict:
    """Compute the interval by the response's test, in units of ``size``."""
    interval = response.interval(significance)
    status = "interval"
    if np.isnan(interval.length):
        status = "no real root"
    elif getattr(interval, "negative_deviation", False):
        status = "fitted deviation is negative at the root"
    elif interval.extrapolated:
        status = "extrapolated"
    return {
        "length": interval.length / size,
        "percent": 100.0 * interval.length / response.base,
        "root": interval.root / size,
        "extrapolated": interval.extrapolated,
        "status": status,
        "linear_length": _linear_length(response, interval) / size,
    }


def _linear_length(response: Response, interval: PairedInterval | IndifferenceInterval) -> float:
    """Return t sqrt(2/n) S/|slope|: the length if mean and deviation are straight lines."""
    if isinstance(interval, PairedInterval):
        return interval.linear_length
    mean = fit_quadratic(response.levels, response.means, response.base)
    deviation = fit_quadratic(response.levels, response.deviations, response.base).d
    slope, n = mean.c / mean.half_range, response.samples.shape[1]
    return interval.critical_value * np.sqrt(2.0 / n) * deviation / abs(slope) if slope else np.inf

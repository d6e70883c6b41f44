"""Tables of a study's closures with standard errors: means, scatter, correlations, elasticities,
indifference intervals, and fits to measured curves.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.measured.curves import MeasuredCurve
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics import control_variates, indifference, quadratics
from jointclosure.statistics import standard_errors as errors
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.randomness import generator, seed_of
from studies.frame.joint_tables import since_seating, succeeded
from studies.frame.settings import BASE
from studies.paper.claims import NET, TARGET
from studies.paper.covariates import Covariates, adjustment
from studies.paper.responses import Response, responses, same_surfaces

if TYPE_CHECKING:  # models of the configuration take long to import
    from studies.frame.keys import Statistics

CLOSURES = (
    TARGET,
    NET,
    "max_closure_seated",
    "max_closure_seated_net",
    "residual_closure",
    "residual_closure_seated_net",
)
CHANGE = f"{TARGET}_change_mm"
"""Column of the change of mean closure from the rock's base case, on the same surfaces."""
PAIRED, UNPAIRED = "paired", "unpaired"
_MM = 1e3
_OF_MEAN, _OF_DEVIATION = ("b", "c", "d"), ("b_s", "c_s", "d_s")
_COEFFICIENTS = [*_OF_MEAN, *_OF_DEVIATION]
_UNKNOWN = errors.Estimate(np.nan, np.nan)
_RESPONSE = ["rock", "parameter", "cycle"]


def estimate_columns(name: str, estimate: errors.Estimate, scale: float = 1.0) -> dict[str, float]:
    """Return an estimate and its standard error by the names of their columns, times ``scale``."""
    return {name: scale * estimate.value, f"{name}_standard_error": scale * estimate.standard_error}


def max_closure_table(study: xr.Dataset, covariates: Covariates | None = None) -> pd.DataFrame:
    """Tabulate means and standard deviations [mm] of closures by case and cycle, with errors.

    ``samples`` is the number of joints that succeeded. The mean and the standard deviation of
    maximum closure are also adjusted by the ``covariates``; without these the columns are NaN.
    Cases with the same surfaces as the rock's base case also have the change of the mean from it,
    whose error is that of the differences on the same surface.
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
            if (base := _paired_with(study, i)) is not None:
                both = good[i] & good[base]
                values = _MM * study[TARGET].sel(cycle=cycle).values
                changes = (values[i] - values[base])[both]
                change = errors.mean_of(changes) if changes.size > 1 else _UNKNOWN
                row |= estimate_columns(CHANGE, change)
            shown = (row[f"{TARGET}_mean_mm"], row[f"{TARGET}_mean_mm_standard_error"])
            rows.append(row | {"max_closure_shown": rounded(*shown)})
    return pd.DataFrame(rows)


def _paired_with(study: xr.Dataset, place: int) -> int | None:
    """Return the place of the base case of the rock of the case at ``place``.

    None if the cases of the rock have different surfaces, or if the case itself is the base case.
    """
    rock = str(study.rock.values[place])
    if study.parameter.values[place] == BASE or not same_surfaces(study, rock):
        return None
    return int(np.flatnonzero((study.rock == rock).values & (study.parameter == BASE).values)[0])


def _scatter(target: str, values: np.ndarray) -> dict[str, float]:
    """Return the mean and standard deviation of values (n,) [mm] of a target, by column.

    They have standard errors. Numbers for which there are too few values are NaN. Maximum closure
    has the coefficient of variation too.
    """
    mean = errors.Estimate(np.nan, np.nan)
    deviation = _UNKNOWN
    variation = _UNKNOWN
    if values.size > 1:
        mean = errors.mean_of(values)
        deviation = errors.deviation_of(values)
        variation = errors.variation_of(values) if mean.value != 0.0 else _UNKNOWN
    elif values.size:
        mean = errors.Estimate(values.mean(), np.nan)
    row = estimate_columns(f"{target}_mean_mm", mean)
    row |= estimate_columns(f"{target}_standard_deviation_mm", deviation)
    return row | (estimate_columns("variation", variation) if target == TARGET else {})


def _adjusted(values: np.ndarray, covariates: Covariates | None) -> dict[str, float]:
    """Return the mean and standard deviation [mm] of maximum closure, adjusted by covariates.

    They are by column, with standard errors; NaN without covariates. ``values`` (n,) [mm] are the
    closures.
    """
    mean = deviation = _UNKNOWN
    if covariates is not None:
        of_surfaces, known, tell_scatter = covariates
        mean = control_variates.adjusted_means(
            values[None], of_surfaces, known, paired=False
        ).estimate(0)
        both = control_variates.adjusted_deviations(values, of_surfaces[0], known, tell_scatter)
        deviation = errors.Estimate(*map(float, both))
    row = estimate_columns(f"{TARGET}_adjusted_mean_mm", mean)
    return row | estimate_columns(f"{TARGET}_adjusted_standard_deviation_mm", deviation)


def correlation_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate the coefficients of Eqs. (24) and (26) for each rock, parameter and cycle.

    These are quadratics of the mean (b, c, d) and of the standard deviation (b_s, c_s, d_s) of
    maximum closure [mm] in the parameter, in the units of Table 1. They have standard errors, and
    the probability of a lack of fit of the mean.
    """
    rows = []
    for response in responses(study, TARGET):
        surfaces = response.samples.shape[1]
        unit = PROPERTIES[response.parameter]
        if surfaces < 2:
            continue
        row: dict = {"rock": response.rock, "parameter": response.parameter, "unit": unit.unit}
        row |= {"cycle": response.cycle, "samples": surfaces}
        rows.append(row | _coefficients(response, unit.size))
    columns = ["rock", "parameter", "unit", "cycle", "samples", *_COEFFICIENTS]
    columns += [f"{name}_standard_error" for name in _COEFFICIENTS]
    return pd.DataFrame(rows, columns=[*columns, "lack_of_fit_p"])


def _coefficients(response: Response, size: float) -> dict:
    levels = response.levels / size
    base = response.base / size
    samples = _MM * response.samples
    paired = response.paired
    means = samples.mean(axis=1)
    deviations = samples.std(axis=1, ddof=1)
    row: dict[str, float] = {}
    for names, values, covariance in (
        (_OF_MEAN, means, errors.mean_covariance(samples, paired)),
        (_OF_DEVIATION, deviations, errors.deviation_covariance(samples, paired)),
    ):
        row |= dict(
            zip(names, quadratics.fit_quadratic(levels, values, base).in_parameter(), strict=True)
        )
        in_parameter = quadratics.quadratic_errors(levels, covariance, base).in_parameter
        row |= {f"{name}_standard_error": e for name, e in zip(names, in_parameter, strict=True)}
    if paired:
        return row | {"lack_of_fit_p": quadratics.paired_lack_of_fit(levels, samples)}
    fit = quadratics.fit_quadratic(levels, means, base)
    return row | {
        "lack_of_fit_p": quadratics.lack_of_fit(levels, means, deviations, samples.shape[1], fit)
    }


def _responses(
    ensemble: xr.Dataset, covariates: Covariates | None
) -> Iterator[tuple[dict, Response, Response]]:
    """Generate rock, parameter and cycle, and the responses of gross and of net maximum closure.

    ``covariates`` are those of gross and net closure alike.
    """
    both = (responses(ensemble, target, covariates) for target in (TARGET, NET))
    for gross, net in zip(*both, strict=True):
        yield {name: getattr(gross, name) for name in _RESPONSE}, gross, net


STIFFNESS = "stiffness_net"
"""Name of the net chord stiffness, whose mean over joints is harmonic."""
ELASTIC = {
    "": TARGET,
    "_net": NET,
    "_seated_net": "max_closure_seated_net",
    "_stiffness": STIFFNESS,
}
"""Results of joints for whose means elasticities are tabulated, by the suffix of their columns."""


def elastic_responses(
    ensemble: xr.Dataset, covariates: Covariates | None = None
) -> Iterator[dict[str, Response]]:
    """Generate the responses of all results of `ELASTIC`, by suffix, for each rock and cycle.

    There is one set of responses for each property that is varied.
    Results that the dataset does not have are left out. Samples of the stiffness are compliances,
    as the mean of stiffnesses is harmonic (`elasticity_of_response`). Realisations without a finite
    value are left out. Only gross closure has ``covariates``.
    """
    known = {suffix: name for suffix, name in ELASTIC.items() if name in ensemble}
    if STIFFNESS in ensemble:
        ensemble = ensemble.assign({STIFFNESS: 1.0 / ensemble[STIFFNESS]})
    of_each = (
        responses(ensemble, name, covariates if name == TARGET else None) for name in known.values()
    )
    for found in zip(*of_each, strict=True):
        yield {
            suffix: one._replace(samples=one.samples[:, np.isfinite(one.samples).all(axis=0)])
            for suffix, one in zip(known, found, strict=True)
        }


def elasticity_of_response(response: Response, suffix: str) -> errors.Estimate:
    """Return the elasticity of the mean of one of `elastic_responses`, with its standard error.

    ``suffix`` is that of the result in `ELASTIC`. The elasticity is NaN for fewer than two joints,
    or for a property whose value is 0.
    """
    if response.samples.shape[1] < 2 or response.base == 0.0:
        return _UNKNOWN
    about = response.levels, response.samples, response.base, response.paired
    found = quadratics.elasticity(*about)
    return found._replace(value=-found.value) if ELASTIC[suffix] == STIFFNESS else found


def elasticity_table(ensemble: xr.Dataset, covariates: Covariates | None = None) -> pd.DataFrame:
    """Tabulate d ln(mean)/d ln(parameter) of closures and stiffness at each rock's value.

    The column ``elasticity`` is that of the mean maximum gross closure. With the suffix ``_net`` it
    is that of closure net of bulk indentation, with ``_seated_net`` of net closure since seating,
    with ``_stiffness`` of net chord stiffness, and with ``_adjusted`` of gross closure adjusted by
    ``covariates``. All have standard errors; they are NaN if the dataset does not have the result,
    or without covariates. ``samples`` is the number of joints, ``samples_stiffness`` that of joints
    with a stiffness.
    """
    rows = []
    for of_each in elastic_responses(ensemble, covariates):
        gross = of_each[""]
        row = {name: getattr(gross, name) for name in _RESPONSE}
        row |= {"samples": gross.samples.shape[1], "paired": gross.paired}
        estimates = dict.fromkeys((*ELASTIC, "_adjusted"), _UNKNOWN)
        for suffix, response in of_each.items():
            estimates[suffix] = elasticity_of_response(response, suffix)
        if gross.covariates is not None and gross.base != 0.0:
            values, known, _ = gross.covariates
            means = control_variates.adjusted_means(gross.samples, values, known, gross.paired)
            estimates["_adjusted"] = quadratics.elasticity_of(gross.levels, *means, gross.base)
        for suffix, estimate in estimates.items():
            row |= estimate_columns(f"elasticity{suffix}", estimate)
            row[f"elasticity{suffix}_shown"] = rounded(*estimate)
        if "_stiffness" in of_each:
            row["samples_stiffness"] = of_each["_stiffness"].samples.shape[1]
        rows.append(row)
    columns = [*_RESPONSE, "samples", "paired"]
    for suffix in ("", "_net", "_adjusted", "_seated_net", "_stiffness"):
        name = f"elasticity{suffix}"
        columns += [name, f"{name}_standard_error", f"{name}_shown"]
    return pd.DataFrame(rows, columns=[*columns, "samples_stiffness"])


_INTERVAL = ["length", "percent", "root", "extrapolated", "status", "length_low", "length_high"]
_INTERVAL += ["standard_error", "share_without_root", "linear_length"]
_INTERVAL += ["unpaired_length", "unpaired_percent"]
"""Columns of an indifference interval; with the suffix ``_net`` that of closure net of bulk
indentation."""
_ADJUSTED = [f"adjusted_{name}" for name in ("length", "percent", "low", "high", "standard_error")]


def indifference_table(
    study: xr.Dataset,
    statistics: "Statistics",
    root_seed: int,
    covariates: Covariates | None = None,
) -> pd.DataFrame:
    """Tabulate indifference intervals by the study's t test, and by the unpaired test of the paper.

    The study's test is paired if all cases of a rock have the same surfaces. Lengths are in the
    units of Table 1, for gross and net closure (suffix ``_net``). With ``covariates``, unpaired
    tests of gross closure are also made with adjusted means. ``root_seed`` is that from which the
    random numbers of the bootstrap follow.
    """
    rows = []
    for row, gross, net in _responses(study, covariates):
        unit = PROPERTIES[gross.parameter]
        row |= {"unit": unit.unit, "base": gross.base / unit.size}
        row |= {"samples": gross.samples.shape[1], "test": PAIRED if gross.paired else UNPAIRED}
        if gross.samples.shape[1] < 2:
            rows.append(row | {"status": "too few successful realisations"})
            continue
        for suffix, response in (("", gross), ("_net", net)):
            interval = _interval(response, unit.size, statistics, root_seed, suffix)
            row |= {f"{name}{suffix}": value for name, value in interval.items()}
        ends = gross.samples[0], gross.samples[-1]
        row["p_of_ends"] = indifference.p_of_difference(*ends, paired=gross.paired)
        row["unpaired_p_of_ends"] = indifference.p_of_difference(*ends, paired=False)
        rows.append(row | _adjusted_interval(gross, unit.size, statistics, root_seed))
    columns = [*_RESPONSE, "unit", "base", "samples", "test", *_INTERVAL]
    columns += [*(f"{name}_net" for name in _INTERVAL), "p_of_ends", "unpaired_p_of_ends"]
    return pd.DataFrame(rows, columns=columns + _ADJUSTED)


def _interval(
    response: Response, size: float, statistics: "Statistics", root_seed: int, suffix: str
) -> dict:
    """Return the columns of the interval of a response, in units of ``size``.

    They are those by the response's own test with bootstrap errors, and its length by the unpaired
    test.
    """
    unpaired = _tested(response._replace(paired=False), size, statistics.significance)
    row = _tested(response, size, statistics.significance) if response.paired else unpaired
    name = ("bootstrap", response.rock, response.parameter, response.cycle, suffix)
    resampled = indifference.bootstrap_length(
        response.levels,
        response.samples,
        generator(seed_of(root_seed, *name)),
        paired=response.paired,
        resamples=statistics.bootstrap_resamples,
        **_settings(response, statistics),
    )
    return row | {
        "length_low": resampled.low / size,
        "length_high": resampled.high / size,
        "standard_error": resampled.standard_error / size,
        "share_without_root": resampled.share_without_root,
        "unpaired_length": unpaired["length"],
        "unpaired_percent": unpaired["percent"],
    }


def _settings(response: Response, statistics: "Statistics") -> dict[str, Any]:
    confidence = statistics.bootstrap_confidence
    significance = statistics.significance
    return {"base": response.base, "confidence": confidence, "significance": significance}


def _adjusted_interval(
    response: Response, size: float, statistics: "Statistics", root_seed: int
) -> dict:
    """Return the columns of the interval from means adjusted by covariates, in units of ``size``.

    There are none if the test is paired or there are no covariates.
    """
    if response.covariates is None or response.paired:
        return {}
    values, known, tell_scatter = response.covariates
    name = ("adjusted", response.rock, response.parameter, response.cycle)
    length, scatter = control_variates.adjusted_length(
        response.levels,
        response.samples,
        values,
        known,
        generator(seed_of(root_seed, *name)),
        draws=statistics.bootstrap_resamples,
        tell_scatter=tell_scatter,
        **_settings(response, statistics),
    )
    low, high, _, error = scatter
    numbers = (length / size, response.percent(length))
    return dict(zip(_ADJUSTED, (*numbers, low / size, high / size, error / size), strict=True))


def _tested(response: Response, size: float, significance: float) -> dict:
    """Return the columns of the interval by the response's own test, in units of ``size``."""
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
        "percent": response.percent(interval.length),
        "root": interval.root / size,
        "extrapolated": interval.extrapolated,
        "status": status,
        "linear_length": _linear_length(response, interval) / size,
    }


def _linear_length(
    response: Response, interval: indifference.PairedInterval | indifference.IndifferenceInterval
) -> float:
    """Return the length [SI] that an interval would have for a linear mean: t sqrt(2/n) S/|slope|.

    The standard deviation S is that at the rock's value. For a paired test it is known already; it
    is infinite for a slope of 0.
    """
    if isinstance(interval, indifference.PairedInterval):
        return interval.linear_length
    mean = quadratics.fit_quadratic(response.levels, response.means, response.base)
    deviation = quadratics.fit_quadratic(response.levels, response.deviations, response.base).d
    slope = mean.c / mean.half_range
    n = response.samples.shape[1]
    return interval.critical_value * np.sqrt(2.0 / n) * deviation / abs(slope) if slope else np.inf


FIT_COLUMNS = (
    "rock", "cycle", "measured_points", "points", "largest_closure_mm", "samples",
    "best_realization", "misfit_mm", "misfit_percent", "median_misfit_mm",
)  # fmt: skip
_READ = (
    *("closure", "bulk_indentation", "status"),
    *("max_closure_net", "max_closure_seated_net", "residual_closure"),
)


def fit_table(
    study: xr.Dataset, curves: dict[str, MeasuredCurve], seating_stress: float
) -> pd.DataFrame:
    """Tabulate the realisation that fits the measured curve of each rock best.

    There is a row for each measured cycle, and one for all cycles of a rock together if it has
    several. ``curves`` are by rock; ``seating_stress`` [Pa] is that from which closures count, both
    measured and simulated. Of the ``measured_points`` of the file ``points`` are used: those above
    seating, and of a dense log means of several.
    """
    rows = []
    for rock, curve in curves.items():
        case = np.flatnonzero((study.rock == rock).values & (study.parameter == "base").values)[0]
        base = study[list(_READ)].isel(case=int(case)).load()
        squares = {}
        largest = {}
        for cycle in curve.cycles:
            branches = list(curve.since_seating(cycle, seating_stress))
            squares[cycle] = _squares(base, cycle, branches)
            largest[cycle] = max(closure.max() for _, _, closure in branches if closure.size)
        counts: dict[int | str, int]
        counts = {cycle: int((curve.cycle == cycle).sum()) for cycle in squares}
        of_rock = [
            _best_fit(rock, cycle, squares[cycle], largest[cycle], base) for cycle in squares
        ]
        if len(squares) > 1:
            together = np.concatenate(list(squares.values()), axis=1)
            of_rock.append(_best_fit(rock, "all", together, max(largest.values()), base))
            counts["all"] = sum(counts.values())
        number = zip(of_rock, counts.values(), strict=True)
        rows += [row | {"measured_points": count} for row, count in number]
    return pd.DataFrame(rows, columns=FIT_COLUMNS)


def fit_lines(table: pd.DataFrame) -> list[str]:
    """Describe how many points of measured curves are used, and the best fits, of `fit_table`."""
    lines = []
    for row in table.itertuples():
        cycle = "all cycles" if row.cycle == "all" else f"cycle {row.cycle}"
        points = f"{row.points} of {row.measured_points} measured points are used"
        fit = "no joint reaches all of their stresses"
        if np.isfinite(row.best_realization):
            fit = f"of {row.samples} joints number {row.best_realization:.0f} fits best"
            fit += f" (rms misfit {row.misfit_mm:.2g} mm)"
        lines.append(f"{row.rock}, {cycle}: {points} (those above seating; points of a dense log "
                     f"are averaged); {fit}")  # fmt: skip
    return lines


def _squares(base: xr.Dataset, cycle: int, branches: list) -> np.ndarray:
    """Return the squared differences (realization, points) [m2] to the points of a measured cycle.

    ``base`` are the joints of the base case, ``branches`` the measured (branch, stress, closure).
    They are NaN for realisations that failed, and at stresses that a realisation does not reach.
    """
    good = succeeded(base).values
    columns = []
    for branch, stress, closure in branches:
        model = since_seating(base).sel(cycle=cycle, branch=branch)
        modelled = np.array([_at(model.stress.values, row, stress) for row in model.values])
        columns.append(np.square(modelled - closure).reshape(good.size, stress.size))
    return np.where(good[:, np.newaxis], np.concatenate(columns, axis=1), np.nan)


def _at(axis: np.ndarray, closure: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Return closures (m,) of a curve at stresses (m,), by a monotone cubic.

    ``axis`` and ``closure`` (n,) are those of the curve; closures beyond its finite points are NaN.
    """
    reached = np.isfinite(closure)
    if reached.sum() < 2:
        return np.full(stress.shape, np.nan)
    cubic = scipy.interpolate.PchipInterpolator(axis[reached], closure[reached], extrapolate=False)
    return cubic(stress)


def _best_fit(rock: str, cycle, squares: np.ndarray, largest: float, base: xr.Dataset) -> dict:
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
    """Generate (cycle, realisation, misfit [mm], misfit [%]) of the best fits of a rock.

    ``table`` is that of `fit_table`. There is one for each cycle that has a fit.
    """
    part = table[(table.rock == rock) & (table.cycle.astype(str) != "all")]
    for row in part[part.best_realization.notna()].itertuples():
        yield int(row.cycle), int(row.best_realization), row.misfit_mm, row.misfit_percent

"""Requested accuracy of a study: results by two levels, and the number of joints that they need.

The first level is the result of n surfaces by the numerics of the study. The second is its
difference to the result of the finest numerics, on the first k of these surfaces. Their sum
(multilevel Monte Carlo, M. B. Giles, Acta Numerica 24, 2015, 259) has only the bias of the finest
numerics, and its error needs no measured tables of numerical errors.
"""

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.assessment.assessed_results import ASSESSED, JUDGED
from jointclosure.ensembles.quantities import QUANTITIES, shown_unit
from jointclosure.inputs import InputError
from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.statistics.two_level import (
    FEWEST_DIFFERENCES,
    Interval,
    best_plan,
    combined,
    two_level_mean,
)
from studies.frame.cases import BLOCK, FEW
from studies.frame.joint_tables import succeeded
from studies.frame.keys import Accuracy
from studies.paper.claims import TARGET
from studies.paper.responses import Response, responses

QUANTITIES_OF = {"mean": JUDGED, "stiffness": ("stiffness_net",)}
"""Quantities whose means must be accurate, by the word of the request (`Accuracy.of`)."""


class Counts(NamedTuple):
    """Numbers of surfaces of each case that are simulated."""

    surfaces: int  # simulated with the numerics of the study
    differences: int  # of these, also simulated with the finest numerics


START = Counts(BLOCK, FEWEST_DIFFERENCES)
"""Numbers of surfaces with which `make study` starts."""


class TwoLevelEstimate(NamedTuple):
    """Result by two levels with its 95 % interval, and the scatter from which this follows."""

    interval: Interval  # with the result
    study: float  # result of the study's numerics alone
    half_width: float  # of the interval, over the result; infinite if not known
    deviations: tuple[float, float]  # of one surface and of one difference, over the result
    finest: float  # standard deviation of one surface by the finest numerics, over the result


def reached_table(
    study: xr.Dataset, finest: xr.Dataset, accuracy: Accuracy, significance: float
) -> pd.DataFrame:
    """Tabulate each requested result by two levels, its 95 % interval, and the counts it needs.

    ``study`` and ``finest`` are the ensembles with the numerics of the study and the finest ones.
    ``study_value`` is the result of the study's numerics alone. ``met`` is whether the request is
    reached. ``least_percent`` is the half-width if `Accuracy.most` surfaces were simulated with
    both numerics. Core minutes are the processor time of one more surface, or one more difference,
    of all cases.
    """
    costs = [part.timing_simulation.mean("realization").values for part in (study, finest)]
    reach = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, accuracy.most - 1) / math.sqrt(accuracy.most)
    rows = []
    for about, counts, cases, estimate in (
        _intervals(study, finest, significance)
        if accuracy.of == "interval"
        else _means(study, finest, QUANTITIES_OF[accuracy.of])
    ):
        seconds = float(costs[0][cases].mean()), float(costs[1][cases].mean())
        needed = math.inf, math.inf
        if math.isfinite(estimate.half_width):
            plan = best_plan(estimate.deviations, seconds, accuracy.within)
            needed = (plan.joints, plan.differences) if plan else needed
        met = estimate.half_width <= accuracy.within and counts.differences >= FEWEST_DIFFERENCES
        rows.append(
            about
            | counts._asdict()
            | estimate.interval._asdict()
            | {"study_value": estimate.study, "half_width_percent": 100.0 * estimate.half_width}
            | {"within_percent": 100.0 * accuracy.within, "met": met}
            | dict(zip(("surfaces_needed", "differences_needed"), needed, strict=True))
            | {"least_percent": 100.0 * reach * estimate.finest}
            | {"surface_core_minutes": float(costs[0].sum()) / 60.0}
            | {"difference_core_minutes": float(costs[1].sum()) / 60.0}
        )
    return pd.DataFrame(rows)


def _means(study: xr.Dataset, finest: xr.Dataset, names: tuple[str, ...]) -> Iterator[tuple]:
    """Generate the estimates of the mean of each quantity ``names``, for each case and cycle.

    Each is (coordinates, `Counts`, place of the case in a list, `TwoLevelEstimate`), in the unit of
    tables. Surfaces that failed are left out. Means of stiffnesses are harmonic.
    """
    pairs = finest.sizes["realization"]
    good = succeeded(study).values
    fine_good = succeeded(finest).values
    for i in range(study.sizes["case"]):
        about = {key: study[key].values[i] for key in ("rock", "parameter", "level")}
        for cycle, name in itertools.product(study.cycle.values.tolist(), names):
            quantity = QUANTITIES[name]
            unit, scale = shown_unit(quantity.unit)
            cheap, fine = (part[name].sel(cycle=cycle).values[i] for part in (study, finest))
            alone = good[i] & np.isfinite(cheap)
            both = alone[:pairs] & fine_good[i] & np.isfinite(fine)
            alone[:pairs] &= ~both
            cheap = np.concatenate([cheap[:pairs][both], cheap[alone]])
            fine = fine[both]
            at = about | {"cycle": cycle, "quantity": name, "unit": unit}
            estimate = (
                _mean(1.0 / cheap, 1.0 / fine) if quantity.has_harmonic_mean else _mean(cheap, fine)
            )
            low, high = sorted(
                _in_shown_unit(end, scale, quantity.has_harmonic_mean) for end in estimate[0][1:]
            )
            value, own = (
                _in_shown_unit(x, scale, quantity.has_harmonic_mean)
                for x in (estimate[0].value, estimate.study)
            )
            shown = estimate._replace(interval=Interval(value, low, high), study=own)
            yield at, Counts(cheap.size, fine.size), [i], shown


def _in_shown_unit(value: float, scale: float, harmonic: bool) -> float:
    """Return a mean [SI], given as its reciprocal if harmonic, times the ``scale`` of tables."""
    return scale / value if harmonic else scale * value


def _mean(cheap: np.ndarray, fine: np.ndarray) -> TwoLevelEstimate:
    """Return the estimate of a mean by two levels, see `two_level_mean`.

    ``cheap`` (n,) are values by the numerics of the study, ``fine`` (k,) those of the first k
    surfaces by the finest numerics. With fewer than two of these nothing is known.
    """
    if fine.size < 2:
        return _UNKNOWN
    differences = fine - cheap[: fine.size]
    mean = two_level_mean(cheap, differences)
    size = abs(mean.value)
    spread = [float(np.std(values, ddof=1)) / size for values in (cheap, differences, fine)]
    half = 0.5 * (mean.high - mean.low) / size
    return TwoLevelEstimate(mean, float(cheap.mean()), half, (spread[0], spread[1]), spread[2])


_UNKNOWN = TwoLevelEstimate(
    Interval(*[math.nan] * 3), math.nan, math.inf, (math.inf, math.inf), math.inf
)


def _intervals(study: xr.Dataset, finest: xr.Dataset, significance: float) -> Iterator[tuple]:
    """Generate the estimates of the length of each indifference interval of maximum closure.

    Each is (coordinates, `Counts`, mask of the rock's cases, `TwoLevelEstimate`); lengths are in
    percent of the rock's value. To first order the logarithm of a length is a sum of contributions
    of the surfaces, which a jackknife gives. The second level is the difference of the logarithms
    of the lengths by both numerics, on the surfaces that were simulated with both; the t test for
    both is that of the number of all surfaces.
    """
    pairs = finest.sizes["realization"]
    both = (succeeded(study).values[:, :pairs] & succeeded(finest).values).all(axis=0)
    kept = np.concatenate([both, np.ones(study.sizes["realization"] - pairs, dtype=bool)])
    study = study.isel(realization=kept)
    finest = finest.isel(realization=both)
    for cheap, fine in zip(responses(study, TARGET), responses(finest, TARGET), strict=True):
        n = cheap.samples.shape[1]
        k = fine.samples.shape[1]
        scale = cheap.percent(1.0)
        estimate = _UNKNOWN
        if k > 2:
            pair = cheap._replace(samples=cheap.samples[:, :k])
            whole, own = _log_length(cheap, significance, n)
            (refined, changed), (same, unchanged) = (
                _log_length(part, significance, n) for part in (fine, pair)
            )
            log = combined(whole + refined - same, [*zip(own, changed - unchanged, strict=True)])
            if math.isfinite(log.low):
                estimate = TwoLevelEstimate(
                    Interval(*(scale * math.exp(end) for end in log)),
                    scale * math.exp(whole),
                    log.high - log.value,
                    (_spread(own), _spread(changed - unchanged)),
                    _spread(changed),
                )
        about = {
            "rock": cheap.rock,
            "parameter": cheap.parameter,
            "level": None,
            "cycle": cheap.cycle,
        }
        about |= {"quantity": "indifference_interval", "unit": "%"}
        yield about, Counts(n, k), (study.rock == cheap.rock).values, estimate


def _log_length(response: Response, significance: float, surfaces: int) -> tuple[float, np.ndarray]:
    """Return the logarithm of the length of an interval, and contributions (groups, n) of surfaces.

    The logarithm is NaN if there is no interval. ``surfaces`` is the number of surfaces in the t
    test. Groups are the levels; if the test is paired there is a single group.
    """
    samples = response.samples
    n = response.samples.shape[1]
    if response.paired:
        drawn = [samples, *(np.delete(samples, i, axis=1) for i in range(n))]
        parts = (response._replace(samples=part) for part in drawn)
        lengths = np.array([part.interval(significance, surfaces).length for part in parts])
    else:
        departures = samples - response.means[:, None]
        squares = (departures**2).sum(axis=1, keepdims=True) - departures**2 * n / (n - 1)
        without = np.sqrt(np.maximum(squares, 0.0) / (n - 2))
        means, deviations = (
            np.tile(values, (n * values.size + 1, 1))
            for values in (response.means, response.deviations)
        )
        for level in range(response.levels.size):
            place = 1 + level * n + np.arange(n)
            means[place, level] = response.means[level] - departures[level] / (n - 1)
            deviations[place, level] = without[level]
        lengths = indifference_lengths(
            response.levels, means, deviations, surfaces, significance, response.base
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(lengths)
    return float(logs[0]), (n - 1) / n * (logs[0] - logs[1:]).reshape(-1, n)


def _spread(contributions: np.ndarray) -> float:
    """Return the standard deviation of one surface from contributions (groups, n) to a mean."""
    n = contributions.shape[1]
    return n * math.sqrt(float(contributions.var(axis=1, ddof=1).sum()))


def start_counts(price: pd.DataFrame, accuracy: Accuracy) -> Counts:
    """Return the numbers of surfaces to start with: `START`, or fewer if the budget is small.

    ``price`` has the columns ``ensemble`` ("cases", "finest"), ``cases`` (their number) and
    ``seconds`` (of a joint).

    Raises
    ------
    InputError
        If the budget does not suffice for two surfaces and two differences.
    """
    joints = price.groupby("ensemble").seconds.max()
    minutes = (price.cases * price.seconds).groupby(price.ensemble).sum() / 60.0
    counts = START
    budget = accuracy.budget_core_minutes
    while budget is not None and _core_minutes(counts, minutes.cases, minutes.finest) > budget:
        if counts == Counts(2, 2):
            least = _core_minutes(counts, minutes.cases, minutes.finest)
            raise InputError(
                f"study.accuracy.budget_core_minutes = {budget:g}: must be at least {least:.2g}, "
                f"for 2 surfaces of all {price.cases.sum() // 2} cases; a joint takes up to "
                f"{joints.cases:.2g} s by the study's numerics and {joints.finest:.2g} s by the "
                "finest"
            )
        counts = Counts(*(max(2, count // 2) for count in counts))
    return counts


def _core_minutes(counts: Counts, surface: float, difference: float) -> float:
    return counts.surfaces * surface + counts.differences * difference


def next_counts(table: pd.DataFrame, accuracy: Accuracy, closed: Counts) -> Counts | None:
    """Return the numbers of surfaces of the next round; None if there is no next round.

    ``table`` is that of `reached_table` for the numbers ``closed``. They are raised to those that
    the table expects to suffice, but at most doubled; if those did not suffice, they are raised by
    a block. There is no next round if all results are accurate enough, or if the budget or the
    largest number of realisations is reached.
    """
    missing = table[~table.met]
    most = accuracy.most
    if missing.empty:
        return None
    needed = [min(missing[f"{name}_needed"].max(), most) for name in Counts._fields]
    surfaces, differences = (
        max(have, min(step * math.ceil(need / step), 2 * have))
        for need, step, have in zip(needed, (BLOCK, FEW), closed, strict=True)
    )
    if (surfaces, differences) == closed:  # the expected counts did not suffice
        surfaces = surfaces + BLOCK
        differences = differences + FEW
    budget = accuracy.budget_core_minutes
    while True:
        surfaces = max(min(surfaces, most), closed.surfaces)
        counts = Counts(surfaces, max(min(differences, surfaces), closed.differences))
        if counts == closed:
            return None
        if budget is None or _core_minutes(counts, *_prices(table)) <= budget:
            return counts
        surfaces = surfaces - BLOCK
        differences = differences - FEW


def _prices(table: pd.DataFrame) -> tuple[float, float]:
    return table.surface_core_minutes.iloc[0], table.difference_core_minutes.iloc[0]


def describe_reached(table: pd.DataFrame, accuracy: Accuracy, ended: bool = True) -> str:
    """Return a sentence on the accuracy that the table of `reached_table` shows.

    If the study has ``ended`` without the request, the sentence also says what limits it.
    """
    if table.empty:
        return f"accuracy: this study has no {accuracy.of}"
    worst = table.loc[table.half_width_percent.idxmax()]
    counts = Counts(int(table.surfaces.max()), int(table.differences.max()))
    about = worst.replace(ASSESSED)[["rock", "parameter", "level", "quantity"]].dropna()
    parts = dict.fromkeys(about)  # parameter and level may both be "base"
    known = math.isfinite(worst.half_width_percent)
    width = f"{worst.half_width_percent:.2g} %" if known else "not known"
    missing = int((~table.met).sum())
    reached = f"not reached in {missing} of {len(table)}" if missing else "reached"
    sentence = (
        f"accuracy: {accuracy.of} within {100.0 * accuracy.within:g} % {reached}, with "
        f"{counts.surfaces} realisations and {counts.differences} differences to the finest "
        f"numerics ({_core_minutes(counts, *_prices(table)):.2g} minutes of processor time); the "
        f"largest half-width is {width} ({' '.join(parts)}, cycle {worst.cycle})"
    )
    if not missing or not ended:
        return sentence
    lacking = table[~table.met]
    least = lacking.least_percent.max()
    needed = lacking[["surfaces_needed", "differences_needed"]].to_numpy().max()
    can = f"can give about {least:.2g} %" if math.isfinite(least) else "do not give all of them"
    if accuracy.most < needed < math.inf:
        return (
            f"{sentence}; this is impossible with {accuracy.most} realisations, the largest number "
            f"(most): it needs about {needed:.2g}, and {accuracy.most} {can}"
        )
    if accuracy.budget_core_minutes is not None and counts.differences < accuracy.most:
        return (
            f"{sentence}; the budget of {accuracy.budget_core_minutes:g} minutes of processor time "
            "does not suffice for more"
        )
    return f"{sentence}; {accuracy.most} realisations, the largest number, {can}"

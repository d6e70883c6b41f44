"""Number of surfaces needed for a goal, from a finished study, and their cost on this machine."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.inputs import InputError, check_number
from jointclosure.statistics.correlations import elasticity, fit_quadratic, quadratic_errors
from jointclosure.statistics.indifference import check_significance
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import mean_covariance, resampled
from studies.frame.tables import succeeded
from studies.paper.claims import TARGET
from studies.paper.responses import Response, responses

MOST = 1_000_000
"""Largest number of surfaces; goals that need more count as unreachable."""
RESAMPLES = 40
"""Number of resamples of an ensemble's surfaces, for the uncertainty of the number of surfaces."""
_NORMAL_95 = 1.96


_COLUMNS = ["rock", "parameter", "cycle", "test", "surfaces", "low_68", "high_68"]
_COLUMNS += ["simulations", "core_minutes"]


_LARGEST = {"length": 1e3, "width": 10.0, "standard-error": 1.0, "elasticity-error": 10.0}
"""Largest allowed amount of each kind of goal, which any study reaches; powers are below 1."""


class Goal(NamedTuple):
    """Goal of a study: its kind, a key of `GOALS`, and its amount."""

    kind: str
    amount: float


GOALS = {
    "length": "length of the indifference interval, in percent of the rock's value",
    "width": "width of the 95 % confidence interval of that length, over the length",
    "standard-error": "standard error of the mean closure of a case, over the mean",
    "elasticity-error": "standard error of the elasticity",
    "power": "probability that the t test tells the lowest level from the highest",
}


def plan(
    ensemble: xr.Dataset, goal: Goal, significance: float = 0.05, paired: bool = False
) -> pd.DataFrame:
    """Compute the surfaces per case that a goal needs, for every rock, parameter and cycle.

    ``low_68`` and ``high_68`` are the central 68 % over resampled surfaces of the ensemble.
    """
    _check(goal)
    check_significance(significance)
    rows, test = [], "paired" if paired else "unpaired"
    for response in responses(ensemble, TARGET):
        if paired and not response.paired:
            raise InputError(
                "paired: this study has different surfaces in every case; must be a study with a "
                "pool (study.pool) or common draws"
            )
        n = surfaces_for(response, goal, significance, paired)
        low, high = _known_to(response, goal, significance, paired)
        seconds = _seconds(ensemble, response)
        about = response.rock, response.parameter, response.cycle, test
        rows.append((*about, n, low, high, n * response.levels.size, n * seconds / 60.0))
    return pd.DataFrame(rows, columns=_COLUMNS)


def surfaces_for(
    response: Response, goal: Goal, significance: float, paired: bool, within: float = 0.0
) -> float:
    """Return the fewest surfaces per case expected to reach the goal, to a relative error."""
    met = _criteria(response._replace(paired=paired), significance)[goal.kind]

    def enough(n: int) -> bool:
        return met(n, goal.amount)

    high = 2
    while not enough(high):
        if high >= MOST:
            return np.inf
        high = min(2 * high, MOST)
    low = high // 2
    while high - low > max(1.0, within * low):
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def _known_to(response: Response, goal: Goal, significance: float, paired: bool):
    """Return the central 68 % of `surfaces_for` over resampled surfaces."""
    random = generator(seed_of(0, "plan", response.rock, response.parameter, response.cycle))
    drawn = resampled(response.samples, random, RESAMPLES, response.paired)
    numbers = [
        surfaces_for(response._replace(samples=one), goal, significance, paired, within=0.05)
        for one in drawn
    ]
    return np.quantile(numbers, (0.16, 0.84), method="inverted_cdf")


def _criteria(response: Response, significance: float) -> dict[str, Callable[[int, float], bool]]:
    """Return for each kind of goal whether n surfaces reach an amount."""
    had = response.samples.shape[1]
    variation = response.deviations / response.means
    at_base = variation[response.levels == response.base][0]

    def length(n: int, amount: float) -> bool:
        expected = response.interval(significance, n).length
        return 100.0 * expected / abs(response.base) <= amount  # no root: NaN, not reached

    def elasticity_error(n: int, amount: float) -> bool:
        estimate = elasticity(response.levels, response.samples, response.base, response.paired)
        return estimate.standard_error * np.sqrt(had / n) <= amount

    return {
        "length": length,
        "width": lambda n, amount: 2.0 * _NORMAL_95 * length_error(response, n) <= amount,
        "standard-error": lambda n, amount: at_base / np.sqrt(n) <= amount,
        "elasticity-error": elasticity_error,
        "power": lambda n, amount: power_of_ends(response, n, significance) >= amount,
    }


def length_error(response: Response, n: int) -> float:
    """Return the relative standard error of a length, scatter over slope, from n surfaces."""
    k, had = response.samples.shape
    mean = fit_quadratic(response.levels, response.means, response.base)
    covariance = mean_covariance(response.samples, response.paired)
    slope_error = quadratic_errors(response.levels, covariance, response.base).reduced[1]
    if mean.c == 0.0:
        return np.inf
    # the scatter is S at the base, or sigma of the residuals from a line for each surface
    freedom = (n - 1) * (k - 2) if response.paired else n - 1
    return float(np.sqrt((slope_error / mean.c) ** 2 * had / n + 0.5 / freedom))


def power_of_ends(response: Response, n: int, significance: float) -> float:
    """Return the power of the t test between the lowest and highest level, with n surfaces each."""
    low, high = response.samples[0], response.samples[-1]
    if response.paired:
        scatter, freedom = (high - low).std(ddof=1), n - 1
    else:
        scatter, freedom = np.sqrt(low.var(ddof=1) + high.var(ddof=1)), 2 * n - 2
    shift = abs(high.mean() - low.mean()) * np.sqrt(n) / scatter if scatter else np.inf
    if not np.isfinite(shift):
        return 1.0
    critical = scipy.stats.t.ppf(1.0 - 0.5 * significance, freedom)
    # beyond a shift of 30 the noncentral t is practically normal, and cannot be evaluated
    if shift > 30.0:
        return float(scipy.stats.norm.sf(critical - shift))
    above = scipy.stats.nct.sf(critical, freedom, shift)
    return float(above + scipy.stats.nct.cdf(-critical, freedom, shift))


def _seconds(ensemble: xr.Dataset, response: Response) -> float:
    """Return the sum over levels of a response of the mean time [s] of a simulation."""
    cases = (ensemble.rock == response.rock).values
    cases &= np.isin(ensemble.parameter.values, [response.parameter, "base"])
    times = ensemble.timing_simulation.where(succeeded(ensemble))[cases]
    return float(times.mean("realization").sum())


def _check(goal: Goal) -> None:
    if goal.kind not in GOALS:
        raise InputError(f"goal = {goal.kind!r}: must be one of {', '.join(GOALS)}")
    check_number(goal.kind, goal.amount)
    largest = _LARGEST.get(goal.kind)
    if not goal.amount > 0.0 or not (goal.amount <= largest if largest else goal.amount < 1.0):
        allowed = f"above 0 and at most {largest:g}" if largest else "between 0 and 1"
        raise InputError(f"{goal.kind} = {goal.amount!r}: must be {allowed}")

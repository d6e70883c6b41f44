"""How many surfaces a wish needs, from what a finished study found, and what they cost here."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy.stats
import xarray as xr

from jointclosure.claims.found import TARGET
from jointclosure.ensemble.aggregation import succeeded
from jointclosure.inputs import InputError, check_number
from jointclosure.sensitivity.responses import (
    Response,
    responses,
)
from jointclosure.statistics.correlations import fit_quadratic
from jointclosure.statistics.indifference import indifference_interval
from jointclosure.statistics.paired import paired_indifference_interval
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import elasticity, mean_covariance, quadratic_errors

MOST = 1_000_000
"""Surfaces beyond which a wish counts as out of reach."""
RESAMPLES = 40
"""Resamples of an ensemble's surfaces: how far the number of surfaces is known."""
_NORMAL_95 = 1.96


_COLUMNS = (
    "rock",
    "parameter",
    "cycle",
    "test",
    "surfaces",
    "low_68",
    "high_68",
    "simulations",
    "core_minutes",
)


_LARGEST = {"length": 1e3, "width": 10.0, "standard-error": 1.0, "elasticity-error": 10.0}
"""Largest amount of each kind of wish that any study could miss; powers are below 1."""


class Wish(NamedTuple):
    """What a study is to reach: its kind, one of `WISHES`, and how much of it."""

    kind: str
    amount: float


WISHES = {
    "length": "length of the indifference interval, in percent of the rock's own value",
    "width": "width of the 95 % confidence interval of that length, over the length",
    "standard-error": "standard error of the mean closure of a case, over the mean",
    "elasticity-error": "standard error of the elasticity",
    "power": "probability that the t test tells the lowest level from the highest",
}


def plan(
    ensemble: xr.Dataset, wish: Wish, significance: float = 0.05, paired: bool = False
) -> pd.DataFrame:
    """Surfaces per case that a wish needs, for every rock, parameter and cycle.

    Parameters
    ----------
    ensemble : Dataset
        A finished study or, better, its pool.
    wish : Wish
    significance : float
        Of the t test.
    paired : bool
        Whether the new study closes the same surfaces in all cases (common draws) or draws
        others for each; the former needs an ensemble of common surfaces.

    Returns
    -------
    DataFrame
        ``surfaces`` per case, infinite where over a million; ``low_68`` and ``high_68``, the
        central 68 % of what other surfaces of the same number would tell (bootstrap);
        ``simulations`` of all levels of the parameter, and ``core_minutes`` by the mean times
        recorded in the ensemble.

    Raises
    ------
    InputError
        A wish or significance out of its range, or paired tests of an ensemble of independent
        draws.
    """
    _check(wish)
    check_number("significance", significance)
    if not 0.0 < significance < 1.0:
        raise InputError(f"significance = {significance!r}: must be between 0 and 1 (0.05 is 5 %)")
    rows = []
    for response in responses(ensemble, TARGET):
        if paired and not response.paired:
            raise InputError(
                "paired: this study has other surfaces in every case; plan from one with a pool "
                "(study.pool) or common draws"
            )
        n = surfaces_for(response, wish, significance, paired)
        low, high = _known_to(response, wish, significance, paired)
        seconds = _seconds(ensemble, response)
        row = {"rock": response.rock, "parameter": response.parameter, "cycle": response.cycle}
        row |= {"test": "paired" if paired else "unpaired", "surfaces": n}
        row |= {"low_68": low, "high_68": high}
        row |= {"simulations": n * response.levels.size, "core_minutes": n * seconds / 60.0}
        rows.append(row)
    return pd.DataFrame(rows, columns=list(_COLUMNS))


def surfaces_for(
    response: Response, wish: Wish, significance: float, paired: bool, within: float = 0.0
) -> float:
    """The smallest number of surfaces per case with which the wish is expected to be met.

    ``within``: relative error that is allowed of it.
    """
    met = _criteria(response._replace(paired=paired), significance)[wish.kind]

    def enough(n: int) -> bool:
        return met(n, wish.amount)

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


def _known_to(response: Response, wish: Wish, significance: float, paired: bool):
    """Central 68 % of `surfaces_for` over resampled surfaces."""
    random = generator(seed_of(0, "plan", response.rock, response.parameter, response.cycle))
    k, n = response.samples.shape
    found = []
    for _ in range(RESAMPLES):
        index = random.integers(n, size=(1, n) if response.paired else (k, n))
        index = np.broadcast_to(index, (k, n))
        drawn = response._replace(samples=np.take_along_axis(response.samples, index, axis=1))
        found.append(surfaces_for(drawn, wish, significance, paired, within=0.05))
    return np.quantile(found, (0.16, 0.84), method="inverted_cdf")


def _criteria(response: Response, significance: float) -> dict[str, Callable[[int, float], bool]]:
    """For each kind of wish, whether n surfaces meet an amount."""
    had = response.samples.shape[1]
    variation = response.deviations / response.means
    own = variation[response.levels == response.base][0]

    def length(n: int, amount: float) -> bool:
        found = _length(response, n, significance)
        return 100.0 * found / abs(response.base) <= amount  # no root: NaN, not met

    def elasticity_error(n: int, amount: float) -> bool:
        found = elasticity(response.levels, response.samples, response.base, response.paired)
        return found.standard_error * np.sqrt(had / n) <= amount

    return {
        "length": length,
        "width": lambda n, amount: 2.0 * _NORMAL_95 * length_error(response, n) <= amount,
        "standard-error": lambda n, amount: own / np.sqrt(n) <= amount,
        "elasticity-error": elasticity_error,
        "power": lambda n, amount: power_of_ends(response, n, significance) >= amount,
    }


def _length(response: Response, n: int, significance: float) -> float:
    levels, base = response.levels, response.base
    if response.paired:
        return paired_indifference_interval(
            levels, response.samples, significance, base, surfaces=n
        ).length
    return indifference_interval(
        levels, response.means, response.deviations, n, significance, base
    ).length


def length_error(response: Response, n: int) -> float:
    """Relative standard error of a length, taken as scatter over slope, both of n surfaces."""
    k, had = response.samples.shape
    mean = fit_quadratic(response.levels, response.means, response.base)
    covariance = mean_covariance(response.samples, response.paired)
    slope_error = quadratic_errors(response.levels, covariance, response.base).reduced[1]
    if mean.c == 0.0:
        return np.inf
    # the scatter: S at the base; or sigma, of what a line of each surface's own leaves
    freedom = (n - 1) * (k - 2) if response.paired else n - 1
    return float(np.sqrt((slope_error / mean.c) ** 2 * had / n + 0.5 / freedom))


def power_of_ends(response: Response, n: int, significance: float) -> float:
    """Power of the t test between the lowest and the highest level with n surfaces each."""
    low, high = response.samples[0], response.samples[-1]
    if response.paired:
        scatter, freedom = (high - low).std(ddof=1), n - 1
    else:
        scatter, freedom = np.sqrt(low.var(ddof=1) + high.var(ddof=1)), 2 * n - 2
    shift = abs(high.mean() - low.mean()) * np.sqrt(n) / scatter if scatter else np.inf
    if not np.isfinite(shift):
        return 1.0
    critical = scipy.stats.t.ppf(1.0 - 0.5 * significance, freedom)
    # beyond a shift of 30 the noncentral t is as good as normal, and cannot be evaluated
    if shift > 30.0:
        return float(scipy.stats.norm.sf(critical - shift))
    above = scipy.stats.nct.sf(critical, freedom, shift)
    return float(above + scipy.stats.nct.cdf(-critical, freedom, shift))


def _seconds(ensemble: xr.Dataset, response: Response) -> float:
    """Mean time [s] of one simulation of every level of a response, added up."""
    cases = (ensemble.rock == response.rock).values
    cases &= np.isin(ensemble.parameter.values, [response.parameter, "base"])
    times = ensemble.timing_simulation.where(succeeded(ensemble))[cases]
    return float(times.mean("realization").sum())


def _check(wish: Wish) -> None:
    if wish.kind not in WISHES:
        raise InputError(f"wish = {wish.kind!r}: must be one of {', '.join(WISHES)}")
    check_number(wish.kind, wish.amount)
    largest = _LARGEST.get(wish.kind)
    if not wish.amount > 0.0 or not (wish.amount <= largest if largest else wish.amount < 1.0):
        allowed = f"above 0 and at most {largest:g}" if largest else "between 0 and 1"
        raise InputError(f"{wish.kind} = {wish.amount!r}: must be {allowed}")

"""Numbers of the model that decide whether a claim is true of it, with confidence intervals.

Each is a function of the mean closures of the cases of a rock. The sensitivity of a closure is
its elasticity, d ln(closure)/d ln(parameter), which no number of surfaces changes; the lengths
of Table 3 in percent go as the scatter over it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.correlations import Quadratic, fit_quadratic
from jointclosure.statistics.standard_errors import Estimate
from jointclosure.studies.sensitivity.responses import TARGET, RockSample

LOOP = "loop"
"""Closure of unloading less that of loading, at half the maximum stress."""
NEGLIGIBLE = 0.02
"""Relative change of a mean closure that counts as no effect: the tolerance to which
`effects: auto` leaves an effect out."""

Means = np.ndarray
"""Means (targets, cases) of a `RockSample`."""


class Quantity(NamedTuple):
    """A number of the model: its name, how it follows from means, and where the claim is true."""

    name: str
    of: Callable[[Means], float]
    true_between: tuple[float, float] = (0.0, np.inf)


def estimated(quantity: Quantity, sample: RockSample) -> Estimate:
    """The number and its standard error.

    The error is to first order in those of the means, whose covariance is that over surfaces:
    what surfaces of a pool have in common at all levels cancels in differences.
    """
    targets, cases, n = sample.values.shape
    means = sample.values.mean(axis=2)
    covariance = np.atleast_2d(np.cov(sample.values.reshape(targets * cases, n))) / n
    if not sample.paired:
        same_case = np.tile(np.eye(cases, dtype=bool), (targets, targets))
        covariance = np.where(same_case, covariance, 0.0)
    errors = np.sqrt(np.diag(covariance))
    gradient = np.zeros(errors.size)
    for i in np.flatnonzero(errors):
        step = np.zeros(errors.size)
        step[i] = 0.1 * errors[i]
        moved = [quantity.of(means + sign * step.reshape(means.shape)) for sign in (1.0, -1.0)]
        gradient[i] = (moved[0] - moved[1]) / (2.0 * step[i])
    return Estimate(quantity.of(means), float(np.sqrt(gradient @ covariance @ gradient)))


def elasticity_of(sample: RockSample, parameter: str, cycle: int, variable: str = TARGET):
    """The function from means to an elasticity."""
    base = sample.levels[parameter].base
    fit = fit_of(sample, parameter, cycle, variable)

    def value(means: Means) -> float:
        found = fit(means)
        return found.c / found.d * base / found.half_range

    return value


def fit_of(sample: RockSample, parameter: str, cycle: int, variable: str = TARGET):
    """The function from means to the quadratic of a response, Eq. (24)."""
    levels, target = sample.levels[parameter], sample.target(variable, cycle)

    def fit(means: Means) -> Quadratic:
        return fit_quadratic(levels.values, means[target, levels.cases], levels.base)

    return fit


def more_sensitive(
    sample: RockSample, first: str, second: str, cycle: int, variable: str = TARGET
) -> Quantity:
    """By how much the closure is more sensitive to one parameter than to another."""
    one = elasticity_of(sample, first, cycle, variable)
    other = elasticity_of(sample, second, cycle, variable)
    return Quantity(
        f"|e({PROPERTIES[first].symbol})| - |e({PROPERTIES[second].symbol})|",
        lambda means: abs(one(means)) - abs(other(means)),
    )


def falls_with_the_cycle(sample: RockSample, parameter: str) -> Quantity:
    """By how much the closure of the first cycle is more sensitive than that of the second."""
    first, second = (elasticity_of(sample, parameter, cycle) for cycle in (1, 2))
    symbol = PROPERTIES[parameter].symbol
    return Quantity(
        f"|e({symbol})| of cycle 1 - cycle 2", lambda means: abs(first(means)) - abs(second(means))
    )


def change_of(sample: RockSample, parameter: str, cycle: int, change: float) -> Quantity:
    """Relative change of the mean closure with a change of the parameter, no effect if small."""
    fit, base = fit_of(sample, parameter, cycle), sample.levels[parameter].base

    def value(means: Means) -> float:
        found = fit(means)
        return float(found.at(base + change) / found.d - 1.0)

    name = f"change with {PROPERTIES[parameter].symbol} {change:+g}, cycle {cycle}"
    return Quantity(name, value, (-NEGLIGIBLE, NEGLIGIBLE))


def rises(
    sample: RockSample, parameter: str, cycle: int, sign: int, variable: str = TARGET
) -> list[Quantity]:
    """Relative change of the mean from each level to the next; of the sign where it rises so."""
    levels, target = sample.levels[parameter], sample.target(variable, cycle)

    def step(i: int) -> Callable[[Means], float]:
        def value(means: Means) -> float:
            lower, upper = means[target, levels.cases[i : i + 2]]
            return sign * (upper / lower - 1.0)

        return value

    direction = "rise" if sign > 0 else "fall"
    return [
        Quantity(f"{direction} with {PROPERTIES[parameter].symbol}, step {i + 1}", step(i))
        for i in range(levels.values.size - 1)
    ]


def relative(
    sample: RockSample, case: int, name: str, first: tuple, second: tuple, less: bool
) -> Quantity:
    """A target of a case over another one (``less``: one less that ratio)."""
    one, other = sample.target(*first), sample.target(*second)

    def value(means: Means) -> float:
        ratio = means[one, case] / means[other, case]
        return float(1.0 - ratio if less else ratio)

    return Quantity(name, value)

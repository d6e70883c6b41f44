"""Total error of a mean over surfaces, from bias and sampling, and its cost.

A method (such as a setting of the numerics) has a bias that more surfaces do not reduce, and
its mean over n surfaces scatters. Control variates explain a share of that scatter by covariates
that are measured on m further surfaces at little cost. The bias is measured with a standard
error e. The total error is

    |bias| + 1.96 sqrt(e^2 + s^2 ((1 - rho) / n + rho / m)),

a bound that holds in 95 of 100 studies: s is the relative standard error of one surface, rho the
explained share.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

REACH = 1.96
"""Half-width of a 95 % confidence interval, in standard errors."""


class Bias(NamedTuple):
    """Signed relative error of a method [1], and the standard error of this value."""

    value: float
    error: float = 0.0

    def total(self, sampling: float) -> float:
        """Return the total error [1] with a given sampling error, both half 95 % intervals."""
        return abs(self.value) + float(np.hypot(REACH * self.error, sampling))

    def room(self, within: float) -> float:
        """Return the largest sampling error [1] with a total error within a bound, or 0."""
        left, known_to = within - abs(self.value), REACH * self.error
        return float(np.sqrt(left**2 - known_to**2)) if left > known_to else 0.0


class Method(NamedTuple):
    """Method to compute a result, with relative errors and with costs per surface."""

    bias: Bias
    scatter: float  # relative standard error of one surface
    left: float  # shares of its variance that control variates leave and explain
    explained: float  # 1 and 0 without control variates
    cost: float  # time of a closed surface [s]
    measured_cost: float  # time of a surface that is only measured [s]
    least: int = 2  # smallest number of surfaces

    def sampling(self, surfaces: float, measured: float = np.inf) -> float:
        """Return half the 95 % confidence interval [1] for closed and measured surfaces."""
        return REACH * self.scatter * np.sqrt(self.left / surfaces + self.explained / measured)

    def total(self, surfaces: float, measured: float = np.inf) -> float:
        """Return the total error [1]."""
        return self.bias.total(self.sampling(surfaces, measured))

    def seconds(self, surfaces: float, measured: float = 0.0) -> float:
        """Return the time of numbers of closed and measured surfaces [s]."""
        return surfaces * self.cost + measured * self.measured_cost

    def surfaces_for(self, within: float, measured: float = np.inf) -> float:
        """Return the fewest surfaces with a total error within a bound; infinite if none."""
        allowed = (self.bias.room(within) / (REACH * self.scatter)) ** 2 - self.explained / measured
        if allowed <= 0.0:
            return np.inf
        return float(max(self.least, np.ceil(self.left / allowed - 1e-9)))


def common_bias(biases: Sequence[Bias]) -> Bias:
    """Return the bias that several measured ones have in common, for any one of them.

    The error holds the variance between them beyond their errors, so that it is also that of a
    single one (random effects, DerSimonian and Laird, Controlled Clinical Trials 7, 1986, 177-188).
    """
    values, errors = np.array(biases).T
    variances = np.maximum(errors, np.finfo(float).eps) ** 2
    weights = 1.0 / variances
    spread = (weights * (values - np.average(values, weights=weights)) ** 2).sum()
    scale = weights.sum() - (weights**2).sum() / weights.sum()
    between = max((spread - (values.size - 1)) / scale, 0.0) if values.size > 1 else 0.0
    weights = 1.0 / (variances + between)
    error = np.sqrt(1.0 / weights.sum() + between)
    return Bias(float(np.average(values, weights=weights)), float(error))


def bias_of(percent: float, low: float, high: float) -> Bias:
    """Make a bias from its percentage and its 95 % confidence interval."""
    return Bias(0.01 * percent, 0.01 * (high - low) / (2.0 * REACH))


def method_of(row) -> Method:
    """Make a method from a row of a table, whose bias is in percent."""
    bias = bias_of(row.bias_percent, row.bias_low, row.bias_high)
    return Method(bias, *(getattr(row, name) for name in Method._fields[1:]))


def shares(worth: float, surfaces: float, measured: float) -> tuple[float, float]:
    """Return the shares of variance that control variates leave and explain."""
    explained = max((1.0 - 1.0 / worth) / (1.0 - surfaces / measured), 0.0)
    return 1.0 / worth - explained * surfaces / measured, explained


def front(seconds: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Return indices of the Pareto front of time and error, by ascending time."""
    order = np.lexsort((errors, seconds))
    best = np.minimum.accumulate(errors[order])
    first = np.concatenate([[True], best[1:] < best[:-1]])
    return order[first]

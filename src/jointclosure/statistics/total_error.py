"""Total error of a mean over surfaces, and what it costs: what a method is off by, and sampling.

A method (a setting of the numerics, say) is off by a bias that more surfaces do not take away, and
its mean over n surfaces scatters. Control variates explain a share of that scatter by numbers that
are measured on m surfaces of their own, which cost little. The bias was measured, to a standard
error e. The total error is

    |bias| + 1.96 sqrt(e^2 + s^2 ((1 - rho) / n + rho / m)),

a bound that holds in 95 of 100 studies: s is the relative standard error of one surface, rho the
share that is explained.
"""

from typing import NamedTuple

import numpy as np

REACH = 1.96
"""Standard errors in half a 95 % confidence interval."""


class Bias(NamedTuple):
    """What a method is off by [1], of either sign, and the standard error that this is known to."""

    value: float
    error: float = 0.0

    def total(self, sampling: float) -> float:
        """Total error [1] with a sampling error of so much: half a 95 % confidence interval."""
        return abs(self.value) + float(np.hypot(REACH * self.error, sampling))

    def room(self, within: float) -> float:
        """The largest sampling error [1] with which the total error is within a bound, or 0."""
        left, known_to = within - abs(self.value), REACH * self.error
        return float(np.sqrt(left**2 - known_to**2)) if left > known_to else 0.0


class Method(NamedTuple):
    """A way to a result: errors are relative to it, costs are those of one surface.

    ``bias``: what it is off by. ``scatter``: relative standard error of one
    surface. ``left``: share of its variance that control variates leave, as told by studies of
    finite size; ``explained``: the share that they explain; 1 and 0 without any. ``cost``: of a
    surface that is closed; ``measured_cost``: of one that is only measured [s]. ``least``: surfaces
    that it takes.
    """

    bias: Bias
    scatter: float
    left: float
    explained: float
    cost: float
    measured_cost: float
    least: int = 2

    def sampling(self, surfaces: float, measured: float = np.inf) -> float:
        """Half the 95 % confidence interval [1] from so many surfaces closed, and measured."""
        return REACH * self.scatter * np.sqrt(self.left / surfaces + self.explained / measured)

    def total(self, surfaces: float, measured: float = np.inf) -> float:
        """Total error [1]."""
        return self.bias.total(self.sampling(surfaces, measured))

    def seconds(self, surfaces: float, measured: float = 0.0) -> float:
        """Time of so many surfaces closed, and measured [s]."""
        return surfaces * self.cost + measured * self.measured_cost

    def surfaces_for(self, within: float, measured: float = np.inf) -> float:
        """The fewest surfaces whose total error is within a bound; infinite where none is."""
        allowed = (self.bias.room(within) / (REACH * self.scatter)) ** 2 - self.explained / measured
        if allowed <= 0.0:
            return np.inf
        return float(max(self.least, np.ceil(self.left / allowed - 1e-9)))


def method_of(row) -> Method:
    """A method from a row of a table with its fields, whose bias is in percent.

    The bias has a 95 % confidence interval, ``bias_low`` to ``bias_high``.
    """
    bias = Bias(0.01 * row.bias_percent, 0.01 * (row.bias_high - row.bias_low) / (2.0 * REACH))
    fields = [getattr(row, name) for name in Method._fields[1:]]
    return Method(bias, *fields)


def shares(worth: float, surfaces: float, measured: float) -> tuple[float, float]:
    """Shares of the variance that control variates leave and explain, by what they were worth.

    Parameters
    ----------
    worth : float
        Plain variance over adjusted, with so many ``surfaces`` closed and ``measured``.

    Returns
    -------
    left, explained : float
        ``left`` is more than 1 - ``explained`` where fitting costs something.
    """
    explained = max((1.0 - 1.0 / worth) / (1.0 - surfaces / measured), 0.0)
    return 1.0 / worth - explained * surfaces / measured, explained


def front(seconds: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Indices of those that no other beats in both, by ascending time: a Pareto front."""
    order = np.lexsort((errors, seconds))
    best = np.minimum.accumulate(errors[order])
    first = np.concatenate([[True], best[1:] < best[:-1]])
    return order[first]

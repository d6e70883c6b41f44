"""Total error of a mean over surfaces, and what it costs: what a method is off by, and sampling.

A method (a setting of the numerics, say) is off by a bias that more surfaces do not take away, and
its mean over n surfaces scatters. Control variates explain a share of that scatter by numbers that
are measured on m surfaces of their own, which cost little. The total error is

    |bias| + 1.96 s sqrt((1 - rho) / n + rho / m),

a bound that holds in 95 of 100 studies: s is the relative standard error of one surface, rho the
share that is explained.
"""

from typing import NamedTuple

import numpy as np

REACH = 1.96
"""Standard errors in half a 95 % confidence interval."""


class Method(NamedTuple):
    """A way to a result: errors are relative to it, costs are those of one surface.

    ``bias``: what it is off by, of either sign. ``scatter``: relative standard error of one
    surface. ``left``: share of its variance that control variates leave, as told by studies of
    finite size; ``explained``: the share that they explain; 1 and 0 without any. ``cost``: of a
    surface that is closed; ``measured_cost``: of one that is only measured [s]. ``least``: surfaces
    that it takes.
    """

    bias: float
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
        return abs(self.bias) + self.sampling(surfaces, measured)

    def seconds(self, surfaces: float, measured: float = 0.0) -> float:
        """Time of so many surfaces closed, and measured [s]."""
        return surfaces * self.cost + measured * self.measured_cost

    def surfaces_for(self, within: float, measured: float = np.inf) -> float:
        """The fewest surfaces whose total error is within a bound; infinite where none is."""
        room = within - abs(self.bias)
        allowed = (room / (REACH * self.scatter)) ** 2 - self.explained / measured
        if room <= 0.0 or allowed <= 0.0:
            return np.inf
        return float(max(self.least, np.ceil(self.left / allowed - 1e-9)))


def method_of(row) -> Method:
    """A method from a row of a table with its fields, whose bias is in percent.

    A bias that is not told from chance (``told``) counts as none.
    """
    bias = 0.01 * row.bias_percent if row.told else 0.0
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

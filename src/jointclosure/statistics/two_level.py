"""Means by two levels of accuracy, and their cost (M. B. Giles, Acta Numerica 24, 2015, 259).

The mean of n joints at a cheap level, plus the mean of k differences to a finer level on k of the
same walls, has no bias but that of the finer level. Its variance is V/n + D/k, with the variance V
of the cheap level and D of the differences.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.standard_errors import CONFIDENCE

FEWEST_DIFFERENCES = 8  # of a plan: fewer do not show their standard deviation


class Interval(NamedTuple):
    """Estimate of a number, and the ends of its confidence interval, in the same unit."""

    value: float
    low: float
    high: float

    @property
    def most(self) -> float:
        """Largest magnitude of the ends of the interval."""
        return max(abs(self.low), abs(self.high))

    def within(self, limit: float) -> bool | None:
        """Return whether the magnitude of the number is at most a ``limit``.

        True if the whole interval is within the limit, False if all of it is beyond, else None.
        """
        if self.most <= limit:
            return True
        return False if self.low > limit or self.high < -limit else None


def t_interval(samples: np.ndarray) -> Interval:
    """Return the mean of samples (n,) with its 95 % interval by Student's t.

    Its ends are infinite for one sample.
    """
    return _interval_about(
        float(np.mean(samples)), [_squared_error(samples)], [np.size(samples) - 1]
    )


def change_interval(samples: np.ndarray) -> Interval:
    """Return the mean of relative changes (n,) of a positive result, with its 95 % interval.

    It is the `t_interval`, whose low end is raised to -1 if it is below, except for one sample.
    """
    interval = t_interval(samples)
    return interval._replace(low=max(interval.low, -1.0)) if np.size(samples) > 1 else interval


def two_level_mean(cheap: np.ndarray, differences: np.ndarray) -> Interval:
    """Return the mean at the finer level, with its 95 % interval.

    ``cheap`` (n,) are the values of n joints at the cheap level, ``differences`` (k,) what the
    finer level adds to those of the first k joints.
    """
    value = float(np.mean(cheap) + np.mean(differences))
    return combined(value, [(cheap / np.size(cheap), differences / np.size(differences))])


def combined(value: float, parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> Interval:
    """Return the 95 % interval about a ``value`` that is a sum over groups of joints.

    Each of the ``parts`` is an independent group: the contributions (n,) of its joints at the cheap
    level, and those (k,) of the differences to the finer level on the first k of them. The two
    contributions of a joint may be correlated. The interval is infinite if a group has fewer than
    two differences. The degrees of freedom are those of B. L. Welch, Biometrika 34, 1947, 28-35.
    """
    squares = []
    freedoms = []
    for cheap, differences in parts:
        n = np.size(cheap)
        k = np.size(differences)
        if k < 2:
            return Interval(value, -math.inf, math.inf)
        squares += [k * float(np.var(cheap[:k] + differences, ddof=1))]
        squares += [(n - k) * float(np.var(cheap, ddof=1))]
        freedoms += [k - 1, n - 1]
    return _interval_about(value, squares, freedoms)


class Plan(NamedTuple):
    """Plan of a two-level mean: numbers of cheap joints and of differences, and what they give.

    ``seconds`` is the processor time, ``half_width`` half of the 95 % interval of the mean.
    """

    joints: int
    differences: int
    seconds: float
    half_width: float


def best_plan(
    deviations: tuple[float, float],
    seconds: tuple[float, float],
    within: float,
    budget: float | None = None,
) -> Plan | None:
    """Return the cheapest plan of a two-level mean whose half-width is at most ``within`` > 0.

    With a ``budget`` [s], ``within`` does not count: it is the plan of smallest half-width for this
    processor time, or None if the time is too short for any plan. ``deviations`` are the standard
    deviations of values at the cheap level and of differences, ``seconds`` the times of one joint
    at the cheap level and of one difference, which has both levels.
    """
    joints = FEWEST_DIFFERENCES
    best = None
    while True:
        plan = _best_split(deviations, seconds, joints)
        if budget is not None and plan.seconds > budget:
            return best
        if budget is None and plan.half_width <= within:
            return plan
        best = plan
        joints = math.ceil(1.02 * joints + 0.5)


def _best_split(deviations: tuple[float, float], seconds: tuple[float, float], joints: int) -> Plan:
    """Return the plan of so many cheap ``joints`` with the best number of differences.

    Arguments are as for `best_plan`.
    """
    first, second = deviations
    cheap, both = seconds
    share = second * math.sqrt(cheap) / (first * math.sqrt(both)) if first * both > 0.0 else 1.0
    differences = min(max(FEWEST_DIFFERENCES, math.ceil(share * joints)), joints)
    squares = [d**2 / n for d, n in zip(deviations, (joints, differences), strict=True)]
    half = _interval_about(0.0, squares, [joints - 1, differences - 1]).high
    return Plan(joints, differences, joints * cheap + differences * both, half)


def _squared_error(samples: np.ndarray) -> float:
    """Return the squared standard error of the mean of samples (n,); infinite for one sample."""
    count = np.size(samples)
    return float(np.var(samples, ddof=1)) / count if count > 1 else math.inf


def _interval_about(value: float, squares: list[float], freedoms: list[int]) -> Interval:
    """Return the 95 % interval about a value, from the squared errors of its parts.

    ``freedoms`` are the degrees of freedom of these errors. The interval is infinite if an error
    is.
    """
    total = sum(squares)
    if not math.isfinite(total):
        return Interval(value, -math.inf, math.inf)
    if total == 0.0:
        return Interval(value, value, value)
    freedom = total**2 / sum(s**2 / f for s, f in zip(squares, freedoms, strict=True) if s > 0.0)
    half = float(scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * math.sqrt(total)
    return Interval(value, value - half, value + half)

"""Second-order correlations of mean and standard deviation, Eqs. (24) to (27)."""

from typing import Any, NamedTuple

import numpy as np
import scipy


class Quadratic(NamedTuple):
    """value(p) = b u^2 + c u + d in the reduced parameter u = (p - base)/half_range.

    Reduced, the coefficients have the values' own size, and ``d`` is the
    fitted value at the base level.
    """

    b: float
    c: float
    d: float
    base: float
    half_range: float

    def at(self, parameter: float | np.ndarray) -> Any:
        """Fitted value at a parameter (or an array of them)."""
        u = (np.asarray(parameter) - self.base) / self.half_range
        return (self.b * u + self.c) * u + self.d

    def in_parameter(self) -> tuple[float, float, float]:
        """The paper's b, c, d: value(p) = b p^2 + c p + d, Eqs. (24) and (26)."""
        b = self.b / self.half_range**2
        slope = self.c / self.half_range
        return (
            float(b),
            float(slope - 2.0 * b * self.base),
            float(self.d - slope * self.base + b * self.base**2),
        )


def fit_quadratic(levels: np.ndarray, values: np.ndarray, base: float) -> Quadratic:
    """The quadratic through three levels, or the least-squares one through more.

    Parameters
    ----------
    levels : array (k,)
        Parameter values, ascending, k >= 3.
    values : array (k,)
        Means or standard deviations at the levels.
    base : float
        The one of the levels about which u counts.

    Notes
    -----
    It is fitted to the differences from the base value, which keeps every digit
    of a response that is small beside its mean. A coefficient b or c that
    rounding of levels and values alone can make is 0: a straight line stays one.
    """
    levels, values = np.asarray(levels, dtype=float), np.asarray(values, dtype=float)
    half_range = 0.5 * (levels[-1] - levels[0])
    others = levels != base
    u = (levels[others] - base) / half_range
    start = float(values[~others][0])
    rises = values[others] - start
    if levels.size == 3:
        (u1, u2), (s1, s2) = u, rises / u
        coefficients = np.array([s2 - s1, u2 * s1 - u1 * s2, 0.0]) / (u2 - u1)
        weights = np.array([[1.0, 1.0], [abs(u2), abs(u1)]]) / (np.abs(u) * (u2 - u1))
    else:
        inverse = np.linalg.pinv(np.vander(np.append(u, 0.0), 3))
        coefficients = inverse @ np.append(rises, 0.0)
        weights = np.abs(inverse[:2, :-1])
    slopes = np.abs(2.0 * coefficients[0] * u) + abs(coefficients[1])
    rounding = np.abs(values).max() + slopes * np.abs(levels).max() / half_range
    noise = np.finfo(float).eps * (weights @ rounding)
    b, c = np.where(np.abs(coefficients[:2]) > noise, coefficients[:2], 0.0)
    d = start + coefficients[2]
    return Quadratic(float(b), float(c), float(d), float(base), float(half_range))


def lack_of_fit(
    levels: np.ndarray,
    means: np.ndarray,
    standard_deviations: np.ndarray,
    samples: int,
    quadratic: Quadratic,
) -> float:
    """p value of the hypothesis that the quadratic fits the means of k > 3 levels.

    The F test of the misfit against the scatter within the levels, whose
    draws it takes as independent; NaN for three levels, where the fit is exact.
    """
    freedom = len(levels) - 3
    scatter = float(np.mean(np.square(standard_deviations)))
    if freedom < 1 or scatter == 0.0:
        return float("nan")
    misfit = samples * float(np.sum((np.asarray(means) - quadratic.at(levels)) ** 2)) / freedom
    return float(scipy.stats.f.sf(misfit / scatter, freedom, len(levels) * (samples - 1)))

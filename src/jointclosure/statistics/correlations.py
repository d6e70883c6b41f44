"""Second-order correlations of mean and standard deviation, Eqs. (24) to (27)."""

from typing import NamedTuple

import numpy as np
import scipy.stats


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

    def at(self, parameter):
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
        Level about which u counts.
    """
    levels = np.asarray(levels, dtype=float)
    half_range = 0.5 * (levels[-1] - levels[0])
    u = (levels - base) / half_range
    terms = np.stack([u * u, u, np.ones_like(u)], axis=1)
    values = np.asarray(values, dtype=float)
    if levels.size == 3:
        b, c, d = np.linalg.solve(terms, values)
    else:
        b, c, d = np.linalg.lstsq(terms, values, rcond=None)[0]
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

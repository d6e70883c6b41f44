"""Quadratics of a response in one parameter: fit, lack of fit, errors and elasticity.

They are the second-order correlations of mean and standard deviation, Eqs. (24) to (27).
"""

import math
from typing import Any, NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.standard_errors import Estimate, mean_covariance


class Quadratic(NamedTuple):
    """Quadratic value(p) = b u^2 + c u + d in u = (p - base)/half_range.

    In u the coefficients b, c and d, numbers or arrays, have the unit of the value. ``half_range``
    is half of the range of the levels to which it was fitted.
    """

    b: Any  # float or array, like c and d
    c: Any
    d: Any
    base: float
    half_range: float

    def at(self, parameter: float | np.ndarray) -> Any:
        """Return the value of the quadratic at a parameter, or at an array of parameters."""
        u = (np.asarray(parameter) - self.base) / self.half_range
        return (self.b * u + self.c) * u + self.d

    def elasticity(self) -> Any:
        """Return the elasticity d ln(value)/d ln(parameter) of the quadratic at the base."""
        return self.c / self.d * self.base / self.half_range

    def relative_change(self, change: float) -> Any:
        """Return the relative change of the value [1] if the parameter changes from its base.

        ``change`` is in the unit of the parameter.
        """
        return self.at(self.base + change) / self.d - 1.0

    def in_parameter(self) -> tuple[float, float, float]:
        """Return the paper's b, c, d: value(p) = b p^2 + c p + d, Eqs. (24) and (26)."""
        b = self.b / self.half_range**2
        slope = self.c / self.half_range
        d = self.d - slope * self.base + b * self.base**2
        return float(b), float(slope - 2.0 * b * self.base), float(d)


def fit_quadratic(levels: np.ndarray, values: np.ndarray, base: float) -> Quadratic:
    """Fit a quadratic to values (..., k) at levels (k,), ascending, of which one is the base.

    It leads through three values, and is fitted by least squares to more. The fit uses differences
    from the value at the base, to keep all digits of a response that is small compared with its
    mean. A coefficient b or c that may result from rounding of levels and values is set to 0, so
    that a straight line stays straight. The coefficients are arrays (...), or numbers for values
    (k,).
    """
    levels = np.asarray(levels, dtype=float)
    values = np.asarray(values, dtype=float)
    half_range = 0.5 * (levels[-1] - levels[0])
    others = levels != base
    u = (levels[others] - base) / half_range
    start = values[..., ~others]
    rises = values[..., others] - start
    if levels.size == 3:
        u1, u2 = u
        s1 = rises[..., 0] / u[0]
        s2 = rises[..., 1] / u[1]
        b = (s2 - s1) / (u2 - u1)
        c = (u2 * s1 - u1 * s2) / (u2 - u1)
        d = start[..., 0]
        weights = np.array([[1.0, 1.0], [abs(u2), abs(u1)]]) / (np.abs(u) * (u2 - u1))
    else:
        inverse = np.linalg.pinv(np.vander(np.append(u, 0.0), 3))
        moved = np.concatenate([rises, np.zeros_like(start)], axis=-1)
        b, c, d = np.moveaxis((inverse @ moved[..., None])[..., 0], -1, 0)
        d = start[..., 0] + d
        weights = np.abs(inverse[:2, :-1])
    slopes = np.abs(2.0 * b[..., None] * u) + np.abs(c)[..., None]
    rounding = np.abs(values).max(axis=-1, keepdims=True)
    rounding = rounding + slopes * np.abs(levels).max() / half_range
    noise = np.finfo(float).eps * (weights @ rounding[..., None])[..., 0]
    b = np.where(np.abs(b) > noise[..., 0], b, 0.0)
    c = np.where(np.abs(c) > noise[..., 1], c, 0.0)
    if values.ndim == 1:
        return Quadratic(float(b), float(c), float(d), float(base), float(half_range))
    return Quadratic(b, c, d, float(base), float(half_range))


def lack_of_fit(
    levels: np.ndarray, means: Any, deviations: Any, samples: int, quadratic: Quadratic
) -> float:
    """Return the p value of the hypothesis that a fitted quadratic holds, by an F test.

    ``means`` and standard ``deviations`` (k,) are of ``samples`` realisations at each of the levels
    (k,), different ones at each. NaN for three levels, or if nothing scatters.
    """
    freedom = len(levels) - 3
    scatter = float(np.mean(np.square(deviations)))
    if freedom < 1 or scatter == 0.0:
        return float("nan")
    misfit = samples * float(np.sum((np.asarray(means) - quadratic.at(levels)) ** 2)) / freedom
    return float(scipy.stats.f.sf(misfit / scatter, freedom, len(levels) * (samples - 1)))


def paired_lack_of_fit(levels: np.ndarray, samples: np.ndarray) -> float:
    """Return the p value of the hypothesis that a quadratic holds for the mean over surfaces.

    ``samples`` (k, n) are the responses of the same n surfaces at levels (k,). The test is that of
    Hotelling's T^2 of the k - 3 contrasts between levels that are 0 for every quadratic. They are
    computed on each surface, so that contributions equal at all levels cancel. NaN for three
    levels, for too few surfaces, or if the contrasts are dependent.
    """
    k, n = samples.shape
    count = k - 3
    if count < 1 or n <= count:
        return float("nan")
    u = (levels - levels.mean()) / (levels[-1] - levels[0])
    contrasts = np.linalg.qr(np.vander(u, 3), mode="complete")[0][:, 3:].T @ samples
    mean = contrasts.mean(axis=1)
    covariance = np.atleast_2d(np.cov(contrasts))
    if np.linalg.matrix_rank(covariance) != count:
        return float("nan")
    statistic = n * float(mean @ np.linalg.solve(covariance, mean))
    return float(scipy.stats.f.sf(statistic * (n - count) / (count * (n - 1)), count, n - count))


class QuadraticErrors(NamedTuple):
    """Errors of the coefficients of a fitted quadratic, in the parameter and in u."""

    in_parameter: np.ndarray  # standard errors (3,) of b, c and d of Eqs. (24) and (26)
    covariance: np.ndarray  # (3, 3) of the errors of b, c and d of `Quadratic`


def quadratic_errors(levels: np.ndarray, covariance: np.ndarray, base: float) -> QuadraticErrors:
    """Compute the errors of the coefficients that `fit_quadratic` returns.

    ``covariance`` (k, k) is that of the errors of the values at the levels (k,).
    """
    levels = np.asarray(levels, dtype=float)
    half_range = 0.5 * (levels[-1] - levels[0])
    fit = np.linalg.pinv(np.vander((levels - base) / half_range, 3))
    reduced = fit @ covariance @ fit.T
    m = base / half_range
    change = np.array([[1.0, 0.0, 0.0], [-2.0 * m, 1.0, 0.0], [m * m, -m, 1.0]])
    change /= np.array([half_range**2, half_range, 1.0])[:, None]
    in_parameter = change @ reduced @ change.T
    return QuadraticErrors(np.sqrt(np.maximum(np.diag(in_parameter), 0.0)), reduced)


def elasticity(levels: np.ndarray, samples: np.ndarray, base: float, paired: bool) -> Estimate:
    """Compute the elasticity d ln(mean)/d ln(parameter) at the base, with its standard error.

    ``samples`` (k, n) are the responses of n surfaces at levels (k,), the same at all levels if
    ``paired``. The form and the cases are those of `elasticity_of`.
    """
    samples = np.asarray(samples, dtype=float)
    return elasticity_of(levels, samples.mean(axis=1), mean_covariance(samples, paired), base)


def elasticity_by_form(levels: np.ndarray, means: np.ndarray, base: float) -> tuple[float, float]:
    """Return the elasticity d ln(mean)/d ln(parameter) at the base by two forms of the response.

    ``means`` (k,) at levels (k,) must be positive. The first form is a quadratic of the logarithms,
    the second is Eq. (24), a quadratic in the parameter. If a level is not positive, both results
    are by Eq. (24).
    """
    levels = np.asarray(levels, dtype=float)
    in_parameter = float(fit_quadratic(levels, means, base).elasticity())
    if (levels <= 0.0).any():
        return in_parameter, in_parameter
    return float(_slope_of_logs(levels, np.log(means), base)), in_parameter


def elasticity_contributions(levels: np.ndarray, samples: np.ndarray, base: float) -> np.ndarray:
    """Return the contributions (k, n) of single samples (k, n) at levels (k,) to an elasticity.

    The elasticity is that of the quadratic of the logarithms; levels must be positive. To first
    order its error is that of the sum, over the levels, of the means of these contributions.
    """
    samples = np.asarray(samples, dtype=float)
    weights = _slope_of_logs(np.asarray(levels, dtype=float), np.eye(len(levels)), base)
    return weights[:, None] * samples / samples.mean(axis=1, keepdims=True)


def _slope_of_logs(levels: np.ndarray, values: np.ndarray, base: float) -> Any:
    """Return the slope (...) at the base of the quadratic of values (..., k) in ln(levels)."""
    logs = np.log(levels)
    fit = fit_quadratic(logs, values, logs[levels == base].item())
    return fit.c / fit.half_range


def elasticity_of(
    levels: np.ndarray, means: np.ndarray, covariance: np.ndarray, base: float
) -> Estimate:
    """Compute the elasticity d ln(mean)/d ln(parameter) at the base, with its standard error.

    ``means`` (k,) are at levels (k,), ``covariance`` (k, k) is that of their errors. The elasticity
    is the slope of the quadratic through the logarithms, which is exact for a power law, however
    far apart the levels are. The slope of Eq. (24), a quadratic in the parameter, is 12 % too steep
    for an inverse proportion and levels of 0.68 and 1.36 times the base. Which form is right cannot
    be known from three levels, so that the standard error contains the difference of both slopes
    besides the error of the sample. If a level is not positive, the slope is that of Eq. (24), with
    the error of the sample alone. Both are NaN if a mean is not positive.
    """
    levels = np.asarray(levels, dtype=float)
    means = np.asarray(means, dtype=float)
    if not (means > 0.0).all():
        return Estimate(math.nan, math.nan)
    value, in_parameter = elasticity_by_form(levels, means, base)
    if (levels <= 0.0).any():
        fit = fit_quadratic(levels, means, base)
        reduced = quadratic_errors(levels, covariance, base).covariance
        gradient = np.array([0.0, base / (fit.half_range * fit.d), -in_parameter / fit.d])
        variance = float(gradient @ reduced @ gradient)
        return Estimate(in_parameter, math.sqrt(max(variance, 0.0)))  # rounding may be below 0
    logs = np.log(levels)
    relative = np.asarray(covariance) / np.outer(means, means)
    errors = quadratic_errors(logs, relative, logs[levels == base].item())
    of_sample = math.sqrt(max(errors.covariance[1, 1], 0.0)) / (0.5 * (logs[-1] - logs[0]))
    return Estimate(value, math.hypot(of_sample, value - in_parameter))


def smoothed_by_all_levels(
    levels: np.ndarray, means: np.ndarray, base: float
) -> tuple[np.ndarray, np.ndarray]:
    """Reduce the means (..., k) at levels (k,) to three levels, smoothed by all of them.

    Return the lowest, the middle and the highest level, and the means (..., 3) there by the
    quadratic of Eq. (24) that is fitted to all levels, so that more levels make the means more
    certain. Three levels are returned with their means as they are.
    """
    three = levels[[0, levels.size // 2, -1]]
    if levels.size == 3:
        return three, means
    fitted = fit_quadratic(levels, means, base)
    return three, np.stack([fitted.at(level) for level in three], axis=-1)

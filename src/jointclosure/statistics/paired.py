"""Indifference interval of a paired t test, with the same surfaces at every level.

A paired t test uses the scatter of the *difference* between a level and the base on the same
surface; the scatter between surfaces, which Eq. (28) uses, cancels. On surface s, with
u = (p - p_M)/half-range, a response is modelled as

    y_s(u) = a_s + c_s u + b u^2 + e_s(u),

a line with coefficients of this surface, a curvature common to all surfaces, and an irregular part
e_s of variance sigma^2 that is independent between levels, because the smallest change alters the
order of breakage. The difference from the base then has the mean b u^2 + c u and, at u != 0,
the variance

    S_d^2(u) = V u^2 + 2 sigma^2,

with V the variance of c_s over surfaces. In place of Eq. (29) it is critical where

    n (b u^2 + c u)^2 = t_cr^2 S_d^2(u),          t_cr with n - 1 degrees of freedom.

Without the irregular part (sigma = 0) u = 0 is a double root on both sides, and the length is 0 if
the mean slope is significant, because differences that decrease with the change are significant for
any change. Therefore sigma limits a paired study. Curvature of single surfaces counts as irregular,
because three levels do not separate it from sigma; the lengths are then too long. For a linear mean
the length is t_cr sqrt(2/n) sigma / sqrt(c^2 - t_cr^2 V/n).
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError, real_array
from jointclosure.statistics.correlations import Quadratic, fit_quadratic
from jointclosure.statistics.indifference import checked, closest_to_zero


class DifferenceScatter(NamedTuple):
    """Variances on single surfaces: V of the slope, and sigma^2 of the irregular part."""

    slope: float
    irregular: float


class PairedInterval(NamedTuple):
    """As `IndifferenceInterval`, of a paired test; the root is the base if the length is 0.

    ``linear_length``: without the curvature of the mean, infinite if the slope is not significant.
    """

    length: float
    root: float
    extrapolated: bool
    linear_length: float
    critical_value: float


def paired_indifference_interval(
    levels,
    samples,
    significance: float = 0.05,
    base: float | None = None,
    surfaces: int | None = None,
) -> PairedInterval:
    """Compute the smallest significant change in a paired t test on the same surfaces."""
    levels, samples = real_array("levels", levels), real_array("samples", samples)
    if samples.ndim != 2 or samples.shape[0] != levels.size or samples.shape[1] < 2:
        raise InputError(
            f"samples {samples.shape}: must be ({levels.size} levels, n >= 2 surfaces)"
        )
    means, deviations, n = samples.mean(axis=1), samples.std(axis=1, ddof=1), samples.shape[1]
    levels, means, _, base = checked(levels, means, deviations, n, significance, base)
    mean, scatter = fit_quadratic(levels, means, base), difference_scatter(levels, samples, base)
    n = n if surfaces is None else surfaces
    critical = float(scipy.stats.t.ppf(1.0 - 0.5 * significance, n - 1))
    u = _closest_root(mean, scatter, n, critical)
    root = base + u * mean.half_range
    slope = n * mean.c**2 - critical**2 * scatter.slope
    linear = np.inf
    if slope > 0.0:
        linear = critical * np.sqrt(2.0 * scatter.irregular / slope) * mean.half_range
    return PairedInterval(
        length=abs(u) * mean.half_range,
        root=float(root),
        extrapolated=bool(root < levels[0] or root > levels[-1]),
        linear_length=float(linear),
        critical_value=critical,
    )


def difference_scatter(levels, samples, base: float) -> DifferenceScatter:
    """Estimate the scatter of differences from the base, from responses of single surfaces.

    Level means are removed; each surface's deviations from them are fitted by a line. Residuals
    give sigma^2, with (n - 1)(k - 2) degrees of freedom, and the variance of the slopes, less what
    sigma^2 alone gives them, gives V. If V is negative, the surfaces show no different responses:
    the deviations are fitted by constants, and V is 0.
    """
    levels, samples = np.asarray(levels, dtype=float), np.asarray(samples, dtype=float)
    k, n = samples.shape
    u = (levels - base) / (0.5 * (levels[-1] - levels[0]))
    deviations = samples - samples.mean(axis=1, keepdims=True)
    for order in (1, 0):
        design = np.vander(u, order + 1, increasing=True)
        inverse = np.linalg.pinv(design)
        coefficients = inverse @ deviations
        freedom = (n - 1) * (k - order - 1)
        residual = float(np.sum((deviations - design @ coefficients) ** 2))
        irregular = residual / freedom
        covariance = coefficients @ coefficients.T / (n - 1) - irregular * (inverse @ inverse.T)
        if order == 0 or covariance[1, 1] >= 0.0:
            break
    return DifferenceScatter(float(covariance[1, 1]) if order else 0.0, irregular)


def p_of_difference(first, second, paired: bool) -> float:
    """Return the two-sided p of the t test that two levels have the same mean."""
    first, second = real_array("first", first), real_array("second", second)
    if first.shape != second.shape or first.ndim != 1 or first.size < 2:
        raise InputError(
            f"first {first.shape} and second {second.shape}: must be (n,) with equal n >= 2"
        )
    n = first.size
    change = second - first
    if paired:
        error, freedom = change.std(ddof=1) / np.sqrt(n), n - 1
    else:
        error = np.sqrt((first.var(ddof=1) + second.var(ddof=1)) / n)
        freedom = 2 * n - 2
    if error == 0.0:
        return 0.0 if change.any() else 1.0
    return float(2.0 * scipy.stats.t.sf(abs(change.mean()) / error, freedom))


def _closest_root(mean: Quadratic, scatter: DifferenceScatter, n: int, critical: float) -> float:
    size = max(abs(mean.b), abs(mean.c))
    if size == 0.0:
        return float("nan")
    b, c, t2 = mean.b / size, mean.c / size, critical**2
    slope, irregular = (value / size**2 for value in scatter)
    squared = n * c * c - t2 * slope
    quartic = np.array([n * b * b, 2.0 * (n * b * c), squared, 0.0, -2.0 * t2 * irregular])
    return closest_to_zero(quartic, scatter_at_zero=irregular > 0.0)

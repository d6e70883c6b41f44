"""Indifference intervals from the roots of the t test's quartic, Eqs. (28), (29).

The quartic is solved in u = (p - p_M)/half-range, where the constant of x cancels exactly and the
coefficients are near 1; in the parameter itself they span 40 decades. See
docs/decisions.md#0008-quartic.
"""

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from jointclosure.inputs import InputError, check_number, real_array
from jointclosure.statistics.correlations import Quadratic, fit_quadratic
from jointclosure.statistics.roots import largest_real_roots, real_roots


class IndifferenceInterval(NamedTuple):
    """Range about the base value in which a change of the parameter is not significant.

    ``length`` and ``root`` (the closest real root, in the parameter's unit) are NaN if the quartic
    has no real root. ``extrapolated``: the root lies outside the sampled levels.
    ``negative_deviation``: the fitted standard deviation is negative at the root.
    ``critical_value``: t with 2 n - 2 degrees of freedom.
    """

    length: float
    root: float
    extrapolated: bool
    negative_deviation: bool
    critical_value: float


def indifference_interval(
    levels: ArrayLike,
    means: ArrayLike,
    standard_deviations: ArrayLike,
    samples: int,
    significance: float = 0.05,
    base: float | None = None,
) -> IndifferenceInterval:
    """Compute the smallest change of a parameter that is significant in a t test.

    Parameters
    ----------
    levels : array (k,)
        Parameter values, strictly ascending, k >= 3.
    means, standard_deviations : array (k,)
        Means and standard deviations (ddof 1) of the target, such as maximum closure.
    samples : int
        Number n of realisations per level, at least 2.
    significance : float
        Significance level of the two-sided t test.
    base : float, optional
        The level p_M from which changes are measured, by default the middle one.

    Raises
    ------
    InputError
        If values are not real and finite (floats and integers of any type are
        converted to float64), there are fewer than three levels, levels are out of
        order, the base is not a level, a deviation is negative, or there are fewer
        than two samples.

    Notes
    -----
    Eqs. (24) to (29). With more than three levels the quadratics are
    least-squares fits, and x_M and S_M their values at the base.
    """
    levels, means, deviations, base = checked(
        levels, means, standard_deviations, samples, significance, base
    )
    mean = fit_quadratic(levels, means, base)
    deviation = fit_quadratic(levels, deviations, base)
    critical = float(scipy.stats.t.ppf(1.0 - 0.5 * significance, 2 * samples - 2))
    u = closest_root(mean, deviation, samples, critical)
    root = base + u * mean.half_range
    return IndifferenceInterval(
        length=abs(u) * mean.half_range,
        root=float(root),
        extrapolated=bool(root < levels[0] or root > levels[-1]),
        negative_deviation=bool(deviation.at(root) < 0.0),
        critical_value=critical,
    )


def indifference_lengths(
    levels: ArrayLike,
    means: ArrayLike,
    deviations: ArrayLike,
    samples: int,
    significance: float = 0.05,
    base: float | None = None,
) -> np.ndarray:
    """Compute the lengths of many indifference intervals at once, as `indifference_interval`.

    Parameters
    ----------
    levels : array (k,)
    means, deviations : arrays (..., k)
        Values of many studies with these levels; finite, deviations not negative.
    samples, significance, base
        As for `indifference_interval`.

    Returns
    -------
    array (...)
        Lengths in the parameter's unit, NaN without a real root. Nearly double roots may
        differ in their last digits from those of `indifference_interval`.

    Raises
    ------
    InputError
        As `indifference_interval`.
    """
    levels, means, deviations, base = checked(
        levels, means, deviations, samples, significance, base, many=True
    )
    shape = means.shape[:-1]
    mean = fit_quadratic(levels, means.reshape(-1, levels.size), base)
    deviation = fit_quadratic(levels, deviations.reshape(-1, levels.size), base)
    critical = float(scipy.stats.t.ppf(1.0 - 0.5 * significance, 2 * samples - 2))
    coefficients = quartic(mean, deviation, samples, critical).T
    varies = (mean.b != 0.0) | (mean.c != 0.0)
    roots = np.full(varies.size, np.nan)
    usual = varies & (coefficients[:, 4] < 0.0)
    # the closest root in u is the largest in 1/u, with reversed coefficients
    roots[usual] = 1.0 / largest_real_roots(coefficients[usual, ::-1])
    for i in np.flatnonzero(varies & ~usual):
        roots[i] = closest_to_zero(coefficients[i], scatter_at_zero=False)
    return (np.abs(roots) * mean.half_range).reshape(shape)


def quartic(mean: Quadratic, deviation: Quadratic, samples: int, critical: float) -> np.ndarray:
    """Return the coefficients (5, ...) of Eq. (29) in u, highest power first.

    The quartic is positive where a change is significant. Its scale is arbitrary: the largest
    coefficient of the quadratics counts as 1.
    """
    n, t2 = float(samples), critical * critical
    sizes = np.abs([*mean[:2], *deviation[:3]]).max(axis=0)
    scale = np.where(sizes > 0.0, sizes, 1.0)
    b, c, bs, cs, ds = (value / scale for value in (*mean[:2], *deviation[:3]))
    return np.array(
        [
            n * b * b - t2 * bs * bs,
            2.0 * n * b * c - 2.0 * t2 * bs * cs,
            n * c * c - t2 * (cs * cs + 2.0 * bs * ds),
            -2.0 * t2 * cs * ds,
            -2.0 * t2 * ds * ds,
        ]
    )


def closest_root(mean: Quadratic, deviation: Quadratic, samples: int, critical: float) -> float:
    """Return the real root u of `quartic` closest to 0, NaN without a real root."""
    if mean.b == 0.0 and mean.c == 0.0:
        return float("nan")
    coefficients = quartic(mean, deviation, samples, critical)
    return closest_to_zero(coefficients, scatter_at_zero=deviation.d != 0.0)


def closest_to_zero(coefficients: np.ndarray, scatter_at_zero: bool) -> float:
    """Return the real root closest to 0 of a quartic that is positive for significant changes.

    Without scatter at 0 the two lowest coefficients are 0 and u = 0 is a double root. It counts as
    a root if an arbitrarily small change is significant. NaN without a root.
    """
    if not scatter_at_zero:
        coefficients = coefficients[:3]
        lowest = next((value for value in coefficients[::-1] if value != 0.0), 0.0)
        odd = coefficients[2] == 0.0 and coefficients[1] != 0.0
        if lowest > 0.0 or odd:
            return 0.0
        coefficients = np.trim_zeros(coefficients, "b")  # ignore the roots at the base
    roots = real_roots(coefficients)
    return float(roots[np.argmin(np.abs(roots))]) if roots.size else float("nan")


def check_significance(significance: float) -> None:
    """Raise `InputError` unless a significance level lies between 0 and 1."""
    check_number("significance", significance)
    if not 0.0 < significance < 1.0:
        raise InputError(f"significance = {significance!r}: must be between 0 and 1 (0.05 is 5 %)")


def checked(
    levels: ArrayLike,
    means: ArrayLike,
    deviations: ArrayLike,
    samples: int,
    significance: float,
    base: float | None,
    many: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return levels, means and deviations as arrays, and the base; raise `InputError`."""
    levels, means = real_array("levels", levels), real_array("means", means)
    deviations = real_array("standard_deviations", deviations)
    if levels.ndim != 1 or levels.size < 3:
        raise InputError(f"levels = {levels.tolist()}: must be at least three")
    if not many and means.ndim != 1:
        raise InputError(f"means {means.shape}: must have the shape {levels.shape} of levels")
    if means.shape[-1:] != levels.shape or deviations.shape != means.shape:
        raise InputError(
            f"means {means.shape} and standard_deviations {deviations.shape}: "
            f"must have one value for each of the {levels.size} levels"
        )
    if not np.all(np.diff(levels) > 0.0):
        raise InputError(f"levels = {levels.tolist()}: must be strictly ascending")
    if np.any(deviations < 0.0):
        raise InputError(
            f"standard_deviations: the smallest is {deviations.min()}, must not be negative"
        )
    check_number("samples", samples, whole=True)
    if samples < 2:
        raise InputError(f"samples = {samples!r}: must be a whole number from 2 on")
    check_significance(significance)
    base = levels[levels.size // 2] if base is None else base
    if base not in levels:
        raise InputError(f"base = {base!r}: must be one of the levels {levels.tolist()}")
    return levels, means, deviations, float(base)

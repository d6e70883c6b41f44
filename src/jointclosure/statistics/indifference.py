"""Indifference intervals from the roots of the t test's quartic, Eqs. (28), (29).

The quartic is solved in u = (p - p_M)/half-range, where the constant of x cancels exactly and the
coefficients are near 1; in the parameter itself they span 40 decades. See
docs/decisions.md#0008-quartic.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from jointclosure.inputs import InputError, check_number, real_array
from jointclosure.statistics.correlations import Quadratic, fit_quadratic

NEGLIGIBLE_ROOT = 1e-30
"""Roots smaller than this share of the bound of all roots are due to rounding."""
ITERATIONS = 200
"""Largest number of iterations of Newton's method with bisection; it needs far fewer."""


def real_roots(coefficients: np.ndarray) -> np.ndarray:
    """Return the distinct real roots of a polynomial (highest power first), ascending."""
    coefficients = np.trim_zeros(np.asarray(coefficients, dtype=float), "f")
    if coefficients.size <= 2:
        return -coefficients[1:] / coefficients[:1]
    # Fujiwara's bound of all roots
    ratios = np.abs(coefficients[1:] / coefficients[0])
    bound = 2.0 * float(np.max(ratios ** (1.0 / np.arange(1, ratios.size + 1))))
    turns = real_roots(np.polyder(coefficients))
    ends = np.concatenate([[-bound], turns[np.abs(turns) < bound], [bound]])
    values = np.polyval(coefficients, ends)
    signs = np.sign(values)  # a product of values may underflow
    crossing = np.flatnonzero(signs[:-1] * signs[1:] < 0.0)
    stated = (coefficients.tolist(),), 1e-300, 1e-15, 5000  # an end may be 1e17 times as far
    inner = [scipy.optimize.brentq(_horner, ends[i], ends[i + 1], *stated) for i in crossing]
    return np.unique([*ends[values == 0.0], *inner])


def _horner(u: Any, coefficients: Any) -> Any:
    """Evaluate polynomials by Horner's scheme, coefficients along the first axis."""
    value = 0.0 * u
    for coefficient in coefficients:
        value = value * u + coefficient
    return value


def largest_real_roots(coefficients: np.ndarray) -> np.ndarray:
    """Return the real root of largest magnitude (m,) of polynomials (m, degree + 1)."""
    roots, bound = _all_real_roots(np.asarray(coefficients, dtype=float))
    sizes = np.where(np.abs(roots) > NEGLIGIBLE_ROOT * bound[:, None], np.abs(roots), -np.inf)
    largest = np.take_along_axis(roots, sizes.argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.where(sizes.max(axis=1) > 0.0, largest, np.nan)


def _all_real_roots(polynomials: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return real roots (m, j), NaN if there are fewer than j, and their bounds (m,)."""
    degree = polynomials.shape[1] - 1
    powers = 1.0 / np.arange(1, degree + 1)
    # Fujiwara's bound of all roots
    ratios = np.abs(polynomials[:, 1:] / polynomials[:, :1])
    bound = 2.0 * (ratios**powers).max(axis=1)
    if degree == 1:
        return -polynomials[:, 1:] / polynomials[:, :1], bound
    derivatives = polynomials[:, :-1] * np.arange(degree, 0, -1)
    turns, _ = _all_real_roots(derivatives)
    outside = ~(np.abs(turns) < bound[:, None])
    turns = np.sort(np.where(outside, -bound[:, None], turns), axis=1)
    ends = np.hstack([-bound[:, None], turns, bound[:, None]])
    values = _horner(ends, polynomials.T[..., None])
    touching = np.where((values == 0.0) & (np.abs(ends) < bound[:, None]), ends, np.nan)
    crossing = np.sign(values[:, :-1]) * np.sign(values[:, 1:]) < 0.0
    row, column = np.nonzero(crossing)
    roots = np.full(crossing.shape, np.nan)
    roots[row, column] = _between(
        polynomials[row].T, derivatives[row].T, ends[row, column], ends[row, column + 1]
    )
    return np.hstack([roots, touching]), bound


def _between(
    polynomials: np.ndarray, derivatives: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Return the root of each polynomial (columns) between two ends of opposite signs."""
    rising = _horner(low, polynomials) < 0.0
    low, high = np.where(rising, low, high), np.where(rising, high, low)  # f(low) < 0
    root, before = 0.5 * (low + high), np.abs(high - low)
    result, open_ones = root.copy(), np.arange(root.size)
    for _ in range(ITERATIONS):
        value, slope = _horner(root, polynomials), _horner(root, derivatives)
        low, high = np.where(value < 0.0, root, low), np.where(value < 0.0, high, root)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = root - value / slope
        inside = (newton > np.minimum(low, high)) & (newton < np.maximum(low, high))
        short = np.abs(newton - root) < 0.5 * before
        following = np.where(inside & short, newton, 0.5 * (low + high))
        following = np.where(value == 0.0, root, following)
        change = np.abs(following - root)
        result[open_ones] = following
        going = change > 2.0 * np.finfo(float).eps * np.abs(following)
        if not going.any():
            break
        open_ones, root, before = open_ones[going], following[going], change[going]
        low, high = low[going], high[going]
        polynomials, derivatives = polynomials[:, going], derivatives[:, going]
    return result


class IndifferenceInterval(NamedTuple):
    """Range about the base value in which a change of the parameter is not significant."""

    length: float  # NaN if the quartic has no real root
    root: float  # the closest one, in the parameter's unit
    extrapolated: bool  # whether the root lies outside the sampled levels
    negative_deviation: bool  # of the fitted quadratic, at the root
    critical_value: float  # t with 2 n - 2 degrees of freedom


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
    critical, u = float(scipy.stats.t.ppf(1.0 - 0.5 * significance, 2 * samples - 2)), np.nan
    if mean.b != 0.0 or mean.c != 0.0:
        u = closest_to_zero(quartic(mean, deviation, samples, critical), deviation.d != 0.0)
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
    """Compute the lengths of many indifference intervals at once, as `indifference_interval`."""
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
    """Return the coefficients (5, ...) of Eq. (29) in u, highest power first."""
    n, t2 = float(samples), critical * critical
    sizes = np.abs([*mean[:2], *deviation[:3]]).max(axis=0)
    scale = np.where(sizes > 0.0, sizes, 1.0)
    b, c, bs, cs, ds = (value / scale for value in (*mean[:2], *deviation[:3]))
    fourth, third = n * b * b - t2 * bs * bs, 2.0 * n * b * c - 2.0 * t2 * bs * cs
    second = n * c * c - t2 * (cs * cs + 2.0 * bs * ds)
    return np.array([fourth, third, second, -2.0 * t2 * cs * ds, -2.0 * t2 * ds * ds])


def closest_to_zero(coefficients: np.ndarray, scatter_at_zero: bool) -> float:
    """Return the real root closest to 0 of a quartic that is positive for significant changes."""
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

"""Indifference intervals: the smallest change of a parameter that a t test finds significant.

Unpaired test, Eqs. (28) and (29): different surfaces at every level. The length of the interval is
a root of the t test's quartic, which is solved in u = (p - p_M)/half-range, where the constant of x
cancels exactly and the coefficients are near 1; in the parameter itself they span 40 decades. See
docs/decisions.md#0008-quartic.

Paired test: the same surfaces at every level. It uses the scatter of the *difference* between a
level and the base on the same surface; the scatter between surfaces, which Eq. (28) uses, cancels.
On surface s a response is modelled as

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

Method: the root closest to 0 is the largest one in 1/u. It is found by Newton's method from a start
beyond which the quartic is convex (`_highest_roots`). Where rounding may decide, all real roots are
isolated by those of the derivative, and bracketed (`_all_real_roots`). Neither needs eigenvalues of
a companion matrix, by which `numpy.roots` finds roots.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from jointclosure.inputs import InputError, check_count, check_number, check_sizes, real_array
from jointclosure.statistics.quadratics import Quadratic, fit_quadratic
from jointclosure.statistics.standard_errors import resampled

NEGLIGIBLE_ROOT = 1e-30  # share of the bound of all roots below which one is due to rounding
BLOCK = 4096  # quartics that are solved at once: they stay in the cache of a processor
NEARLY = 1e-10  # share of its terms below which the sign of a value may be due to rounding
NEWTON_STEPS = 16  # at most, from a start near the root; it needs about six
EPSILON = float(np.finfo(float).eps)  # distance of 1 to the next larger double
THIRD_TURNS = (2.0 * np.pi / 3.0, -2.0 * np.pi / 3.0, 0.0)
"""Angles [rad] that the trigonometric solution of a cubic adds for its three roots: the lowest, the
middle and the highest."""
LEAST_SIGNIFICANCE = 1e-9  # for less the critical value is lost in the rounding of 1 - p/2
MOST_SAMPLES = 10**12  # realisations per level; chosen
ITERATIONS = 200  # at most, of Newton's method with bisection; it needs far fewer


def _horner(u: Any, coefficients: Any) -> Any:
    """Evaluate polynomials at u by Horner's scheme.

    ``coefficients`` are along the first axis, highest power first.
    """
    value = 0.0 * u
    for coefficient in coefficients:
        value = value * u + coefficient
    return value


def largest_real_roots(coefficients: np.ndarray) -> np.ndarray:
    """Return the real root of largest magnitude (m,) of each of m polynomials; NaN if it has none.

    ``coefficients`` (m, degree + 1) are in descending order of powers.
    """
    coefficients = np.asarray(coefficients, dtype=float)
    if coefficients.shape[1] != 5:
        return _largest_isolated_roots(coefficients)
    largest = np.empty(len(coefficients))
    certain = np.empty(len(coefficients), dtype=bool)
    for start in range(0, len(coefficients), BLOCK):
        block = slice(start, start + BLOCK)
        with np.errstate(all="ignore"):
            largest[block], certain[block] = _largest_quartic_roots(coefficients[block])
    uncertain = np.flatnonzero(~certain)
    for start in range(0, uncertain.size, BLOCK):
        part = uncertain[start : start + BLOCK]
        largest[part] = _largest_isolated_roots(coefficients[part])
    return largest


def _largest_quartic_roots(quartics: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the real roots of largest magnitude (m,) of quartics (m, 5), and which are certain.

    A root is NaN if there is none. The second value (m,) is False where rounding may decide, or
    where the method does not hold: the caller must solve these quartics in another way.

    In s = root/bound, with the bound a power of two, which rounds nothing, the quartic becomes
    q(s) = s^4 + ..., whose minima are at roots of a cubic. The outermost roots lie beyond the
    outermost minima below 0, where q is convex. Where rounding may decide, or q is not convex,
    nothing is certain.
    """
    monic = quartics.T[1:] / quartics.T[0]
    third, second, first, zeroth = np.abs(monic)
    bound = np.maximum(np.maximum(third, np.sqrt(second)), np.cbrt(first))
    bound = np.maximum(bound, np.sqrt(np.sqrt(zeroth)))
    scale = np.ldexp(2.0, np.frexp(bound)[1])
    monic = monic / scale ** np.arange(1, 5)[:, None]
    low, middle, high = _turning_points(monic)
    odd = np.array([-1.0, 1.0, -1.0, 1.0])[:, None]
    right = _highest_roots(high, monic)
    left = _highest_roots(-low, odd * monic)  # of q(-s)
    clear = right.clear & left.clear
    both = right.below & left.below
    both_solved = both & right.solved & left.solved
    of_right = np.where(both, right.solved, right.below)
    of_right = np.where(both_solved, right.root > left.root, of_right)
    largest = np.where(of_right, right.root, -left.root)
    # is the other root next to the same minimum, or beyond the other one, surely smaller?
    opposite = -largest
    rest = np.abs(opposite)
    positive = _evaluate_monic(opposite, monic) > NEARLY * _evaluate_monic(rest, np.abs(monic))
    outside = np.where(of_right, opposite <= low, opposite >= high)
    past_middle = np.where(of_right, opposite <= middle, opposite >= middle)
    past_minimum = np.where(of_right, opposite < high, opposite > low)
    smaller = np.where(
        both, both_solved | (outside & positive), past_minimum & (past_middle | positive)
    )
    solved = np.where(of_right, right.solved, left.solved)
    certain = clear & smaller & solved & (rest > NEARLY)
    none = ~right.below & ~left.below
    return np.where(none, np.nan, largest * scale), np.where(none, clear, certain)


def _evaluate_monic(s: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Evaluate monic quartics s^4 + ... at s (m,); the other ``coefficients`` are (4, m)."""
    third, second, first, zeroth = coefficients
    return (((s + third) * s + second) * s + first) * s + zeroth


def _turning_points(monic: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the lowest, middle and highest turning point (m,) of monic quartics (4, m).

    All three are the same where a quartic has one turning point.
    """
    third, second, first, _ = monic
    centre = -0.25 * third
    p = 0.5 * second - 3.0 * centre * centre
    q = 0.25 * first + centre * (0.5 * second - 2.0 * centre * centre)
    half = 0.5 * q
    third_p = p / 3.0
    discriminant = half * half + third_p * third_p * third_p
    single = discriminant > 0.0
    cube = np.cbrt(np.abs(half) + np.sqrt(np.where(single, discriminant, 0.0)))
    only = np.where(half > 0.0, -1.0, 1.0) * (cube - third_p / cube)
    radius = np.sqrt(np.where(single, 0.0, -third_p))
    angle = np.arccos(np.clip(-half / (radius * radius * radius), -1.0, 1.0)) / 3.0
    points = (2.0 * radius * np.cos(angle + turn) for turn in THIRD_TURNS)
    low, middle, high = (centre + np.where(single, only, point) for point in points)
    return low, middle, high


class _Outermost(NamedTuple):
    """Roots (m,) of quartics above their highest minimum."""

    root: np.ndarray  # meaningful only where the minimum is below 0
    below: np.ndarray  # whether the minimum is below 0, so that there is a root
    clear: np.ndarray  # whether that is certain in spite of rounding
    solved: np.ndarray  # whether Newton's method found the root


def _highest_roots(minimum: np.ndarray, monic: np.ndarray) -> _Outermost:
    """Return the roots of monic quartics (4, m) above their highest ``minimum`` (m,).

    Newton's method. The start is the root of the parabola through the minimum, but not below the
    inflection, so that it lies where the quartic is convex: then the first step overshoots at most,
    and all others descend to the root. A textbook's Newton method has no such guarantee.
    """
    third, second, first, _ = monic
    depth = _evaluate_monic(minimum, monic)
    size = _evaluate_monic(np.abs(minimum), np.abs(monic))
    below = depth < 0.0
    bend = np.sqrt(np.maximum(0.0625 * third * third - second / 6.0, 0.0)) - 0.25 * third
    convex = (bend <= minimum) | (_evaluate_monic(bend, monic) < 0.0)
    curvature = (6.0 * minimum + 3.0 * third) * minimum + second
    s = minimum + np.sqrt(np.maximum(-depth / curvature, 0.0))
    s = np.where(np.isfinite(s), np.minimum(np.maximum(s, bend), 1.0), 1.0)
    step = s
    for _ in range(NEWTON_STEPS):
        slope = ((4.0 * s + 3.0 * third) * s + 2.0 * second) * s + first
        step = _evaluate_monic(s, monic) / slope
        s = s - step
        if not np.any(below & convex & (np.abs(step) > 2.0 * EPSILON * np.abs(s))):
            break
    solved = convex & (np.abs(step) <= NEARLY * np.abs(s))
    return _Outermost(s, below, np.abs(depth) > NEARLY * size, solved)


def _largest_isolated_roots(polynomials: np.ndarray) -> np.ndarray:
    """Return the real root of largest magnitude (m,) of polynomials, by way of all real roots.

    It is NaN if there is none, or only roots that may be rounding (`NEGLIGIBLE_ROOT`).
    """
    roots, bound = _all_real_roots(polynomials)
    sizes = np.where(np.abs(roots) > NEGLIGIBLE_ROOT * bound[:, None], np.abs(roots), -np.inf)
    largest = np.take_along_axis(roots, sizes.argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.where(sizes.max(axis=1) > 0.0, largest, np.nan)


def _all_real_roots(polynomials: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the real roots (m, j) of polynomials (m, degree + 1), and a bound (m,) of their sizes.

    Places without a root are NaN, and roots are not in order. Between two neighbouring roots of the
    derivative, which are found by a call of this function, a polynomial has at most one root.
    """
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
    touching = np.where((values == 0.0) & (np.abs(ends) <= bound[:, None]), ends, np.nan)
    crossing = np.sign(values[:, :-1]) * np.sign(values[:, 1:]) < 0.0
    row, column = np.nonzero(crossing)
    roots = np.full(crossing.shape, np.nan)
    roots[row, column] = _bracketed_roots(
        polynomials[row].T, derivatives[row].T, ends[row, column], ends[row, column + 1]
    )
    return np.hstack([roots, touching]), bound


def _bracketed_roots(
    polynomials: np.ndarray, derivatives: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Return the root (m,) of each polynomial between ``low`` and ``high`` (m,).

    ``polynomials`` (degree + 1, m) have opposite signs there; ``derivatives`` are theirs.

    Newton's method within a bracket: the bracket is halved instead where a step leaves it, or is
    not shorter than half of the last one, so that it ends also where the slope vanishes.
    """
    rising = _horner(low, polynomials) < 0.0
    below = np.where(rising, low, high)  # where the polynomial is negative
    above = np.where(rising, high, low)
    root = 0.5 * (below + above)
    before = np.abs(above - below)
    result = root.copy()
    open_ones = np.arange(root.size)
    for _ in range(ITERATIONS):
        value = _horner(root, polynomials)
        slope = _horner(root, derivatives)
        below = np.where(value < 0.0, root, below)
        above = np.where(value < 0.0, above, root)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = root - value / slope
        inside = (newton > np.minimum(below, above)) & (newton < np.maximum(below, above))
        short = np.abs(newton - root) < 0.5 * before
        following = np.where(inside & short, newton, 0.5 * (below + above))
        following = np.where(value == 0.0, root, following)
        change = np.abs(following - root)
        result[open_ones] = following
        going = change > 2.0 * EPSILON * np.abs(following)
        if not going.any():
            break
        open_ones = open_ones[going]
        root = following[going]
        before = change[going]
        below = below[going]
        above = above[going]
        polynomials = polynomials[:, going]
        derivatives = derivatives[:, going]
    return result


class IndifferenceInterval(NamedTuple):
    """Range about the base value in which a change of the parameter is not significant."""

    length: float  # distance of the root from the base; NaN if the quartic has no real root
    root: float  # the closest one to the base, in the parameter's unit; NaN like the length
    extrapolated: bool  # whether the root lies outside the sampled levels
    negative_deviation: bool  # whether the fitted deviation is below 0 at the root
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

    Returns
    -------
    IndifferenceInterval
        The length of the interval and its end, in the unit of the levels. Both are NaN if no change
        is significant.

    Raises
    ------
    InputError
        If values are not real and finite (floats and integers of any type are
        converted to float64), there are fewer than three levels, levels are out of
        order, the base is not a level, a deviation is negative, there are fewer
        than two samples, the significance is below 1e-9, or numbers are so large
        or small that their squares do not fit in double precision.

    Notes
    -----
    Eqs. (24) to (29). With more than three levels the quadratics are
    least-squares fits, and x_M and S_M their values at the base.
    """
    levels, means, deviations, base = checked_levels(
        levels, means, standard_deviations, samples, significance, base
    )
    _, deviation, critical, (u,) = _solve(levels, means, deviations, samples, significance, base)
    root = base + u * deviation.half_range
    return IndifferenceInterval(
        length=abs(float(u)) * deviation.half_range,
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
    """Compute the lengths (...) of many indifference intervals at once; NaN where there is no root.

    ``means`` and ``deviations`` are (..., k) at ``levels`` (k,). Other arguments and errors are as
    for `indifference_interval`.
    """
    response = ResponseMoments(levels, means, deviations, base)
    return lengths_of_responses([response], samples, significance)[0]


class ResponseMoments(NamedTuple):
    """Means and standard deviations of a response at the levels of one parameter."""

    levels: ArrayLike  # (k,)
    means: Any  # (..., k); converted and checked where lengths are computed
    deviations: Any  # (..., k)
    base: float | None  # level from which changes are measured, by default the middle one


def lengths_of_responses(
    responses: Sequence[ResponseMoments], samples: int, significance: float = 0.05
) -> list[np.ndarray]:
    """Compute the `indifference_lengths` of several parameters, an array (...) for each.

    The roots of all parameters are solved at once, which takes less time.
    """
    half_ranges = []
    shapes = []
    varying = []
    quartics = []
    for response in responses:
        levels, means, deviations, base = checked_levels(
            *response[:3], samples, significance, response.base, many=True
        )
        mean, _, _, varies, coefficients = _quartics(
            levels, means, deviations, samples, significance, base
        )
        half_ranges.append(mean.half_range)
        shapes.append(means.shape[:-1])
        varying.append(varies)
        quartics.append(coefficients)
    if not shapes:
        return []
    varies = np.concatenate(varying)
    roots = np.full(varies.size, np.nan)
    roots[varies] = closest_roots(np.concatenate(quartics))
    parts = np.split(np.abs(roots), np.cumsum([one.size for one in varying])[:-1])
    return [
        (part * half_range).reshape(shape)
        for part, half_range, shape in zip(parts, half_ranges, shapes, strict=True)
    ]


def _solve(
    levels: np.ndarray,
    means: np.ndarray,
    deviations: np.ndarray,
    samples: int,
    significance: float,
    base: float,
) -> tuple[Quadratic, Quadratic, float, np.ndarray]:
    """Fit quadratics to means and deviations (m, k) at levels (k,), and solve Eq. (29).

    Return the quadratics of means and of deviations, the critical value of the t test, and the
    roots (m,) closest to the base, in u. A root is NaN if there is none, or if the means do not
    vary.
    """
    mean, deviation, critical, varies, quartics = _quartics(
        levels, means, deviations, samples, significance, base
    )
    roots = np.full(varies.size, np.nan)
    roots[varies] = closest_roots(quartics)
    return mean, deviation, critical, roots


@cache
def critical_value(samples: int, significance: float) -> float:
    """Return the critical value of the two-sided t test with 2 n - 2 degrees of freedom."""
    return float(scipy.stats.t.ppf(1.0 - 0.5 * significance, 2 * samples - 2))


def _quartics(
    levels: np.ndarray,
    means: np.ndarray,
    deviations: np.ndarray,
    samples: int,
    significance: float,
    base: float,
) -> tuple[Quadratic, Quadratic, float, np.ndarray, np.ndarray]:
    """Fit quadratics to means and deviations (m, k), and make the quartics of Eq. (29) in u.

    Return the quadratics of means and of deviations, the critical value of the t test, whether the
    means vary with the parameter (m,), and the quartics (n, 5) of the n that vary, highest power
    first.
    """
    mean, deviation = (
        fit_quadratic(levels, values.reshape(-1, levels.size), base)
        for values in (means, deviations)
    )
    critical = critical_value(samples, significance)
    varies = (mean.b != 0.0) | (mean.c != 0.0)
    return mean, deviation, critical, varies, quartic(mean, deviation, samples, critical).T[varies]


def quartic(mean: Quadratic, deviation: Quadratic, samples: int, critical: float) -> np.ndarray:
    """Return the coefficients (5, ...) of Eq. (29) in u, highest power first.

    ``mean`` and ``deviation`` are the fitted quadratics (...), ``samples`` the number n of
    surfaces, ``critical`` the critical value of the t test. The coefficients are scaled by the
    largest of the quadratics', which does not change the roots.
    """
    n = float(samples)
    t2 = critical * critical
    sizes = np.abs([*mean[:2], *deviation[:3]]).max(axis=0)
    scale = np.where(sizes > 0.0, sizes, 1.0)
    b, c, bs, cs, ds = (value / scale for value in (*mean[:2], *deviation[:3]))
    fourth = n * b * b - t2 * bs * bs
    third = 2.0 * n * b * c - 2.0 * t2 * bs * cs
    second = n * c * c - t2 * (cs * cs + 2.0 * bs * ds)
    return np.array([fourth, third, second, -2.0 * t2 * cs * ds, -2.0 * t2 * ds * ds])


def closest_roots(quartics: np.ndarray) -> np.ndarray:
    """Return the real roots (m,) closest to 0 of quartics (m, 5), highest power first.

    A quartic is positive where a change is significant, so that the root is where changes begin to
    be significant: NaN if none is, and 0 if any change is. The constant of a quartic is 0 if there
    is no scatter at the base, and negative otherwise.
    """
    usual = quartics[:, 4] < 0.0
    roots = np.full(usual.size, np.nan)
    # the closest root in u is the largest in 1/u, with reversed coefficients
    roots[usual] = 1.0 / largest_real_roots(quartics[usual, ::-1])
    roots[~usual] = _closest_quadratic_roots(quartics[~usual, :3])
    return roots


def _closest_quadratic_roots(quadratics: np.ndarray) -> np.ndarray:
    """Return the `closest_roots` (m,) of quartics without scatter at the base.

    Such a quartic has a double root at 0. ``quadratics`` (m, 3) are what is left when it is divided
    by u^2, highest power first.
    """
    second, first, constant = quadratics.T
    lowest = np.where(constant != 0.0, constant, np.where(first != 0.0, first, second))
    at_zero = (lowest > 0.0) | ((constant == 0.0) & (first != 0.0))
    apart = ~at_zero & (constant < 0.0) & ((second != 0.0) | (first != 0.0))
    roots = np.where(at_zero, 0.0, np.nan)
    roots[apart] = 1.0 / largest_real_roots(quadratics[apart, ::-1])
    return roots


def check_significance(significance: float) -> None:
    """Raise `InputError` unless a significance level is from `LEAST_SIGNIFICANCE` to below 1."""
    check_number("significance", significance)
    if not LEAST_SIGNIFICANCE <= significance < 1.0:
        raise InputError(
            f"significance = {significance!r}: must be from {LEAST_SIGNIFICANCE:g} to below 1 "
            "(0.05 is 5 %)"
        )


def checked_levels(
    levels: ArrayLike,
    means: ArrayLike,
    deviations: ArrayLike,
    samples: int,
    significance: float,
    base: float | None,
    many: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return levels (k,), means and deviations (k,) as arrays, and the base, by default the middle.

    Raise `InputError` if one of them, the number of samples or the significance is not allowed
    (`indifference_interval`). With ``many`` means and deviations may be (..., k).
    """
    levels = real_array("levels", levels)
    means = real_array("means", means)
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
    check_count("samples", samples, 2, MOST_SAMPLES)
    check_significance(significance)
    check_sizes("levels", levels)
    check_sizes("range of the levels", levels[[-1]] - levels[0])
    check_sizes("means", means)
    check_sizes("standard_deviations", deviations)
    if base is not None:
        check_number("base", base)
    base = levels[levels.size // 2] if base is None else base
    if base not in levels:
        raise InputError(f"base = {base!r}: must be one of the levels {levels.tolist()}")
    return levels, means, deviations, float(base)


class DifferenceScatter(NamedTuple):
    """Variances (...) of responses on single surfaces: V of slopes, sigma^2 of irregular parts."""

    slope: np.ndarray
    irregular: np.ndarray


class PairedInterval(NamedTuple):
    """Range about the base value in which a change is not significant in a paired test.

    ``length``, ``root`` and ``extrapolated`` are as for `IndifferenceInterval`; the root is the
    base if the length is 0. ``linear_length`` is the length without the curvature of the mean,
    infinite if the slope of the mean is not significant. ``critical_value`` is t with n - 1 degrees
    of freedom.
    """

    length: float
    root: float
    extrapolated: bool
    linear_length: float
    critical_value: float


def paired_indifference_interval(
    levels: np.ndarray,
    samples: np.ndarray,
    significance: float = 0.05,
    base: float | None = None,
    surfaces: int | None = None,
) -> PairedInterval:
    """Compute the smallest change of a parameter that is significant in a paired t test.

    ``samples`` (k, n) are the responses of the same n surfaces at ``levels`` (k,), ascending, from
    which the model of the module is estimated. The ``base`` is one of the levels, by default the
    middle one. ``surfaces`` is the number of surfaces of the test, by default n. Arguments are not
    checked.
    """
    base = float(levels[levels.size // 2]) if base is None else base
    n = samples.shape[1] if surfaces is None else surfaces
    mean, scatter, critical, (u,) = _solve_pairs(levels, samples[None], n, significance, base)
    root = base + u * mean.half_range
    slope = float(n * mean.c[0] ** 2 - critical**2 * scatter.slope[0])
    linear = np.inf
    if slope > 0.0:
        linear = critical * np.sqrt(2.0 * scatter.irregular[0] / slope) * mean.half_range
    return PairedInterval(
        length=abs(float(u)) * mean.half_range,
        root=float(root),
        extrapolated=bool(root < levels[0] or root > levels[-1]),
        linear_length=float(linear),
        critical_value=critical,
    )


def _solve_pairs(
    levels: np.ndarray, samples: np.ndarray, n: int, significance: float, base: float
) -> tuple[Quadratic, DifferenceScatter, float, np.ndarray]:
    """Fit the paired model to samples (m, k, surfaces) and solve its quartics.

    ``n`` is the number of surfaces of the test. Return the quadratics of the means, the scatters of
    the differences, the critical value of the t test, and the roots (m,) closest to the base, in u:
    NaN if there is none, or if the means do not vary.
    """
    mean = fit_quadratic(levels, samples.mean(axis=-1), base)
    scatter = difference_scatter(levels, samples, base)
    critical = float(scipy.stats.t.ppf(1.0 - 0.5 * significance, n - 1))
    size = np.maximum(np.abs(mean.b), np.abs(mean.c))
    varies = size > 0.0
    t2 = critical**2
    size = size[varies]
    b = mean.b[varies] / size
    c = mean.c[varies] / size
    slope, irregular = (value[varies] / size**2 for value in scatter)
    quartics = [
        n * b * b,
        2.0 * (n * b * c),
        n * c * c - t2 * slope,
        0.0 * b,
        -2.0 * t2 * irregular,
    ]
    roots = np.full(varies.size, np.nan)
    roots[varies] = closest_roots(np.stack(quartics, axis=1))
    return mean, scatter, critical, roots


def difference_scatter(levels: ArrayLike, samples: ArrayLike, base: float) -> DifferenceScatter:
    """Estimate the variances V and sigma^2 (...) of responses (..., k, n) of the same n surfaces.

    They are those of the paired model (see the module). The mean of each of the k ``levels`` is
    removed, and the deviations of each surface are fitted by a line in u. The residuals give
    sigma^2, with (n - 1)(k - 2) degrees of freedom. The variance of the slopes, less what sigma^2
    alone contributes to it, is V. Where V would be negative, the surfaces do not differ in their
    response: the deviations are then fitted by constants instead, and V is 0.
    """
    levels = np.asarray(levels, dtype=float)
    samples = np.asarray(samples, dtype=float)
    k, n = samples.shape[-2:]
    u = (levels - base) / (0.5 * (levels[-1] - levels[0]))
    deviations = samples - samples.mean(axis=-1, keepdims=True)
    fits = []
    for order in (1, 0):
        design = np.vander(u, order + 1, increasing=True)
        inverse = np.linalg.pinv(design)
        last = inverse[-1] @ deviations
        rest = deviations - design @ (inverse @ deviations)
        irregular = np.sum(rest**2, axis=(-2, -1)) / ((n - 1) * (k - order - 1))
        variance = np.sum(last**2, axis=-1) / (n - 1) - irregular * (inverse[-1] @ inverse[-1])
        fits.append((variance, irregular))
    (slope, of_lines), (_, of_constants) = fits
    alike = slope < 0.0
    return DifferenceScatter(np.where(alike, 0.0, slope), np.where(alike, of_constants, of_lines))


def p_of_difference(first: np.ndarray, second: np.ndarray, paired: bool) -> float:
    """Return the two-sided p value of a t test of two samples (n,) for the same mean.

    If ``paired``, both are of the same surfaces in the same order. Without any scatter p is 1 for
    equal samples, else 0.
    """
    n = first.size
    change = second - first
    if paired:
        error = change.std(ddof=1) / np.sqrt(n)
        freedom = n - 1
    else:
        error = np.sqrt((first.var(ddof=1) + second.var(ddof=1)) / n)
        freedom = 2 * n - 2
    if error == 0.0:
        return 0.0 if change.any() else 1.0
    return float(2.0 * scipy.stats.t.sf(abs(change.mean()) / error, freedom))


class BootstrapInterval(NamedTuple):
    """Percentile interval of an indifference length over resamples.

    A resample without a root has an infinite length. ``standard_error`` is half of the central
    68.3 % range, which single long lengths do not affect; it is infinite if this range is not
    bounded.
    """

    low: float
    high: float
    share_without_root: float
    standard_error: float


def bootstrap_length(
    levels: np.ndarray,
    samples: np.ndarray,
    random: np.random.Generator,
    *,
    base: float,
    resamples: int,
    confidence: float = 0.95,
    significance: float = 0.05,
    paired: bool = False,
) -> BootstrapInterval:
    """Compute the bootstrap interval of an indifference length, by percentiles.

    ``samples`` (k, n) are the responses of n surfaces at ``levels`` (k,), one of which is the
    ``base``. If ``paired``, the surfaces are the same at all levels, and are resampled together.
    """
    drawn = resampled(samples, random, resamples, paired)
    chosen = np.array(list(drawn))
    if paired:
        mean, *_, u = _solve_pairs(levels, chosen, chosen.shape[2], significance, base)
        return interval_of_lengths(np.abs(u) * mean.half_range, confidence)
    means = chosen.mean(axis=2)
    deviations = chosen.std(axis=2, ddof=1)
    lengths = indifference_lengths(levels, means, deviations, chosen.shape[2], significance, base)
    return interval_of_lengths(lengths, confidence)


def interval_of_lengths(lengths: np.ndarray, confidence: float) -> BootstrapInterval:
    """Return the percentile interval of the lengths (resamples,) of resampled studies.

    NaN, which is a length without a root, counts as infinite.
    """
    lengths = np.where(np.isnan(lengths), np.inf, lengths)
    tail = 0.5 * (1.0 - confidence)
    low, high = np.quantile(lengths, [tail, 1.0 - tail], method="higher")
    below, above = np.quantile(lengths, scipy.stats.norm.cdf([-1.0, 1.0]), method="higher")
    error = 0.5 * (above - below) if np.isfinite(above) else np.inf
    without = float(np.mean(np.isinf(lengths)))
    return BootstrapInterval(float(low), float(high), without, float(error))

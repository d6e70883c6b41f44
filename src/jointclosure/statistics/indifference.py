"""Indifference intervals: from the roots of the t test's quartic, Eqs. (28), (29).

The quartic is solved in u = (p - p_M)/half-range, where the constant of x
drops out exactly and the coefficients stay near 1; in the parameter itself
they span 40 decades. See docs/decisions/0008-quartic.md.
"""

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from jointclosure.inputs import InputError, check_number, real_array
from jointclosure.statistics.correlations import Quadratic, fit_quadratic


class IndifferenceInterval(NamedTuple):
    """Within ``length`` of the base, a change makes no significant difference.

    ``length`` and ``root`` (the closest real root, in the parameter's unit)
    are NaN where the quartic has no real root. ``extrapolated``: the root lies
    outside the sampled levels. ``negative_deviation``: the fitted standard
    deviation is negative there. ``critical_value``: t with 2 n - 2 degrees of
    freedom.
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
    """Smallest change of a parameter that a t test tells from none.

    Parameters
    ----------
    levels : array (k,)
        Parameter values, strictly ascending, k >= 3.
    means, standard_deviations : array (k,)
        Of the target (maximum closure, say) at the levels; ddof 1.
    samples : int
        Realisations n per level, at least 2.
    significance : float
        Of the two-sided t test.
    base : float, optional
        The level p_M that a change departs from; the middle one unless given.

    Returns
    -------
    IndifferenceInterval

    Raises
    ------
    InputError
        Values that are no real finite numbers (floats and integers of any type
        are promoted to float64), fewer than three levels, levels out of order,
        a base that is none of them, a negative deviation, fewer than two samples.

    Notes
    -----
    Eqs. (24) to (29). With more than three levels the quadratics are
    least-squares fits, and x_M and S_M their values at the base.
    """
    levels, means, deviations = (
        real_array(name, values)
        for name, values in (
            ("levels", levels),
            ("means", means),
            ("standard_deviations", standard_deviations),
        )
    )
    base = _checked(levels, means, deviations, samples, significance, base)
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


def quartic(mean: Quadratic, deviation: Quadratic, samples: int, critical: float) -> np.ndarray:
    """Coefficients (5,) of Eq. (29) in u, highest power first; positive is significant."""
    n, t2 = float(samples), critical * critical
    b, c = mean.b, mean.c
    bs, cs, ds = deviation.b, deviation.c, deviation.d
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
    """Real root u of `quartic` closest to 0, NaN where there is none.

    Without scatter at the base, u = 0 is a double root. It counts where an
    arbitrarily small change is significant, else the next one does.
    """
    scale = max(abs(value) for value in (*mean[:2], *deviation[:3]))
    if scale == 0.0 or (mean.b == 0.0 and mean.c == 0.0):
        return float("nan")
    coefficients = quartic(
        Quadratic(mean.b / scale, mean.c / scale, 0.0, 0.0, 1.0),
        Quadratic(deviation.b / scale, deviation.c / scale, deviation.d / scale, 0.0, 1.0),
        samples,
        critical,
    )
    if deviation.d == 0.0:
        coefficients = coefficients[:3]
        lowest = next((value for value in coefficients[::-1] if value != 0.0), 0.0)
        odd = coefficients[2] == 0.0 and coefficients[1] != 0.0
        if lowest > 0.0 or odd:
            return 0.0
        coefficients = np.trim_zeros(coefficients, "b")  # the roots at the base do not count
    roots = real_roots(coefficients)
    return float(roots[np.argmin(np.abs(roots))]) if roots.size else float("nan")


def real_roots(coefficients: np.ndarray) -> np.ndarray:
    """Real roots of a polynomial (highest power first), each once, ascending.

    Between two neighbouring roots of the derivative a polynomial is monotone
    and has one root or none, which bisection finds: no threshold on imaginary
    parts decides whether a nearly double root is real.
    """
    coefficients = np.trim_zeros(np.asarray(coefficients, dtype=float), "f")
    if coefficients.size < 2:
        return np.empty(0)
    if coefficients.size == 2:
        return np.array([-coefficients[1] / coefficients[0]])
    # Fujiwara's bound of all roots
    ratios = np.abs(coefficients[1:] / coefficients[0])
    bound = 2.0 * float(np.max(ratios ** (1.0 / np.arange(1, ratios.size + 1))))
    turns = real_roots(np.polyder(coefficients))
    ends = np.concatenate([[-bound], turns[np.abs(turns) < bound], [bound]])
    values = np.polyval(coefficients, ends)
    signs = np.sign(values)  # a product of values may underflow
    roots = [end for end, value in zip(ends, values, strict=True) if value == 0.0]
    for left, right, before, after in zip(ends[:-1], ends[1:], signs[:-1], signs[1:], strict=True):
        if before * after < 0.0:
            roots.append(
                scipy.optimize.brentq(
                    _horner,
                    left,
                    right,
                    (coefficients.tolist(),),
                    xtol=1e-300,
                    rtol=1e-15,
                    maxiter=5000,  # an end may be 1e17 times as far as the root
                )
            )
    return np.array(sorted(set(roots)))


def _horner(u: float, coefficients: list[float]) -> float:
    """`numpy.polyval` of one number, to the last bit, in a tenth of its time."""
    value = 0.0
    for coefficient in coefficients:
        value = value * u + coefficient
    return value


def _checked(
    levels: np.ndarray,
    means: np.ndarray,
    deviations: np.ndarray,
    samples: int,
    significance: float,
    base: float | None,
) -> float:
    if levels.ndim != 1 or levels.size < 3:
        raise InputError(f"levels = {levels.tolist()}: needs at least three")
    if means.shape != levels.shape or deviations.shape != levels.shape:
        raise InputError(
            f"means {means.shape} and standard_deviations {deviations.shape}: "
            f"must have the shape {levels.shape} of levels"
        )
    if not np.all(np.diff(levels) > 0.0):
        raise InputError(f"levels = {levels.tolist()}: must be strictly ascending")
    if np.any(deviations < 0.0):
        raise InputError(f"standard_deviations = {deviations.tolist()}: must not be negative")
    check_number("samples", samples, whole=True)
    check_number("significance", significance)
    if samples < 2:
        raise InputError(f"samples = {samples!r}: must be a whole number from 2 on")
    if not 0.0 < significance < 1.0:
        raise InputError(f"significance = {significance!r}: must lie between 0 and 1")
    if base is None:
        return float(levels[levels.size // 2])
    if base not in levels:
        raise InputError(f"base = {base!r}: must be one of the levels {levels.tolist()}")
    return float(base)

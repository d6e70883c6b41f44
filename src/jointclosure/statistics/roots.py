"""Real roots of polynomials: to the last digits for one, or for many at once."""

import numpy as np
import scipy


def real_roots(coefficients: np.ndarray) -> np.ndarray:
    """Return the distinct real roots of a polynomial (highest power first), ascending.

    Between two neighbouring roots of the derivative a polynomial is monotone and has one root or
    none, which is computed by bisection. No threshold on imaginary parts decides whether a nearly
    double root is real.
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
    """Evaluate `numpy.polyval` for one number, to the last bit, in a tenth of its time."""
    value = 0.0
    for coefficient in coefficients:
        value = value * u + coefficient
    return value


NEGLIGIBLE_ROOT = 1e-30
"""Roots smaller than this share of the bound of all roots are due to rounding."""

ITERATIONS = 200
"""Largest number of iterations of Newton's method with bisection; it needs far fewer."""


def largest_real_roots(coefficients: np.ndarray) -> np.ndarray:
    """Return the real root of largest magnitude of each of many polynomials.

    Parameters
    ----------
    coefficients : array (m, degree + 1)
        Highest power first; the first must not be 0.

    Returns
    -------
    array (m,)
        Roots, NaN without a real root (other than 0).

    Notes
    -----
    As in `real_roots`, a polynomial is monotone between neighbouring roots of its
    derivative, so that signs identify roots, without any threshold.
    """
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
    values = _values(polynomials.T[..., None], ends)
    touching = np.where((values == 0.0) & (np.abs(ends) < bound[:, None]), ends, np.nan)
    crossing = np.sign(values[:, :-1]) * np.sign(values[:, 1:]) < 0.0
    row, column = np.nonzero(crossing)
    roots = np.full(crossing.shape, np.nan)
    roots[row, column] = _between(
        polynomials[row].T, derivatives[row].T, ends[row, column], ends[row, column + 1]
    )
    return np.hstack([roots, touching]), bound


def _values(coefficients, u):
    """Evaluate polynomials by Horner's scheme, coefficients along the first axis."""
    value = np.zeros_like(u)
    for coefficient in coefficients:
        value = value * u + coefficient
    return value


def _between(polynomials, derivatives, low, high) -> np.ndarray:
    """Return the root of each polynomial (columns) between two ends of opposite signs.

    Newton's step is used if it stays inside and halves the last but one step, and bisection
    otherwise.
    """
    rising = _values(polynomials, low) < 0.0
    low, high = np.where(rising, low, high), np.where(rising, high, low)  # f(low) < 0
    root = 0.5 * (low + high)
    result = root.copy()
    open_ones = np.arange(root.size)
    before = np.abs(high - low)
    for _ in range(ITERATIONS):
        value, slope = _values(polynomials, root), _values(derivatives, root)
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

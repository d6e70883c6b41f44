"""Standard errors of what a study publishes, and numbers rounded to them."""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.correlations import Quadratic, fit_quadratic


class Estimate(NamedTuple):
    """A number and its standard error, in the same unit."""

    value: float
    standard_error: float


class QuadraticErrors(NamedTuple):
    """Standard errors of a quadratic's coefficients, in u and in the parameter.

    ``reduced``: of `Quadratic`'s b, c, d; ``in_parameter``: of those of Eqs. (24) and (26).
    ``covariance`` (3, 3): of the reduced ones.
    """

    reduced: tuple[float, float, float]
    in_parameter: tuple[float, float, float]
    covariance: np.ndarray


def mean_of(samples) -> Estimate:
    """Mean of samples (n,) and its standard error S/sqrt(n)."""
    samples = np.asarray(samples, dtype=float)
    return Estimate(float(samples.mean()), float(samples.std(ddof=1) / np.sqrt(samples.size)))


def deviations_of(samples) -> tuple[np.ndarray, np.ndarray]:
    """Standard deviations (ddof 1) of rows (..., n), and their errors if they are normal."""
    samples = np.asarray(samples, dtype=float)
    deviations = samples.std(axis=-1, ddof=1)
    return deviations, deviations / np.sqrt(2.0 * (samples.shape[-1] - 1))


def deviation_of(samples) -> Estimate:
    """`deviations_of` one row (n,)."""
    deviation, error = deviations_of(samples)
    return Estimate(float(deviation), float(error))


def variation_of(samples) -> Estimate:
    """Coefficient of variation S/mean of normal samples (n,), with its standard error."""
    samples = np.asarray(samples, dtype=float)
    ratio = float(samples.std(ddof=1) / samples.mean())
    n = samples.size
    return Estimate(ratio, abs(ratio) * float(np.sqrt(0.5 / (n - 1) + ratio**2 / n)))


def correlation_of(first, second) -> Estimate:
    """Pearson's correlation of two rows (n,), and its error (1 - r^2)/sqrt(n - 1)."""
    r = float(np.corrcoef(first, second)[0, 1])
    return Estimate(r, (1.0 - r * r) / float(np.sqrt(len(first) - 1)))


def bootstrap_error(
    statistic, samples, random: np.random.Generator, resamples: int = 400, paired: bool = True
):
    """Standard error of any statistic, by resampling surfaces.

    Parameters
    ----------
    statistic : callable
        From samples like those given to a number or an array of numbers.
    samples : array (n,) or (k, n)
        The last axis is surfaces.
    random : Generator
    resamples : int
    paired : bool
        Whether a column is the same surface at every level; else every row is resampled alone.

    Returns
    -------
    float or array, as the statistic. Deviations are enlarged by sqrt(n/(n - 1)), which
    makes the error of a mean S/sqrt(n).
    """
    samples = np.asarray(samples, dtype=float)
    n = samples.shape[-1]
    found = []
    for _ in range(resamples):
        shape = (n,) if paired else samples.shape
        index = np.broadcast_to(random.integers(n, size=shape), samples.shape)
        found.append(statistic(np.take_along_axis(samples, index, axis=-1)))
    return np.std(found, axis=0, ddof=1) * np.sqrt(n / (n - 1))


def mean_covariance(samples, paired: bool) -> np.ndarray:
    """Covariance (k, k) of the means over samples (k, n); diagonal for independent draws."""
    covariance = np.atleast_2d(np.cov(samples)) / np.shape(samples)[1]
    return covariance if paired else np.diag(np.diag(covariance))


def deviation_covariance(samples, paired: bool) -> np.ndarray:
    """Covariance (k, k) of the standard deviations of normal samples (k, n).

    r^2 S_i S_j/(2 (n - 1)) with the correlation r between two levels, 0 for independent draws.
    """
    covariance = np.cov(samples)
    deviations = np.sqrt(np.diag(covariance))
    scale = np.outer(deviations, deviations)
    shared = np.divide(covariance**2, scale, out=np.zeros_like(scale), where=scale > 0.0)
    shared = shared / (2.0 * (np.shape(samples)[1] - 1))
    return shared if paired else np.diag(np.diag(shared))


def quadratic_errors(levels, covariance, base: float) -> QuadraticErrors:
    """Errors of the coefficients of `fit_quadratic`.

    Parameters
    ----------
    levels : array (k,)
    covariance : array (k, k)
        Of the fitted values: `mean_covariance` or `deviation_covariance`.
    base : float
    """
    fit = fit_matrix(levels, base)
    reduced = fit @ covariance @ fit.T
    half_range = 0.5 * (levels[-1] - levels[0])
    m = base / half_range
    change = np.array([[1.0, 0.0, 0.0], [-2.0 * m, 1.0, 0.0], [m * m, -m, 1.0]])
    change /= np.array([half_range**2, half_range, 1.0])[:, None]
    own = change @ reduced @ change.T
    return QuadraticErrors(_roots_of_diagonal(reduced), _roots_of_diagonal(own), reduced)


def fit_matrix(levels, base: float) -> np.ndarray:
    """The matrix (3, k) from values at the levels to the coefficients of their fit."""
    levels = np.asarray(levels, dtype=float)
    return np.linalg.pinv(np.vander((levels - base) / (0.5 * (levels[-1] - levels[0])), 3))


def elasticity(levels, samples, base: float, paired: bool) -> Estimate:
    """d ln(mean)/d ln(parameter) at the base, from the fitted quadratic.

    Parameters
    ----------
    levels : array (k,)
        Ascending; in one unit with ``base``.
    samples : array (k, n)
        The target at every level (rows); columns are the same surfaces where ``paired``.
    base : float
        The base level, not 0.
    paired : bool
        Common draws: what surfaces share at all levels leaves the error.

    Returns
    -------
    Estimate
        Its error to first order in those of slope and fitted value.
    """
    samples = np.asarray(samples, dtype=float)
    return elasticity_of(levels, samples.mean(axis=1), mean_covariance(samples, paired), base)


def elasticity_of(levels, means, covariance, base: float) -> Estimate:
    """`elasticity` from means (k,) at the levels (k,) and the covariance (k, k) of their errors."""
    levels = np.asarray(levels, dtype=float)
    mean: Quadratic = fit_quadratic(levels, means, base)
    value = mean.c / mean.d * base / mean.half_range
    reduced = quadratic_errors(levels, covariance, base).covariance
    gradient = np.array([0.0, base / (mean.half_range * mean.d), -value / mean.d])
    variance = max(float(gradient @ reduced @ gradient), 0.0)  # rounding may make it negative
    return Estimate(float(value), float(np.sqrt(variance)))


def rounded(value: float, standard_error: float) -> str:
    """A number rounded to its error, as text: "0.083 ± 0.004".

    The error has two digits where they begin with 10 to 35, one where with 36 to 94 (the
    rule of the Particle Data Group); the number ends at the same place. Where the error
    is 0 or not known (NaN or infinite) the number has four significant digits, and says
    no error; a number that is NaN is a dash.
    """
    if np.isnan(value):
        return "–"
    if not np.isfinite(value) or not 0.0 < standard_error < np.inf:
        return f"{value:.4g}"
    exponent = int(f"{standard_error:.2e}".partition("e")[2])
    leading = round(standard_error / 10.0**exponent, 2)
    digits = 1 - exponent if leading < 3.55 else -exponent
    if leading >= 9.5:  # 10 of the next power: two digits
        digits = -exponent
    places = max(digits, 0)
    value, standard_error = round(value, digits), round(standard_error, digits)
    return f"{value + 0.0:.{places}f} ± {standard_error:.{places}f}"


def _roots_of_diagonal(covariance: np.ndarray) -> tuple[float, float, float]:
    b, c, d = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return float(b), float(c), float(d)

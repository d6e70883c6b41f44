"""Standard errors and confidence limits of results, and of ratios of means."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy

CONFIDENCE = 0.95  # of all intervals, unless another is stated


class Estimate(NamedTuple):
    """Number and its standard error, in the same unit."""

    value: float
    standard_error: float


class Limits(NamedTuple):
    """Lower and upper confidence limit; they may be infinite."""

    low: float
    high: float


def mean_of(samples) -> Estimate:
    """Return the mean of samples (n,) and its standard error S/sqrt(n), with S by n - 1."""
    samples = np.asarray(samples, dtype=float)
    return Estimate(float(samples.mean()), float(samples.std(ddof=1) / np.sqrt(samples.size)))


def confidence_limits(
    estimate: tuple[float, float], samples: int, confidence: float = CONFIDENCE
) -> Limits:
    """Return the confidence limits of a mean, by Student's t.

    ``estimate`` is its value and standard error from so many ``samples``. NaN for fewer than two.
    """
    value, error = estimate
    reach = half_width(error, samples, confidence)
    return Limits(value - reach, value + reach)


def half_width(standard_error: float, samples: int, confidence: float = CONFIDENCE) -> float:
    """Return half of the width of the confidence interval of a mean, by Student's t.

    NaN for fewer than two samples.
    """
    return float(scipy.stats.t.ppf(0.5 + 0.5 * confidence, samples - 1)) * standard_error


def deviations_of(samples) -> tuple[np.ndarray, np.ndarray]:
    """Return the standard deviations (...) of rows of samples (..., n), and their standard errors.

    The deviations are by n - 1, and the errors those of normal samples.
    """
    samples = np.asarray(samples, dtype=float)
    deviations = samples.std(axis=-1, ddof=1)
    return deviations, deviations / np.sqrt(2.0 * (samples.shape[-1] - 1))


def deviation_of(samples) -> Estimate:
    """Return the standard deviation of samples (n,) and its standard error (`deviations_of`)."""
    deviation, error = deviations_of(samples)
    return Estimate(float(deviation), float(error))


def variation_of(samples) -> Estimate:
    """Return the coefficient of variation S/mean of normal samples (n,), and its standard error."""
    samples = np.asarray(samples, dtype=float)
    ratio = float(samples.std(ddof=1) / samples.mean())
    n = samples.size
    return Estimate(ratio, abs(ratio) * float(np.sqrt(0.5 / (n - 1) + ratio**2 / n)))


def resampled(
    samples, random: np.random.Generator, resamples: int, paired: bool
) -> Iterator[np.ndarray]:
    """Generate ``resamples`` bootstrap samples (..., n) of samples (..., n) of n surfaces.

    All rows have the same resampled surfaces if ``paired``, else each row its own.
    """
    n = np.shape(samples)[-1]
    samples = np.asarray(samples, dtype=float)
    for _ in range(resamples):
        index = random.integers(n, size=n if paired else samples.shape)
        yield np.take_along_axis(samples, np.broadcast_to(index, samples.shape), axis=-1)


def jackknife_error(left_out):
    """Return the standard errors (...) of values by the jackknife.

    ``left_out`` (groups, ...) are the values that result without each of the groups.
    """
    return np.sqrt((len(left_out) - 1) * np.var(left_out, axis=0))


def mean_covariance(samples, paired: bool) -> np.ndarray:
    """Return the covariance (k, k) of the errors of the means of samples (k, n) of n surfaces.

    It is diagonal unless the samples are ``paired``, that is of the same surfaces.
    """
    covariance = np.atleast_2d(np.cov(samples)) / np.shape(samples)[1]
    return covariance if paired else np.diag(np.diag(covariance))


def deviation_covariance(samples, paired: bool) -> np.ndarray:
    """Return the covariance (k, k) of the errors of the standard deviations of samples (k, n).

    The samples are taken as normal. It is diagonal unless they are ``paired``, that is of the same
    surfaces.
    """
    covariance = np.cov(samples)
    deviations = np.sqrt(np.diag(covariance))
    scale = np.outer(deviations, deviations)
    shared = np.divide(covariance**2, scale, out=np.zeros_like(scale), where=scale > 0.0)
    shared = shared / (2.0 * (np.shape(samples)[1] - 1))
    return shared if paired else np.diag(np.diag(shared))


def ratio_of_means(over: np.ndarray, under: np.ndarray) -> Estimate:
    """Compute the ratio of the means of two rows (n,) on the same surfaces, with standard error.

    The error is by the delta method. Surfaces on which a value is not finite are left out. The
    ratio is NaN if none is left, or if the mean ``under`` it is 0; the error is NaN for one surface
    too.
    """
    known = np.isfinite(over) & np.isfinite(under)
    over = over[known]
    under = under[known]
    if not known.any() or under.mean() == 0.0:
        return Estimate(np.nan, np.nan)
    ratio = float(over.mean() / under.mean())
    if over.size < 2:
        return Estimate(ratio, np.nan)
    error = mean_of(over - ratio * under).standard_error
    return Estimate(ratio, error / abs(float(under.mean())))


def harmonic_mean(values: np.ndarray) -> Estimate:
    """Compute the harmonic mean of values (n,), and its standard error; NaN are left out."""
    return ratio_of_means(np.ones(values.size), 1.0 / values)

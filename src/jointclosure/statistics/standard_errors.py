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
    """Return the mean of samples (n,) and its standard error S/sqrt(n)."""
    samples = np.asarray(samples, dtype=float)
    return Estimate(float(samples.mean()), float(samples.std(ddof=1) / np.sqrt(samples.size)))


def confidence_limits(
    estimate: tuple[float, float], samples: int, confidence: float = CONFIDENCE
) -> Limits:
    """Return the confidence limits of (value, standard error) from n samples, by Student's t."""
    value, error = estimate
    reach = half_width(error, samples, confidence)
    return Limits(value - reach, value + reach)


def half_width(standard_error: float, samples: int, confidence: float = CONFIDENCE) -> float:
    """Return half of the confidence interval of a mean of n samples; NaN for fewer than two."""
    return float(scipy.stats.t.ppf(0.5 + 0.5 * confidence, samples - 1)) * standard_error


def deviations_of(samples) -> tuple[np.ndarray, np.ndarray]:
    """Return standard deviations (ddof 1) of rows (..., n), and their errors for normal samples."""
    samples = np.asarray(samples, dtype=float)
    deviations = samples.std(axis=-1, ddof=1)
    return deviations, deviations / np.sqrt(2.0 * (samples.shape[-1] - 1))


def deviation_of(samples) -> Estimate:
    """Return the standard deviation of one row (n,) and its error, see `deviations_of`."""
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
    """Generate bootstrap samples (..., n) of surfaces: the same in all rows if ``paired``."""
    n = np.shape(samples)[-1]
    samples = np.asarray(samples, dtype=float)
    for _ in range(resamples):
        index = random.integers(n, size=n if paired else samples.shape)
        yield np.take_along_axis(samples, np.broadcast_to(index, samples.shape), axis=-1)


def jackknife_error(left_out):
    """Return standard errors (...) from values (groups, ...), each without one of the groups."""
    return np.sqrt((len(left_out) - 1) * np.var(left_out, axis=0))


def mean_covariance(samples, paired: bool) -> np.ndarray:
    """Return the covariance (k, k) of means over samples (k, n); diagonal for independent draws."""
    covariance = np.atleast_2d(np.cov(samples)) / np.shape(samples)[1]
    return covariance if paired else np.diag(np.diag(covariance))


def deviation_covariance(samples, paired: bool) -> np.ndarray:
    """Return the covariance (k, k) of the standard deviations of normal samples (k, n)."""
    covariance = np.cov(samples)
    deviations = np.sqrt(np.diag(covariance))
    scale = np.outer(deviations, deviations)
    shared = np.divide(covariance**2, scale, out=np.zeros_like(scale), where=scale > 0.0)
    shared = shared / (2.0 * (np.shape(samples)[1] - 1))
    return shared if paired else np.diag(np.diag(shared))


def ratio_of_means(over: np.ndarray, under: np.ndarray) -> Estimate:
    """Compute the ratio of means of rows (n,) on the same surfaces, its error by delta method."""
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

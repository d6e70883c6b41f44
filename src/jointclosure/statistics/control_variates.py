"""Means and scatters of few simulations, adjusted by covariates known on many surfaces.

A covariate is a number that is cheap on any surface (a depth of the summed heights), so that its
mean over surfaces is known. On the few simulated surfaces the mean of the covariate deviates by
chance, and a correlated target deviates too. This part is subtracted: y_i - beta (c_i - mean of c).
beta is fitted without surface i (leave-one-out cross-fitting), so that no value affects its own
adjustment, and the scatter of the adjusted values gives their error, including the error of beta.
The errors also contain the uncertainty of the covariates' means, which are from a finite number of
surfaces.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.indifference import (
    BootstrapInterval,
    indifference_lengths,
    interval_of_lengths,
)
from jointclosure.statistics.standard_errors import Estimate, deviations_of, mean_covariance


class Known(NamedTuple):
    """Means of m covariates that are known from many surfaces, and their scatter."""

    means: np.ndarray  # (m,)
    covariance: np.ndarray  # (m, m) of covariates from surface to surface, not of their means
    surfaces: float  # number of surfaces; infinite if the means are exact


class Means(NamedTuple):
    """Means (k,) of a target at k levels, and the covariance (k, k) of their errors."""

    values: np.ndarray
    covariance: np.ndarray

    def estimate(self, level: int) -> Estimate:
        """Return the mean at the level of an index, and its standard error."""
        return self.combined(np.eye(self.values.size)[level])

    def combined(self, weights) -> Estimate:
        """Return a weighted sum of the means with its standard error, such as a difference.

        ``weights`` (k,) are those of the levels.
        """
        weights = np.asarray(weights)
        variance = max(float(weights @ self.covariance @ weights), 0.0)
        return Estimate(float(weights @ self.values), float(np.sqrt(variance)))


def fewest_surfaces(covariates: int) -> int:
    """Return the smallest number of surfaces on which means can be adjusted by ``covariates``.

    It is five for each covariate and the mean.
    """
    return 5 * (covariates + 1)


def adjusted_means(samples, covariates, known: Known, paired: bool) -> Means:
    """Compute the means of samples (k, n) of n surfaces at k levels, adjusted by covariates.

    The covariates (k, n, m) have means that are ``known`` from many surfaces. ``paired`` is whether
    the n surfaces are the same at all levels. Raise `InputError` if covariates are constant or
    dependent.
    """
    adjusted, coefficients = adjusted_values(samples, covariates, known.means)
    coefficients = coefficients.mean(axis=1)
    of_known = coefficients @ np.asarray(known.covariance) @ coefficients.T / known.surfaces
    return Means(adjusted.mean(axis=1), mean_covariance(adjusted, paired) + of_known)


def adjusted_values(values, covariates, known_means) -> tuple[np.ndarray, np.ndarray]:
    """Adjust the values (..., n) of n surfaces by their covariates (..., n, m).

    Return the adjusted values (..., n), whose mean is the adjusted mean and whose scatter is what
    the covariates do not explain, and the coefficients beta (..., n, m). The coefficients of a
    surface are fitted without this surface: with the least-squares coefficients beta of all
    surfaces, residuals e and leverages h, those without surface i are
    beta - (X'X)^-1 x_i e_i/(1 - h_i). ``known_means`` (m,) are the means of the covariates on many
    surfaces. Raise `InputError` if covariates are constant, constant but for one surface, or
    dependent.
    """
    values = np.asarray(values, float)
    covariates = np.asarray(covariates, float)
    # scale columns, so that their rank does not depend on their units
    scale = covariates.std(axis=-2, keepdims=True)
    if not np.all(scale > 0.0):
        raise InputError("covariates: a column is constant")
    known_means = np.asarray(known_means, dtype=float)
    offsets = (covariates - known_means) / scale
    design = np.concatenate([np.ones((*offsets.shape[:-1], 1)), offsets], axis=-1)
    size = np.linalg.norm(design, axis=(-2, -1))
    rank = np.linalg.matrix_rank(design, tol=1e-9 * size)
    if np.any(rank < design.shape[-1]):
        raise InputError("covariates: a column is a combination of others")
    inverse = np.linalg.pinv(design)
    coefficients = inverse @ values[..., None]
    residuals = values - (design @ coefficients)[..., 0]
    leverages = np.einsum("...ij,...ji->...i", design, inverse)
    if np.any(leverages > 1.0 - 1e-9):
        raise InputError("covariates: a column is constant except on one surface")
    without_one = coefficients - inverse * (residuals / (1.0 - leverages))[..., None, :]
    fitted = np.swapaxes(without_one[..., 1:, :], -1, -2) / scale
    return values - np.sum(fitted * (covariates - known_means), axis=-1), fitted


def adjusted_deviations(
    samples, covariates, known: Known, tell_scatter: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the standard deviations of samples (k, n) at k levels, adjusted by covariates.

    Return the deviations (k,) and their standard errors (k,). The covariates (k, n, m) have
    ``known`` means and variances. Without ``tell_scatter`` the covariates are not used, and the
    result is that of `deviations_of`.

    S^2 is the mean of (y_i - m)^2 + S_a^2/n, where m is the adjusted mean and S_a the scatter of
    the adjusted values, which corrects for the fit of m. (With the plain mean it would be biased,
    because the plain mean correlates with the covariates.) This mean is adjusted by the covariates
    c and the squares (c - mean of c)^2, whose means are the known variances. At a level at which
    the adjusted S^2 would not be positive, it is not adjusted. The error neglects the uncertainty
    of the known means: with a hundred times as many surfaces as were simulated it would add a
    percent.
    """
    samples = np.asarray(samples, float)
    covariates = np.asarray(covariates, float)
    if not tell_scatter:
        return deviations_of(samples)
    n = samples.shape[-1]
    means = np.asarray(known.means, dtype=float)
    centred, _ = adjusted_values(samples, covariates, means)
    about = samples - centred.mean(axis=-1, keepdims=True)
    squares = about**2 + centred.var(axis=-1, ddof=1, keepdims=True) / n
    wider = np.concatenate([covariates, (covariates - means) ** 2], axis=-1)
    expected = np.concatenate([means, np.diag(np.atleast_2d(known.covariance))])
    adjusted, _ = adjusted_values(squares, wider, expected)
    # a negative variance after adjustment: the covariates do not help
    helped = adjusted.mean(axis=-1, keepdims=True) > 0.0
    adjusted = np.where(helped, adjusted, squares)
    deviations = np.sqrt(adjusted.mean(axis=-1))
    scatter = adjusted.std(axis=-1, ddof=1) / np.sqrt(n)
    some = deviations > 0.0
    none = np.zeros_like(scatter)
    return deviations, np.divide(scatter, 2.0 * deviations, none, where=some)


def adjusted_length(
    levels,
    samples,
    covariates,
    known: Known,
    random: np.random.Generator,
    *,
    base: float,
    draws: int = 400,
    confidence: float = 0.95,
    significance: float = 0.05,
    tell_scatter: bool = True,
) -> tuple[float, BootstrapInterval]:
    """Compute the indifference length of the unpaired test from adjusted means and deviations.

    ``samples`` (k, n) and ``covariates`` (k, n, m) are at ``levels`` (k,), one of which is the
    ``base``. Return the length, in the unit of the levels and NaN without a root, and its interval
    of a ``confidence``. The interval is from ``draws`` of means and deviations within their errors.
    ``significance`` is that of the t test; other arguments are as for `adjusted_deviations`.
    """
    means = adjusted_means(samples, covariates, known, paired=False)
    deviations, errors = adjusted_deviations(samples, covariates, known, tell_scatter)
    drawn = random.multivariate_normal(means.values, means.covariance, size=draws, method="svd")
    scattered = np.abs(deviations + errors * random.standard_normal((draws, deviations.size)))
    of = {"samples": np.shape(samples)[1], "significance": significance, "base": base}
    length = float(indifference_lengths(levels, means.values, deviations, **of))
    lengths = indifference_lengths(levels, drawn, scattered, **of)
    return length, interval_of_lengths(lengths, confidence)

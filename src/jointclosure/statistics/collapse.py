"""Power laws that collapse responses at several conditions onto one: exponents and their effect.

Responses and predictors are logarithms over (condition, surface). The surfaces are the same at all
conditions. Therefore the mean of each surface over the conditions (of its group) is subtracted
first. What remains is the spread between conditions, which also contains the differences between
surfaces in it.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.standard_errors import jackknife_error


class Collapse(NamedTuple):
    """Effect of a product of powers on the spread between conditions.

    ``exponents`` (k,) of the predictors with their ``errors``. ``removed`` is the share of the mean
    square spread that is removed on surfaces that were not fitted, and its error. ``left`` is the
    root mean square spread, of a logarithm, that remains there. Errors are from the jackknife over
    surfaces.
    """

    exponents: np.ndarray
    errors: np.ndarray
    removed: float
    removed_error: float
    left: float


def centred(logs: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Subtract from logarithms (..., condition, surface) each surface's mean over its group."""
    answer = np.array(logs, dtype=float)
    for group in np.unique(groups):
        members = groups == group
        answer[..., members, :] -= answer[..., members, :].mean(axis=-2, keepdims=True)
    return answer


def exponents_of(predictors: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Fit the exponents (k,) of centred predictors (k, condition, surface) by least squares."""
    if not len(predictors):
        return np.zeros(0)
    design = predictors.reshape(len(predictors), -1).T
    return np.linalg.lstsq(design, response.ravel())[0]


def spreads(predictors: np.ndarray, response: np.ndarray) -> tuple[float, float]:
    """Return the mean square spread between conditions, before and after, by cross-validation.

    The square of a mean over surfaces is too large by the variance of that mean, which is
    subtracted. The result may be negative if it is smaller than the noise of the surfaces.
    """
    halves = np.arange(response.shape[1]) % 2
    before, after = [], []
    for half in (0, 1):
        fitted, tested = halves != half, halves == half
        powers = exponents_of(predictors[..., fitted], response[:, fitted])
        rest = response[:, tested] - np.tensordot(powers, predictors[..., tested], axes=1)
        before.append(_mean_square(response[:, tested]))
        after.append(_mean_square(rest))
    return float(np.mean(before)), float(np.mean(after))


def _mean_square(values: np.ndarray) -> float:
    """Return the mean over conditions of squared means over surfaces, corrected for their noise."""
    noise = values.var(axis=1, ddof=1) / values.shape[1]
    return float(np.mean(values.mean(axis=1) ** 2 - noise))


def collapse_of(predictors: np.ndarray, response: np.ndarray) -> Collapse:
    """Fit exponents and evaluate their effect, with errors; arguments as for `spreads`."""
    exponents = exponents_of(predictors, response)
    before, after = spreads(predictors, response)
    drawn, shares = [], []
    for left_out in range(response.shape[1]):
        kept = np.arange(response.shape[1]) != left_out
        one = predictors[..., kept], response[:, kept]
        drawn.append(exponents_of(*one))
        first, second = spreads(*one)
        shares.append(1.0 - second / first)
    errors = np.array([jackknife_error(column) for column in np.array(drawn).T])
    removed = 1.0 - after / before
    return Collapse(
        exponents, errors, removed, jackknife_error(shares), float(np.sqrt(max(after, 0.0)))
    )

"""Powers under which responses at several conditions become one: exponents, and what they remove.

Responses and predictors are logarithms over (condition, surface). The surfaces are the same at all
conditions, so each surface's mean over conditions (of its group) is taken off first: what is left
is the spread between conditions, and the surfaces' own differences in it.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.drawn_studies import jackknife_error


class Collapse(NamedTuple):
    """What a product of powers does to the spread between conditions.

    ``exponents`` (k,) of the predictors with their ``errors``; ``removed``: share of the mean
    square spread that is gone on surfaces that were not fitted, and its error; ``left``: root
    mean square spread that stays there, of a logarithm. Errors by the jackknife over surfaces.
    """

    exponents: np.ndarray
    errors: np.ndarray
    removed: float
    removed_error: float
    left: float


def centred(logs: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Logarithms (..., condition, surface) less each surface's mean over its group's conditions.

    ``groups`` (condition,) are their labels.
    """
    answer = np.array(logs, dtype=float)
    for group in np.unique(groups):
        own = groups == group
        answer[..., own, :] -= answer[..., own, :].mean(axis=-2, keepdims=True)
    return answer


def exponents_of(predictors: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Least squares exponents (k,) of centred predictors (k, condition, surface)."""
    if not len(predictors):
        return np.zeros(0)
    design = predictors.reshape(len(predictors), -1).T
    return np.linalg.lstsq(design, response.ravel())[0]


def spreads(predictors: np.ndarray, response: np.ndarray) -> tuple[float, float]:
    """Mean square spread between conditions, before and after, on surfaces that were not fitted.

    Every second surface is fitted, the others are told of, and the other way round.

    Parameters
    ----------
    predictors : array (k, condition, surface)
    response : array (condition, surface)
        Both centred.

    Notes
    -----
    The square of a mean over surfaces is too large by the variance of that mean, which is taken
    off. What is left over may come out negative where it is lost in the surfaces' noise.
    """
    halves = np.arange(response.shape[1]) % 2
    before, after = [], []
    for half in (0, 1):
        fitted, told = halves != half, halves == half
        powers = exponents_of(predictors[..., fitted], response[:, fitted])
        rest = response[:, told] - np.tensordot(powers, predictors[..., told], axes=1)
        before.append(_mean_square(response[:, told]))
        after.append(_mean_square(rest))
    return float(np.mean(before)), float(np.mean(after))


def _mean_square(values: np.ndarray) -> float:
    """Mean over conditions of the squared mean over surfaces, free of the surfaces' noise."""
    noise = values.var(axis=1, ddof=1) / values.shape[1]
    return float(np.mean(values.mean(axis=1) ** 2 - noise))


def collapse_of(predictors: np.ndarray, response: np.ndarray) -> Collapse:
    """Exponents and what they remove, with errors; arguments as for `spreads`, 6 surfaces up."""
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

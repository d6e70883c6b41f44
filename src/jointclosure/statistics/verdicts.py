"""Verdicts on claims: whether they are true, and how often a study would find them."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.drawn_studies import DrawnResponse, Key

STANDS = "stands"
FALLS = "falls"
CANNOT_BE_TOLD = "cannot be told"
NO_DIFFERENCE = "no difference"
VERDICTS = (STANDS, FALLS, NO_DIFFERENCE, CANNOT_BE_TOLD)


class Interval(NamedTuple):
    """A confidence interval; its ends may be infinite."""

    low: float
    high: float


class Frequency(NamedTuple):
    """Share of repetitions, its standard error, and its 95 % interval."""

    share: float
    standard_error: float
    low: float
    high: float


def verdict(
    interval: tuple[float, float],
    true_between: tuple[float, float],
    alike: float | None = None,
) -> str:
    """Whether a claim about a number is true, from the number's confidence interval.

    Parameters
    ----------
    interval : (low, high)
        Of the number.
    true_between : (low, high)
        The open range of numbers for which the claim is true, declared beforehand: (0, inf)
        for "rises", (-0.1, 0.1) for "has no effect beyond 0.1".
    alike : float, optional
        The largest difference that counts as none, of a claim that one number is larger than
        another, whose difference has the interval.

    Returns
    -------
    str
        "stands": the whole interval is inside; "falls": all of it is outside, and of a
        difference below ``-alike``; "no difference": all of it is within ``alike`` of 0; else
        "cannot be told", and so for an interval with an end that is NaN.

    Raises
    ------
    InputError
        An interval or a range whose ends are in the wrong order.
    """
    for name, (low, high) in (("interval", interval), ("true_between", true_between)):
        if low > high:
            raise InputError(f"{name} = ({low!r}, {high!r}): must be (low, high)")
    (low, high), (least, most) = interval, true_between
    if np.isnan([low, high]).any():
        return CANNOT_BE_TOLD
    if (low > least or least == -np.inf) and (high < most or most == np.inf):
        return STANDS
    if alike is not None and -alike <= low and high <= alike:
        return NO_DIFFERENCE
    if high < -alike if alike is not None else high <= least or low >= most:
        return FALLS
    return CANNOT_BE_TOLD


def t_interval(estimate: tuple[float, float], samples: int, confidence: float = 0.95) -> Interval:
    """Confidence interval of (value, standard error) from n samples, n - 1 degrees of freedom.

    For several numbers judged together give confidence 1 - (1 - confidence)/number
    (Bonferroni).
    """
    value, error = estimate
    reach = float(scipy.stats.t.ppf(0.5 + 0.5 * confidence, samples - 1)) * error
    return Interval(value - reach, value + reach)


def frequency(found, pool_error: float = 0.0) -> Frequency:
    """How often, from one boolean (R,) per repetition; see `frequency_of`."""
    found = np.asarray(found)
    if found.dtype != bool or found.ndim != 1 or found.size == 0:
        raise InputError(
            f"found: {found.dtype} {found.shape}, must be one row of booleans, one a repetition"
        )
    return frequency_of(int(found.sum()), found.size, pool_error)


def frequency_of(count: int, n: int, pool_error: float = 0.0) -> Frequency:
    """How often, from a count of n repetitions.

    ``pool_error``: standard error of the share from the pool that they were drawn from, which is
    added to the binomial one. The interval is Wilson's, with a pool's error at least two errors.
    """
    share = count / n
    low, high = scipy.stats.binomtest(count, n).proportion_ci(method="wilson")
    error = float(np.hypot(np.sqrt(share * (1.0 - share) / n), pool_error))
    if pool_error:
        low, high = min(low, share - 2.0 * error), max(high, share + 2.0 * error)
    return Frequency(share, error, max(0.0, float(low)), min(1.0, float(high)))


def frequency_of_finding(
    judge: Callable[[Mapping[Key, DrawnResponse]], np.ndarray], drawn: Mapping[Key, DrawnResponse]
) -> Frequency:
    """How often a study, judged as it judges itself, finds a claim.

    Parameters
    ----------
    judge : callable
        From drawn studies (`draw_studies`) to a boolean for each repetition, (R,): whether
        the claim is found there. Means, deviations and lengths of a repetition have the first
        axis, so that a judge needs no loop.
    drawn : mapping
        Repetitions of the study.

    Raises
    ------
    InputError
        A judge that does not give one boolean for each repetition.
    """
    found = np.asarray(judge(drawn))
    repetitions = next(iter(drawn.values())).lengths.shape[0]
    if found.shape != (repetitions,):
        raise InputError(
            f"judge: gave {found.shape}, must give ({repetitions},), a boolean for each repetition"
        )
    return frequency(found)

"""Verdicts on claims: whether they are true, and how often a study would find them."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.drawn_studies import DrawnResponse, Key

STANDS = "stands"
FALLS = "falls"
CANNOT_BE_TOLD = "cannot be told"


class Interval(NamedTuple):
    """A confidence interval; its ends may be infinite."""

    low: float
    high: float


class Frequency(NamedTuple):
    """Share of repetitions, its binomial standard error, and Wilson's 95 % interval."""

    share: float
    standard_error: float
    low: float
    high: float


def verdict(interval: tuple[float, float], true_between: tuple[float, float]) -> str:
    """Whether a claim about a number is true, from the number's confidence interval.

    Parameters
    ----------
    interval : (low, high)
        Of the number.
    true_between : (low, high)
        The open range of numbers for which the claim is true, declared beforehand: (0, inf)
        for "rises", (-0.1, 0.1) for "has no effect beyond 0.1".

    Returns
    -------
    str
        "stands": the whole interval is inside; "falls": all of it is outside; else
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
    if high <= least or low >= most:
        return FALLS
    return CANNOT_BE_TOLD


def verdict_on_all(verdicts: Iterable[str]) -> str:
    """Of a claim about several rocks: falls with one, stands only with all."""
    verdicts = list(verdicts)
    if FALLS in verdicts:
        return FALLS
    return STANDS if verdicts and set(verdicts) == {STANDS} else CANNOT_BE_TOLD


def t_interval(estimate: tuple[float, float], samples: int, confidence: float = 0.95) -> Interval:
    """Confidence interval of (value, standard error) from n samples, n - 1 degrees of freedom.

    For several numbers judged together give confidence 1 - (1 - confidence)/number
    (Bonferroni).
    """
    value, error = estimate
    reach = float(scipy.stats.t.ppf(0.5 + 0.5 * confidence, samples - 1)) * error
    return Interval(value - reach, value + reach)


def frequency(found) -> Frequency:
    """How often, from one boolean (R,) per repetition."""
    found = np.asarray(found)
    if found.dtype != bool or found.ndim != 1 or found.size == 0:
        raise InputError(
            f"found: {found.dtype} {found.shape}, must be one row of booleans, one a repetition"
        )
    return frequency_of(int(found.sum()), found.size)


def frequency_of(count: int, n: int) -> Frequency:
    """How often, from a count of n repetitions."""
    share = count / n
    low, high = scipy.stats.binomtest(count, n).proportion_ci(method="wilson")
    error = float(np.sqrt(share * (1.0 - share) / n))
    return Frequency(share, error, float(low), float(high))


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

"""Verdicts on claims: whether they are true, and how often a study would confirm them."""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError, check_count, check_number

STANDS = "stands"  # the whole interval confirms the claim
FALLS = "falls"  # the whole interval contradicts it
UNDECIDED = "undecided"  # the interval does neither
NO_DIFFERENCE = "no difference"  # the whole interval is within what counts as no difference
VERDICTS = (STANDS, FALLS, NO_DIFFERENCE, UNDECIDED)


class Frequency(NamedTuple):
    """Share of the repetitions of a study, its standard error, and its 95 % interval [1]."""

    share: float
    standard_error: float
    low: float
    high: float


def verdict(interval: tuple[float, float], above: float, alike: float | None = None) -> str:
    """Return the verdict on the claim that a number exceeds ``above``.

    ``interval`` (low, high) is the confidence interval of the number. The claim stands if all of it
    is above, falls if none of it is, and is undecided otherwise, or if an end is NaN. With
    ``alike``, an interval within -alike to alike is no difference, and the claim falls only if the
    whole interval is below -alike. Raise `InputError` if a limit is not allowed.
    """
    low, high = interval
    if low > high:
        raise InputError(f"interval = ({low!r}, {high!r}): must be (low, high), low <= high")
    if np.isnan(above) or (alike is not None and not alike >= 0.0):
        raise InputError(
            f"above = {above!r}, alike = {alike!r}: must be a number, and one that is not negative"
        )
    if np.isnan([low, high]).any():
        return UNDECIDED
    if low > above:
        return STANDS
    if alike is not None and -alike <= low and high <= alike:
        return NO_DIFFERENCE
    if high < -alike if alike is not None else high <= above:
        return FALLS
    return UNDECIDED


def frequency(count: int, n: int, pool_error: float = 0.0) -> Frequency:
    """Return the share ``count``/n of n repetitions, with its standard error and 95 % interval.

    The interval is Wilson's. ``pool_error`` is the standard error of the share due to the surfaces
    of the pool (`repetitions.pool_error`); with it, the interval also contains two standard errors
    on either side. Raise `InputError` if there is no repetition, the count is not from 0 to n, or
    the error is negative or not finite.
    """
    check_count("n", n)
    check_count("count", count, 0, n)
    check_number("pool_error", pool_error)
    if not 0.0 <= pool_error < np.inf:
        raise InputError(f"pool_error = {pool_error!r}: must be finite and not negative")
    share = count / n
    low, high = scipy.stats.binomtest(count, n).proportion_ci(method="wilson")
    error = float(np.hypot(np.sqrt(share * (1.0 - share) / n), pool_error))
    if pool_error:
        low = min(low, share - 2.0 * error)
        high = max(high, share + 2.0 * error)
    return Frequency(share, error, max(0.0, float(low)), min(1.0, float(high)))

"""Distribution of a published length over repetitions of the study.

An interval without a root counts as infinitely long. Lengths are then ordered, and a dash is one of
their values, with its probability.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError


class LengthDistribution(NamedTuple):
    """Median, ranges, and share of repetitions without a root (infinite length).

    Ranges leave out the same probability at both ends. If the share without a root is larger than
    this probability, the range ends at infinity and covers more than its nominal probability.
    """

    median: float
    low_90: float
    high_90: float
    low_95: float
    high_95: float
    share_without_root: float


def length_distribution(lengths) -> LengthDistribution:
    """Summarise the lengths (R,) of repeated studies, infinite without a root."""
    lengths = _lengths(lengths)
    middle = float(np.quantile(lengths, 0.5, method="inverted_cdf"))
    low = np.quantile(lengths, [0.05, 0.025], method="lower")
    high = np.quantile(lengths, [0.95, 0.975], method="higher")
    return LengthDistribution(
        middle,
        float(low[0]),
        float(high[0]),
        float(low[1]),
        float(high[1]),
        float(np.mean(np.isinf(lengths))),
    )


def two_sided_p(lengths, observed: float) -> float:
    """Compute the two-sided mid-p value of a published length.

    Parameters
    ----------
    lengths : array (R,)
        Lengths of repeated studies, infinite without a root.
    observed : float
        The published length; NaN or infinite for a dash.

    Returns
    -------
    float
        2 min(F, 1 - F) with F = P(shorter) + P(equal)/2. The observed length counts as one
        more repetition, so that p is never 0. A dash has F = 1 - q/2, where q is the share
        without a root, hence p = q; a length far in the upper tail has at least p = 2 q.

    Notes
    -----
    If q exceeds 2.5 %, no length at the upper end is significant at the level of 5 %, and
    the test rejects 2.5 % of true tables instead of 5 %: it is conservative.
    """
    lengths, observed = _lengths(lengths), _outcome(observed)
    shorter = np.count_nonzero(lengths < observed)
    equal = np.count_nonzero(lengths == observed)
    below = (shorter + 0.5 * (equal + 1)) / (lengths.size + 1)
    return float(2.0 * min(below, 1.0 - below))


def share_as_short(lengths, observed: float) -> float:
    """Return the probability of a length at most as long as the published one; 1 for a dash.

    With the lengths of studies of a parameter `without_effect` it is the probability that noise
    alone appears as sensitive. Arguments as for `two_sided_p`.
    """
    lengths, observed = _lengths(lengths), _outcome(observed)
    return float((1 + np.count_nonzero(lengths <= observed)) / (lengths.size + 1))


def _outcome(observed: float) -> float:
    if np.isnan(observed):
        return np.inf
    if observed < 0.0:
        raise InputError(f"observed = {observed!r}: must be a length, or NaN for no root")
    return float(observed)


def _lengths(lengths) -> np.ndarray:
    lengths = np.asarray(lengths, dtype=float)
    if lengths.ndim != 1 or lengths.size == 0 or np.isnan(lengths).any():
        raise InputError(f"lengths: shape {lengths.shape}, must be (R,), with infinity for no root")
    return lengths

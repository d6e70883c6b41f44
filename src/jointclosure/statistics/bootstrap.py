"""Confidence intervals of indifference intervals by resampling the surfaces."""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.paired import paired_indifference_interval
from jointclosure.statistics.standard_errors import resampled


class BootstrapInterval(NamedTuple):
    """Percentile interval of a length, which is infinite without a root.

    ``standard_error`` is half the central 68.3 % range, which single long lengths do not affect; it
    is infinite if this range is not bounded.
    """

    low: float
    high: float
    share_without_root: float
    standard_error: float


def bootstrap_length(
    levels: np.ndarray,
    samples: np.ndarray,
    random: np.random.Generator,
    *,
    base: float,
    resamples: int,
    confidence: float = 0.95,
    significance: float = 0.05,
    paired: bool = False,
) -> BootstrapInterval:
    """Compute the percentile bootstrap interval of a length from samples (k, n) at levels (k,)."""
    drawn = resampled(samples, random, resamples, paired)
    if paired:
        each = (paired_indifference_interval(levels, x, significance, base) for x in drawn)
        return interval_of_lengths(np.array([interval.length for interval in each]), confidence)
    chosen = np.array(list(drawn))
    moments = chosen.mean(axis=2), chosen.std(axis=2, ddof=1)
    lengths = indifference_lengths(levels, *moments, chosen.shape[2], significance, base)
    return interval_of_lengths(lengths, confidence)


def interval_of_lengths(lengths: np.ndarray, confidence: float) -> BootstrapInterval:
    """Return the percentile interval of lengths (resamples,); NaN, no root, counts as infinite."""
    lengths = np.where(np.isnan(lengths), np.inf, lengths)
    tail = 0.5 * (1.0 - confidence)
    low, high = np.quantile(lengths, [tail, 1.0 - tail], method="higher")
    below, above = np.quantile(lengths, scipy.stats.norm.cdf([-1.0, 1.0]), method="higher")
    error = 0.5 * (above - below) if np.isfinite(above) else np.inf
    without = float(np.mean(np.isinf(lengths)))
    return BootstrapInterval(float(low), float(high), without, float(error))

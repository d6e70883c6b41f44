"""Confidence intervals of indifference intervals by resampling the surfaces."""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.paired import paired_indifference_interval


class BootstrapInterval(NamedTuple):
    """Percentile interval of a length, share of resamples without a root, and standard error.

    A missing root counts as an infinite length: `high` is infinite if too many resamples have no
    root. ``standard_error`` is half the central 68.3 % range, which single long lengths do not
    affect; it is infinite if this range is not bounded.
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
) -> BootstrapInterval:
    """Compute the percentile bootstrap interval of a length from independent draws.

    Parameters
    ----------
    levels : array (k,)
        Parameter values, ascending.
    samples : array (k, n)
        Target of every realisation at every level, finite.
    base, significance
        As for `indifference_interval`.
    """
    k, n = samples.shape
    index = random.integers(0, n, size=(resamples, k, n))
    chosen = np.take_along_axis(samples[None], index, axis=2)
    means, deviations = chosen.mean(axis=2), chosen.std(axis=2, ddof=1)
    lengths = indifference_lengths(levels, means, deviations, n, significance, base)
    return interval_of_lengths(lengths, confidence)


def bootstrap_paired_length(
    levels: np.ndarray,
    samples: np.ndarray,
    random: np.random.Generator,
    *,
    base: float,
    resamples: int,
    confidence: float = 0.95,
    significance: float = 0.05,
) -> BootstrapInterval:
    """Compute the bootstrap interval of a `paired_indifference_interval`, over surfaces.

    Parameters are those of `bootstrap_length`.
    """
    n = samples.shape[1]
    lengths = np.empty(resamples)
    for i in range(resamples):
        chosen = samples[:, random.integers(0, n, size=n)]
        lengths[i] = paired_indifference_interval(levels, chosen, significance, base).length
    return interval_of_lengths(lengths, confidence)


def interval_of_lengths(lengths: np.ndarray, confidence: float) -> BootstrapInterval:
    """Return the percentile interval of resampled lengths (resamples,).

    NaN means no root and counts as infinite.
    """
    lengths = np.where(np.isnan(lengths), np.inf, lengths)
    tail = 0.5 * (1.0 - confidence)
    low, high = np.quantile(lengths, [tail, 1.0 - tail], method="higher")
    below, above = np.quantile(lengths, scipy.stats.norm.cdf([-1.0, 1.0]), method="higher")
    error = 0.5 * (above - below) if np.isfinite(above) else np.inf
    without = float(np.mean(np.isinf(lengths)))
    return BootstrapInterval(float(low), float(high), without, float(error))

"""Confidence intervals of indifference intervals by resampling the surfaces."""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.indifference import indifference_interval
from jointclosure.statistics.paired import paired_indifference_interval


class BootstrapInterval(NamedTuple):
    """Percentile interval of a length, and how often there was no root.

    An absent root counts as an infinite length: `high` is infinite where too
    many resamples have none.
    """

    low: float
    high: float
    share_without_root: float


def bootstrap_length(
    levels: np.ndarray,
    samples: np.ndarray,
    random: np.random.Generator,
    *,
    base: float,
    resamples: int,
    confidence: float = 0.95,
    significance: float = 0.05,
    paired: bool = True,
) -> BootstrapInterval:
    """Percentile bootstrap of an indifference interval's length.

    Parameters
    ----------
    levels : array (k,)
        Parameter values, ascending.
    samples : array (k, n)
        The target of every realisation at every level, finite.
    random : Generator
    base, significance
        As for `indifference_interval`.
    resamples : int
    confidence : float
    paired : bool
        Whether a realisation is the same surface at every level (common
        draws): then realisations are resampled, and not values.
    """
    k, n = samples.shape
    lengths = np.empty(resamples)
    for i in range(resamples):
        index = random.integers(0, n, size=(1 if paired else k, n))
        chosen = np.take_along_axis(samples, np.broadcast_to(index, (k, n)), axis=1)
        found = indifference_interval(
            levels, chosen.mean(axis=1), chosen.std(axis=1, ddof=1), n, significance, base
        )
        lengths[i] = found.length
    return _percentiles(lengths, confidence)


def bootstrap_paired_length(
    levels: np.ndarray,
    samples: np.ndarray,
    random: np.random.Generator,
    *,
    base: float,
    resamples: int,
    confidence: float = 0.95,
    significance: float = 0.05,
    degree: int = 1,
) -> BootstrapInterval:
    """Percentile bootstrap of a `paired_indifference_interval`'s length, over surfaces.

    Parameters are as for `bootstrap_length`; ``degree`` as for the interval.
    """
    n = samples.shape[1]
    lengths = np.empty(resamples)
    for i in range(resamples):
        chosen = samples[:, random.integers(0, n, size=n)]
        lengths[i] = paired_indifference_interval(levels, chosen, significance, base, degree).length
    return _percentiles(lengths, confidence)


def _percentiles(lengths: np.ndarray, confidence: float) -> BootstrapInterval:
    lengths = np.where(np.isnan(lengths), np.inf, lengths)
    tail = 0.5 * (1.0 - confidence)
    low, high = np.quantile(lengths, [tail, 1.0 - tail], method="higher")
    return BootstrapInterval(float(low), float(high), float(np.mean(np.isinf(lengths))))

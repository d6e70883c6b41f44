"""Indifference intervals without a polynomial, by isotonic regression of the means.

The only assumption is that means increase or decrease monotonically with the parameter. They are
the isotonic regression of the level means, in the direction that fits better, with straight lines
between the levels. There is no curvature to extrapolate, and no length beyond the levels. The
scatter is that of the t test used: for the unpaired test standard deviations with straight lines
between the levels, for the paired test S_d^2 of `jointclosure.statistics.paired`. The method needs
more than three levels: five or nine.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.paired import checked_samples, difference_scatter
from jointclosure.statistics.roots import real_roots


class MonotoneInterval(NamedTuple):
    """Range about the base value in which no change is significant.

    ``length`` and ``root`` are NaN if no change within the levels is significant. ``fitted`` (k,):
    means of the regression.
    """

    length: float
    root: float
    fitted: np.ndarray


def monotone_interval(
    levels,
    samples,
    significance: float = 0.05,
    base: float | None = None,
    paired: bool = False,
) -> MonotoneInterval:
    """Compute the smallest significant change within the levels, for monotone means.

    Parameters
    ----------
    levels : array (k,)
        Parameter values, strictly ascending, k >= 3.
    samples : array (k, n)
        Target at every level (rows); columns are the same surfaces if ``paired``.
    significance, base
        As for `indifference_interval`.
    paired : bool
        Whether to use the t test for the same surfaces, or that for independent draws.

    Raises
    ------
    InputError
        As `paired_indifference_interval`.
    """
    levels, samples, base = checked_samples(levels, samples, significance, base)
    n = samples.shape[1]
    fitted = _isotonic(samples, paired)
    half_range = 0.5 * (levels[-1] - levels[0])
    u = (levels - base) / half_range
    deviations = samples.std(axis=1, ddof=1)
    scatter = difference_scatter(levels, samples, base) if paired else None
    t = scipy.stats.t.ppf(1.0 - 0.5 * significance, n - 1 if paired else 2 * n - 2)
    at_base = int(np.flatnonzero(u == 0.0)[0])
    roots = [
        _first_significant(u, fitted - fitted[at_base], deviations, scatter, n / t**2, at_base, way)
        for way in (-1, 1)
    ]
    reached = [root for root in roots if not np.isnan(root)]
    root = min(reached, key=abs) if reached else np.nan
    return MonotoneInterval(float(abs(root) * half_range), float(base + root * half_range), fitted)


def _isotonic(samples, paired) -> np.ndarray:
    """Return level means (k,) that rise or fall monotonically, whichever fits better."""
    means, variances = samples.mean(axis=1), samples.var(axis=1, ddof=1)
    weights = None if paired or not np.all(variances > 0.0) else variances.min() / variances
    fits = [
        scipy.optimize.isotonic_regression(means, weights=weights, increasing=increasing).x
        for increasing in (True, False)
    ]
    size = np.ones_like(means) if weights is None else weights
    misfits = [float(np.sum(size * (means - fit) ** 2)) for fit in fits]
    return fits[0 if misfits[0] <= misfits[1] else 1]


def _first_significant(u, rise, deviations, scatter, strength, at_base, way) -> float:
    """Return the u closest to the base on one side where strength * rise^2 exceeds the variance."""
    i = at_base
    while 0 <= i + way < u.size:
        start, end = u[i], u[i + way]
        line = np.polyfit([start, end], [rise[i], rise[i + way]], 1)
        if scatter is None:
            spread = np.polyfit([start, end], [deviations[i], deviations[i + way]], 1)
            variance = np.polyadd(np.polymul(spread, spread), [deviations[at_base] ** 2])
        else:
            variance = np.array([scatter.slope, 0.0, 2.0 * scatter.irregular])
        excess = np.polysub(strength * np.polymul(line, line), variance)
        inside = [r for r in real_roots(excess) if min(start, end) < r < max(start, end)]
        nodes = [start, *sorted(inside, key=abs), end]
        for near, far in pairwise(nodes):
            if np.polyval(excess, 0.5 * (near + far)) > 0.0:
                return float(near)
        i += way
    return float("nan")

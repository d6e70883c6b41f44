"""Interpolation of measured and simulated curves, and monotone curves near them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from jointclosure.joint.status import LOADING

LAST_CHORD = 0.15
"""Share of the range of stress, at least, over which the last stiffness of a curve is computed."""
END_SLOPES = 0.5, 2.0
"""Least stiffness at the lower end of a curve, and largest stiffness at its upper end, over the
stiffness of the outer block of equal slope. They limit the extrapolation from its middle."""
END_CHANGE = 0.5
"""Largest change of a monotone curve beyond the middle of an outer group, over the group's mean."""


def crossing(stress: np.ndarray, values: np.ndarray, level: float, branch: str = LOADING) -> float:
    """Return the value where the stress (n,) [Pa] of a branch first reaches a level [Pa].

    On unloading this is the last place at the level. Values (n,) are linear between steps. The
    result is NaN if the stress is nowhere as high as the level. If a loading starts above the
    level, or an unloading ends above it, the value there is returned.
    """
    reached = np.flatnonzero(stress >= level)
    if reached.size == 0:
        return float("nan")
    at = int(reached[0 if branch == LOADING else -1])
    before = at - 1 if branch == LOADING else at
    if not 0 <= before < stress.size - 1:
        return float(values[at])
    rise = stress[before + 1] - stress[before]
    part = (level - stress[before]) / rise
    return float(values[before] + part * (values[before + 1] - values[before]))


def cubic_over(stress: np.ndarray, values: np.ndarray) -> Callable[[Any], Any]:
    """Return a function of stress [Pa]: the monotone cubic through values (n,) at stresses (n,).

    Only points whose stress exceeds the stress of all points before are used. The function is NaN
    outside their range, and between two of them if the value of either is NaN. If fewer than two
    points have a value, it is NaN except at the stress of a point.
    """
    rises = np.concatenate([[True], stress[1:] > np.maximum.accumulate(stress)[:-1]])
    stress = stress[rises]
    values = values[rises]
    known = np.isfinite(values)
    if known.sum() < 2:
        at = dict(zip(stress.tolist(), values.tolist(), strict=True))
        return np.vectorize(lambda level: at.get(level, np.nan), otypes=[float])
    cubic = scipy.interpolate.PchipInterpolator(stress[known], values[known], extrapolate=False)
    if known.all():
        return cubic

    def where_known(level: Any) -> np.ndarray:
        last = stress.size - 1
        after = np.minimum(np.searchsorted(stress, level, "left"), last)
        beyond = np.minimum(np.searchsorted(stress, level, "right"), last)
        before = np.where(stress[after] == level, after, np.maximum(beyond - 1, 0))
        return np.where(known[before] & known[after], cubic(level), np.nan)

    return where_known


def rising_slopes(stress: np.ndarray, closure: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return the stiffness (levels,) [Pa/m] of closures (n,) [m] at stresses (n,) [Pa].

    It rises with stress, as the inverse slope of the concave curve of closure over stress that is
    nearest to the closures (isotonic regression of the chords). It is read in the middle of each
    block of equal slope, and is linear between. It is NaN if the closure rises nowhere.
    """
    run = np.diff(stress)
    fit = scipy.optimize.isotonic_regression(np.diff(closure) / run, weights=run, increasing=False)
    # no later slope corrects the last slopes: they are replaced by one chord
    blocks = fit.blocks[stress[fit.blocks] <= stress[-1] - LAST_CHORD * np.ptp(stress)]
    blocks = np.append(blocks, stress.size - 1)
    middle = 0.5 * (stress[blocks[:-1]] + stress[blocks[1:]])
    compliance = np.diff(closure[blocks]) / np.diff(stress[blocks])
    closes = compliance > 0.0
    middle = middle[closes]
    slopes = 1.0 / compliance[closes]
    if slopes.size < 2:
        return np.full(levels.size, slopes[0] if slopes.size else np.nan)
    rise = np.diff(slopes)[[0, -1]] / np.diff(middle)[[0, -1]]
    outer = slopes[[0, -1]]
    ends = outer + rise * (stress[[0, -1]] - middle[[0, -1]])
    least, largest = END_SLOPES
    ends = np.clip(ends, outer * [least, 1.0], outer * [1.0, largest])
    places = np.concatenate([stress[:1], middle, stress[-1:]])
    return np.interp(levels, places, np.concatenate([ends[:1], slopes, ends[1:]]))


def monotone_curve(at: np.ndarray, values: np.ndarray, rises: bool) -> np.ndarray:
    """Return a monotone curve (n,) near values (n,) at ascending places (n,), without steps.

    ``rises`` is whether it rises or falls. Neighbouring values that are against this order have one
    mean (isotonic regression). A monotone cubic leads through the middles of such groups, so that
    the curve is not flat along them. It is straight beyond the outer middles, and changes there by
    at most `END_CHANGE` of the outer mean. If all values are in order they are returned as they
    are, and if all are one group their mean is.
    """
    fit = scipy.optimize.isotonic_regression(values, increasing=rises)
    # values that agree with the order stay as they are, each a group of its own
    kept_block = np.logical_and.reduceat(fit.x == values, fit.blocks[:-1])
    kept = np.flatnonzero(np.repeat(kept_block, np.diff(fit.blocks)))
    starts = np.union1d(fit.blocks[:-1], kept)
    if starts.size < 2 or starts.size == values.size:
        return fit.x
    sizes = np.diff(np.append(starts, values.size))
    middle = np.add.reduceat(at, starts) / sizes
    means = fit.x[starts]
    slopes = np.diff(means)[[0, -1]] / np.diff(middle)[[0, -1]]
    change = slopes * (at[[0, -1]] - middle[[0, -1]])
    most = END_CHANGE * np.abs(means[[0, -1]])
    ends = means[[0, -1]] + np.clip(change, -most, most)
    inner = (middle > at[0]) & (middle < at[-1])
    places = np.concatenate([at[:1], middle[inner], at[-1:]])
    through = np.concatenate([ends[:1], means[inner], ends[1:]])
    return scipy.interpolate.PchipInterpolator(places, through)(at)

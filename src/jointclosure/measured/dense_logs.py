"""Branches of measured curves, and dense logs: their scatter, spikes, loadings and averages.

A log has its points in the order of measurement, so that the number of a point is free of error,
while stress and closure both scatter. Neighbouring points are therefore averaged by their number:
the means lie on the curve. Points that exceed all former stresses do not, because they are those
with a positive error of stress.
"""

from typing import NamedTuple

import numpy as np
import scipy

LEAST_POINTS = 30
"""Least number of points of a branch whose points are averaged."""
_NOT_RISING = 0.1
"""Share of the points of a branch that do not exceed all former ones, from which it is averaged."""
_REVERSAL = 0.05
"""Least fall and rise of stress that divide two loadings, over the range of stresses."""
_LARGEST_REVERSAL = 0.25
"""Fall and rise of stress, over the range of stresses, that divide two loadings in any scatter."""
_OF_NOISE = 10.0
"""Reversal that scatter may cause, over its standard deviation."""
_STEPS_OVER_NOISE = 30.0
"""Rise from one mean to the next, over the standard error of a mean."""
_FEWEST = 8
"""Least number of means of a branch, unless these have too few points."""
_OF_END = 3.0
"""Distance of an end from the mean before it, over its standard error, beyond which the stress was
not held there."""
_SPIKE = 0.2  # least size of a spike over the range of values; chosen
_OF_NEIGHBOURS = 5.0  # least size of a spike over the changes before and after it; chosen
_DENSE = 200
"""Least number of points of a log in which a spike is known from a jump."""
_MOST_SMOOTHED = 50
"""Least number of points of a log over the number of points of its moving average."""


class MeasuredBranch(NamedTuple):
    """Branch of a measured curve: stresses (n,) [Pa] and closures (n,) [m], in ascending order.

    Each may be as measured, or a mean of measured points. ``points`` (n,) are the numbers of
    measured points in each mean, 1 for a point as measured. ``errors`` (n,) [m] are the standard
    errors of the closures by the scatter of these points, 0 for a point as measured. ``scatter``
    are the standard deviations of a single measured stress [Pa] and closure [m], 0 if no points are
    means.
    """

    stress: np.ndarray
    closure: np.ndarray
    points: np.ndarray
    errors: np.ndarray
    scatter: tuple[float, float] = (0.0, 0.0)

    @property
    def averaged(self) -> bool:
        """Whether any point of the branch is a mean of several measured points."""
        return bool((self.points > 1).any())


def exceeds_former(values: np.ndarray) -> np.ndarray:
    """Return whether each of the values (n,) of a branch exceeds all former ones."""
    return np.append(True, values[1:] > np.maximum.accumulate(values)[:-1])[: values.size]


def scatter_of(values: np.ndarray) -> float:
    """Estimate the standard deviation of the values (n,) of a log about a smooth curve.

    It follows from their second differences, and is 0 for fewer than `LEAST_POINTS` values. If many
    neighbours are equal, the log has its values in steps, and the result is at least the standard
    deviation of the rounding to a step.
    """
    if values.size < LEAST_POINTS:
        return 0.0
    changes = np.abs(np.diff(values))
    # by the median deviation of normal values; a second difference has 6 times their variance
    scatter = 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / np.sqrt(6.0)
    if (changes == 0.0).mean() < _NOT_RISING or not changes.any():
        return scatter
    rounding = float(changes[changes > 0.0].min()) / np.sqrt(12.0)
    return max(scatter, rounding)


def smoothed(stress: np.ndarray) -> np.ndarray:
    """Return the moving average (n,) of the stresses (n,) of a log; unchanged without scatter.

    The average is over at most a fiftieth of the points. If it would be over fewer than three
    points, nothing is averaged.
    """
    width = 1
    if scatter := scatter_of(stress):
        width = round(stress.size / _number_of_means(stress.size, np.ptp(stress), scatter))
    width = min(width, stress.size // _MOST_SMOOTHED)
    return stress if width < 3 else scipy.ndimage.uniform_filter1d(stress, width, mode="nearest")


def place_of_largest(stress: np.ndarray) -> int:
    """Return the index of the largest of the stresses (n,) of a log, after smoothing."""
    return int(np.argmax(smoothed(stress)))


def troughs(stress: np.ndarray) -> list[int]:
    """Return the indices of the stresses (n,) at which one loading ends and the next begins.

    They are those of the smallest smoothed stress in between. Two loadings are divided by a fall
    and a rise of more than ten times the scatter, but at least 5 % and at most 25 % of the range of
    stresses.
    """
    values = smoothed(stress)
    largest = float(np.ptp(values))
    least = np.clip(
        _OF_NOISE * scatter_of(values), _REVERSAL * largest, _LARGEST_REVERSAL * largest
    )
    found: list[int] = []
    low = high = 0
    loaded = rising = False
    for number, value in enumerate(values):
        low = number if value < values[low] else low
        high = number if value > values[high] else high
        if rising and values[high] - value > least:
            rising = False
            low = number
        elif not rising and value - values[low] > least:
            found += [low] * loaded
            rising = True
            loaded = True
            high = number
    return found


def spikes(values: np.ndarray) -> np.ndarray:
    """Return the indices of single values of a dense log (n,) that lie far from their neighbours.

    There are none in a log of fewer than `_DENSE` values, where spikes are not known from jumps.
    """
    if values.size < _DENSE:
        return np.zeros(0, int)
    apart = np.abs(values - scipy.ndimage.median_filter(values, 5, mode="nearest"))
    steps = np.pad(np.abs(np.diff(values)), 2, mode="edge")  # from the point before the last
    beside = np.maximum(steps[:-3], steps[3:])
    largest = max(_OF_NOISE * scatter_of(values), _SPIKE * float(np.ptp(np.sort(values)[1:-1])))
    return np.flatnonzero((apart > largest) & (apart > _OF_NEIGHBOURS * beside))


def averaged(stress: np.ndarray, closure: np.ndarray) -> MeasuredBranch:
    """Return a branch of a curve, with means of its points if it is dense and scatters.

    ``stress`` (n,) [Pa] and ``closure`` (n,) [m] are in ascending order of stress apart from
    scatter. The branch is returned as measured if it has fewer than `LEAST_POINTS` points, or if
    almost all stresses and closures exceed all former ones. Otherwise the means are evenly spaced
    along the curve, at distances that exceed their standard error. An end at which the stress was
    not held is the end of a straight line through the points there.
    """
    plain = MeasuredBranch(stress, closure, np.ones(stress.size, int), np.zeros(stress.size))
    if stress.size < LEAST_POINTS or not (_is_scattered(stress) or _is_scattered(closure)):
        return plain
    group = _group_numbers(stress, closure)
    order = np.arange(stress.size)
    points = np.bincount(group)
    centres, *means = (np.bincount(group, values) / points for values in (order, stress, closure))
    for end in (0, -1):
        last = group == group[end]
        values = [_line_at_end(column[last], end) for column in (stress, closure)]
        at = points.size if end else 0
        of_mean = scatter_of(stress) / np.sqrt(last.sum())
        if abs(values[0] - means[0][end]) > _OF_END * of_mean:  # no hold of the stress
            means = [np.insert(mean, at, value) for mean, value in zip(means, values, strict=True)]
            points = np.insert(points, at, last.sum())
            centres = np.insert(centres, at, order[end])
    misses = [
        values - np.interp(order, centres, mean)
        for values, mean in zip((stress, closure), means, strict=True)
    ]
    lines = (scipy.optimize.isotonic_regression(mean).x for mean in means)
    # one mean, of points at one stress, has no slope
    rises, closes = (np.gradient(line) if line.size > 1 else np.zeros(1) for line in lines)
    slope = np.divide(closes, rises, out=np.zeros(points.size), where=rises > 0.0)
    across = misses[1] - np.interp(order, centres, slope) * misses[0]
    near = np.abs(order[:, np.newaxis] - centres).argmin(axis=1)
    spread = np.bincount(near, across**2) / np.bincount(near)  # each mean is nearest to a point
    errors = np.sqrt(scipy.ndimage.median_filter(spread, min(9, spread.size), mode="nearest"))
    ends = np.where(np.isin(centres, (0, order[-1])), 2.0, 1.0)  # of a straight line at its end
    scatter = float(np.std(misses[0])), float(np.std(misses[1]))
    return MeasuredBranch(means[0], means[1], points, ends * errors / np.sqrt(points), scatter)


def _group_numbers(stress: np.ndarray, closure: np.ndarray) -> np.ndarray:
    """Return the number (n,) of the group to which each point of a branch belongs, from 0.

    The points of a group are replaced by their mean. Groups are evenly spaced along the curve: in
    the sum of stress and closure, each over its range. Small neighbouring groups are merged.
    """
    along = np.zeros(stress.size)
    number = 0.5 * stress.size
    rising = [scipy.optimize.isotonic_regression(values).x for values in (stress, closure)]
    for values, known in zip(rising, (stress, closure), strict=True):
        if (rise := values[-1] - values[0]) > 0.0:
            along += (values - values[0]) / rise
            number = min(number, _number_of_means(stress.size, rise, scatter_of(known)))
    run = np.cumsum(np.diff(rising[0], prepend=rising[0][0]) > 0.0)  # of one stress
    along = (np.bincount(run, along) / np.bincount(run))[run]
    width = max(float(np.ptp(along)), np.finfo(float).tiny) / max(_FEWEST, int(number))
    group = np.floor((along - along[0]) / width).astype(int)
    group = np.unique(group, return_inverse=True)[1]
    centres = np.bincount(group, along) / np.bincount(group)
    sizes = np.bincount(group)
    least = stress.size / number / 4.0
    merged = np.zeros(sizes.size, int)
    last = 0.0
    count = 0
    for place in range(1, sizes.size):
        count += int(sizes[place - 1])
        apart = count >= least and centres[place] - last >= 0.5 * width
        merged[place] = merged[place - 1] + apart
        last, count = (centres[place], 0) if apart else (last, count)
    if merged[-1] > 0 and count + sizes[-1] < least:
        merged[merged == merged[-1]] -= 1
    return merged[group]


def _line_at_end(values: np.ndarray, end: int) -> float:
    """Return the value at the first (0) or last (-1) point of a straight line through values (n,).

    The line is fitted over the numbers of the points. The result is clipped to the range of the
    values.
    """
    number = np.arange(values.size) - 0.5 * (values.size - 1)
    slope = float(number @ values) / max(float(number @ number), 1.0)
    return float(np.clip(values.mean() + slope * number[end], values.min(), values.max()))


def _is_scattered(values: np.ndarray) -> bool:
    """Return whether the values (n,) of a branch scatter.

    At least a tenth of them, and three, must not exceed all former ones.
    """
    falls = int((~exceeds_former(values)).sum())
    return falls >= _NOT_RISING * LEAST_POINTS and falls >= _NOT_RISING * values.size


def _number_of_means(count: int, rise: float, scatter: float) -> float:
    """Return into how many means ``count`` points of a branch are best divided.

    Neighbouring means then differ by `_STEPS_OVER_NOISE` of their standard errors. ``rise`` is the
    change of the values from first to last, ``scatter`` their standard deviation. The number is
    from 1 to half of the points, and half of the points without scatter.
    """
    most = 0.5 * count
    if scatter == 0.0:
        return most
    return float(
        np.clip((rise * np.sqrt(count) / (_STEPS_OVER_NOISE * scatter)) ** (2 / 3), 1, most)
    )

"""Rounding of a scan: steps of which its heights and places are multiples."""

from typing import NamedTuple

import numpy as np

from jointclosure.walls.gridding import Cloud, Scan, points_of


class Rounding(NamedTuple):
    """Steps [m] of which heights and places of a scan are multiples, 0 where there is no step."""

    heights: float  # of all differences of heights
    places: float  # the smaller one of the steps of x and of y of a `Cloud`; 0 for a `Scan`


def step_of(values: np.ndarray) -> float:
    """Return the step of which all differences of values (n,) are multiples; 0 without a step.

    The unit is the unit of the values. NaN is ignored. Fewer than three different values have no
    step. The step is found as by Euclid's algorithm: the smallest difference, then the smallest
    remainder of the others, until none is left but rounding.
    """
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 3:
        return 0.0
    rounding = 16.0 * np.finfo(float).eps * float(np.abs(levels).max())
    between = np.diff(levels)
    between = between[between > rounding]
    if len(between) < 2:
        return 0.0
    least = 1e-4 * float(np.median(between))
    step = float(between.min())
    while step > max(least, 4.0 * rounding):
        left = np.abs(between - step * np.rint(between / step))
        left = left[left > np.maximum(0.01 * step, rounding)]
        if not left.size:
            whole = between / np.rint(between / step)
            return float(np.median(whole))
        step = float(left.min())
    return 0.0


def rounding_of(scan: Scan | Cloud) -> Rounding:
    """Return the rounding [m] of a scan's heights, and of the places of a `Cloud`."""
    points = points_of(scan)
    if isinstance(scan, Scan):
        return Rounding(step_of(points[:, 2]), 0.0)
    return Rounding(step_of(points[:, 2]), min(step_of(points[:, 0]), step_of(points[:, 1])))

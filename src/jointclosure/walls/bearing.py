"""Bearing-area curve (Abbott & Firestone 1933) of a joint's summed heights.

Two rigid walls touch first where the sum of their heights towards each other is largest. At a
closure d they overlap in the cells whose sum is less than d below this maximum. The curve of summed
heights therefore relates the closure to the share of overlapping cells.
"""

import numpy as np
from numpy.typing import ArrayLike


def bearing_depths(summed: np.ndarray, shares: ArrayLike) -> np.ndarray:
    """Return the depths below the highest point above which given shares of the cells lie.

    Parameters
    ----------
    summed : array (y, x)
        Sum of the heights of both walls towards each other [m].
    shares : float or array
        Shares of all cells, in (0, 1].

    Returns
    -------
    float or array, as ``shares`` [m]
        Depth of the k-th highest cell, with k = share times the number of cells, linearly
        interpolated between whole k; 0, the depth of the highest cell, for k below 1.
    """
    flat = np.ravel(summed)
    ranks = np.maximum(np.asarray(shares, dtype=float) * flat.size - 1.0, 0.0)
    below = np.floor(ranks).astype(int)
    deepest = min(int(below.max()) + 1, flat.size - 1)
    # sort only the highest cells, which are all that is needed
    highest = np.sort(np.partition(flat, flat.size - 1 - deepest)[flat.size - 1 - deepest :])[::-1]
    at, next_at = highest[below], highest[np.minimum(below + 1, deepest)]
    return highest[0] - (at + (ranks - below) * (next_at - at))


def bearing_excess(summed: np.ndarray, share: float) -> float:
    """Return the mean height [m] of the highest share of cells above their lowest level.

    Parameters are those of `bearing_depths`, with one share.
    """
    level = np.max(summed) - bearing_depths(summed, share)
    above = summed[summed >= level]
    return float(np.mean(above - level))

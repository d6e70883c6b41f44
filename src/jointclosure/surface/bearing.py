"""The bearing-area curve (Abbott & Firestone 1933) of a joint's summed heights.

Two rigid walls touch first where the sum of their heights towards each other is largest; at a
closure d they overlap in the cells that lie less than d below that. So the curve of summed heights
says which share of the cells overlaps at a closure, and at which closure a share does.
"""

import numpy as np
from numpy.typing import ArrayLike


def bearing_depths(summed: np.ndarray, shares: ArrayLike) -> np.ndarray:
    """Depths below the highest point above which given shares of the cells lie.

    Parameters
    ----------
    summed : array (y, x)
        Heights of the upper and the lower wall towards each other, added up [m].
    shares : float or array
        Of all cells, in (0, 1].

    Returns
    -------
    float or array, as ``shares`` [m]
        With k = share times the number of cells: the depth of the k-th highest cell, linear
        between whole k; that of the highest, 0, for k below 1.
    """
    flat = np.ravel(summed)
    ranks = np.maximum(np.asarray(shares, dtype=float) * flat.size - 1.0, 0.0)
    below = np.floor(ranks).astype(int)
    deepest = min(int(below.max()) + 1, flat.size - 1)
    # all that is needed, and no more: the highest cells in order
    highest = np.sort(np.partition(flat, flat.size - 1 - deepest)[flat.size - 1 - deepest :])[::-1]
    at, next_at = highest[below], highest[np.minimum(below + 1, deepest)]
    return highest[0] - (at + (ranks - below) * (next_at - at))


def bearing_excess(summed: np.ndarray, share: float) -> float:
    """Mean height [m] of the highest share of the cells above the level that they lie above.

    Parameters as for `bearing_depths`, one share.
    """
    level = np.max(summed) - bearing_depths(summed, share)
    above = summed[summed >= level]
    return float(np.mean(above - level))

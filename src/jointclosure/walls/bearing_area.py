"""Bearing-area curve of the summed heights of two walls."""

import numpy as np
from numpy.typing import ArrayLike


def bearing_depths(summed: np.ndarray, shares: ArrayLike) -> np.ndarray:
    """Return the depths [m] below the highest of summed heights (y, x) [m] that hold given shares.

    A share of the cells lies above each depth: the bearing-area curve of Abbott (1933).
    """
    flat = np.ravel(summed)
    ranks = np.maximum(np.asarray(shares, dtype=float) * flat.size - 1.0, 0.0)
    below = np.floor(ranks).astype(int)
    deepest = min(int(below.max()) + 1, flat.size - 1)
    # sort only the highest cells, which are all that is needed
    highest = np.sort(np.partition(flat, flat.size - 1 - deepest)[flat.size - 1 - deepest :])[::-1]
    at = highest[below]
    next_at = highest[np.minimum(below + 1, deepest)]
    return highest[0] - (at + (ranks - below) * (next_at - at))

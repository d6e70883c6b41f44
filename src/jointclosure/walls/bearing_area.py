"""Bearing-area curve (Abbott 1933) of the summed heights of two walls."""

import numpy as np
from numpy.typing import ArrayLike


def bearing_depths(summed: np.ndarray, shares: ArrayLike) -> np.ndarray:
    """Return the depth [m] on the bearing-area curve at each of the given shares of the cells.

    The depth is measured below the highest of the ``summed`` heights (y, x) [m]; the share of the
    cells lies above it. It is interpolated between heights. For the share of one cell or less it
    is 0.
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

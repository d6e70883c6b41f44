"""Rough walls and pairs of them: JRC relations, synthesis, and measures of walls."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

Walls = tuple[np.ndarray, np.ndarray]
"""Upper and lower wall (y, x), heights towards the other [m]."""


def shifted(walls: Walls, cells: Sequence[int]) -> Walls:
    """Move the upper wall by (y, x) cells towards the origin; the cells that meet are left."""
    upper, lower = walls
    for axis, count in enumerate(cells):
        kept = np.arange(upper.shape[axis] - abs(count))
        upper = upper.take(kept + max(count, 0), axis)
        lower = lower.take(kept + max(-count, 0), axis)
    return upper, lower


class CrushedWalls(NamedTuple):
    """Walls that were crushed before, and as they were before anything broke."""

    walls: Walls
    pristine: Walls

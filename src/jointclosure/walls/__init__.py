"""Rough walls and pairs of them: JRC relations, synthesis, and measures of walls."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

Walls = tuple[np.ndarray, np.ndarray]
"""Upper and lower wall (y, x), heights towards the other [m]."""


def shifted(walls: Walls, cells: Sequence[int]) -> Walls:
    """Return walls with the upper one shifted by (y, x) cells towards the origin.

    They have the cells that both walls cover.
    """
    upper, lower = walls
    for axis, count in enumerate(cells):
        kept = np.arange(upper.shape[axis] - abs(count))
        upper = upper.take(kept + max(count, 0), axis)
        lower = lower.take(kept + max(-count, 0), axis)
    return upper, lower


class CrushedWalls(NamedTuple):
    """Walls after an earlier loading, and the same walls before any loading."""

    walls: Walls
    pristine: Walls

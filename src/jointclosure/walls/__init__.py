"""Rough walls and pairs of them: JRC relations, synthesis, and measures of walls."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

Walls = tuple[np.ndarray, np.ndarray]
"""Upper and lower wall of a joint: heights (y, x) [m], positive towards the other wall."""


def shifted(walls: Walls, cells: Sequence[int]) -> Walls:
    """Return the walls of a joint with the upper wall shifted by ``cells`` (y, x).

    A positive number shifts it towards the origin. Both walls are cut to the cells that both cover
    after the shift, so that they have fewer cells than before.
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

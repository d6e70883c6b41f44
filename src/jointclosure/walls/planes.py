"""Mean planes of walls, and heights of walls less their mean planes.

To detrend is to subtract the mean plane from heights, whose places stay: `detrended` for a whole
wall on a grid, `detrended_points` for points and for grids with missing heights. To level is to
turn a scan until its mean plane is horizontal, which moves its places too (`levelling.py`).
"""

from typing import NamedTuple

import numpy as np


class Plane(NamedTuple):
    """Heights of a plane [m]: ``level`` at the place ``x``, ``y`` [m], and slopes along x and y."""

    x: float
    y: float
    level: float
    slope_x: float
    slope_y: float

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the heights [m] of the plane at places [m]."""
        return self.level + self.slope_x * (x - self.x) + self.slope_y * (y - self.y)


def plane_through(x: np.ndarray, y: np.ndarray, heights: np.ndarray) -> Plane:
    """Return the least-squares plane of points with coordinates (n,) [m], all finite.

    It is computed by sums, which have the same bits on any processor. Points on one line have the
    plane that is level across the line.
    """
    middle_x = float(np.mean(x))
    middle_y = float(np.mean(y))
    level = float(np.mean(heights))
    x = x - middle_x
    y = y - middle_y
    heights = heights - level
    xx, xy, yy = (float(np.sum(a * b)) for a, b in ((x, x), (x, y), (y, y)))
    xh = float(np.sum(x * heights))
    yh = float(np.sum(y * heights))
    determinant = xx * yy - xy * xy
    trace = xx + yy
    if determinant > 1e-12 * trace * trace:
        slopes = (yy * xh - xy * yh) / determinant, (xx * yh - xy * xh) / determinant
    elif trace > 0.0:
        slopes = (xx * xh + xy * yh) / trace**2, (xy * xh + yy * yh) / trace**2
    else:
        slopes = 0.0, 0.0
    return Plane(middle_x, middle_y, level, *slopes)


def detrended_points(x: np.ndarray, y: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Return the heights (n,) [m] of points less their least-squares plane."""
    return heights - plane_through(x, y, heights).at(x, y)


def detrended(heights: np.ndarray) -> np.ndarray:
    """Return the heights (y, x) [m] of a whole wall less its least-squares plane.

    Heights must be known in all cells: the terms of the plane are then orthogonal, and are
    subtracted one after the other.
    """
    ny, nx = heights.shape
    y, x = (np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1) for n in (ny, nx))
    level = heights - np.mean(heights)
    for terms, axis in ((y[:, None], 1), (x[None, :], 0)):
        squares = np.sum(terms * terms) * heights.shape[axis]
        if squares > 0.0:
            level = level - terms * (np.sum(terms * level) / squares)
    return level

"""Mean planes of walls and of points."""

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
        """Return the heights at places [m]."""
        return self.level + self.slope_x * (x - self.x) + self.slope_y * (y - self.y)


def plane_through(x: np.ndarray, y: np.ndarray, heights: np.ndarray) -> Plane:
    """Fit the plane of points (n,) [m] by sums, which have the same bits on any processor."""
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


def detrended(heights: np.ndarray) -> np.ndarray:
    """Return a wall (y, x) [m] less its plane, whose terms are orthogonal on a regular grid."""
    ny, nx = heights.shape
    y, x = (np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1) for n in (ny, nx))
    level = heights - np.mean(heights)
    for terms, axis in ((y[:, None], 1), (x[None, :], 0)):
        squares = np.sum(terms * terms) * heights.shape[axis]
        if squares > 0.0:
            level = level - terms * (np.sum(terms * level) / squares)
    return level

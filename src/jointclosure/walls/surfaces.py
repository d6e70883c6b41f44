"""Surface: heights of one scan on a square grid, from which the position of two walls is fitted.

Unlike a wall of a joint, a surface may lack heights, keeps its inclination, and has a place in the
frame of its scan.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.walls import gridding
from jointclosure.walls.gridding import Cloud
from jointclosure.walls.planes import plane_through

LEAST_KNOWN_WEIGHT = 0.9  # least share of the weights of a mean that must be those of known heights


class Surface(NamedTuple):
    """Surface of a scanned wall: ``heights`` (y, x) [m] of square cells, NaN where missing.

    ``low`` (x, y) [m] is the place of the first cell, ``spacing`` [m] is that of the grid, and
    ``slopes`` are those of the mean plane along x and y.
    """

    heights: np.ndarray
    low: np.ndarray
    spacing: float
    slopes: tuple[float, float]

    @property
    def middle(self) -> np.ndarray:
        """Middle (x, y, z) [m] of the surface: that of its grid, at the mean height."""
        size = np.array(self.heights.shape[::-1]) - 1.0
        return np.append(self.low + 0.5 * self.spacing * size, np.nanmean(self.heights))

    @property
    def plane(self) -> np.ndarray:
        """Heights (y, x) [m] of the plane with the surface's slopes, 0 at the first cell."""
        y, x = np.indices(self.heights.shape) * self.spacing
        return self.slopes[0] * x + self.slopes[1] * y

    def smoothed(self, width: float) -> np.ndarray:
        """Return Gaussian means (y, x) [m] of the heights; ``width`` is their deviation [cells].

        They are NaN where known heights have less than `LEAST_KNOWN_WEIGHT` of the weights. The
        plane is kept: only departures from it are smoothed.
        """
        level = self.heights - self.plane
        known = np.isfinite(level)
        middle = np.nanmean(level)
        weight = gaussian_sums(known.astype(float), width, 3.0)
        sums = gaussian_sums(np.where(known, level - middle, 0.0), width, 3.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = np.where(weight >= LEAST_KNOWN_WEIGHT, sums / weight, np.nan)
        return means + middle + self.plane


def surface_of(points: np.ndarray, spacing: float) -> Surface:
    """Return the surface of points (n, 3) [m] on a grid; NaN are heights that are missing.

    Raise `InputError` as `gridding.wall_on_grid`.
    """
    plane = plane_through(*points[np.isfinite(points[:, 2])].T)
    slopes = (plane.slope_x, plane.slope_y)
    low = points[:, :2].min(axis=0)
    bare = Surface(gridding.wall_on_grid(Cloud(points), spacing), low, spacing, slopes)
    offset = float(plane.at(low[0], low[1]))
    return bare._replace(heights=bare.heights + bare.plane + offset)


def gaussian_sums(values: np.ndarray, width: float, truncate: float) -> np.ndarray:
    """Return sums (y, x) of values (y, x) by Gaussian weights of a standard deviation [cells].

    Weights end at ``truncate`` times the ``width``. Values beyond the edges count as 0.
    """
    return scipy.ndimage.gaussian_filter(values, width, mode="constant", truncate=truncate)

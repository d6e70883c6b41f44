"""Heights of one scan on a grid, with the slopes of their plane, as a fit of two walls needs them.

Unlike a wall, a surface may lack heights, and has a place in the frame of its scan.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.walls import gridding
from jointclosure.walls.gridding import Cloud
from jointclosure.walls.planes import plane_through

LEAST_KNOWN_WEIGHT = 0.9  # share of a mean's weights that known heights must have


class Surface(NamedTuple):
    """Heights (y, x) [m], NaN where missing, of square cells, the first one at ``low`` (x, y)."""

    heights: np.ndarray
    low: np.ndarray
    spacing: float
    slopes: tuple[float, float]

    @property
    def middle(self) -> np.ndarray:
        """Middle (x, y, z) of the wall [m]."""
        size = np.array(self.heights.shape[::-1]) - 1.0
        return np.append(self.low + 0.5 * self.spacing * size, np.nanmean(self.heights))

    @property
    def plane(self) -> np.ndarray:
        """Heights (y, x) [m] of its plane, 0 at the first cell."""
        y, x = np.indices(self.heights.shape) * self.spacing
        return self.slopes[0] * x + self.slopes[1] * y

    def smoothed(self, width: float) -> np.ndarray:
        """Return Gaussian means (y, x) [m] of a width in cells, NaN with too few known heights."""
        level = self.heights - self.plane
        known = np.isfinite(level)
        middle = np.nanmean(level)
        weight = gaussian_sums(known.astype(float), width, 3.0)
        sums = gaussian_sums(np.where(known, level - middle, 0.0), width, 3.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = np.where(weight >= LEAST_KNOWN_WEIGHT, sums / weight, np.nan)
        return means + middle + self.plane


def surface_of(points: np.ndarray, spacing: float) -> Surface:
    """Return points (n, 3) [m], NaN where a height is missing, on a grid."""
    plane = plane_through(*points[np.isfinite(points[:, 2])].T)
    slopes = (plane.slope_x, plane.slope_y)
    low = points[:, :2].min(axis=0)
    bare = Surface(gridding.wall_on_grid(Cloud(points), spacing), low, spacing, slopes)
    offset = float(plane.at(low[0], low[1]))
    return bare._replace(heights=bare.heights + bare.plane + offset)


def gaussian_sums(values: np.ndarray, width: float, truncate: float) -> np.ndarray:
    """Return Gaussian sums (y, x) of values (y, x), which count as 0 beyond their edges."""
    return scipy.ndimage.gaussian_filter(values, width, mode="constant", truncate=truncate)

"""Slopes that a wall lost, or gained, when heights of a scan were interpolated onto its grid."""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs.remarks import Caution, caution
from jointclosure.walls.gridding import USUAL_HURST, Cloud, Scan, node_counts, points_of
from jointclosure.walls.planes import detrended_points

_PAIRS = 0.75, 1.25
"""Distances of the points, in cells, whose height differences are compared with those of cells."""
_SAMPLE = 20_000  # most nodes, and points, that are asked for their neighbours


class Slopes(NamedTuple):
    """Rms slopes [1] of a wall over about one cell, before and after its interpolation."""

    scanned: float  # between scanned points
    kept: float  # between nodes of the grid

    @property
    def lost_square(self) -> float:
        """Mean square slope [1] that interpolation took, 0 if it took none."""
        return max(self.scanned**2 - self.kept**2, 0.0)


def slopes_by_interpolation(
    points: np.ndarray, wall: np.ndarray, spacing: float, low: np.ndarray, high: np.ndarray
) -> Slopes | None:
    """Compare slopes of scanned points (n, 3) [m] with those of a wall (y, x) [m] made of them.

    The slopes of the points are those between points which are about one cell apart. Points whose
    height is NaN are left out. The first and the last node of the wall are at ``low`` and ``high``
    (x, y) [m]. None if the nodes lie on points, or there are too few points.
    """
    place = points[:, :2]
    edge = 0.5 * spacing
    inside = ((place > low - edge) & (place < high + edge)).all(axis=1) & np.isfinite(points[:, 2])
    x, y, heights = points[inside].T
    if len(x) < 4 or min(wall.shape) < 2:
        return None
    ny, nx = (max(count, 1) for count in node_counts(low, high, spacing))
    tree = scipy.spatial.cKDTree(np.column_stack([x, y]))
    row, column = np.divmod(np.arange(0, nx * ny, -(-nx * ny // _SAMPLE)), nx)
    nearest = tree.query(low + spacing * np.column_stack([column, row]))[0] / spacing
    # nearer nodes have the height of a point, and farther ones are in a hole
    if np.mean((nearest > 1e-5) & (nearest < 0.75)) < 0.05:
        return None
    some = np.arange(0, len(x), -(-len(x) // _SAMPLE))
    pairs = tree.sparse_distance_matrix(
        scipy.spatial.cKDTree(tree.data[some]), _PAIRS[1] * spacing, output_type="coo_matrix"
    )
    apart = pairs.data / spacing
    used = apart > _PAIRS[0]
    bare = detrended_points(x, y, heights)
    rise = (bare[pairs.row] - bare[some][pairs.col])[used] / apart[used] ** USUAL_HURST
    if not rise.any():
        return None
    along = [np.diff(wall, axis=axis) for axis in (0, 1)]
    steps = np.concatenate([(part - np.nanmean(part)).ravel() for part in along])
    scanned, kept = (float(np.sqrt(np.nanmean(part**2))) / spacing for part in (rise, steps))
    return Slopes(scanned, kept)


def interpolation_remarks(
    scan: Scan | Cloud,
    wall: np.ndarray,
    spacing: float,
    low: np.ndarray | None = None,
    high: np.ndarray | None = None,
) -> tuple[Caution, ...]:
    """Return a caution if heights of a wall were interpolated between points of a scan, else none.

    The caution compares the rms slope of the wall with the rms slope between scanned points about
    one cell apart. Less than 5 % of interpolated nodes, and fewer than four points on the grid,
    are ignored.

    Parameters
    ----------
    scan : Scan or Cloud
        In metres, in the frame of the wall.
    wall : ndarray, shape (y, x)
        Heights [m] on a grid, NaN where missing.
    spacing : float
        Spacing of the grid [m].
    low, high : ndarray, shape (2,), optional
        Places (x, y) [m] of the first and the last node of the wall: by default the first point of
        a `Scan` or the lowest x and y of a `Cloud`, and as many nodes farther as the wall has.
    """
    points = points_of(scan)
    if low is None:
        at = scan.origin or (0.0, 0.0) if isinstance(scan, Scan) else points[:, 1::-1].min(axis=0)
        low = np.array(at)[::-1]
    if high is None:
        high = low + spacing * (np.array(wall.shape)[::-1] - 1)
    slopes = slopes_by_interpolation(points, wall, spacing, low, high)
    return interpolation_caution(slopes, spacing)


def interpolation_caution(slopes: Slopes | None, spacing: float) -> tuple[Caution, ...]:
    """Return a caution on slopes of a wall that interpolation changed; none if slopes are None."""
    if slopes is None:
        return ()
    change = "smoothed" if slopes.kept < slopes.scanned else "roughened"
    lost = (
        f"interpolation onto the grid {change} the wall: its rms slope over "
        f"{1e3 * spacing:.4g} mm is {slopes.kept:.3g} instead of {slopes.scanned:.3g} "
        f"({100.0 * (slopes.kept / slopes.scanned - 1.0):+.2g} %)"
    )
    if slopes.kept < slopes.scanned:
        lost += "; on a grid of larger spacing (--spacing) less of the slope is lost"
    return (caution(lost),)

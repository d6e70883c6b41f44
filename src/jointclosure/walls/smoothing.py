"""What interpolation between scanned points costs: the slope that the wall on the grid has lost."""

import numpy as np
import scipy

from jointclosure.inputs.remarks import Caution, caution
from jointclosure.walls.measured import Cloud, Scan
from jointclosure.walls.outliers import points_of
from jointclosure.walls.roughness import plane_through

AT_NODE, BETWEEN = 1e-5, 0.75
"""Distances of a node from the nearest point, in cells, below which it has that point's height, and
up to which it lies between points; farther nodes are in holes."""
LEAST_BETWEEN = 0.05
"""Smallest share of nodes between points from which a wall counts as interpolated."""
_PAIRS = 0.75, 1.25
"""Distances of the points, in cells, whose height differences are compared with those of cells."""
_HURST = 0.8
"""Exponent with which height differences are carried from the distance of points to a cell."""
_SAMPLE = 20_000
"""Largest number of nodes, and of points, that are asked for their neighbours."""


def smoothing_of(
    scan: Scan | Cloud, wall: np.ndarray, spacing: float, bounds: np.ndarray | None = None
) -> tuple[Caution, ...]:
    """Warn as `smoothing` of a wall by `jointclosure.walls.measured.wall_on_grid`."""
    points = points_of(scan)
    low = points[:, :2].min(axis=0)
    if bounds is not None:
        low = bounds[0]
    elif isinstance(scan, Scan):
        low = np.array(scan.origin or (0.0, 0.0))[::-1]
    return smoothing(points, wall, spacing, (low, low + spacing * (np.array(wall.shape)[::-1] - 1)))


def smoothing(
    points: np.ndarray, wall: np.ndarray, spacing: float, box: tuple[np.ndarray, np.ndarray]
) -> tuple[Caution, ...]:
    """Warn of the slope that a wall lost by interpolation; empty if its nodes are at points.

    Parameters
    ----------
    points : array (n, 3)
        x, y and height [m], NaN where missing.
    wall : array (y, x)
        Heights on the grid [m], NaN where missing.
    spacing : float
        [m].
    box : two arrays (2,)
        Place (x, y) of a node of the grid, and the other corner of the compared area [m].
    """
    low, high = box
    place, edge = points[:, :2], 0.5 * spacing
    inside = ((place > low - edge) & (place < high + edge)).all(axis=1) & np.isfinite(points[:, 2])
    x, y, heights = points[inside].T
    nx, ny = np.maximum(((high - low) / spacing + 1e-6).astype(int) + 1, 1).tolist()
    if len(x) < 4 or min(wall.shape) < 2:
        return ()
    tree = scipy.spatial.cKDTree(np.column_stack([x, y]))
    row, column = np.divmod(np.arange(0, nx * ny, -(-nx * ny // _SAMPLE)), nx)
    nearest = tree.query(low + spacing * np.column_stack([column, row]))[0] / spacing
    if np.mean((nearest > AT_NODE) & (nearest < BETWEEN)) < LEAST_BETWEEN:
        return ()
    some = np.arange(0, len(x), -(-len(x) // _SAMPLE))
    pairs = tree.sparse_distance_matrix(
        scipy.spatial.cKDTree(tree.data[some]), _PAIRS[1] * spacing, output_type="coo_matrix"
    )
    apart = pairs.data / spacing
    used = apart > _PAIRS[0]
    level = heights - plane_through(x, y, heights).at(x, y)
    rise = (level[pairs.row] - level[some][pairs.col])[used] / apart[used] ** _HURST
    if not rise.any():
        return ()
    slopes = [np.diff(wall, axis=axis) for axis in (0, 1)]
    steps = np.concatenate([(part - np.nanmean(part)).ravel() for part in slopes])
    measured, kept = (float(np.sqrt(np.nanmean(part**2))) / spacing for part in (rise, steps))
    change = f"{100.0 * (kept / measured - 1.0):+.2g} %"
    return (
        caution(
            "heights were interpolated between points: the rms slope at a distance of "
            f"{1e3 * spacing:.4g} mm is {kept:.3g}, between points {measured:.3g} ({change})"
        ),
    )

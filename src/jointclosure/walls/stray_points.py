"""Scattered points that belong to no wall: in patches beside the wall, or far off in height."""

import numpy as np
import scipy

from jointclosure.walls.neighbours import connected_parts

_LEAST = 8  # points of a scan, below which none is a stray one


def stray_points(points: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) [m] belong to no wall: in small patches, or far off in height.

    The result is bool (n,). ``patch`` (n,) are the numbers of the points' patches
    (`patch_numbers`). Far off is beyond 20 times the range between the quantiles of 1 and 99 %.
    Missing heights (NaN) are not far off, and of fewer than eight points none is a stray one.
    """
    if len(points) < _LEAST:
        return np.zeros(len(points), bool)
    stray = _in_small_patches(patch)
    known = np.isfinite(points[:, 2]) & ~stray
    if known.sum() >= _LEAST:
        low, middle, high = np.percentile(points[known, 2], (1.0, 50.0, 99.0))
        if high > low:
            stray |= np.abs(points[:, 2] - middle) > 20.0 * (high - low)
    return stray


def patch_numbers(places: np.ndarray) -> np.ndarray:
    """Return the number (n,) of the patch to which each place (n, 2) [m] belongs.

    Patches are apart by more than about five times the usual distance of places.
    """
    distances = scipy.spatial.cKDTree(places).query(places, k=2)[0][:, 1]
    if not (distances > 0.0).any():
        return np.zeros(len(places), int)
    size = 5.0 * float(np.median(distances[distances > 0.0]))
    cells, of_point = unique_places(np.floor(places / size))
    pairs = scipy.spatial.cKDTree(cells).query_pairs(1.5, p=np.inf, output_type="ndarray")
    return connected_parts(pairs, len(cells))[of_point]


def _in_small_patches(patch: np.ndarray) -> np.ndarray:
    """Return which points are in patches of less than 1 % of all points, bool (n,).

    ``patch`` (n,) are the numbers of the points' patches. The largest patch is never a small one.
    """
    members = np.bincount(patch)
    small = members < 0.01 * len(patch)
    small[members.argmax()] = False
    return small[patch]


def unique_places(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the different places (m, 2) in order of x and y, and the number of each (n,)."""
    unique, numbers = np.unique(
        np.ascontiguousarray(places, dtype=float).view(complex).ravel(), return_inverse=True
    )
    return unique.view(float).reshape(-1, 2), numbers

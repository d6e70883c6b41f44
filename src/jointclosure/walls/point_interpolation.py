"""Linear interpolation of heights between scattered points, in their Delaunay triangles."""

import numpy as np
import scipy
from threadpoolctl import threadpool_limits


def interpolate_heights(
    places: np.ndarray, heights: np.ndarray, nodes: np.ndarray, reach: float
) -> np.ndarray:
    """Return heights (...) [m] at nodes (..., 2) [m], interpolated linearly between points.

    Points have ``heights`` (n,) [m] at ``places`` (n, 2) [m]. A node outside of the convex hull of
    the points, or without a point within ``reach`` [m], has NaN.
    """
    count = min(12, len(places))  # enough for the Delaunay triangle of all
    distances, near = scipy.spatial.cKDTree(places).query(nodes, k=np.arange(1, count + 1))
    nearest = distances[..., 0]
    interpolated = heights[near[..., 0]]
    off = nearest >= 1e-6 * reach  # others are at a scanned point
    if off.any():
        used = np.zeros(len(places), bool)
        used[near[off]] = True
        interpolated[off] = triangle_interpolation(places[used], heights[used], nodes[off])
    return np.where(nearest <= reach, interpolated, np.nan)


def triangle_interpolation(
    places: np.ndarray, heights: np.ndarray, nodes: np.ndarray
) -> np.ndarray:
    """Return heights (...) at nodes (..., 2), linear in the Delaunay triangles of points.

    Points have ``heights`` (n,) at ``places`` (n, 2). Nodes outside of all triangles have NaN. The
    result has the same bits on any processor.
    """
    # the triangulation is most robust for coordinates of order one about zero
    centre = places.mean(axis=0)
    scale = np.ptp(places)
    corners = (places - centre) / scale
    at = (nodes - centre) / scale
    triangles = scipy.spatial.Delaunay(corners)
    # called for each triangle: on a busy machine each call would wait for the other threads
    with threadpool_limits(limits=1, user_api="blas"):
        triangle = triangles.find_simplex(at)
    corner = triangles.simplices[triangle]
    x, y = np.moveaxis(corners[corner] - at[..., None, :], -1, 0)
    areas = np.stack(
        [x[..., i - 2] * y[..., i - 1] - y[..., i - 2] * x[..., i - 1] for i in range(3)], axis=-1
    )
    with np.errstate(invalid="ignore", divide="ignore"):  # triangles without area hold no node
        inside = np.sum(areas * heights[corner], axis=-1) / np.sum(areas, axis=-1)
    return np.where(triangle >= 0, inside, np.nan)

"""Scans of walls, and their interpolation on the square grid of a joint. See docs/two_scans.md."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.walls.missing_heights import between_known, fill_with_nearest
from jointclosure.walls.planes import plane_through
from jointclosure.walls.point_interpolation import interpolate_heights

FLAT = "flat"  # stands in place of a scan for a flat wall, such as a saw cut
LARGEST_TILT = 20.0  # largest inclination [degrees] of a scan's mean plane; heights are along z
REACH = 2.0  # largest distance of a cell with a height from the nearest point, in point distances
MOST_CELLS_PER_POINT = 100  # of a grid; with more, nearly all cells are far from points
USUAL_HURST = 0.8  # of rock, with which a slope is carried to another spacing or distance
PAPER_SPACING = 0.25e-3  # of the paper's walls [m], at which relations of JRC are stated


class Scan(NamedTuple):
    """Scanned wall on a grid: ``heights`` (y, x) [m], NaN where missing.

    ``spacing`` (dy, dx) [m] is that of the grid, ``origin`` (y, x) [m] is the place of the first
    cell, None if it is not known, and ``remarks`` are sentences on what was found in the scan.
    """

    heights: np.ndarray
    spacing: tuple[float, float]
    origin: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        ny, nx = self.heights.shape
        dy, dx = self.spacing
        missing = 100.0 * float(np.isnan(self.heights).mean())
        low = 1e3 * np.nanmin(self.heights)
        high = 1e3 * np.nanmax(self.heights)
        grid = f"{nx} x {ny} points, {1e3 * dx:.4g} x {1e3 * dy:.4g} mm apart"
        return f"<Scan: {grid}, heights {low:.4g} to {high:.4g} mm, {missing:.3g} % missing>"


class Cloud(NamedTuple):
    """Scanned wall as ``points`` (n, 3) [m]: x, y and height, in any order; remarks as `Scan`."""

    points: np.ndarray
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        if not len(self.points):
            return "<Cloud: no points>"
        x, y, z = 1e3 * np.ptp(self.points, axis=0)
        area = f"{len(self.points)} points on {x:.4g} x {y:.4g} mm"
        return f"<Cloud: {area}, heights within {z:.4g} mm>"


def points_of(scan: Scan | Cloud, missing: bool = False) -> np.ndarray:
    """Return the points (n, 3) [m] of a scan, row by row: x, y and height.

    With ``missing``, a grid also gives points with a height of NaN: the cells without a height in
    the smallest rectangle of rows and columns that contains all known heights.
    """
    if isinstance(scan, Cloud):
        return scan.points
    listed = np.isfinite(scan.heights)
    if missing:
        listed = np.logical_and.outer(*(between_known(listed.any(axis=axis)) for axis in (1, 0)))
    y, x = np.nonzero(listed)
    y0, x0 = scan.origin or (0.0, 0.0)
    return np.column_stack(
        [x0 + x * scan.spacing[1], y0 + y * scan.spacing[0], scan.heights[listed]]
    )


def without_points(scan: Scan | Cloud, cut: np.ndarray) -> Scan | Cloud:
    """Return a scan without the points ``cut``, bool (n,) in the order of `points_of`.

    Points of a `Cloud` are left out, and cells of a `Scan` become missing; the given scan is not
    changed.
    """
    if isinstance(scan, Cloud):
        return scan._replace(points=scan.points[~cut])
    left = scan.heights.copy()
    left[np.isfinite(left)] = np.where(cut, np.nan, left[np.isfinite(left)])
    return scan._replace(heights=left)


def point_distance(scan: Scan | Cloud) -> float:
    """Return the distance [m] of neighbouring points of a scan.

    For a grid it is the larger of both spacings, for a cloud the square root of the area of its
    convex hull in the plan per point. Raise `InputError` if the points of a cloud lie on one line
    or are too few.
    """
    if isinstance(scan, Scan):
        return max(scan.spacing)
    try:
        area = scipy.spatial.ConvexHull(scan.points[:, :2]).volume
    except (scipy.spatial.QhullError, ValueError):
        problem = "they lie on one line or are too few for a wall"
        raise InputError(f"{len(scan.points)} points: {problem}") from None
    return float(np.sqrt(area / len(scan.points)))


def usual_grid_spacing(distance: float) -> float:
    """Return the usual spacing [m] of a joint's grid for scans, near that of the paper's walls.

    It is the multiple of the distance [m] of the scanned points that is nearest to `PAPER_SPACING`.
    """
    return distance * max(round(PAPER_SPACING / distance), 1)


def plane_of(scan: Scan | Cloud, sign: int = 1) -> Scan | Cloud:
    """Return a scan with the same places whose heights are those of the scan's mean plane.

    The plane keeps its inclination. Heights are multiplied by ``sign``, which is 1 or -1. Missing
    heights stay missing. Raise `InputError` for fewer than four heights, or a plane steeper than
    `LARGEST_TILT`.
    """
    if isinstance(scan, Scan):
        return Scan(sign * (scan.heights - _heights_less_plane(scan)), scan.spacing, scan.origin)
    plane = scan.points[:, 2] - _heights_less_plane(scan)
    return Cloud(np.column_stack([scan.points[:, :2], sign * plane]))


def wall_on_grid(scan: Scan | Cloud, spacing: float, box: np.ndarray | None = None) -> np.ndarray:
    """Return heights (y, x) [m] of a scan on a square grid of a ``spacing`` [m], less its plane.

    Heights are NaN where the scan has none. ``box`` (2, 2) has the lowest and the highest place
    (x, y) [m] of the grid for a cloud, by default those of its points; a scanned grid ignores it.
    Raise `InputError` if the grid is finer than the scan or has too many cells for its points, or
    if the scan has fewer than four heights or is steeper than `LARGEST_TILT`.
    """
    distance = point_distance(scan)
    if spacing < (0.99 if isinstance(scan, Scan) else 0.8) * distance:
        finer = f"finer than the scan, whose points are {1e3 * distance:.4g} mm apart"
        raise InputError(f"grid spacing {1e3 * spacing:g} mm: {finer}")
    bare = _heights_less_plane(scan)
    if isinstance(scan, Scan):
        return _resampled(Scan(bare, scan.spacing), spacing, (0.0, 0.0))
    places = scan.points[:, :2]
    low, high = (places.min(axis=0), places.max(axis=0)) if box is None else box
    ny, nx = node_counts(low, high, spacing)
    if nx * ny > MOST_CELLS_PER_POINT * len(places):
        x, y = 1e3 * (high - low)
        raise InputError(
            f"{len(places)} points lie in {x:.4g} x {y:.4g} mm (x, y), {ny} x {nx} cells of the "
            f"grid: must be at most {MOST_CELLS_PER_POINT} cells for each point"
        )
    return interpolate_heights(places, bare, grid_nodes(low, (ny, nx), spacing), REACH * distance)


def node_counts(low: np.ndarray, high: np.ndarray, spacing: float) -> tuple[int, int]:
    """Return the numbers (y, x) of nodes of a square grid from ``low`` to ``high`` (x, y) [m]."""
    nx, ny = (np.floor((high - low) / spacing + 1e-6).astype(int) + 1).tolist()
    return ny, nx


def grid_nodes(low: np.ndarray, shape: tuple[int, int], spacing: float) -> np.ndarray:
    """Return the places (y, x, 2) of the nodes of a grid [m], the first one at ``low`` (x, y)."""
    ny, nx = shape
    along = np.meshgrid(low[0] + spacing * np.arange(nx), low[1] + spacing * np.arange(ny))
    return np.stack(along, axis=-1)


def sample_grid(scan: Scan, spacing: float, anchor: tuple[float, float]) -> Scan:
    """Return a scanned grid sampled at the nodes of a coarser square grid of a ``spacing`` [m].

    One of the nodes, or one of their continuation beyond the scan, is the ``anchor`` (y, x) [m].
    Heights are taken at nodes and not averaged over cells, since averages would have smaller slopes
    than the wall. Raise `InputError` if the scan is too small to be interpolated.
    """
    origin = np.array(scan.origin or (0.0, 0.0))
    steps = np.array(scan.spacing)
    first = anchor + spacing * np.ceil((origin - anchor) / spacing - 1e-6)
    start = np.maximum((first - origin) / steps, 0.0)
    y, x = (origin + start * steps).tolist()
    heights = _resampled(scan, spacing, start.tolist())
    return scan._replace(heights=heights, spacing=(spacing, spacing), origin=(y, x))


def _heights_less_plane(scan: Scan | Cloud) -> np.ndarray:
    """Return heights [m] of a scan, (y, x) or (n,), less their least-squares plane; NaN remain.

    Raise `InputError` for fewer than four known heights, or a plane steeper than `LARGEST_TILT`.
    """
    if isinstance(scan, Cloud):
        x, y, heights = scan.points.T
    else:
        heights = scan.heights
        y, x = np.indices(heights.shape) * np.reshape(scan.spacing, (2, 1, 1))
    known = np.isfinite(heights)
    if known.sum() < 4:
        raise InputError(f"{int(known.sum())} heights: too few for a wall")
    plane = plane_through(x[known], y[known], heights[known])
    tilt = np.degrees(np.arctan(np.hypot(plane.slope_x, plane.slope_y)))
    if tilt > LARGEST_TILT:
        must = f"at most {LARGEST_TILT:g}; turn the scan so that its mean plane is about horizontal"
        raise InputError(f"the mean plane is inclined by {tilt:.1f} degrees: {must}")
    return heights - plane.at(x, y)


def _resampled(scan: Scan, spacing: float, start: Sequence[float]) -> np.ndarray:
    """Return the heights (y, x) [m] of a scanned grid at another, square ``spacing`` [m].

    The first node is at ``start`` (y, x), counted in cells of the scan. If all nodes are cells of
    the scan, their heights are copied. Otherwise heights are interpolated by cubic splines, and are
    NaN beside missing ones. Raise `InputError` if a side has fewer than four cells to interpolate.
    """
    heights = scan.heights
    ratios = [spacing / scanned for scanned in scan.spacing]
    exact = np.column_stack([start, ratios])
    whole = np.rint(exact).astype(int)
    if np.all(np.abs(exact - whole) < 1e-6 * exact[:, 1:]):
        rows, columns = (slice(first, None, step) for first, step in whole)
        return heights[rows, columns].copy()
    if min(heights.shape) < 4:
        raise InputError(f"{heights.shape} heights: too few to be brought to another spacing")
    axes = [np.arange(n, dtype=float) for n in heights.shape]
    wanted = [
        first + np.arange(int(np.floor((n - 1 - first) / ratio + 1e-9)) + 1) * ratio
        for n, first, ratio in zip(heights.shape, start, ratios, strict=True)
    ]
    wall = scipy.interpolate.RectBivariateSpline(*axes, fill_with_nearest(heights))(*wanted)
    missing = (~np.isfinite(heights)).astype(float)
    nodes = np.meshgrid(*wanted, indexing="ij")
    touched = scipy.ndimage.map_coordinates(missing, nodes, order=1, mode="nearest")
    return np.where(touched > 1e-9, np.nan, wall)

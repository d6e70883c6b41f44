"""Overlap of the scans of two walls in one frame: both walls on a grid where both were scanned.

Points of scans have z upwards. In an `Overlap`, as in all registered walls, the heights of both
walls count towards the other wall; `overlap_of` changes the sign of the upper wall's heights.

In holes of a scan the walls are made not to touch. With such holes the closures of 14 joints were
0.94 to 1.03 times those without holes. With holes filled between their rims they were 0.95 to 1.8
times as large, as the filled parts lack the waves that both walls share.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls import Walls, gridding
from jointclosure.walls.missing_heights import fill_dropouts, fill_missing, in_holes
from jointclosure.walls.planes import detrended, plane_through
from jointclosure.walls.point_interpolation import interpolate_heights

SMALLEST_SIDE = 8  # fewest cells of the walls along each side
MOST_FILLED = 0.9  # largest share of cells in holes, also if the user allows a larger one
HeightsAt = Callable[[np.ndarray], np.ndarray]
"""Heights (...) [m] of a wall at nodes (..., 2) [m], NaN where they are not known."""


class Overlap(NamedTuple):
    """Walls on the grid of a joint where both were scanned, less their common plane."""

    upper: np.ndarray  # heights (y, x) [m] towards the other wall
    lower: np.ndarray  # heights (y, x) [m] towards the other wall
    upper_holes: np.ndarray  # cells (y, x) without contact, as the upper scan has no height there
    lower_holes: np.ndarray  # the same of the lower scan
    shares: list[float]  # of the area of the upper and of the lower scan that the walls cover
    inclination: float  # of the common plane [degrees]
    relative: float  # inclination of the walls to each other [degrees]
    cut: int  # number of cells in holes outside of the walls' rectangle
    box: tuple[np.ndarray, np.ndarray]  # lowest and highest (x, y) [m] that both scans cover
    first: np.ndarray  # place (x, y) [m] of the first cell

    @property
    def holes(self) -> np.ndarray:
        """Cells (y, x) in which either scan has no height."""
        return self.upper_holes | self.lower_holes

    def scanned(self, side: str) -> np.ndarray:
        """Return the heights (y, x) [m] of the wall of a side, NaN in holes, which were filled."""
        holes = {"upper": self.upper_holes, "lower": self.lower_holes}[side]
        return np.where(holes, np.nan, {"upper": self.upper, "lower": self.lower}[side])

    @property
    def gap(self) -> np.ndarray:
        """Height (y, x) [m] of the upper wall above the lower one, below 0 where it lies lower."""
        return -(self.upper + self.lower)

    @property
    def parallel_walls(self) -> Walls:
        """Both walls (y, x) [m], each less its own plane."""
        return detrended(self.upper), detrended(self.lower)

    def every_node(self, step: int) -> "Overlap":
        """Return the overlap on a grid of which one node in ``step`` is kept along each axis."""
        fields = ("upper", "lower", "upper_holes", "lower_holes")
        return self._replace(**{name: getattr(self, name)[::step, ::step] for name in fields})

    def with_flat_wall(self, side: str) -> "Overlap":
        """Return the overlap with an exactly flat wall on a side; the other wall gets all holes.

        The other wall is kept except in holes, where it becomes the sum of both walls, so that the
        gap there does not change.
        """
        flat = np.zeros(self.upper.shape)
        none = np.zeros_like(self.holes)
        together = self.upper + self.lower
        if side == "upper":
            lower = np.where(self.holes, together, self.lower)
            return self._replace(upper=-flat, lower=lower, upper_holes=none, lower_holes=self.holes)
        upper = np.where(self.holes, together, self.upper)
        return self._replace(upper=upper, lower=flat, upper_holes=self.holes, lower_holes=none)


def overlap_of(
    clouds: list[np.ndarray],
    spacing: float,
    distances: list[float],
    largest_filled_share: float,
    heights_at: tuple[HeightsAt | None, HeightsAt | None] = (None, None),
) -> Overlap:
    """Return both walls in the largest rectangle of nodes at which both were scanned.

    ``clouds`` are the points (n, 3) [m] of the upper and the lower scan, with mean ``distances``
    [m] of points. Nodes lie at multiples of the ``spacing`` [m] from the corner of the lower scan.
    ``heights_at`` are functions that return the heights of the upper and of the lower wall at nodes
    (y, x, 2) [m]; a wall without one is interpolated linearly between its points. Nodes in holes of
    a scan count as scanned, unless they would be more than ``largest_filled_share`` of the
    rectangle; then the largest rectangle without holes is taken.

    Raise `InputError` if the walls overlap in less than `SMALLEST_SIDE` cells along a side, if the
    scans have fewer than four points in common, or if their common plane is too inclined.
    """
    corners = [(cloud[:, :2].min(axis=0), cloud[:, :2].max(axis=0)) for cloud in clouds]
    low = np.maximum(corners[0][0], corners[1][0])
    high = np.minimum(corners[0][1], corners[1][1])
    low = corners[1][0] + spacing * np.ceil((low - corners[1][0]) / spacing - 1e-6)
    shape = gridding.node_counts(low, high, spacing)
    _check_size(shape, spacing)
    nodes = gridding.grid_nodes(low, shape, spacing)
    plane = 0.5 * (_fitted_plane(clouds[0], low, high) + _fitted_plane(clouds[1], low, high))
    inclination = float(np.degrees(np.arctan(np.hypot(plane[0], plane[1]))))
    if inclination > gridding.LARGEST_TILT:
        raise InputError(
            f"the walls' common plane is inclined by {inclination:.1f} degrees: at most "
            f"{gridding.LARGEST_TILT:g}; turn the scans so that it is about horizontal"
        )
    walls = []
    holes = []
    common = nodes[..., 0] * plane[0] + nodes[..., 1] * plane[1] + plane[2]
    for cloud, distance, at in zip(clouds, distances, heights_at, strict=True):
        if at is None:
            level = cloud[:, 2] - cloud[:, 0] * plane[0] - cloud[:, 1] * plane[1] - plane[2]
            wall = interpolate_heights(cloud[:, :2], level, nodes, gridding.REACH * distance)
        else:
            wall = at(nodes) - common
        scattered = np.isfinite(cloud[:, 2]).all() and at is None
        hole = _hole_cells(wall, gridding.REACH * distance / spacing if scattered else 0.0)
        walls.append(np.where(hole, np.nan, fill_dropouts(wall, hole)))
        holes.append(hole)
    inside = np.logical_or(*holes)
    covered = np.logical_and(*(np.isfinite(walls) | holes))
    rectangle = largest_rectangle(covered)
    if inside[rectangle].sum() > min(largest_filled_share, MOST_FILLED) * inside[rectangle].size:
        rectangle = largest_rectangle(covered & ~inside)
    cut = int(inside.sum() - inside[rectangle].sum())
    _check_size(inside[rectangle].shape, spacing, f"; {cut} cells lie in holes" if cut else "")
    upper_holes, lower_holes = (hole[rectangle] for hole in holes)
    walls = _fill_holes(walls[0][rectangle], walls[1][rectangle], upper_holes, lower_holes)
    shares = [float(min(walls[0].size * spacing**2 / np.prod(b - a), 1.0)) for a, b in corners]
    planes = [wall - detrended(wall) for wall in walls]
    slopes = [np.array([plane[1, 0], plane[0, 1]]) - plane[0, 0] for plane in planes]
    relative = float(np.degrees(np.hypot(*(slopes[0] - slopes[1])) / spacing))
    first = nodes[rectangle[0].start, rectangle[1].start]
    return Overlap(
        -walls[0], walls[1], upper_holes, lower_holes, shares, inclination, relative, cut,
        (low, high), first,
    )  # fmt: skip


def largest_rectangle(full: np.ndarray) -> tuple[slice, slice]:
    """Return slices (y, x) of the largest rectangle of true cells in a mask (y, x)."""
    best = 0
    place = (slice(0, 0), slice(0, 0))
    heights = np.zeros(full.shape[1], int)
    for row, line in enumerate(full):
        heights = np.where(line, heights + 1, 0)
        # columns of increasing height, with the first position that each covers
        open_columns: list[tuple[int, int]] = []
        for column, height in enumerate([*heights.tolist(), 0]):
            start = column
            while open_columns and open_columns[-1][1] >= height:
                start, tall = open_columns.pop()
                if tall * (column - start) > best:
                    best = tall * (column - start)
                    place = (slice(row + 1 - tall, row + 1), slice(start, column))
            open_columns.append((start, height))
    return place


def _check_size(shape: tuple[int, ...], spacing: float, more: str = "") -> None:
    if min(shape) < SMALLEST_SIDE:
        cells = grid_text((max(shape[0], 0), max(shape[1], 0)), spacing)
        must = f"at least {SMALLEST_SIDE} along each side (is the grid spacing too large?)"
        raise InputError(f"the walls overlap in {cells} (x, y): {must}{more}")


def _fitted_plane(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the mean plane of the points (n, 3) [m] between ``low`` and ``high`` (x, y) [m].

    It is (slope along x, slope along y, height [m] at the origin). Raise `InputError` for fewer
    than four points.
    """
    inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
    inside &= np.isfinite(points[:, 2])
    if inside.sum() < 4:
        raise InputError(f"the scans have {int(inside.sum())} points in common: too few for walls")
    plane = plane_through(*points[inside].T)
    return np.array([plane.slope_x, plane.slope_y, float(plane.at(np.zeros(()), np.zeros(())))])


def _hole_cells(wall: np.ndarray, reach: float) -> np.ndarray:
    """Return which cells (y, x) of a wall (y, x), NaN where unknown, are in holes of its scan.

    If the scan has scattered points, ``reach`` [cells] is above 0, and cells within this distance
    of a hole are taken to be in it, since their heights are interpolated across the hole.
    """
    known = np.isfinite(wall)
    holes = in_holes(known)
    if reach > 0.0:
        holes |= scipy.ndimage.binary_fill_holes(known) & ~known
        if holes.any():
            holes |= scipy.ndimage.distance_transform_edt(~holes) <= reach
    return holes


def _fill_holes(
    upper: np.ndarray, lower: np.ndarray, upper_holes: np.ndarray, lower_holes: np.ndarray
) -> list[np.ndarray]:
    """Return walls (y, x) [m], z upwards, whose holes are filled so that they do not touch.

    In a hole the distance of the walls becomes the largest distance beside the hole: the wall with
    the hole is placed at this distance from the other wall. Where both walls have a hole, the lower
    wall is interpolated linearly first.
    """
    either = upper_holes | lower_holes
    both = upper_holes & lower_holes
    if not either.any():
        return [upper, lower]
    upper = np.where(upper_holes, np.nan, upper)
    lower = np.where(lower_holes, np.nan, lower)
    gap = np.where(either, -np.inf, upper - lower)
    while np.isinf(gap).any():
        gap = np.where(np.isinf(gap), scipy.ndimage.maximum_filter(gap, 3), gap)
    if both.any():
        lower = np.where(both, fill_missing(lower, "linear", 1.0), lower)
    upper = np.where(upper_holes, lower + gap, upper)
    return [upper, np.where(lower_holes & ~upper_holes, upper - gap, lower)]

"""Overlap of two clouds of points in one frame, z upwards: walls where both are known."""

from typing import Any, NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.surface.measured import LARGEST_TILT, REACH, filled, heights_between
from jointclosure.surface.roughness import detrended, plane_through

SMALLEST_SIDE = 8
"""Smallest number of cells of the walls along each side."""


class Overlap(NamedTuple):
    """Walls (y, x) [m] where both are known, less the plane common to both, z upwards.

    ``shares`` are those of the area of the upper and of the lower scan. ``inclination`` is that of
    the common plane, and ``relative`` that of the walls to each other, in degrees. ``filled_cells``
    is the number of filled cells of both walls in holes.
    """

    upper: np.ndarray
    lower: np.ndarray
    shares: tuple[float, float]
    inclination: float
    relative: float
    filled_cells: int


def overlap_of(
    upper: np.ndarray,
    lower: np.ndarray,
    spacing: float,
    distances: tuple[float, float],
    largest_filled_share: float,
) -> Overlap:
    """Find the largest rectangle of a grid in which two clouds of points (n, 3) [m] are known.

    Parameters
    ----------
    upper, lower : array (n, 3)
    spacing : float
        Grid spacing [m].
    distances : (upper, lower)
        Mean distances of the points [m], see `jointclosure.surface.measured.REACH`.
    largest_filled_share : float
        Largest share of cells in holes inside both walls for which holes are filled linearly.

    Raises
    ------
    InputError
        If the clouds overlap by less than `SMALLEST_SIDE` cells, or are inclined too much.
    """
    corners = [(cloud[:, :2].min(axis=0), cloud[:, :2].max(axis=0)) for cloud in (upper, lower)]
    low = np.maximum(*(least for least, _ in corners))
    high = np.minimum(*(most for _, most in corners))
    nx, ny = (np.floor((high - low) / spacing + 1e-6).astype(int) + 1).tolist()
    _check_size((max(ny, 0), max(nx, 0)), spacing)
    nodes = np.stack(
        np.meshgrid(low[0] + spacing * np.arange(nx), low[1] + spacing * np.arange(ny)), axis=-1
    )
    plane = 0.5 * (_plane(upper, low, high) + _plane(lower, low, high))
    inclination = float(np.degrees(np.arctan(np.hypot(plane[0], plane[1]))))
    if inclination > LARGEST_TILT:
        raise InputError(
            f"the walls' common plane is inclined by {inclination:.1f} degrees: at most "
            f"{LARGEST_TILT:g}; turn the scans so that it is about horizontal"
        )
    walls = [
        heights_between(
            cloud[:, :2],
            cloud[:, 2] - cloud[:, 0] * plane[0] - cloud[:, 1] * plane[1] - plane[2],
            nodes,
            REACH * distance,
        )
        for cloud, distance in zip((upper, lower), distances, strict=True)
    ]
    walls, holes = _without_holes(walls, largest_filled_share)
    rectangle = largest_rectangle(np.isfinite(walls[0]) & np.isfinite(walls[1]))
    walls = [wall[rectangle] for wall in walls]
    _check_size(walls[0].shape, spacing)
    areas = [np.prod(most - least) for least, most in corners]
    slopes = [_slope(wall) for wall in walls]
    relative = float(np.degrees(np.hypot(*(slopes[0] - slopes[1])) / spacing))
    upper_share, lower_share = (min(walls[0].size * spacing**2 / area, 1.0) for area in areas)
    filled_cells = int(sum(hole[rectangle].sum() for hole in holes))
    shares = float(upper_share), float(lower_share)
    return Overlap(walls[0], walls[1], shares, inclination, relative, filled_cells)


def largest_rectangle(full: np.ndarray) -> tuple[slice, slice]:
    """Return slices (y, x) of the largest rectangle of true cells in a mask (y, x)."""
    best, place = 0, (slice(0, 0), slice(0, 0))
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


def _check_size(shape: tuple[int, int], spacing: float) -> None:
    if min(shape) < SMALLEST_SIDE:
        raise InputError(
            f"the walls overlap in {shape[0]} x {shape[1]} cells (y, x) of {1e3 * spacing:.4g} mm: "
            f"at least {SMALLEST_SIDE} along each side (is the grid spacing too large?)"
        )


def _plane(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Fit slopes along x and y, and height at the origin, of the points in a window."""
    inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
    if inside.sum() < 4:
        raise InputError(f"the scans have {int(inside.sum())} points in common: too few for walls")
    places, heights = points[inside, :2], points[inside, 2]
    plane = plane_through(places[:, 0], places[:, 1], heights)
    return np.array([plane.slope_x, plane.slope_y, float(plane.at(np.zeros(()), np.zeros(())))])


def _slope(wall: np.ndarray) -> np.ndarray:
    """Return the slopes of a wall's plane along y and x, in height per cell."""
    plane = wall - detrended(wall)
    return np.array([plane[1, 0] - plane[0, 0], plane[0, 1] - plane[0, 0]])


def _without_holes(walls: list[np.ndarray], largest_share: float) -> Any:
    """Return walls with holes filled if they are few enough, and masks of the filled cells."""
    filled_walls, holes = [], []
    for wall in walls:
        known = np.isfinite(wall)
        inside = scipy.ndimage.binary_fill_holes(known) & ~known
        if not 0 < inside.sum() <= largest_share * wall.size:
            filled_walls.append(wall)
            holes.append(np.zeros_like(inside))
            continue
        whole = filled(wall, "linear", 1.0)
        filled_walls.append(np.where(known | inside, whole, np.nan))
        holes.append(inside)
    return filled_walls, holes

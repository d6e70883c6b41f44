"""Cells of a scanned wall without a height: gaps, holes, and how they are filled."""

import numpy as np
import scipy

from jointclosure.inputs import InputError, check_one_of
from jointclosure.walls.point_interpolation import triangle_interpolation

MISSING = ("refuse", "avoid", "nearest", "linear")
"""What is done with cells without a height: an error, joints are cut elsewhere, or they are filled
by the nearest height or linearly."""

LARGEST_FILLED_SHARE = 0.05  # of a wall's cells, unless the user allows more


def between_known(known: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return which places (bool) lie between the first and the last known one along an axis."""
    after = np.logical_or.accumulate(known, axis)
    return after & np.flip(np.logical_or.accumulate(np.flip(known, axis), axis), axis)


def in_gaps(known: np.ndarray) -> np.ndarray:
    """Return which unknown cells (y, x) lie between known ones of their row or their column."""
    return (between_known(known, 0) | between_known(known, 1)) & ~known


def _closed_gaps(known: np.ndarray) -> np.ndarray:
    """Return which cells (y, x) are known, or in a gap of one or two between known ones of a line.

    Unknown cells at the rim of the grid are in no gap.
    """
    closed = scipy.ndimage.binary_closing
    return closed(known, np.ones((3, 1))) | closed(known, np.ones((1, 3)))


def in_holes(known: np.ndarray) -> np.ndarray:
    """Return which unknown cells (y, x) are in holes of a scan, not single values that were lost.

    They are the cells `in_gaps` of three cells or more in both directions, and unknown cells
    between known ones of their row and of their column that are in no gap of one or two cells.
    """
    inside = between_known(known, 0) & between_known(known, 1) & ~(known | _closed_gaps(known))
    return scipy.ndimage.binary_opening(in_gaps(known), np.ones((3, 3))) | inside


def fill_dropouts(wall: np.ndarray, hole: np.ndarray) -> np.ndarray:
    """Return a wall (y, x) whose gaps of one or two cells, except in holes, are filled linearly."""
    known = np.isfinite(wall)
    dropouts = _closed_gaps(known) & ~(known | hole)
    return np.where(dropouts, fill_missing(wall, "linear", 1.0), wall) if dropouts.any() else wall


def fill_missing(wall: np.ndarray, missing: str, most: float = LARGEST_FILLED_SHARE) -> np.ndarray:
    """Return a wall (y, x) whose missing cells (NaN) are filled, or kept to be avoided.

    ``missing`` is one of `MISSING`. Raise `InputError` if a cell is missing that may not be, or if
    more than the share ``most`` of all cells would be filled.
    """
    holes = ~np.isfinite(wall)
    check_one_of("missing", missing, MISSING)
    if not holes.any() or missing == "avoid":
        return wall
    message = f"{int(holes.sum())} of {holes.size} cells have no height"
    if missing == "refuse":
        first = ", ".join(map(str, np.argwhere(holes)[0]))
        raise InputError(
            f"{message}, the first at (y, x) = ({first}); choose missing: avoid (joints are cut "
            "where no cell is missing), nearest or linear (missing cells are filled)"
        )
    if holes.mean() > most:
        raise InputError(
            f"{message}: a share of {holes.mean():.3f}, at most {most:g} may be filled "
            "(largest_filled_share); choose missing: avoid, or crop the scan"
        )
    result = fill_with_nearest(wall)
    if missing == "linear":
        rim = scipy.ndimage.binary_dilation(holes, iterations=2) & ~holes
        inside = triangle_interpolation(np.argwhere(rim), wall[rim], np.argwhere(holes))
        result[holes] = np.where(np.isfinite(inside), inside, result[holes])
    return result


def fill_with_nearest(heights: np.ndarray) -> np.ndarray:
    """Return heights (y, x) with missing ones (NaN) replaced by the nearest known height."""
    holes = ~np.isfinite(heights)
    if not holes.any():
        return heights
    where = scipy.ndimage.distance_transform_edt(holes, return_distances=False, return_indices=True)
    return heights[tuple(where)]

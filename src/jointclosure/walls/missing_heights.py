"""Cells of a scanned wall without a height: gaps and holes, and filling of these."""

import numpy as np
import scipy

from jointclosure.inputs import InputError, check_one_of
from jointclosure.walls.point_interpolation import triangle_interpolation

MISSING = ("refuse", "avoid", "nearest", "linear")
"""What is done with cells without a height: an error is raised, joints are cut elsewhere, or the
cells are filled with the nearest height or linearly."""

LARGEST_FILLED_SHARE = 0.05  # largest share of a wall's cells that is filled unless stated


def between_known(known: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return which cells lie between the first and the last known cell along an axis, inclusive.

    ``known`` and the result are masks of any shape.
    """
    after = np.logical_or.accumulate(known, axis)
    return after & np.flip(np.logical_or.accumulate(np.flip(known, axis), axis), axis)


def in_gaps(known: np.ndarray) -> np.ndarray:
    """Return which unknown cells (y, x) lie between known cells of their row or of their column."""
    return (between_known(known, 0) | between_known(known, 1)) & ~known


def _closed_gaps(known: np.ndarray) -> np.ndarray:
    """Return which cells (y, x) are known, or lie in a gap of one or two cells of a row or column.

    A gap has known cells on both of its sides; unknown cells at the rim of the grid are in no gap.
    """
    closed = scipy.ndimage.binary_closing
    return closed(known, np.ones((3, 1))) | closed(known, np.ones((1, 3)))


def in_holes(known: np.ndarray) -> np.ndarray:
    """Return which unknown cells (y, x) are in holes of a scan, in contrast to single lost values.

    These are the cells of 3 x 3 cells that all lie `in_gaps`. They are also the unknown cells that
    lie between known cells of their row and between known cells of their column, and in no gap of
    one or two cells.
    """
    inside = between_known(known, 0) & between_known(known, 1) & ~(known | _closed_gaps(known))
    return scipy.ndimage.binary_opening(in_gaps(known), np.ones((3, 3))) | inside


def fill_dropouts(wall: np.ndarray, hole: np.ndarray) -> np.ndarray:
    """Return a wall (y, x) whose gaps of one or two cells, except in holes, are filled linearly.

    ``hole`` (y, x) tells which cells are in holes (`in_holes`).
    """
    known = np.isfinite(wall)
    dropouts = _closed_gaps(known) & ~(known | hole)
    return np.where(dropouts, fill_missing(wall, "linear", 1.0), wall) if dropouts.any() else wall


def fill_missing(wall: np.ndarray, missing: str, most: float = LARGEST_FILLED_SHARE) -> np.ndarray:
    """Return a wall (y, x) whose missing heights (NaN) are filled, or are kept to be avoided.

    ``missing`` is one of `MISSING`: "avoid" keeps them, "refuse" raises `InputError` if there are
    any. It is raised too if more than the share ``most`` of all cells would be filled. Linearly
    filled cells outside of all known cells get the nearest height.
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
    """Return heights (y, x) whose missing ones (NaN) are replaced by the nearest known height."""
    holes = ~np.isfinite(heights)
    if not holes.any():
        return heights
    where = scipy.ndimage.distance_transform_edt(holes, return_distances=False, return_indices=True)
    return heights[tuple(where)]

"""Matrices of heights framed by their places: x in the first row, y in the first column."""

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls.scans.lattice import LARGEST_OFFSET

_LEAST_PLACES = 5
"""Smallest number of evenly spaced numbers that are places and not heights."""


def are_places(values: np.ndarray) -> bool:
    """Return whether numbers (n,) are places along an axis: evenly spaced, rising or falling.

    They may be rounded by `LARGEST_OFFSET` of their distance.
    """
    if len(values) < _LEAST_PLACES or not np.isfinite(values).all():
        return False
    step = (values[-1] - values[0]) / (len(values) - 1)
    offsets = values - values[0] - step * np.arange(len(values))
    return bool(step != 0.0 and np.abs(offsets).max() <= LARGEST_OFFSET * abs(step))


def points_on(x: np.ndarray, y: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Return points (n, 3) of heights (y, x) at places x and y along the axes."""
    columns = (*np.meshgrid(x, y), heights)
    return np.stack([column.ravel() for column in columns], axis=1)


def framed_points(matrix: np.ndarray) -> np.ndarray | None:
    """Return the points (n, 3) of a matrix with x in its first row and y in its first column.

    The corner may be any number. None if the matrix contains only heights, which may be those of a
    plane: its second row and second column are then evenly spaced too.

    Raises
    ------
    InputError
        If only the first row, or only the first column, looks like places.
    """
    x, y, heights = matrix[0, 1:], matrix[1:, 0], matrix[1:, 1:]
    if not heights.size or (are_places(heights[0]) and are_places(heights[:, 0])):
        return None
    row, column = are_places(x), are_places(y)
    if row and column:
        return points_on(x, y, heights)
    for looks, line, second in ((row, "row", heights[0]), (column, "column", heights[:, 0])):
        if looks and not are_places(second):
            raise InputError(
                f"its first {line} is evenly spaced, as places are: a matrix must have x in its "
                "first row and y in its first column, or contain only heights"
            )
    return None

"""Differences of a wall's heights (y, x): over distances, of slopes, of neighbours; peaks.

NaN remain NaN.
"""

import numpy as np


def difference(heights: np.ndarray, axis: str, lag: int) -> np.ndarray:
    """Return the height of the cell ``lag`` cells further along an axis less that of the cell."""
    if axis == "x":
        return heights[:, lag:] - heights[:, :-lag]
    return heights[lag:] - heights[:-lag]


def second_difference(heights: np.ndarray, axis: str, lag: int) -> np.ndarray:
    """Return second differences z(x + 2 d) - 2 z(x + d) + z(x)."""
    return difference(difference(heights, axis, lag), axis, lag)


def slope_correlation(heights: np.ndarray, lags: np.ndarray, axis: str) -> np.ndarray:
    """Return the correlation of slopes along an axis with those ``lags`` cells further."""
    steps = difference(heights, axis, 1)
    if axis == "y":
        steps = steps.T
    size = np.nanmean(steps**2)
    return np.array(
        [np.nanmean(steps[:, : steps.shape[1] - lag] * steps[:, lag:]) / size for lag in lags]
    )


def peak_cells(heights: np.ndarray) -> np.ndarray:
    """Return whether a cell (y, x) is higher than its eight neighbours; never true at the edge.

    This is for a scan, where heights beyond the edge and in gaps (NaN) are unknown. The joints of
    the model end at their edge, see `jointclosure.solvers.cells.is_peak`.
    """
    here = heights[1:-1, 1:-1]
    higher = np.ones(here.shape, bool)
    ny, nx = heights.shape
    for down in (0, 1, 2):
        for right in (0, 1, 2):
            if (down, right) != (1, 1):
                higher &= here > heights[down : ny - 2 + down, right : nx - 2 + right]
    return np.pad(higher, 1)


def mean_curvature(heights: np.ndarray, spacing: float) -> np.ndarray:
    """Return -(z_xx + z_yy) / 2 [1/m] by second differences: positive on peaks, NaN at edges."""
    curvature = np.full(heights.shape, np.nan)
    curvature[1:-1, 1:-1] = -0.5 * sum(
        (before - 2.0 * heights[1:-1, 1:-1] + after) / spacing**2
        for before, after in (
            (heights[1:-1, :-2], heights[1:-1, 2:]),
            (heights[:-2, 1:-1], heights[2:, 1:-1]),
        )
    )
    return curvature

"""Checks of the two walls that a caller gives as arrays (y, x)."""

import warnings

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.inputs import LENGTHS, InputError, real_array, size_of
from jointclosure.walls.plausibility import doubts

_SAME_PLACE = 1e-6
"""Largest difference of the coordinates of both walls, over the spacing."""
_SAME_STEP = 1e-3
"""Largest difference of the steps of both walls, over the spacing."""


def checked_walls(upper, lower, spacing: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the heights (y, x) [m] of two walls of one shape, as new arrays.

    ``upper`` and ``lower`` are arrays, or `xarray.DataArray` or `pandas.DataFrame`, whose
    dimensions are used by name. Raise `InputError` if heights or shapes are not allowed, or if
    coordinates differ between the walls or are not in steps of the ``spacing`` [m].
    """
    walls = []
    for name, wall in zip(("upper", "lower"), _aligned(upper, lower), strict=True):
        if spacing is not None and isinstance(wall, xr.DataArray):
            _check_coordinate_steps(name, wall, spacing)
        heights = real_array(name, wall)
        if heights.ndim != 2 or min(heights.shape) < 1 or max(heights.shape) < 3:
            raise InputError(
                f"{name}: shape {heights.shape}, must be (y, x) with at least 3 cells one way"
            )
        largest = float(np.abs(heights).max())
        if largest > LENGTHS[1]:
            raise InputError(f"{name}: a height of {largest!r} m, must be at most {LENGTHS[1]:g} m")
        walls.append(heights)
    one, other = walls
    if one.shape != other.shape:
        raise InputError(f"upper and lower: shapes {one.shape} and {other.shape} must be equal")
    return one, other


def _aligned(upper, lower) -> tuple:
    """Return both walls with dimensions in the same order, (y, x) if these are their names.

    Raise `InputError` if their named dimensions or coordinates differ.
    """
    upper = _by_names("upper", upper)
    lower = _by_names("lower", lower)
    if not (isinstance(upper, xr.DataArray) and isinstance(lower, xr.DataArray)):
        return upper, lower
    if set(upper.dims) != set(lower.dims):
        raise InputError(f"upper and lower: dimensions {upper.dims} and {lower.dims} must be equal")
    lower = lower.transpose(*upper.dims)
    for axis in upper.dims:
        if axis in upper.coords and axis in lower.coords:
            _check_coordinates(str(axis), upper[axis].values, lower[axis].values)
    return upper, lower


def warn_of_doubts(
    upper: np.ndarray, lower: np.ndarray, spacing: float, stacklevel: int = 3
) -> None:
    """Warn (`UserWarning`) of probable errors of units or orientation of two walls (y, x) [m].

    The warning is at the line that called the caller, or at another ``stacklevel`` of Python.
    """
    for doubt in doubts(upper, lower, spacing):
        warnings.warn(doubt, stacklevel=stacklevel)


def _by_names(name: str, wall):
    """Return a wall with dimensions (y, x) in this order, if these are the names of its dimensions.

    A `pandas.DataFrame` becomes a `xarray.DataArray`. Raise `InputError` for a `xarray.Dataset`.
    """
    if isinstance(wall, xr.Dataset):
        raise InputError(
            f"{name}: is an xarray.Dataset of {', '.join(map(str, wall.data_vars))}; must be an "
            "array, for example one of these variables"
        )
    if isinstance(wall, pd.DataFrame):
        wall = xr.DataArray(wall)
        if set(wall.dims) != {"y", "x"}:
            wall = wall.rename(dict(zip(wall.dims, ("y", "x"), strict=True)))
    if isinstance(wall, xr.DataArray) and set(wall.dims) == {"y", "x"}:
        return wall.transpose("y", "x")
    return wall


def _check_coordinate_steps(name: str, wall: xr.DataArray, spacing: float) -> None:
    """Raise `InputError` if a wall's coordinates are not a grid of the given spacing [m].

    Coordinates that are not numbers, or that count cells in steps of 1, are not checked.
    """
    for axis in wall.dims:
        if axis not in wall.coords or wall[axis].size < 2 or wall[axis].dtype.kind not in "fiu":
            continue
        steps = np.diff(wall[axis].values.astype(float))
        if wall[axis].dtype.kind in "iu" and (steps == 1.0).all():
            continue
        try:
            steps = np.abs(steps) * size_of(str(wall[axis].attrs.get("units", "m")))
        except InputError as error:
            raise InputError(f"{name}: coordinate {axis}: {error}") from None
        if not (np.abs(steps - spacing) <= _SAME_STEP * spacing).all():
            ends = dict.fromkeys(f"{step:.6g}" for step in (steps.min(), steps.max()))
            raise InputError(
                f"{name}: its coordinate {axis} has steps of {' to '.join(ends)} m, and spacing = "
                f"{spacing:.6g} m; must be equal, or leave the coordinates out"
            )


def _check_coordinates(name: str, above: np.ndarray, below: np.ndarray) -> None:
    """Raise `InputError` unless the coordinates of both walls along one dimension are equal.

    Numbers may differ by `_SAME_PLACE` of the spacing. Different lengths are not an error here.
    """
    if above.shape != below.shape:
        return  # the shapes are compared later
    if above.dtype.kind not in "fiu" or below.dtype.kind not in "fiu":
        if np.array_equal(above, below):
            return
        raise InputError(f"upper and lower: their labels {name} differ; must be equal")
    above, below = (real_array(f"coordinate {name}", values) for values in (above, below))
    spacing = float(np.abs(np.diff(above)).min()) if above.size > 1 else 0.0
    apart = float(np.abs(above - below).max())
    if apart > _SAME_PLACE * spacing:
        raise InputError(
            f"upper and lower: their coordinates {name} differ by up to {apart:.6g}; must be equal"
        )

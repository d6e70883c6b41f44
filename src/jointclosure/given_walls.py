"""The two walls that a caller gives, as arrays (y, x) that belong together."""

import numpy as np
import xarray as xr

from jointclosure.inputs import LENGTHS, InputError, real_array

_SAME_PLACE = 1e-6
"""By what two walls' coordinates may differ, over their spacing."""


def checked_walls(upper, lower) -> tuple[np.ndarray, np.ndarray]:
    """Heights (y, x) [m] of two walls of one shape, as new arrays.

    Parameters
    ----------
    upper, lower : array_like or xarray.DataArray
        Heights [m]. An `xarray.DataArray` is taken by the names of its dimensions: those
        named y and x are brought into this order, others into that of the upper wall.

    Raises
    ------
    InputError
        Heights that are not real, not finite, too few or too large; shapes, names of
        dimensions or coordinates in which the walls differ.
    """
    walls = []
    for name, wall in zip(("upper", "lower"), _aligned(upper, lower), strict=True):
        heights = real_array(name, wall)
        if heights.ndim != 2 or min(heights.shape) < 1 or max(heights.shape) < 3:
            raise InputError(
                f"{name}: shape {heights.shape}, must be (y, x) with at least 3 cells one way"
            )
        largest = float(np.abs(heights).max())
        if largest > LENGTHS[1]:
            raise InputError(f"{name}: a height of {largest!r} m, must be at most {LENGTHS[1]:g} m")
        walls.append(heights)
    if walls[0].shape != walls[1].shape:
        raise InputError(
            f"upper and lower: shapes {walls[0].shape} and {walls[1].shape} must be equal"
        )
    return walls[0], walls[1]


def _aligned(upper, lower) -> tuple:
    """Both walls with their dimensions in one order, where they have names."""
    for name, wall in (("upper", upper), ("lower", lower)):
        if isinstance(wall, xr.Dataset):
            raise InputError(
                f"{name}: is an xarray.Dataset of {', '.join(map(str, wall.data_vars))}; must be "
                "an array, such as one of these"
            )
    upper, lower = (
        wall.transpose("y", "x")
        if isinstance(wall, xr.DataArray) and set(wall.dims) == {"y", "x"}
        else wall
        for wall in (upper, lower)
    )
    if not (isinstance(upper, xr.DataArray) and isinstance(lower, xr.DataArray)):
        return upper, lower
    if set(upper.dims) != set(lower.dims):
        raise InputError(f"upper and lower: dimensions {upper.dims} and {lower.dims} must be equal")
    lower = lower.transpose(*upper.dims)
    for axis in upper.dims:
        if axis in upper.coords and axis in lower.coords:
            _check_coordinates(str(axis), upper[axis].values, lower[axis].values)
    return upper, lower


def _check_coordinates(name: str, above: np.ndarray, below: np.ndarray) -> None:
    """Raise `InputError` unless the coordinates of both walls are the same places."""
    if above.shape != below.shape:
        return  # the shapes are compared later
    above, below = (real_array(f"coordinate {name}", each) for each in (above, below))
    spacing = float(np.abs(np.diff(above)).min()) if above.size > 1 else 0.0
    apart = float(np.abs(above - below).max())
    if apart > _SAME_PLACE * spacing:
        raise InputError(
            f"upper and lower: their coordinates {name} differ by up to {apart:.6g}; must be equal"
        )


_STEEPEST, _FLATTEST = 2.0, 1e-3
"""Rms slopes of rough walls beyond which their heights rather have another unit than the spacing:
natural ones have 0.1 to 0.6."""
_ALIKE = 0.5
"""Correlation of slopes from which two walls count as alike."""
_SUMMITS = 10
"""From as many on a wall counts as rough: a lens or a lattice may be like its partner."""


def doubts(upper: np.ndarray, lower: np.ndarray, spacing: float) -> list[str]:
    """What looks like a slip of units or of orientation, in sentences.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights towards the other wall [m].
    spacing : float
        [m].
    """
    if min(upper.shape) < 3 or min(map(_summits, (upper, lower))) < _SUMMITS:
        return []
    said = []
    for name, wall in (("upper", upper), ("lower", lower)):
        slope = float(np.sqrt(np.mean([np.mean(part**2) for part in _slopes(wall)]))) / spacing
        if not _FLATTEST <= slope <= _STEEPEST:
            said.append(
                f"{name}: its rms slope is {slope:.3g}, and natural walls have 0.1 to 0.6; heights "
                "and spacing are both in m"
            )
    fits = {
        "": _likeness(upper, lower),
        "y": _likeness(upper[::-1], lower),
        "x": _likeness(upper[:, ::-1], lower),
    }
    if fits[""] > _ALIKE:
        said.append(
            f"the walls are alike (correlation {fits['']:.2f}), where those of a joint are each "
            "other's negative: heights count towards the other wall, so that of a scanned upper "
            "wall in the frame of the lower one they are -z"
        )
    for axis in ("y", "x"):
        if fits[axis] < -_ALIKE and fits[""] > -0.5 * _ALIKE:
            said.append(
                f"the walls mate where the upper one is turned round along {axis} (correlation "
                f"{-fits[axis]:.2f}), and not as they are ({-fits['']:.2f}): is it the other "
                f"way round?"
            )
    return said


def _slopes(wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Differences of neighbours along y and x, on the cells that have both."""
    return np.diff(wall, axis=0)[:, 1:], np.diff(wall, axis=1)[1:]


def _likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of the slopes of two walls, 0 where one has none."""
    a, b = (np.concatenate([part.ravel() for part in _slopes(wall)]) for wall in (one, other))
    scale = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else 0.0


def _summits(wall: np.ndarray) -> int:
    """Inner cells that are higher than their four neighbours."""
    inner = wall[1:-1, 1:-1]
    beside = (wall[:-2, 1:-1], wall[2:, 1:-1], wall[1:-1, :-2], wall[1:-1, 2:])
    return int(np.logical_and.reduce([inner > each for each in beside]).sum())

"""Checks that points (x, y, z) are one sheet seen along z, with coordinates that are exact enough.

Neighbours in the plan show it, whatever the units of heights: on one sheet their heights are alike.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.number_texts import percent
from jointclosure.walls.rounding import step_of

_SAMPLE = 2000  # most points whose neighbours are compared
_NEIGHBOURS = 12  # of a point, so many that both sheets have some
_LEAST_POINTS = 100  # fewer points are judged by later checks
_SMOOTH = 0.5  # scatter of neighbours over that of all points below which they lie on one sheet
_ROUGH = 0.3  # the same above which heights along z may be those of a sheet along another axis
_APART = 0.55  # the same above which neighbours may lie on two sheets
_TWO_LEVELS = 1.75  # median kurtosis of neighbours below which they lie on two sheets
_FLAT = 1e-9  # deviation from a plane over the heights that is rounding
_THIN = 0.05  # largest thickness of a rough or flat sheet over its shorter side
_LEAST_GAP = 0.06  # of two sheets, over the standard deviation of all heights
_SPLIT = 0.5  # share of neighbourhoods in which a gap is more than half of their height: two sheets
_STEEP_SHARE = 0.05  # of points with another far above or below them: faces of a solid
_NEAR = 0.3  # largest distance of such points in the plan, over the mean one of all points
_AT_ONE_PLACE = 0.02  # the same of a rough sheet, on which near points have different heights
_FAR = 0.2  # height of such points above each other over that of all
_INEXACT = 0.05  # largest step of coordinates in single precision, over the distance of points
_PATCH = 0.1  # share of points of a second patch that is a wall
_TURNED = {0: ("x", "2,3,1"), 1: ("y", "3,1,2")}
"""Axes along which heights may lie, and columns that turn them to z without mirroring the wall."""
TWO_WALLS = "a solid or both walls in one file must be cut to one wall"
"""Advice where a file has more than one wall."""


class _Neighbours(NamedTuple):
    """Heights of neighbours, which show whether points are one sheet."""

    heights: (
        np.ndarray
    )  # of the neighbours of n points (n, k), less the plane of each neighbourhood
    apart: np.ndarray  # distances of these neighbours in the plan (n, k)
    all_heights: np.ndarray  # of all points (m,), less their plane
    raw: np.ndarray  # of all points (m,), as given

    @property
    def scatter(self) -> float:
        """Median standard deviation of neighbours over the one of all points."""
        total = float(np.std(self.all_heights))
        if total <= _FLAT * float(np.abs(self.raw).max()):
            return 0.0
        return float(np.median(np.std(self.heights, axis=1))) / total


def _neighbours(points: np.ndarray, axis: int) -> _Neighbours:
    """Find the neighbours of a sample of points in the plan across an axis."""
    plan = np.delete(points, axis, axis=1)
    heights = points[:, axis]
    plan = plan - plan.mean(axis=0)
    columns = np.column_stack([plan, np.ones(len(plan))])
    level = heights - columns @ np.linalg.lstsq(columns, heights, rcond=None)[0]
    some = np.arange(0, len(points), -(-len(points) // _SAMPLE))
    apart, near = scipy.spatial.cKDTree(plan).query(plan[some], k=_NEIGHBOURS + 1)
    # less the plane of each neighbourhood
    around = plan[near] - plan[near].mean(axis=1, keepdims=True)
    rest = level[near] - level[near].mean(axis=1, keepdims=True)
    slopes = np.linalg.pinv(np.swapaxes(around, 1, 2) @ around) @ (
        np.swapaxes(around, 1, 2) @ rest[..., None]
    )
    return _Neighbours(rest - (around @ slopes)[..., 0], apart, level, heights)


def check_sheet(points: np.ndarray) -> None:
    """Raise `InputError` unless known points (n, 3) are one wall, whose heights lie along z."""
    if len(points) < _LEAST_POINTS:
        return
    check_precision_of_places(points)
    seen = _neighbours(points, 2)
    _check_upright(points, seen.scatter)
    ordered = np.sort(seen.heights, axis=1)
    steps = np.diff(ordered, axis=1)
    height = np.ptp(ordered, axis=1)
    split = steps[:, 2:-2].max(axis=1) > 0.5 * height
    split &= height > _LEAST_GAP * float(np.std(seen.all_heights))
    if split.mean() > _SPLIT or _has_two_levels(seen):
        gap = 2.0 * float(np.median(np.std(seen.heights, axis=1)))
        raise InputError(
            f"the points lie on two sheets above each other, about {gap:.2g} apart: {TWO_WALLS}, "
            "and passes of a scanner must fit each other"
        )
    tall = np.ptp(seen.all_heights)
    area = float(np.prod(np.ptp(points[:, :2], axis=0)))
    near = _NEAR if seen.scatter < _ROUGH else _AT_ONE_PLACE
    beside = seen.apart[:, 1:] < near * np.sqrt(area / len(points))
    if seen.scatter >= _ROUGH:
        beside &= seen.apart[:, 1:] > 1e-6 * np.sqrt(
            area / len(points)
        )  # places with several heights are named later
    over = beside & (np.abs(seen.heights[:, 1:] - seen.heights[:, :1]) > _FAR * tall)
    if (share := float(over.any(axis=1).mean())) > _STEEP_SHARE:
        raise InputError(
            f"{percent(share)} of the points have another one far above or below them, as on "
            f"the faces of a block: {TWO_WALLS}"
        )


def _has_two_levels(seen: _Neighbours) -> bool:
    """Return whether neighbours are far apart and on two levels, which are not those of rounding.

    The kurtosis of 13 heights is 2.3 on rough walls, 2.0 for uniform noise, 1.3 to 1.65 on the two
    walls of a joint at first touch.
    """
    squares = np.mean(seen.heights**2, axis=1)
    known = squares > 0.0
    kurtosis = np.mean(seen.heights[known] ** 4, axis=1) / squares[known] ** 2
    levels = np.unique(seen.raw)
    rounded = float(np.median(np.diff(levels))) if len(levels) > 1 else 0.0
    far = (
        seen.scatter > _APART and known.any() and float(np.median(np.sqrt(squares))) > 2.0 * rounded
    )
    return bool(far and float(np.median(kurtosis)) < _TWO_LEVELS)


def _check_upright(points: np.ndarray, scatter: float) -> None:
    """Raise `InputError` if points (n, 3) are a sheet with heights along another axis than z.

    ``scatter`` is that of heights along z among neighbours (`_neighbours`).
    """
    thickness, directions = np.linalg.eigh(np.cov(points.T))
    thin = thickness[0] < _THIN**2 * thickness[1] and scatter > _ROUGH
    normal = int(np.abs(directions[:, 0]).argmax())
    along = {axis: _neighbours(points, axis).scatter for axis in _TURNED}
    axis = normal if thin and normal in along else min(along, key=lambda axis: along[axis])
    if (thin and axis == normal) or along[axis] < min(_SMOOTH, 0.5 * scatter):
        raise InputError(vertical(*_TURNED[axis]))


def check_one_patch(members: np.ndarray) -> None:
    """Raise `InputError` if the second of the patches of points, by their counts, is a wall."""
    sizes = np.sort(members)[::-1]
    if len(sizes) > 1 and sizes[1] > _PATCH * sizes.sum():
        raise InputError(
            f"the points lie in separate patches, of {sizes[0]} and {sizes[1]} points: both walls "
            "beside each other in one file must be cut to one wall"
        )


def vertical(axis: str, columns: str) -> str:
    """Return the message on a wall that is not seen along z."""
    return (
        f"the heights of the wall lie along {axis}, not along z, as in a vertical scan: heights "
        f"must be the third coordinate; for points of a text file or a mesh, variable = "
        f"{columns!r} (--variable {columns} on the command line) turns the wall, if heights count "
        f"towards larger {axis}; otherwise turn the scan"
    )


def in_single_precision(values: np.ndarray) -> float:
    """Return the step of single precision at the largest of values that are stored in it; else 0.

    Values that were rounded more coarsely, as to 0.5, may fit single precision by chance, and count
    as not stored in it.
    """
    known = values[np.isfinite(values)]
    if not known.size or float(np.abs(known).max()) > np.finfo(np.float32).max:
        return 0.0
    if (known != known.astype(np.float32)).any():
        return 0.0
    step = float(np.spacing(np.abs(known).max().astype(np.float32)))
    return 0.0 if step_of(known) > 1.5 * step else step


def check_precision_of_places(points: np.ndarray) -> None:
    """Raise `InputError` if single precision is too coarse for the places of points (n, 3)."""
    distance = float(np.sqrt(np.prod(np.sort(np.ptp(points, axis=0))[1:]) / len(points)))
    for name, values in zip("xyz", points.T, strict=True):
        step = in_single_precision(values)
        if name != "z" and step > _INEXACT * distance:
            raise InputError(
                _inexact_message(name, values, step, f"points are {distance:.3g} apart")
            )


def check_precision_of_heights(differences: np.ndarray, heights: np.ndarray) -> None:
    """Raise `InputError` if single precision is coarser than the differences of neighbours."""
    known = differences[np.isfinite(differences)]
    step = in_single_precision(heights)
    usual = float(np.sqrt(np.mean(known**2))) if known.size else 0.0
    if step > usual > 0.0:
        among = f"neighbours differ by {usual:.3g} (rms)"
        raise InputError(_inexact_message("z", heights, step, among))


def _inexact_message(name: str, values: np.ndarray, step: float, among: str) -> str:
    largest = float(np.nanmax(np.abs(values)))
    return (
        f"{name} is stored in single precision, in which values up to {largest:.6g} have steps of "
        f"{step:.3g}, and {among}: the scan is too far from its origin; move it to near the origin "
        "in the program that wrote it, or save it in double precision"
    )

"""Checks that points (x, y, z) are one sheet seen along z, with coordinates that are exact enough.

Neighbours in the plan show it, whatever the units of heights: on one sheet their heights are alike.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.number_texts import percent
from jointclosure.walls.rounding import step_of

_SAMPLE = 2000  # largest number of points whose neighbourhoods are compared
_NEIGHBOURS = 12  # neighbours of a point in the plan, so many that both of two sheets have some
_LEAST_POINTS = 100  # fewer points are not judged here, but by later checks

# Relative scatter: the scatter of heights within a neighbourhood over that of all heights, see
# `_Neighbours.scatter`. It is small on one sheet.
_SMOOTH = 0.5  # largest relative scatter of heights along x or y for a sheet along that axis
_ROUGH = 0.3  # relative scatter above which heights along z may be no heights of a sheet
_APART = 0.55  # relative scatter above which a neighbourhood may contain two sheets

_STEEPEST = 5.0
"""Largest slope [1] of a neighbourhood along x or y on a sheet along that axis; chosen. On a grid
that is turned by a small angle, rows seen along x or y are lines with a slope of one over it."""

_TWO_LEVELS = 1.75  # median kurtosis of neighbourhoods below which they contain two sheets
_FLAT = 1e-9  # deviation of all heights from their plane, over the heights, that is rounding
_THIN = 0.05  # largest thickness of points, over their shorter side, for one rough or flat sheet
_LEAST_GAP = 0.06  # least height of a neighbourhood with a gap, over the deviation of all heights
_SPLIT = 0.5
"""Share of neighbourhoods above which points lie on two sheets, if one gap between consecutive
heights is more than half of the height of these neighbourhoods."""
_STEEP_SHARE = 0.05  # share of points beside another height above which they are a solid's faces
_NEAR = 0.3  # largest distance in the plan of points beside each other, over the mean distance
_AT_ONE_PLACE = 0.02  # the same limit for rough sheets, on which near points differ in height
_FAR = 0.2  # least difference in height of points beside each other on a face, over that of all
_INEXACT = 0.05  # largest step of single precision in x and y, over the distance of points
_PATCH = 0.1  # share of points above which a second patch of points is a second wall
_TURNED = {0: ("x", "2,3,1"), 1: ("y", "3,1,2")}
"""Axes along which heights may lie, and columns that turn them to z without mirroring the wall."""
TWO_WALLS = "a solid or both walls in one file must be cut to one wall"
"""Advice where a file has more than one wall."""


class _Neighbours(NamedTuple):
    """Heights in the neighbourhoods of some points, which show whether all points are one sheet.

    A neighbourhood is a point and its `_NEIGHBOURS` nearest ones in the plan; the point is first.
    """

    heights: np.ndarray  # of n neighbourhoods (n, k), less the plane of each
    apart: np.ndarray  # distances in the plan (n, k) from the first point of each neighbourhood
    all_heights: np.ndarray  # of all points (m,), less their plane
    raw: np.ndarray  # of all points (m,), as given

    @property
    def scatter(self) -> float:
        """Median standard deviation within neighbourhoods over that of all heights; 0 if flat."""
        total = float(np.std(self.all_heights))
        if total <= _FLAT * float(np.abs(self.raw).max()):
            return 0.0
        return float(np.median(np.std(self.heights, axis=1))) / total


def _neighbours(points: np.ndarray, axis: int, steepest: float = np.inf) -> _Neighbours:
    """Return neighbourhoods of points (n, 3) with heights along an axis (0: x, 1: y, 2: z).

    They are those of at most `_SAMPLE` points, by distances across the axis. Planes with a slope
    above ``steepest`` [1] are not taken from the heights of their neighbourhoods.
    """
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
    used = np.linalg.norm(slopes, axis=1, keepdims=True) <= steepest
    return _Neighbours(rest - (around @ (slopes * used))[..., 0], apart, level, heights)


def check_sheet(points: np.ndarray) -> None:
    """Raise `InputError` unless finite points (n, 3) are one wall, whose heights lie along z.

    It is raised too if x and y are stored too coarsely. Fewer than `_LEAST_POINTS` are accepted.
    """
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
    """Return whether heights within neighbourhoods scatter widely and have two levels.

    Levels that are only steps of rounding do not count. The kurtosis of 13 heights shows levels: it
    is 2.3 on rough walls, 2.0 for uniform noise, and 1.3 to 1.65 on the two walls of a joint at
    first touch.
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
    """Raise `InputError` if points (n, 3) are a sheet whose heights lie along x or y, not z.

    ``scatter`` is the relative scatter of heights along z (`_Neighbours.scatter`).
    """
    thickness, directions = np.linalg.eigh(np.cov(points.T))
    thin = thickness[0] < _THIN**2 * thickness[1] and scatter > _ROUGH
    normal = int(np.abs(directions[:, 0]).argmax())
    along = {axis: _neighbours(points, axis, _STEEPEST).scatter for axis in _TURNED}
    axis = normal if thin and normal in along else min(along, key=lambda axis: along[axis])
    if (thin and axis == normal) or along[axis] < min(_SMOOTH, 0.5 * scatter):
        raise InputError(vertical(*_TURNED[axis]))


def check_one_patch(members: np.ndarray) -> None:
    """Raise `InputError` if the second largest patch of points is so large that it is a wall too.

    ``members`` (patches,) are the numbers of points of separate patches.
    """
    sizes = np.sort(members)[::-1]
    if len(sizes) > 1 and sizes[1] > _PATCH * sizes.sum():
        raise InputError(
            f"the points lie in separate patches, of {sizes[0]} and {sizes[1]} points: both walls "
            "beside each other in one file must be cut to one wall"
        )


def vertical(axis: str, columns: str) -> str:
    """Return the message on a wall whose heights lie along an ``axis`` (x or y), not z.

    ``columns`` is the order of coordinates that turns its heights to z, such as "2,3,1".
    """
    return (
        f"the heights of the wall lie along {axis}, not along z, as in a vertical scan: heights "
        f"must be the third coordinate; for points of a text file or a mesh, variable = "
        f"{columns!r} (--variable {columns} on the command line) turns the wall, if heights count "
        f"towards larger {axis}; otherwise turn the scan"
    )


def in_single_precision(values: np.ndarray) -> float:
    """Return the step of single precision at the largest of values, if they are stored in it.

    Otherwise return 0. NaN are ignored. Values that were rounded more coarsely, as to 0.5, may be
    exact in single precision by chance, and count as not stored in it.
    """
    known = values[np.isfinite(values)]
    if not known.size or float(np.abs(known).max()) > np.finfo(np.float32).max:
        return 0.0
    if (known != known.astype(np.float32)).any():
        return 0.0
    step = float(np.spacing(np.abs(known).max().astype(np.float32)))
    return 0.0 if step_of(known) > 1.5 * step else step


def check_precision_of_places(points: np.ndarray) -> None:
    """Raise `InputError` if single precision is too coarse for x or y of points (n, 3)."""
    distance = float(np.sqrt(np.prod(np.sort(np.ptp(points, axis=0))[1:]) / len(points)))
    for name, values in zip("xyz", points.T, strict=True):
        step = in_single_precision(values)
        if name != "z" and step > _INEXACT * distance:
            raise InputError(
                _inexact_message(name, values, step, f"points are {distance:.3g} apart")
            )


def check_precision_of_heights(differences: np.ndarray, heights: np.ndarray) -> None:
    """Raise `InputError` if single precision is too coarse for ``heights`` stored in it.

    It is so if its step exceeds the rms of the ``differences`` of neighbours; NaN are ignored.
    """
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

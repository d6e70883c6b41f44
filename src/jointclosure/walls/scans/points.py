"""Points of a scan file, in any order and with gaps: recognition of the grid on which they lie."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import Caution, caution
from jointclosure.statistics.number_texts import percent
from jointclosure.walls.gridding import Cloud
from jointclosure.walls.missing_heights import in_gaps
from jointclosure.walls.rounding import step_of
from jointclosure.walls.scans.contents import (
    Contents,
    missing_heights,
    missing_text,
    missing_values,
)
from jointclosure.walls.scans.sheet import TWO_WALLS, check_one_patch, check_sheet
from jointclosure.walls.stray_points import patch_numbers, stray_points, unique_places

LARGEST_OFFSET = 0.05
"""Largest distance [steps of the grid] of a point from its node that counts as rounding."""
MOST_MOVED = 0.25
"""Largest distance [steps of the grid] by which a point may be moved to its node. Slopes (H = 0.8)
are then up to 2 % too large."""
_OUTLYING = 3.0
"""Distance of a point from its node, over the upper quartile (along one axis: over the median) of
these distances, beyond which the point is off the grid."""
MOST_AMBIGUOUS = 0.01
"""Largest share of places with several heights that is accepted, and of empty nodes inside the wall
that gives no caution."""
_LEAST_UNEVEN = 4
"""Number of empty lines of nodes, or of longer steps between places, from which places are taken
for coarsely rounded ones."""
_COARSE = 0.4  # rounding of places, over the mean distance of points, beyond which it is refused
_LEAST_ROUNDED = 8  # fewest different places along an axis that are numbered in their order
_DIGITS = 7  # significant digits of a step, those of single precision

SCATTERED = caution(
    "the points lie on no regular grid along x and y: heights between them are interpolated, which "
    "makes walls smoother"
)
"""Remark on scattered points."""


def contents_of(
    points: np.ndarray, units: Sequence[str | None] = (None,) * 3, remarks: tuple[str, ...] = ()
) -> Contents:
    """Return the contents of a file of points (n, 3): a grid if they lie on one, otherwise points.

    ``units`` are those of x, y and z, None where not stated; ``remarks`` precede those that are
    found. Stray points are cut and repeated ones merged. Raise `InputError` if the units of x and y
    differ, if points with a height lack x or y, or if the points are not a single wall along z.
    """
    along_x, along_y, height = units
    if along_x != along_y:
        raise InputError(f"x is in {along_x} and y in {along_y}: must be in the same units")
    points, found = _clean_points(points)
    if (contents := lattice_of(points)) is None:
        numbers = unique_places(points[:, :2])[1]
        if len(points) and numbers.max() + 1 < len(points):
            first = np.unique(numbers, return_index=True)[1]
            places, heights, repeats = _merge_repeated(numbers, points)
            points = np.column_stack([points[first[places], :2], heights])[np.isfinite(heights)]
            found += repeats
        contents = Contents(points=points, remarks=(SCATTERED,))
    remarks += found + contents.remarks
    return contents._replace(height_units=height, length_units=along_x, remarks=remarks)


def _clean_points(points: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the points (n, 3) that have a place and are no stray ones, and remarks on the others.

    Missing heights are NaN. Raise `InputError` as `contents_of`, except for units.
    """
    points = points.astype(float)
    places, sentinels = zip(*(missing_values(column) for column in points[:, :2].T), strict=True)
    without_height, remarks = missing_heights(Cloud(points))
    missing = np.column_stack([*places, without_height])
    if count := int(missing[:, :2].any(axis=1).sum()):
        remarks += (missing_text(count, np.unique(np.concatenate(sentinels)), "places"),)
    points[missing | ~np.isfinite(points)] = np.nan
    placed = np.isfinite(points[:, :2]).all(axis=1)
    nowhere = np.flatnonzero(~placed & np.isfinite(points[:, 2]) & ~missing.any(axis=1))
    if nowhere.size:
        raise InputError(f"{nowhere.size} points lack x or y, the first is number {nowhere[0] + 1}")
    if not placed.all():
        remarks += (f"{int((~placed).sum())} lines without a place were skipped",)
        points = points[placed]
    check_sheet(points[np.isfinite(points[:, 2])])
    patch = patch_numbers(points[:, :2]) if len(points) > 1 else np.zeros(len(points), int)
    check_one_patch(np.bincount(patch, minlength=1))
    stray = stray_points(points, patch)
    if count := int(stray.sum()):
        named = ", ".join(f"({x:g}, {y:g}, {z:g})" for x, y, z in points[stray][:3])
        cut = f"{count} stray point{'s were' if count > 1 else ' was'} cut, far from all others"
        more = ", ..." if count > 3 else ""
        remarks += (f"{cut}: {named}{more} (x, y, z in the file's units)",)
    return points[~stray], remarks


class _Axis(NamedTuple):
    """Evenly spaced nodes along an axis, and the node next to each point."""

    step: float  # distance of neighbouring nodes, in the file's units
    first: float  # place of node 0, in the file's units
    node: np.ndarray  # number of the node next to each point (n,)
    offset: np.ndarray  # place of each point less that of its node, in steps (n,)

    def numbered(self, on: np.ndarray) -> tuple[np.ndarray, int, float]:
        """Number the nodes along this axis from 0, beginning with the first that has a point.

        Only points (n,) of the mask ``on`` count. Return the numbers of their nodes, the number of
        nodes from the first to the last of these, and the coordinate of the first.
        """
        low = int(self.node[on].min())
        high = int(self.node[on].max())
        digits = _DIGITS - 1 - int(np.floor(np.log10(self.step)))
        first = round(self.first + low * self.step, digits)
        return self.node[on].astype(int) - low, high - low + 1, first


def lattice_of(points: np.ndarray) -> Contents | None:
    """Return the regular grid on which points (n, 3) lie, with remarks; None if they do not.

    Nine tenths of the points must lie at nodes; the others are left out. Raise `InputError` if x or
    y are rounded too coarsely, or if too many places have several heights.
    """
    if len(points) < 9:
        return None
    # coordinates closer than a twentieth of the mean distance of points count as equal
    apart = 0.05 * float(np.sqrt(np.prod(np.ptp(points[:, :2], axis=0)) / len(points)))
    axes = [_find_axis(values, apart) for values in points[:, :2].T]
    remarks: tuple[str, ...] = ()
    if not _has_all_lines(axes):
        rounded = [_rounded_axis(values, apart) for values in points[:, :2].T]
        if None not in rounded:
            axes, remarks = _equalise_steps(rounded, points)
    x, y = axes
    if x is None or y is None:
        return None
    on, allowed = _points_on_nodes(x, y)
    if on.mean() < 0.9:  # scattered
        return None
    (column, nx, x_first), (row, ny, y_first) = (axis.numbered(on) for axis in (x, y))
    if nx * ny > 20 * len(points):  # too sparse for a grid
        return None
    numbers = row * nx + column
    occupied = np.zeros((ny, nx), bool)
    occupied.flat[numbers] = True
    _check_resolution(points, occupied)
    followed = (occupied[1:] & occupied[:-1]).sum(), (occupied[:, 1:] & occupied[:, :-1]).sum()
    if min(followed) < 0.5 * occupied.sum():  # few have a point at the next node: staggered
        return None
    places, heights, repeats = _merge_repeated(numbers, points[on])
    grid = np.full(nx * ny, np.nan)
    grid[places] = heights
    remarks += (
        repeats
        + _irregularity_cautions(points, x, y, on, allowed)
        + _describe_empty_nodes(occupied)
    )
    contents = Contents(grid.reshape(ny, nx), (y.step, x.step), origin=(y_first, x_first))
    return contents._replace(remarks=remarks)


def _points_on_nodes(x: _Axis, y: _Axis) -> tuple[np.ndarray, float]:
    """Return which points (n,) lie at nodes of both axes, and the distance allowed [steps]."""
    offset = np.maximum(np.abs(x.offset), np.abs(y.offset))
    allowed = float(np.clip(_OUTLYING * np.quantile(offset, 0.75), LARGEST_OFFSET, MOST_MOVED))
    return offset <= allowed, allowed


def _has_all_lines(axes: Sequence[_Axis | None]) -> bool:
    """Return whether 0.9 of the points lie at nodes of both axes, and few lines of nodes are empty.

    An axis is None if no even spacing was found along it; the answer is then no.
    """
    x, y = axes
    if x is None or y is None or (on := _points_on_nodes(x, y)[0]).mean() < 0.9:
        return False
    lines = [np.unique(axis.node[on]) for axis in (x, y)]
    return all(np.ptp(line) + 1 - len(line) < _LEAST_UNEVEN for line in lines)


def _equalise_steps(
    axes: Sequence[_Axis | None], points: np.ndarray
) -> tuple[list[_Axis | None], tuple[str, ...]]:
    """Return both axes of rounded places (n, 3), and remarks on the rounding.

    If the steps of the axes differ by no more than rounding explains, both get the mean step.
    """
    known = [axis for axis in axes if axis is not None]
    roundings = [step_of(values) for values in points[:, :2].T]
    error = max(r / np.ptp(axis.node) for r, axis in zip(roundings, known, strict=True))
    steps = [axis.step for axis in known]
    if np.ptp(steps) < error:
        known = [axis._replace(step=float(np.mean(steps))) for axis in known]
    remarks = [
        f"{name} is a multiple of {rounding:.4g} in the file's units, and points are "
        f"{axis.step:.4g} apart: they were numbered in order"
        for name, axis, rounding in zip("xy", known, roundings, strict=True)
    ]
    return [*known], tuple(remarks)


def _irregularity_cautions(
    points: np.ndarray, x: _Axis, y: _Axis, on: np.ndarray, allowed: float
) -> tuple[Caution, ...]:
    """Return cautions about points (n, 3) that were left out, as they are off the nodes, or moved.

    The points ``on`` nodes were moved to these by at most ``allowed`` steps; there is no caution if
    all moves are within rounding (`LARGEST_OFFSET`).
    """
    remarks = []
    if off := int((~on & np.isfinite(points[:, 2])).sum()):
        remarks.append(
            f"{off} of {len(points)} points lie off the nodes of the points' grid, by more than "
            f"{percent(allowed)} of its step, and were left out"
        )
    offsets = np.abs([x.offset[on], y.offset[on]])
    if offsets.max() > LARGEST_OFFSET:
        moved = float(np.sqrt(np.mean(np.sum(offsets**2, axis=0))))
        remarks.append(
            f"points were moved to the nodes of their grid, by an rms {percent(moved)} of its "
            f"step; for H = 0.8 this changes heights by {percent(moved**0.8)} of the rms "
            "difference of neighbours"
        )
    return tuple(map(caution, remarks))


def _describe_empty_nodes(occupied: np.ndarray) -> tuple[str, ...]:
    """Return a remark on the nodes (y, x) of a grid that are not ``occupied`` by a point.

    It is a caution if more than `MOST_AMBIGUOUS` of all nodes are empty inside the wall. There is
    no remark if no node is empty.
    """
    empty = int((~occupied).sum())
    inside = int(in_gaps(occupied).sum())
    if inside <= MOST_AMBIGUOUS * occupied.size:
        return (f"{empty} of {occupied.size} heights are missing",) if empty else ()
    share = f"{inside} of {occupied.size} heights ({percent(inside / occupied.size)})"
    return (caution(f"{share} are missing inside the wall; the file may be incomplete"),)


def _find_axis(values: np.ndarray, apart: float) -> _Axis | None:
    """Find the evenly spaced nodes along an axis at which most coordinates (n,) of points lie.

    Coordinates closer than ``apart`` are grouped. None if fewer than three groups have about as
    many points as others.
    """
    levels, of_value, count = np.unique(values, return_inverse=True, return_counts=True)
    group = np.concatenate([[0], np.cumsum(np.diff(levels) > apart)])
    size = np.bincount(group, count)
    middles = np.bincount(group, levels * count) / size
    middles = middles[size >= 0.5 * np.median(size[group[of_value]])]
    if len(middles) < 3:
        return None
    ratio = (between := np.diff(middles)) / np.median(between)
    step = float(between[(ratio > 0.4) & (ratio < 1.6)].mean())
    for reach in 2 ** np.arange((len(middles) // 2).bit_length()):
        distance = middles[reach:] - middles[:-reach]
        step = float(np.median(distance / np.maximum(np.round(distance / step), 1.0)))
    first = float(middles[0])
    phase = float(np.angle(np.exp(2j * np.pi * (middles - first) / step).mean()))
    first += phase / 2 / np.pi * step
    for _ in range(3):
        offset = (values - first) / step - (node := np.round((values - first) / step))
        on = np.abs(offset) <= max(_OUTLYING * np.median(np.abs(offset)), 1e-6)
        centred = node[on] - node[on].mean()
        mean = values[on].mean()
        if not centred.any():
            return None
        step = float(np.sum(centred * (values[on] - mean)) / np.sum(centred**2))
        first = float(mean - step * node[on].mean())
    offset = (values - first) / step - (node := np.round((values - first) / step))
    return _Axis(float(f"{step:.{_DIGITS - 1}e}"), first, node, offset)


def _rounded_axis(values: np.ndarray, apart: float) -> _Axis | None:
    """Find the nodes along an axis of coordinates (n,) that were rounded coarsely; None if not so.

    The different coordinates are numbered in their order, and a straight line through them gives
    the step of the nodes. Coarse rounding is accepted as an explanation if each coordinate is
    within about half of a rounding step of the line, if the step of the nodes is larger than the
    rounding step and no multiple of it, and if some nodes follow at longer steps than others.
    """
    levels = np.unique(values[np.isfinite(values)])
    rounding = step_of(values)
    if len(levels) < _LEAST_ROUNDED or rounding <= apart:
        return None
    number = np.arange(len(levels))
    step = float(np.polyfit(number, levels - levels[0], 1)[0])
    off = levels - step * number
    if np.ptp(off) > 1.2 * rounding or step < 1.01 * rounding:
        return None
    if abs(step / rounding - round(step / rounding)) < 1e-3:  # the nodes are at their places
        return None
    if (np.diff(levels) > 1.5 * rounding).sum() < _LEAST_UNEVEN:  # profiles are missing
        return None
    first = float(np.mean(off))
    return _Axis(step, first, number[np.searchsorted(levels, values)], np.zeros(len(values)))


def _check_resolution(points: np.ndarray, occupied: np.ndarray) -> None:
    """Raise `InputError` if x or y of points (n, 3) are rounded so coarsely that lines are empty.

    Lines are the rows and columns of the grid; ``occupied`` (y, x) tells which nodes have a point.
    """
    known = [np.flatnonzero(occupied.sum(axis=axis)) for axis in (0, 1)]
    lines = [len(places) for places in known]
    empty = [int(np.ptp(places)) + 1 - len(places) for places in known]
    roundings = [step_of(values) for values in points[:, :2].T]
    distance = float(np.sqrt(np.prod(np.ptp(points[:, :2], axis=0)) / len(points)))
    if any(
        few >= max(0.1 * full, 3.0) and rounding > _COARSE * distance
        for few, full, rounding in zip(empty, lines, roundings, strict=True)
    ):
        x, y = roundings
        raise InputError(
            f"x and y are multiples of {x:.4g} and {y:.4g} in the file's units, so coarse that "
            f"{empty[0]} columns and {empty[1]} rows of their grid are empty between others: must "
            "be less than half of the distance of the points; export more digits"
        )


def _merge_repeated(
    numbers: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """Merge points (n, 3) at the same place; ``numbers`` (n,) tell the place of each point.

    Return the numbers (m,) of the places with a height, ascending, their heights (m,), and remarks.
    A place with different heights has NaN. Raise `InputError` if more than `MOST_AMBIGUOUS` of the
    places are so.
    """
    known = np.flatnonzero(np.isfinite(points[:, 2]))
    known = known[np.argsort(numbers[known], kind="stable")]
    heights = points[known, 2]
    places, start, count = np.unique(numbers[known], return_index=True, return_counts=True)
    if len(places) == len(known):
        return places, heights, ()
    low = np.minimum.reduceat(heights, start)
    high = np.maximum.reduceat(heights, start)
    several = high - low > 1e-6 * np.ptp(heights)
    if several.sum() > MOST_AMBIGUOUS * len(places):
        at = int(np.argmax(high - low))
        x, y = points[known[start[at]], :2]
        raise InputError(
            f"{int(several.sum())} of {len(places)} places have several heights, such as (x, y) = "
            f"({x:g}, {y:g}) with {low[at]:g} and {high[at]:g}: a wall has one height at each "
            f"place; {TWO_WALLS}, and x and y (all x are multiples of {step_of(points[:, 0]):.3g}) "
            "need more digits if points are closer"
        )
    remarks = []
    if repeated := int((count - 1)[~several].sum()):
        remarks.append(f"{repeated} repeated points were skipped")
    if several.any():
        remarks.append(f"{int(several.sum())} places with several heights were treated as missing")
    return places, np.where(several, np.nan, heights[start]), tuple(remarks)

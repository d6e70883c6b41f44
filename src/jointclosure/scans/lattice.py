"""Points that lie on a regular grid, whatever their order, gaps and repeats; one height a place."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError

LARGEST_OFFSET = 0.05
"""Distance of a point from its node, over the step of the grid: places are written rounded."""
LEAST_NEIGHBOURS = 0.5
"""Share of the points whose next node is a point too, along each axis: what has fewer is scattered
or staggered."""
MOST_CELLS_PER_POINT = 20
"""Nodes of a grid for each point: sparser points are scattered."""
SAME_HEIGHT = 1e-6
"""Difference of repeated heights over the range of all heights."""
MOST_AMBIGUOUS = 0.01
"""Share of the places that may have several heights: these are left out, more are an error."""
_DIGITS = 7
"""Significant digits of a step: single precision has as many, and files of it the same grid."""


class Lattice(NamedTuple):
    """Heights (y, x) on a grid of a spacing (dy, dx), NaN at nodes without a point, and the place
    (y, x) of the first node."""

    heights: np.ndarray
    spacing: tuple[float, float]
    origin: tuple[float, float]
    remarks: tuple[str, ...]


def lattice_of(points: np.ndarray) -> Lattice | None:
    """The regular grid along x and y on whose nodes all points (n, 3) lie, None without one.

    Heights may be NaN. Nodes may lack a point, and points may be repeated.

    Raises
    ------
    InputError
        More than `MOST_AMBIGUOUS` of the nodes have points of several heights.
    """
    if len(points) < 9:
        return None
    # levels of a coordinate closer than this are one: a twentieth of the mean distance of points
    apart = 0.05 * float(np.sqrt(np.prod(np.ptp(points[:, :2], axis=0)) / len(points)))
    axes = [_axis_of(values, apart) for values in points[:, :2].T]
    if axes[0] is None or axes[1] is None:
        return None
    x, y = axes[0], axes[1]
    nx, ny = int(x.node.max()) + 1, int(y.node.max()) + 1
    if nx * ny > MOST_CELLS_PER_POINT * len(points):
        return None
    numbers = y.node * nx + x.node
    occupied = np.zeros((ny, nx), bool)
    occupied.flat[numbers] = True
    followed = (occupied[1:] & occupied[:-1]).sum(), (occupied[:, 1:] & occupied[:, :-1]).sum()
    if min(followed) < LEAST_NEIGHBOURS * occupied.sum():
        return None
    places, heights, remarks = _merged(numbers, points)
    grid = np.full(nx * ny, np.nan)
    grid[places] = heights
    empty = int((~occupied).sum())
    if empty:
        remarks += (f"{empty} of {nx * ny} nodes of the points' grid have no point",)
    return Lattice(grid.reshape(ny, nx), (y.step, x.step), (y.first, x.first), remarks)


def merged_points(points: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Points (n, 3) with one height a place, and what was left out.

    Raises
    ------
    InputError
        More than `MOST_AMBIGUOUS` of the places have several heights.
    """
    numbers = np.unique(points[:, :2], axis=0, return_inverse=True)[1].ravel()
    if not len(points) or numbers.max() + 1 == len(points):
        return points, ()
    first = np.unique(numbers, return_index=True)[1]
    places, heights, remarks = _merged(numbers, points)
    kept = np.column_stack([points[first[places], :2], heights])
    return kept[np.isfinite(heights)], remarks


class _Axis(NamedTuple):
    """Number of each point's node along an axis, distance of the nodes and place of the first."""

    node: np.ndarray
    step: float
    first: float


def _axis_of(values: np.ndarray, apart: float) -> _Axis | None:
    levels, of_value = np.unique(values, return_inverse=True)
    group = np.concatenate([[0], np.cumsum(np.diff(levels) > apart)])
    middles = np.bincount(group, levels) / np.bincount(group)
    if len(middles) < 3:
        return None
    gaps = np.diff(middles)
    node = np.concatenate([[0.0], np.cumsum(np.round(gaps / np.median(gaps)))])
    centred = node - node.mean()
    step = float(f"{np.sum(centred * middles) / np.sum(centred**2):.{_DIGITS - 1}e}")
    level = middles.mean() + step * centred
    if not np.abs(levels - level[group]).max() <= LARGEST_OFFSET * step:
        return None
    return _Axis(node[group].astype(int)[of_value], step, float(middles[0]))


def _merged(
    numbers: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """Numbers of the places that have a height, these heights, and what was left out.

    A place of several heights has NaN.
    """
    known = np.flatnonzero(np.isfinite(points[:, 2]))
    known = known[np.argsort(numbers[known], kind="stable")]
    heights = points[known, 2]
    places, start = np.unique(numbers[known], return_index=True)
    if len(places) == len(known):
        return places, heights, ()
    low, high = np.minimum.reduceat(heights, start), np.maximum.reduceat(heights, start)
    several = high - low > SAME_HEIGHT * np.ptp(heights)
    if several.sum() > MOST_AMBIGUOUS * len(places):
        at = int(np.argmax(high - low))
        x, y = points[known[start[at]], :2]
        raise InputError(
            f"{int(several.sum())} of {len(places)} places have several heights, as (x, y) = "
            f"({x:g}, {y:g}) has {low[at]:g} and {high[at]:g}: a wall has one height at each; a "
            "solid or both walls in one file must be cut to one wall"
        )
    remarks = []
    repeated = len(known) - len(places) - int((np.diff([*start, len(known)])[several] - 1).sum())
    if repeated:
        remarks.append(f"{repeated} repeated points were passed over")
    if several.any():
        remarks.append(f"{int(several.sum())} places of several heights were taken as missing")
    return places, np.where(several, np.nan, heights[start]), tuple(remarks)

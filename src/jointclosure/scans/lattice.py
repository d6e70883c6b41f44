"""Points on a regular grid in any order, with gaps and repetitions; one height for each node."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.surface.outliers import unique_places

LARGEST_OFFSET = 0.05
"""Largest distance of a point from its node, over the step of the grid, due to rounding in
files."""
LEAST_NEIGHBOURS = 0.5
"""Smallest share of points whose next node has a point too, along both axes; points with less are
scattered or staggered."""
MOST_CELLS_PER_POINT = 20
"""Largest number of nodes of a grid for each point; sparser points are scattered."""
SAME_HEIGHT = 1e-6
"""Largest difference of repeated heights, over the range of all heights."""
MOST_AMBIGUOUS = 0.01
"""Largest share of places with several heights; these are left out, and more are an error."""
_DIGITS = 7
"""Significant digits of a step: those of single precision, so that files in single precision give
the same grid."""


class Lattice(NamedTuple):
    """Heights (y, x) on a grid of a spacing (dy, dx), NaN at nodes without a point.

    The last field is the place (y, x) of the first node.
    """

    heights: np.ndarray
    spacing: tuple[float, float]
    origin: tuple[float, float]
    remarks: tuple[str, ...]


def lattice_of(points: np.ndarray) -> Lattice | None:
    """Find the regular grid along x and y on whose nodes all points (n, 3) lie, None without one.

    Heights may be NaN. Nodes may have no point, and points may be repeated.

    Raises
    ------
    InputError
        If more than `MOST_AMBIGUOUS` of the nodes have several heights.
    """
    if len(points) < 9:
        return None
    # coordinates closer than a twentieth of the mean distance of points count as equal
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
    """Return points (n, 3) with one height for each place, and remarks on what was left out.

    Raises
    ------
    InputError
        If more than `MOST_AMBIGUOUS` of the places have several heights.
    """
    numbers = unique_places(points[:, :2])[1]
    if not len(points) or numbers.max() + 1 == len(points):
        return points, ()
    first = np.unique(numbers, return_index=True)[1]
    places, heights, remarks = _merged(numbers, points)
    kept = np.column_stack([points[first[places], :2], heights])
    return kept[np.isfinite(heights)], remarks


class _Axis(NamedTuple):
    """Number of each point's node along an axis, distance of the nodes, and place of the first."""

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
    """Return numbers of the places with a height, these heights, and remarks on what was left out.

    A place with several heights has NaN.
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
            f"{int(several.sum())} of {len(places)} places have several heights, such as (x, y) = "
            f"({x:g}, {y:g}) with {low[at]:g} and {high[at]:g}: a wall has one height at each "
            "place; a solid or both walls in one file must be cut to one wall"
        )
    remarks = []
    repeated = len(known) - len(places) - int((np.diff([*start, len(known)])[several] - 1).sum())
    if repeated:
        remarks.append(f"{repeated} repeated points were skipped")
    if several.any():
        remarks.append(f"{int(several.sum())} places with several heights were treated as missing")
    return places, np.where(several, np.nan, heights[start]), tuple(remarks)

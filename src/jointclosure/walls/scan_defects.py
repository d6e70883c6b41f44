"""Defects of a scanned wall that show in its heights, and their removal.

In a grid each block of equal heights becomes one height, profiles that are displaced along
themselves are moved back, rims that a sharp step sets off are cut, and heights in patches without
short waves become missing (NaN), because such patches are filled holes. Plateaus (`outliers.py`)
are removed from grids and from points.
"""

from collections.abc import Callable, Mapping

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution, cautions
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.plateaus import remove_plateaus
from jointclosure.walls.rounding import step_of

LARGEST_BLOCK = 4  # cells along a side of the largest blocks of equal heights that are looked for
SMOOTH = 0.03
"""Smoothness below which a cell lies in a patch without short waves. The smoothness of a cell is
the mean squared second difference of heights in the 3 x 3 cells around it, over the median of this
mean in the whole wall. The smallest smoothness of any cell was 0.079 in self-affine walls of 128 x
128 cells (H 0.5 to 0.9), and 0.11 in a scanned foliation joint."""
ASIDE = 2  # largest displacement [cells] of a profile from its neighbour that is looked for
CLEAR_SHIFT = 2.5
"""Score above which a single profile counts as displaced along itself, and is moved back. The score
of a shift is the decrease of misfit that it brings, averaged over the cells of the profile, over
the standard error of this average. Misfit is the squared difference between the slopes of the
profile and the mean slopes of its two neighbours. The largest score in 1,200 self-affine fields of
64 and 128 profiles, of which none is displaced, was 1.5."""
CLEAR_STEP = 4.0
"""Score above which a profile and all after it count as displaced against those before. The score
is that of `CLEAR_SHIFT`, except that the misfit of a profile is to the profile before it. The
largest score in the same self-affine fields was 2.8."""
RIM = 8.0
"""Sharpness above which a step at an edge of the grid is the inner side of a rim, which is cut. The
sharpness is the size of the bend at the step over the scatter of the bends farther in. The bend of
a profile is the mean second difference [m] of heights across profiles. The scatter is 1.48 times
the median absolute deviation. The value was chosen."""
_RIM_OF_MEDIAN = 0.75
"""Factor of `RIM` for the second test of a rim, in which medians over a profile replace the means.
Both tests must be passed. Medians scatter 1.25 times as much as means, so that the same step is
less sharp among them."""
_RIM_SHARE = 0.03  # largest width of a rim, as a share of the profiles across it; chosen
_RIM_CELLS = 3  # largest width of a rim [profiles] in grids where the share is less; chosen


def inspected(scan: Scan | Cloud) -> Scan | Cloud:
    """Return a scan without the defects that its heights show; its remarks have a caution on each.

    In points only plateaus are looked for; in grids also blocks of equal heights, displaced
    profiles, rims, and patches without short waves.
    """
    if isinstance(scan, Scan):
        for undo in (merge_equal_blocks, align_profiles, cut_rim):
            scan = undo(scan)
    scan = remove_plateaus(scan)
    return mask_smooth_patches(scan) if isinstance(scan, Scan) else scan


def inspected_together(scans: Mapping[str, Scan | Cloud]) -> dict[str, Scan | Cloud]:
    """Return the scans of both walls, by side, without the defects that their heights show.

    The cells (y, x) of two grids must lie on each other, and still do so afterwards: if the size of
    a grid has changed, both are cut to the cells that both still have, and then have no ``origin``.

    Raises
    ------
    InputError
        If the size of a grid has changed, and the cells of the grids no longer lie on each other.
    """
    kept: dict[str, Scan | Cloud] = {}
    grids: dict[str, Scan] = {}
    cells = set()
    firsts = []
    changed = False
    for side, scan in scans.items():
        if isinstance(scan, Scan):
            place = scan.origin or (0.0, 0.0)
            kept[side] = grid = inspected(scan._replace(origin=place))
            assert isinstance(grid, Scan)
            grids[side] = grid
            changed |= grid.heights.shape != scan.heights.shape
            cells.add((scan.heights.shape, scan.spacing, grid.spacing))
            firsts.append(np.subtract(grid.origin or place, place) / grid.spacing)
        else:
            kept[side] = inspected(scan)
    if len(grids) < 2 or not changed:
        return kept
    low = np.max(firsts, axis=0)
    starts = [low - first for first in firsts]
    whole = [np.rint(start).astype(int) for start in starts]
    if len(cells) > 1 or not np.allclose(starts, whole, atol=1e-3):
        remarks = "; ".join(remark for grid in grids.values() for remark in cautions(grid.remarks))
        raise InputError(
            f"the cells of the scans do not lie on each other once defects are undone: {remarks}; "
            "a registration finds the area that both cover (bring_together: true in a study)"
        )
    sizes = [grid.heights.shape - start for grid, start in zip(grids.values(), whole, strict=True)]
    ny, nx = np.min(sizes, axis=0)
    for (side, grid), (y, x) in zip(grids.items(), whole, strict=True):
        kept[side] = grid._replace(heights=grid.heights[y : y + ny, x : x + nx], origin=None)
    return kept


def merge_equal_blocks(scan: Scan) -> Scan:
    """Return a scanned grid in which each block of n x n equal heights has become one height.

    The height lies in the middle of its block, so that the spacing is n times as large. The largest
    n from `LARGEST_BLOCK` down to 2 is taken; a grid without blocks is returned as it is.
    """
    heights = scan.heights
    for size in range(LARGEST_BLOCK, 1, -1):
        firsts = [_first_of_blocks(heights, axis, size) for axis in (0, 1)]
        if None in firsts:
            continue
        y, x = (int(first or 0) for first in firsts)
        dy, dx = scan.spacing
        origin = scan.origin or (0.0, 0.0)
        middle = 0.5 * (size - 1)
        message = (
            f"heights are equal in blocks of {size} x {size} cells, so that the scan was refined "
            f"without measuring: one height of each block was taken, {1e3 * size * dx:.4g} mm apart"
        )
        return Scan(
            heights[y::size, x::size],
            (size * dy, size * dx),
            (origin[0] + (y + middle) * dy, origin[1] + (x + middle) * dx),
            (*scan.remarks, caution(message)),
        )
    return scan


def _first_of_blocks(heights: np.ndarray, axis: int, size: int) -> int | None:
    """Return the index along an axis at which the first whole block of equal heights begins.

    None if heights (y, x) do not repeat in blocks of ``size`` cells along the axis, which 0.9 of
    the differences within blocks and at most half of those between blocks must show by being 0, or
    if there are no more than four such blocks.
    """
    steps = np.moveaxis(np.diff(heights, axis=axis), axis, 0)
    if len(steps) < 4 * size:
        return None
    with np.errstate(invalid="ignore"):
        known = np.isfinite(steps)
        equal = np.array(
            [
                (steps[first::size] == 0.0).sum() / max(known[first::size].sum(), 1)
                for first in range(size)
            ]
        )
    between = int(equal.argmin())  # steps from one block to the next
    if equal[between] > 0.5 or (np.delete(equal, between) < 0.9).any():
        return None
    return (between + 1) % size


def align_profiles(scan: Scan) -> Scan:
    """Return a scanned grid whose displaced rows and columns were moved back by whole cells.

    Profiles are displaced along themselves where a scanner lost steps. Cells at the ends of
    profiles that not all profiles cover after the move are cut.
    """
    for axis, name in ((0, "rows"), (1, "columns")):
        heights = scan.heights if axis == 0 else scan.heights.T
        places = _places_aside(heights)
        aside = places != 0
        if not aside.any():
            continue
        moved = np.full(heights.shape, np.nan)
        for row, place in enumerate(places.tolist()):
            part = heights[row, max(place, 0) : heights.shape[1] + min(place, 0)]
            moved[row, max(-place, 0) : max(-place, 0) + len(part)] = part
        low = max(-places.min(), 0)
        high = heights.shape[1] - max(places.max(), 0)
        moved = moved[:, low:high]
        origin = None
        if scan.origin is not None:
            first = list(scan.origin)
            first[1 - axis] += low * scan.spacing[1 - axis]
            origin = (first[0], first[1])
        message = (
            f"{int(aside.sum())} of {len(aside)} {name} lie {np.abs(places).max()} cells or less "
            "aside of their neighbours, as after lost steps of the scanner: they were moved back"
        )
        scan = scan._replace(
            heights=moved if axis == 0 else moved.T,
            origin=origin,
            remarks=(*scan.remarks, caution(message)),
        )
    return scan


def _places_aside(heights: np.ndarray) -> np.ndarray:
    """Return the displacement (y,) [cells] of each row of heights (y, x) from most rows.

    It is positive if the row must be moved towards smaller x. Single rows, or every second row, are
    first compared with the means of both neighbours; then each row is compared with the one before
    it, which finds displacements of all rows beyond. All are 0 if the grid is too small.
    """
    slopes = heights[:, 2:] - heights[:, :-2]  # less affected by noise than neighbours
    places = np.zeros(len(heights), int)
    if slopes.shape[1] < 8 * ASIDE or len(slopes) < 4:
        return places
    shifts, scores = _clear_shifts(0.5 * (slopes[:-2] + slopes[2:]), slopes[1:-1], CLEAR_SHIFT)
    first = int(scores[1::2].sum() > scores[::2].sum())
    every_second = shifts[first::2]
    usual = _most_frequent(every_second)
    if usual and (every_second == usual).mean() > 0.5:  # on the way back of the scanner
        places[(first + 1) % 2 :: 2] = usual
    else:
        for row in np.argsort(-scores):
            if shifts[row] and not places[row : row + 3].any():
                places[row + 1] = shifts[row]
    moved = np.stack([np.roll(row, -place) for row, place in zip(slopes, places, strict=True)])
    steps, _ = _clear_shifts(moved[:-1], moved[1:], CLEAR_STEP)
    places[1:] += np.cumsum(steps)
    return places - _most_frequent(places)


def _most_frequent(values: np.ndarray) -> int:
    """Return the most frequent of whole numbers (n,); of several, the smallest."""
    return int(np.bincount(values - values.min()).argmax() + values.min())


def _clear_shifts(
    fixed: np.ndarray, rows: np.ndarray, clear: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the shifts (n,) [cells] at which rows (n, x) fit the ``fixed`` rows (n, x) better.

    The second array (n,) has the scores of these shifts, see `CLEAR_SHIFT`. A shift of at most
    `ASIDE` cells is found if its score exceeds ``clear``. Otherwise, or if a row has fewer than 16
    known cells in common with its fixed row, its shift and its score are 0.
    """
    inner = np.s_[:, ASIDE : rows.shape[1] - ASIDE]
    here = ((fixed - rows) ** 2)[inner]
    shifts = np.zeros(len(rows), int)
    scores = np.zeros(len(rows))
    for shift in (s for s in range(-ASIDE, ASIDE + 1) if s):
        gain = here - ((fixed - np.roll(rows, -shift, axis=1)) ** 2)[inner]
        count = np.isfinite(gain).sum(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.nansum(gain, axis=1) / count
            deviation = np.sqrt(np.nansum((gain - mean[:, None]) ** 2, axis=1)) / count
            score = np.where(count >= 16, mean / deviation, 0.0)
        better = np.nan_to_num(score) > np.maximum(scores, clear)
        shifts[better] = shift
        scores[better] = score[better]
    return shifts, scores


def cut_rim(scan: Scan) -> Scan:
    """Return a scanned grid without rims: profiles at its edges that a sharp step sets off."""
    cuts = []
    for axis in (0, 1):
        low = _rim_width(scan.heights, axis)
        high = _rim_width(np.flip(scan.heights, axis), axis)
        cuts.append((low, scan.heights.shape[axis] - high))
    if all(cut == (0, n) for cut, n in zip(cuts, scan.heights.shape, strict=True)):
        return scan
    (top, bottom), (left, right) = cuts
    y, x = scan.origin or (0.0, 0.0)
    ny, nx = scan.heights.shape
    counts = f"{left}, {nx - right} columns and {top}, {ny - bottom} rows"
    message = (
        f"the rim of the scan is raised or lowered by a sharp step: {counts} at its sides were cut"
    )
    return Scan(
        scan.heights[top:bottom, left:right],
        scan.spacing,
        (y + top * scan.spacing[0], x + left * scan.spacing[1]),
        (*scan.remarks, caution(message)),
    )


def _rim_width(heights: np.ndarray, axis: int) -> int:
    """Return the number of profiles at the start of an axis that are a rim; 0 if there is none.

    It is 0 too if the grid is too small, or if a profile near this edge has heights in no more than
    half of its cells.
    """
    side = heights.shape[axis]
    widest_rim = max(int(_RIM_SHARE * side), _RIM_CELLS)
    if side < 8 * widest_rim or min(heights.shape) < 24:
        return 0
    around = np.moveaxis(heights, axis, 0)[:, widest_rim:-widest_rim]  # without rims of other sides
    with np.errstate(invalid="ignore"):
        is_judged = np.isfinite(around).sum(axis=1) > 0.5 * around.shape[1]
    if not is_judged[: widest_rim + 2].all():
        return 0
    # means are more accurate than medians, but a patch near the edge changes only the means
    bends = _bends(around, np.nanmean)
    means = _deviations(bends, widest_rim)
    medians = _deviations(_bends(around, np.nanmedian), widest_rim)
    sharp = np.flatnonzero((means > RIM) & (medians > _RIM_OF_MEDIAN * RIM))
    # a step between profiles bends the means on both of its sides, in opposite directions
    ends = [n + 1 for n in sharp if n + 1 in sharp and bends[n + 1] * bends[n + 2] < 0.0]
    if sharp.size and sharp[0] == 0 and not ends:
        return 1
    return int(max(ends, default=0)) + (1 if ends else 0)


def _bends(profiles: np.ndarray, middle: Callable[[np.ndarray], float]) -> np.ndarray:
    """Return the bend (n,) [m] of each of the profiles (n, m): its mean second difference.

    Second differences are those of heights in three neighbouring profiles. ``middle`` is the mean
    or the median over the cells of a profile, which ignores NaN. The bend is NaN for the first and
    the last profile, and where at most half of the differences are known.
    """
    bends = np.full(len(profiles), np.nan)
    bends[1:-1] = [
        middle(row) if np.isfinite(row).sum() > 0.5 * row.size else np.nan
        for row in np.diff(profiles, 2, axis=0)
    ]
    return bends


def _deviations(bends: np.ndarray, widest_rim: int) -> np.ndarray:
    """Return the sizes (widest_rim,) of the bends at an edge, over the scatter of those farther in.

    ``bends`` (n,) are those of `_bends`; the sizes begin with that of the second profile, as the
    first profile has no bend. The scatter is the standard deviation, estimated by the median
    absolute deviation, which a rim does not affect. If fewer than eight bends farther in are known,
    all sizes are 0.
    """
    inner = bends[2 * widest_rim : -2 * widest_rim]
    inner = inner[np.isfinite(inner)]
    if len(inner) < 8:
        return np.zeros(widest_rim)
    usual = 1.4826 * float(np.median(np.abs(inner - np.median(inner))))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.abs(bends[1 : widest_rim + 1]) / usual


def mask_smooth_patches(scan: Scan) -> Scan:
    """Return a scanned grid in which heights are NaN in patches without short waves (`SMOOTH`).

    Such patches are filled holes. No height is removed if more than 0.3 of the cells lie in them,
    or if heights are rounded so coarsely that rounding alone makes flat patches.
    """
    heights = scan.heights
    around = np.pad(heights, 1, constant_values=np.nan)
    bend = np.diff(around[:, 1:-1], 2, axis=0) ** 2 + np.diff(around[1:-1], 2, axis=1) ** 2
    known = np.isfinite(bend)
    share = scipy.ndimage.uniform_filter(known.astype(float), 3, mode="constant")
    sums = scipy.ndimage.uniform_filter(np.where(known, bend, 0.0), 3, mode="constant")
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(share > 0.9, sums / share, np.nan)
    if not np.isfinite(mean).any() or not (usual := float(np.nanmedian(mean))) > 0.0:
        return scan
    smooth = mean < SMOOTH * usual
    if step_of(heights.ravel()) ** 2 > 0.1 * usual:  # rounding leaves flat patches
        return scan
    if not smooth.any() or smooth.mean() > 0.3:  # a smooth or stepped wall
        return scan
    # the 3 x 3 second differences of a mean contain heights of one more cell on each side
    patch = scipy.ndimage.binary_dilation(smooth, np.ones((3, 3)), iterations=2)
    patch &= np.isfinite(heights)
    message = (
        f"{int(patch.sum())} of {heights.size} heights lie in patches without short waves, whose "
        f"mean squared curvature is below {100.0 * SMOOTH:g} % of that of the wall, as in filled "
        "holes; they were treated as missing"
    )
    return scan._replace(
        heights=np.where(patch, np.nan, heights), remarks=(*scan.remarks, caution(message))
    )

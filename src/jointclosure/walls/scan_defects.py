"""Defects of a scanned grid that are found in its heights, and undone where that is possible.

Blocks of equal heights are taken once, profiles that lie aside are moved back, raised rims are cut,
and patches without short waves count as missing, as filled holes have no roughness of the wall.
"""

from collections.abc import Callable, Mapping

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution, cautions
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.plateaus import remove_plateaus
from jointclosure.walls.rounding import step_of

LARGEST_BLOCK = 4  # cells along a side of blocks of equal heights that are looked for
SMOOTH = 0.03
"""Mean squared second difference of 3 x 3 cells, over the median of the wall, below which a patch
has no short waves. The least of self-affine walls of 128 x 128 cells (H 0.5 to 0.9) was 0.079, of a
scanned foliation joint 0.11."""
ASIDE = 2  # largest shift [cells] at which profiles are compared
CLEAR_SHIFT = 2.5
"""Mean over standard error of the misfit that a shift takes from a single profile between both of
its neighbours, from which it is moved. The largest of 1,200 self-affine fields of 64 and 128
profiles was 1.5, as a shift adds misfit."""
CLEAR_STEP = 4.0
"""The same for all profiles from one on; the largest of these fields was 2.8."""
RIM = 8.0
"""Bend of the profile means at the step of a rim from which it is cut, over the usual bend of means
inside (1.48 times the median deviation); chosen."""
_RIM_OF_MEDIAN = 0.75
"""The same for the median of a profile, over `RIM`: medians scatter 1.25 times as much as means."""
_RIM_SHARE = 0.03  # share of the cells along an axis in which a rim may end; chosen
_RIM_CELLS = 3  # number of these cells where the share is fewer; chosen


def inspected(scan: Scan | Cloud) -> Scan | Cloud:
    """Return a scan without the defects that its heights show, with a remark on each.

    Those of profiles, blocks and rims are found in grids only; plateaus also in points.
    """
    if isinstance(scan, Scan):
        for undo in (merge_equal_blocks, align_profiles, cut_rim):
            scan = undo(scan)
    scan = remove_plateaus(scan)
    return mask_smooth_patches(scan) if isinstance(scan, Scan) else scan


def inspected_together(scans: Mapping[str, Scan | Cloud]) -> dict[str, Scan | Cloud]:
    """Return scans whose cells lie on each other without their defects, so that they still do.

    Of grids the cells are kept that all have afterwards.

    Raises
    ------
    InputError
        If cells were cut or taken in blocks, and those of the grids do not lie on each other.
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
    """Return a scan with one height for each block of n x n equal ones, which was measured once.

    The height lies in the middle of the block.
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
    """Return the first cell of whole blocks of equal heights along an axis; None without blocks."""
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
    """Return a scan with profiles moved back that lie whole cells aside, as after lost steps."""
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
    """Return the cells by which each row (y, x) lies aside of most rows.

    Single rows are compared with the mean of both neighbours, then each row with the next.
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
    """Return the whole number that is most frequent."""
    return int(np.bincount(values - values.min()).argmax() + values.min())


def _clear_shifts(
    fixed: np.ndarray, rows: np.ndarray, clear: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the shift [cells] of each row at which it clearly fits a fixed row better, else 0.

    The second value (rows,) is the mean over standard error of the misfit that the shift takes;
    a shift is clear from ``clear`` on.
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
    """Return a scan without profiles at its edges whose mean height is set off by a sharp step."""
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
    """Return the number of profiles at the start of an axis that are a rim, 0 if there is none."""
    side = heights.shape[axis]
    most = max(int(_RIM_SHARE * side), _RIM_CELLS)
    if side < 8 * most or min(heights.shape) < 24:
        return 0
    around = np.moveaxis(heights, axis, 0)[:, most:-most]  # without the rims of the other sides
    with np.errstate(invalid="ignore"):
        known = np.isfinite(around).sum(axis=1) > 0.5 * around.shape[1]
    if not known[: most + 2].all():
        return 0
    # the mean is the more accurate, but a patch near the edge moves it too, and not the median
    bends = _bends(around, np.nanmean)
    means = _deviations(bends, most)
    medians = _deviations(_bends(around, np.nanmedian), most)
    sharp = np.flatnonzero((means > RIM) & (medians > _RIM_OF_MEDIAN * RIM))
    # a step between profiles bends the means on both of its sides, in opposite directions
    ends = [n + 1 for n in sharp if n + 1 in sharp and bends[n + 1] * bends[n + 2] < 0.0]
    if sharp.size and sharp[0] == 0 and not ends:
        return 1
    return int(max(ends, default=0)) + (1 if ends else 0)


def _bends(profiles: np.ndarray, middle: Callable[[np.ndarray], float]) -> np.ndarray:
    """Return the mean or median (n,) of the second differences [m] across profiles (n, m)."""
    bends = np.full(len(profiles), np.nan)
    bends[1:-1] = [
        middle(row) if np.isfinite(row).sum() > 0.5 * row.size else np.nan
        for row in np.diff(profiles, 2, axis=0)
    ]
    return bends


def _deviations(bends: np.ndarray, most: int) -> np.ndarray:
    """Return the sizes of the first ``most`` bends, in standard deviations of those farther in.

    The deviation is estimated by the median absolute deviation, which a rim does not affect. If
    fewer than eight bends farther in are known, all sizes are 0.
    """
    inner = bends[2 * most : -2 * most]
    inner = inner[np.isfinite(inner)]
    if len(inner) < 8:
        return np.zeros(most)
    usual = 1.4826 * float(np.median(np.abs(inner - np.median(inner))))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.abs(bends[1 : most + 1]) / usual


def mask_smooth_patches(scan: Scan) -> Scan:
    """Return a scan without patches that have no short waves: they are filled holes."""
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
    # a mean is of 3 x 3 second differences, which take heights of one more cell on each side
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

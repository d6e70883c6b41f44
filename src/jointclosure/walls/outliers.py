"""Measured points that belong to no wall: stray points beside it, spikes, and plateaus."""

import numpy as np
import scipy

from jointclosure.inputs.remarks import caution
from jointclosure.walls.gridding import Cloud, Scan, points_of
from jointclosure.walls.planes import detrended_points

NEIGHBOURS = 8  # nearest points with which the height of a point is compared
ROUNDS = 4  # most rounds of spike removal: higher spikes hide others
PLATEAU = 5.0
"""Connected points of equal height beyond which a plateau is no rock: this times log10(points) / (1
- m)^2, with the share m of differences of one step; the largest of 3,200 walls had 0.65 times."""

CONTACT_STEP = 1.5
"""Rms step from zeros to their neighbours, over that between other neighbours, up to which zeros
are contacts. Of Gaussian fields that are cut at 0 it is below 1, and 1.2 without correlation."""


def stray_points(points: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Return which points (n, 3) belong to no wall: those in small patches, and far off in height.

    ``patch`` (n,) are the numbers of their patches. Far off is beyond 20 times the range between
    the quantiles of 1 and 99 %.
    """
    if len(points) < NEIGHBOURS:
        return np.zeros(len(points), bool)
    stray = _in_small_patches(patch)
    known = np.isfinite(points[:, 2]) & ~stray
    if known.sum() >= NEIGHBOURS:
        low, middle, high = np.percentile(points[known, 2], (1.0, 50.0, 99.0))
        if high > low:
            stray |= np.abs(points[:, 2] - middle) > 20.0 * (high - low)
    return stray


def patch_numbers(places: np.ndarray) -> np.ndarray:
    """Return the number (n,) of the patch to which each place (n, 2) belongs.

    Patches are apart by more than about five times the usual distance of places.
    """
    distances = scipy.spatial.cKDTree(places).query(places, k=2)[0][:, 1]
    if not (distances > 0.0).any():
        return np.zeros(len(places), int)
    size = 5.0 * float(np.median(distances[distances > 0.0]))
    cells, of_point = unique_places(np.floor(places / size))
    pairs = scipy.spatial.cKDTree(cells).query_pairs(1.5, p=np.inf, output_type="ndarray")
    return _components(pairs, len(cells))[of_point]


def _in_small_patches(patch: np.ndarray) -> np.ndarray:
    """Return which points (n,) are in patches of less than 1 % of all points, given patches (n,).

    The largest patch is never a small one.
    """
    members = np.bincount(patch)
    small = members < 0.01 * len(patch)
    small[members.argmax()] = False
    return small[patch]


def _components(pairs: np.ndarray, count: int) -> np.ndarray:
    """Return the connected component of each of ``count`` items, from pairs (m, 2)."""
    one, other = pairs.T
    links = scipy.sparse.coo_array((np.ones(len(pairs), bool), (one, other)), shape=(count, count))
    return scipy.sparse.csgraph.connected_components(links, directed=False)[1]


def unique_places(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the different places (m, 2) in order of x and y, and the number of each (n,)."""
    unique, numbers = np.unique(
        np.ascontiguousarray(places, dtype=float).view(complex).ravel(), return_inverse=True
    )
    return unique.view(float).reshape(-1, 2), numbers


def spike_heights(points: np.ndarray) -> np.ndarray:
    """Return heights (n,) [m] by which points (n, 3) exceed all neighbours but one; NaN for others.

    Only sharp ones count: beyond eight times the usual difference of neighbours.
    """
    found = np.full(len(points), np.nan)
    left = np.arange(len(points))
    for _ in range(ROUNDS):
        if len(left) <= NEIGHBOURS:
            break
        x, y, heights = points[left].T
        bare = detrended_points(x, y, heights)
        places = points[left, :2]
        near = scipy.spatial.cKDTree(places).query(places, k=NEIGHBOURS + 1)[1][:, 1:]
        around = np.sort(bare[near], axis=1)
        usual = np.median(np.abs(bare[near] - bare[:, None]))
        up = bare - around[:, -2]
        down = around[:, 1] - bare
        heights = np.where(up >= down, up, -down)
        sharp = np.abs(heights) > 8.0 * usual  # self-affine walls reach 2
        if not sharp.any():
            break
        found[left[sharp]] = heights[sharp]
        left = left[~sharp]
    return found


def remove_spikes(scan: Scan | Cloud) -> tuple[Scan | Cloud, str]:
    """Return a scan without its spikes, and a text that describes them, empty if there are none.

    Cells of a grid become missing.
    """
    points = points_of(scan)
    heights = spike_heights(points)
    cut = np.isfinite(heights)
    if not cut.any():
        return scan, ""
    highest = np.nanargmax(np.abs(heights))
    x, y = 1e3 * points[highest, :2]
    return _remove_points(scan, cut), (
        f"{int(cut.sum())} of {len(points)} points are spikes: they stand out from all but one of "
        f"their eight neighbours by {1e3 * np.nanmin(np.abs(heights)):.3g} mm or more, the "
        f"highest by {1e3 * heights[highest]:.3g} mm at (x, y) = ({x:.4g}, {y:.4g}) mm"
    )


def remove_plateaus(scan: Scan | Cloud) -> Scan | Cloud:
    """Return a scan without plateaus and planes that no rough wall has, with a remark on them.

    Where they are most of the scan, its wall is flat or stepped, and they are kept.
    """
    points = points_of(scan)
    pairs = neighbour_pairs(scan)
    size = _plateau_sizes(points[:, 2], pairs)
    touching = (points[:, 2] == 0.0) & zeros_are_contacts(points[:, 2], pairs)
    size[touching] = 0
    if isinstance(scan, Scan):
        of_planes = _plane_sizes(scan.heights)[np.isfinite(scan.heights)]
        size = np.maximum(size, np.where(touching, 0, of_planes))
    cut = size > 0
    if not cut.any():
        return scan
    largest = size.argmax()
    x, y, height = 1e3 * points[largest]
    message = (
        f"{int(cut.sum())} of {len(points)} heights lie in plateaus, of equal heights or of a "
        f"plane, the largest of {size[largest]} points with {height:.4g} mm at (x, y) = "
        f"({x:.4g}, {y:.4g}) mm"
    )
    if cut.mean() > 0.5:  # a flat or stepped wall
        done = "; they were used as heights"
    else:
        scan = _remove_points(scan, cut)
        done = ", as no rough wall has; they were treated as missing"
    return scan._replace(remarks=(*scan.remarks, caution(message + done)))


def zeros_are_contacts(heights: np.ndarray, pairs: np.ndarray) -> bool:
    """Return whether zeros among heights (n,) are contacts of an aperture map, by its steps.

    An aperture is nowhere negative, and its steps from contacts are about as large as those between
    other neighbours. Around zeros that stand for missing heights they are larger. ``pairs`` (m, 2)
    are neighbours.
    """
    if not (heights == 0.0).any() or heights.min() < 0.0:
        return False
    one, other = heights[pairs].T
    touching = (one == 0.0) != (other == 0.0)
    between = (one > 0.0) & (other > 0.0)
    if not (touching.any() and between.any()):
        return False
    squares = (one - other) ** 2
    return bool(squares[touching].mean() <= CONTACT_STEP**2 * squares[between].mean())


def neighbour_pairs(scan: Scan | Cloud) -> np.ndarray:
    """Return pairs (m, 2) of neighbours: along the axes of a grid, or the four nearest points."""
    if isinstance(scan, Cloud):
        places = scan.points[:, :2]
        near = scipy.spatial.cKDTree(places).query(places, k=min(5, len(places)))[1]
        return np.column_stack([np.repeat(near[:, 0], near.shape[1] - 1), near[:, 1:].ravel()])
    known = np.isfinite(scan.heights)
    number = np.where(known, np.cumsum(known).reshape(known.shape) - 1, -1)
    beside = [(number[1:], number[:-1]), (number[:, 1:], number[:, :-1])]
    pairs = np.concatenate([np.column_stack([one.ravel(), other.ravel()]) for one, other in beside])
    return pairs[(pairs >= 0).all(axis=1)]


def _plateau_sizes(heights: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return the number of points of the plateau of each point (n,), 0 for points in none.

    A plateau are connected points of equal height, more than `PLATEAU` allows. ``pairs`` (m, 2) are
    neighbours.
    """
    level = np.unique(heights, return_inverse=True)[1]
    steps = np.abs(np.diff(level[pairs], axis=1).ravel())
    of_one_step = float((steps == 1).sum()) / max(int((steps > 0).sum()), 1)
    plateau = _components(pairs[steps == 0], len(level))
    size = np.bincount(plateau)[plateau]
    largest = PLATEAU * np.log10(len(level)) / max(1.0 - of_one_step, 1e-9) ** 2
    return np.where(size > largest, size, 0)


def _plane_sizes(heights: np.ndarray) -> np.ndarray:
    """Return the number of cells of the plane patch of each cell (y, x) of a grid, 0 outside.

    Second differences are nearly 0 on a plane, inclined or not.
    """
    around = np.pad(heights, 1, constant_values=np.nan)
    along_y = np.diff(around[:, 1:-1], 2, axis=0)
    along_x = np.diff(around[1:-1], 2, axis=1)
    bend = np.maximum(np.abs(along_y), np.abs(along_x))
    usual = np.nanmedian(bend) if np.isfinite(bend).any() else 0.0
    level = bend <= 1e-3 * usual  # as on a plane
    patch = scipy.ndimage.label(level)[0]
    size = np.where(level, np.bincount(patch.ravel())[patch], 0)
    size *= size > PLATEAU * np.log10(heights.size)
    if usual == 0.0 or (level & (size == 0)).mean() > 0.05:  # heights are rounded coarsely
        return np.zeros_like(size)
    # the rim of a patch bends towards the wall around
    whole = scipy.ndimage.label(scipy.ndimage.binary_dilation(size > 0, np.ones((3, 3))))[0]
    return np.where(whole, np.bincount(whole.ravel())[whole], 0)


def _remove_points(scan: Scan | Cloud, cut: np.ndarray) -> Scan | Cloud:
    """Return a scan without the points ``cut``, bool in the order of `points_of`.

    Cells of a grid become missing.
    """
    if isinstance(scan, Cloud):
        return scan._replace(points=scan.points[~cut])
    left = scan.heights.copy()
    left[np.isfinite(left)] = np.where(cut, np.nan, left[np.isfinite(left)])
    return scan._replace(heights=left)

"""Plateaus and planes in a scan that no rough wall has, and zeros that are contacts."""

import numpy as np
import scipy

from jointclosure.inputs.remarks import caution
from jointclosure.walls.gridding import Cloud, Scan, points_of, without_points
from jointclosure.walls.neighbours import connected_parts, neighbour_pairs

PLATEAU = 5.0
"""Connected points of equal height beyond which a plateau is no rock: this times log10(points) / (1
- m)^2, with the share m of differences of one step; the largest of 3,200 walls had 0.65 times."""

CONTACT_STEP = 1.5
"""Rms step from zeros to their neighbours, over that between other neighbours, up to which zeros
are contacts. Gaussian fields that are cut at 0 have less than 1, and 1.2 without correlation."""


def remove_plateaus(scan: Scan | Cloud) -> Scan | Cloud:
    """Return a scan without plateaus and planes that no rough wall has, with a remark on them.

    Points of a `Cloud` are left out, and cells of a `Scan` become missing; the given scan is not
    changed. Plateaus are kept, with another remark, if they are most of the scan, because its wall
    is flat or stepped. Zeros that are contacts of an aperture map are no plateau. Planes are found
    in grids only.
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
        scan = without_points(scan, cut)
        done = ", as no rough wall has; they were treated as missing"
    return scan._replace(remarks=(*scan.remarks, caution(message + done)))


def zeros_are_contacts(heights: np.ndarray, pairs: np.ndarray) -> bool:
    """Return whether zeros among heights (n,) are contacts of an aperture map, by its steps.

    An aperture is nowhere negative, and its steps from contacts are about as large as steps between
    other neighbours. Steps around zeros that stand for missing heights are larger. ``pairs`` (m, 2)
    are neighbours (`jointclosure.walls.neighbours.neighbour_pairs`).
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


def _plateau_sizes(heights: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return the number of points of the plateau of each point (n,), 0 for points in none.

    A plateau consists of connected points of equal height, more than `PLATEAU` allows. ``heights``
    are (n,), and ``pairs`` (m, 2) are neighbours.
    """
    level = np.unique(heights, return_inverse=True)[1]
    steps = np.abs(np.diff(level[pairs], axis=1).ravel())
    of_one_step = float((steps == 1).sum()) / max(int((steps > 0).sum()), 1)
    plateau = connected_parts(pairs[steps == 0], len(level))
    size = np.bincount(plateau)[plateau]
    largest = PLATEAU * np.log10(len(level)) / max(1.0 - of_one_step, 1e-9) ** 2
    return np.where(size > largest, size, 0)


def _plane_sizes(heights: np.ndarray) -> np.ndarray:
    """Return the number of cells of the plane patch of each cell (y, x) of a grid, 0 outside.

    Second differences are nearly 0 on a plane, inclined or not. Heights that are rounded coarsely
    have no plane patches.
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

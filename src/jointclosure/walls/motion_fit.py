"""Fit of the motion that lays the upper wall on the lower one, by least squares of heights.

It begins with a rotation and a shift found by correlation. Walls are smoothed, less and less, and
the fit of the smoothing with the smallest standard errors is used, because this smoothing leaves
out the waves that do not mate.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.walls.motion import (
    Motion,
    levelling_rotation,
    rotated,
    rotation_matrix,
    spline_values,
)
from jointclosure.walls.rotation_search import LEAST_OVERLAP, SlopeFit
from jointclosure.walls.surfaces import Surface, gaussian_sums

# All constants were chosen. With them the errors of 40 pairs of known truth are those that
# docs/two_scans.md states (`python -m benchmarks.registration`).
FARTHEST = 0.25
"""Largest distance of the corners of the wall from where the fit by correlation places them, over
half of the longer side, at which a refined fit is believed."""
SIDE_OVER_WIDEST = 12.0  # shorter side of the walls over the largest width of smoothing
LEAST_WIDTHS = 20.0
"""Shorter side of a wall, in widths of the smoothing, from which errors of a fit are believed. On a
shorter side the tiles that give the errors are not independent, and errors are too small."""
LONG_WAVE_WIDTH = 4.0  # width of the means that hold the long waves, over that of the smoothing
LONG_WAVES_WORTH = 0.7
"""A fit with a separate term for long waves replaces one without if its error is below this many
times the error of the other."""
MOST_POINTS = 20_000  # largest number of points of the upper wall that are compared (about)
LEAST_POINTS = 50  # fewest points in the overlap with which a fit is made
ROUNDS = 40  # largest number of rounds of least squares
CONVERGED = 1e-7  # change of a place [cells] below which the rounds end
CAUCHY_SCALE = 3.5  # scale of the Cauchy weights, in medians of the absolute residual
ERROR_TILES = 6  # tiles along each axis, whose sums of gradients give the errors
LEAST_ERROR = 0.01
"""Error [cells] that interpolation leaves in each direction of the shift, and in the rotation at
the radius of gyration."""
_DIGITS = 9
"""Decimals of a rotation; a shift [m] has two more: rounded results are the same on any
processor."""


def refined_motion(upper: Surface, lower: Surface, flip: np.ndarray, fit: SlopeFit) -> Motion:
    """Return the motion of the upper wall, refined by least squares of heights.

    ``fit`` is the rotation and shift found by correlation, ``flip`` (3, 3) the matrix of its
    orientation. Walls are compared by Gaussian means over fewer and fewer cells, as a fit to short
    waves finds the right place only from nearby. The fit with the smallest standard errors is
    returned. If no fit is made or believed, the motion is that of ``fit``, with an infinite
    covariance.
    """
    turn = rotation_matrix(0.0, 0.0, math.radians(fit.angle)) @ flip
    rotation = levelling_rotation(lower.slopes).T @ turn @ levelling_rotation(upper.slopes)
    place = lower.middle + np.append(fit.shift, 0.0)
    start = best = Motion(flip, rotation, upper.middle, place, np.full((3, 3), np.inf))
    error = math.inf
    side = min(*upper.heights.shape, *lower.heights.shape)
    reach = 0.5 * upper.spacing * np.array(upper.heights.shape[::-1])
    widest = int(math.log2(max(side / SIDE_OVER_WIDEST, 1.0)))
    for smoothing in 2.0 ** np.arange(widest, -1, -1):
        for long_waves in (False, True)[: 2 if smoothing == 1.0 else 1]:
            refined = _least_squares_fit(upper, lower, best, smoothing, long_waves)
            if refined is None or refined[0].corner_distance(start, reach) > FARTHEST * reach.max():
                continue
            motion, its_error = refined
            worth = LONG_WAVES_WORTH if long_waves else 1.0
            if its_error < worth * error or not math.isfinite(error):
                best = motion
                # without tiles that are independent the fit is only a start for the next one
                error = its_error if smoothing <= side / LEAST_WIDTHS else math.inf
    return best


class _SmoothedWall(NamedTuple):
    """Smoothed heights and slopes of the lower wall, prepared for interpolation between cells."""

    spline: np.ndarray  # coefficients (y, x) of the cubic spline through its heights
    slopes: Sequence[np.ndarray]  # along y and along x (y, x)
    known: np.ndarray  # 1 where a height is known, else 0 (y, x)
    low: np.ndarray  # place (x, y) of the first cell [m]
    spacing: float  # [m]

    def cells_at(self, points: np.ndarray) -> np.ndarray:
        """Return the places (2, n), y before x, of points (n, 3) [m] in cells of the grid."""
        return ((points[:, :2] - self.low) / self.spacing).T[::-1]

    def knows(self, cells: np.ndarray) -> np.ndarray:
        """Return for places (2, n) [cells] whether all heights around them are known."""
        return scipy.ndimage.map_coordinates(self.known, cells, order=1) > 0.999

    def normals_at(self, cells: np.ndarray) -> np.ndarray:
        """Return normals (n, 3) of the wall at places (2, n) [cells], with a z component of 1."""
        along_y, along_x = (
            scipy.ndimage.map_coordinates(slope, cells, order=1) for slope in self.slopes
        )
        return np.stack([-along_x, -along_y, np.ones(cells.shape[1])], axis=1)


def _smoothed_wall(wall: Surface, heights: np.ndarray) -> _SmoothedWall:
    """Return smoothed heights (y, x) [m] of a wall, prepared for interpolation between cells.

    Missing heights are replaced by the mean; `_SmoothedWall.knows` tells where.
    """
    known = np.isfinite(heights)
    bare = np.where(known, heights, np.nanmean(heights))
    slopes = tuple(np.gradient(bare, wall.spacing))
    spline = scipy.ndimage.spline_filter(bare)
    return _SmoothedWall(spline, slopes, known.astype(float), wall.low, wall.spacing)


def _least_squares_fit(
    upper: Surface, lower: Surface, start: Motion, smoothing: float, long_waves: bool
) -> tuple[Motion, float] | None:
    """Find the motion by which the smoothed upper wall differs least from the smoothed lower wall.

    Unknowns are a small rotation (times the radius of gyration [m]) and a shift [m], added to the
    motion ``start``. They are found by Gauss-Newton iteration, with three changes. Residuals have
    the weights of a Cauchy distribution, renewed in each round (iteratively reweighted least
    squares), so that parts that do not mate count less. The first round sets the median residual to
    0 by a shift along z. A step is at most twice the width of the smoothing, as slopes of the wall
    are about constant only so far. ``smoothing`` is the width of the means [cells]. With
    ``long_waves`` the long waves have a term of their own (`_normal_equations`).

    Returns
    -------
    motion : Motion
        The fitted motion, with the covariance of its rotation and shift in the plane.
    error : float
        Standard error [m] of a place at the radius of gyration.

    None is returned in place of both if too little of the walls overlaps.
    """
    fine = upper.smoothed(smoothing)
    heights = lower.smoothed(smoothing)
    # cells from one used point to the next: half a width of the smoothing, or more for many cells
    step = max(math.ceil(math.sqrt(fine.size / MOST_POINTS)), int(0.5 * smoothing))
    listed = np.isfinite(fine[::step, ::step])
    row, column = step * np.array(np.nonzero(listed))
    xy = upper.low + upper.spacing * np.stack([column, row], axis=-1)
    points = np.column_stack([xy, fine[row, column]])
    least = LEAST_OVERLAP * 0.5 * min(len(points), np.isfinite(heights).sum() / step**2)
    if least < LEAST_POINTS:
        return None
    wall = _smoothed_wall(lower, heights)
    arms = rotated(start.rotation, points - start.middle)
    radius = float(np.sqrt(np.mean(arms[:, 0] ** 2 + arms[:, 1] ** 2)))  # of gyration
    change = math.inf
    x = np.zeros(6)  # rotation vector times radius [m], shift [m]
    for _ in range(ROUNDS):
        turned = rotated(rotation_matrix(*x[:3] / radius), arms)
        at = turned + start.place + x[3:]
        places = wall.cells_at(at)
        inside = wall.knows(places)
        if inside.sum() < least:
            return None
        used = listed.copy()
        used[listed] = inside
        places = places[:, inside]
        turned = turned[inside]
        residual = at[inside, 2] - spline_values(wall.spline, places)
        if change == math.inf:
            x[5] = -np.median(residual)
            residual = residual - np.median(residual)
        normal = wall.normals_at(places)
        columns = np.column_stack([np.cross(turned, normal) / radius, normal, residual])
        width = LONG_WAVE_WIDTH * smoothing / step if long_waves else None
        gradients, inverse = _normal_equations(columns, used, width)
        if change < CONVERGED * lower.spacing:
            break
        taken = -inverse @ gradients.sum(axis=0)
        taken *= min(1.0, 2.0 * smoothing * lower.spacing / np.abs(taken).max())
        x = x + taken
        change = np.abs(taken).max()
    covariance = _motion_covariance(gradients, inverse, places, radius, lower.spacing)
    rotation = rotation_matrix(*x[:3] / radius) @ start.rotation
    rotation = np.round(rotation, _DIGITS)
    place = np.round(start.place + x[3:], _DIGITS + 2)
    error = math.sqrt(covariance[0, 0] * radius**2 + covariance[1, 1] + covariance[2, 2])
    return Motion(start.flip, rotation, start.middle, place, covariance), error


def _normal_equations(
    columns: np.ndarray, used: np.ndarray, width: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the gradients (n, 6) of the points, and the inverse (6, 6) of the normal equations.

    ``columns`` (n, 7) are the derivatives of the residual with respect to rotation and shift, and
    the residual [m], at the ``used`` nodes of a grid (y, x). A residual over `CAUCHY_SCALE` times
    the median size of residuals is r, and has the weight 1 / (1 + r^2). With a ``width`` [nodes]
    residuals are split into Gaussian means over this width, and the rest. Only the rest is weighted
    in this way. The means are divided by `LONG_WAVE_WIDTH` times their own median size, so that
    long waves count even if their residuals are small beside those of short waves.
    """
    low = np.zeros_like(columns)
    if width is not None:
        low = _wide_means(columns, used, width)
    high = columns - low
    # 1e-12 m: no division by 0 where walls fit exactly
    low /= LONG_WAVE_WIDTH * np.median(np.abs(low[:, 6])) + 1e-12
    high /= CAUCHY_SCALE * np.median(np.abs(high[:, 6])) + 1e-12
    weighted = high / (1.0 + high[:, 6:] ** 2)
    inverse = np.linalg.pinv(weighted[:, :6].T @ high[:, :6] + low[:, :6].T @ low[:, :6])
    gradients = weighted[:, :6] * high[:, 6:] + low[:, :6] * low[:, 6:]
    return gradients, inverse


def _motion_covariance(
    gradients: np.ndarray, inverse: np.ndarray, places: np.ndarray, radius: float, spacing: float
) -> np.ndarray:
    """Return the covariance (3, 3) of the rotation about z [rad] and the shift (x, y) [m] of a fit.

    ``gradients`` (n, 6) and ``inverse`` (6, 6) are those of `_normal_equations`, ``places`` (2, n)
    those of the points, ``radius`` [m] is that of gyration, and ``spacing`` [m] that of the lower
    wall. Errors of interpolation (`LEAST_ERROR`) are added.
    """
    covariance = _tiled_covariance(gradients, inverse, places)
    scaled = np.diag([1.0 / radius] * 3 + [1.0] * 3)
    covariance = (scaled @ covariance @ scaled)[2:5, 2:5]
    least_error = LEAST_ERROR * spacing
    return covariance + np.diag([least_error / radius, least_error, least_error]) ** 2


def _wide_means(columns: np.ndarray, used: np.ndarray, width: float) -> np.ndarray:
    """Return Gaussian means (n, k) of columns (n, k) over the ``used`` nodes of a grid (y, x).

    ``width`` is their standard deviation [nodes].
    """
    weight = gaussian_sums(used.astype(float), width, 2.5)[used]
    means = np.empty_like(columns)
    field = np.zeros(used.shape)
    for number, values in enumerate(columns.T):
        field[used] = values
        means[:, number] = gaussian_sums(field, width, 2.5)[used] / weight
    return means


def _tiled_covariance(gradients: np.ndarray, inverse: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the covariance (6, 6) of the six fitted parameters from gradients (n, 6) of points.

    It is that of the sandwich estimator, inverse * sum(s s^T) * inverse. The s are the sums of the
    gradients in each of `ERROR_TILES` x `ERROR_TILES` tiles, over which the ``places`` (2, n) are
    divided, because neighbouring points have no independent errors. For k tiles with points there
    is a factor k / (k - 6).
    """
    low = places.min(axis=1, keepdims=True)
    high = places.max(axis=1, keepdims=True)
    row, column = np.minimum((places - low) / (high - low) * ERROR_TILES, ERROR_TILES - 1).astype(
        int
    )
    sums = np.stack(
        [np.bincount(row * ERROR_TILES + column, g, ERROR_TILES**2) for g in gradients.T]
    )
    count = int((np.abs(sums).sum(axis=0) > 0.0).sum())
    return inverse @ (sums @ sums.T) @ inverse * count / max(count - 6, 1)

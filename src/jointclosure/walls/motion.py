"""Rigid motion that lays the scan of one wall on that of the other, in six degrees of freedom.

Rotations over the full circle are compared by the correlation of slopes over all shifts. Least
squares follow on walls that are smoothed less and less; the smoothing with the smallest standard
errors is used, because it leaves out waves that do not mate.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.walls.gridding import Scan
from jointclosure.walls.mating import slope_correlations
from jointclosure.walls.missing_heights import fill_dropouts, fill_with_nearest, in_holes
from jointclosure.walls.surfaces import Surface, gaussian_sums

# All constants were chosen. With them the errors of 40 pairs of known truth are those that
# docs/two_scans.md states (`python -m benchmarks.registration`).
LEAST_OVERLAP = 0.5  # least share of the smaller wall that overlaps; other shifts are not tried
BLOCKS = (48, 24)
"""Blocks along the shorter side on which rotations are compared; the second if no fit is clear."""
ROTATION_STEP = 3.0  # between the rotations that are compared [degrees]
DIFFERENT_ROTATIONS = 10.0  # least difference of two rotations that count as two fits [degrees]
CLEAR = 1.25  # ratio of the best correlation of slopes to the second from which a fit is clear
FARTHEST = 0.25
"""Largest distance of the corners from the fit on blocks, over half of the longer side, at which a
refined fit is believed."""
SIDE_OVER_WIDEST = 12.0  # shorter side over the width of the first means
LEAST_WIDTHS = 20.0
"""Shorter side of a wall, in widths of the means, from which errors of a fit are believed. On a
shorter side the tiles that give the errors are not independent, and errors are too small."""
LONG_WAVE_WIDTH = 4.0  # width of the means that hold the long waves, over that of the smoothing
LONG_WAVES_WORTH = 0.7
"""Ratio of the errors of fits with and without weights for long waves, below which the first is
used."""
MOST_POINTS = 20_000  # of the upper wall that least squares compare
LEAST_POINTS = 50  # within the overlap, below which no fit is made
ROUNDS = 40  # most rounds of least squares
CONVERGED = 1e-7  # change of a place [cells] below which they end
CAUCHY_SCALE = 3.5  # scale of the Cauchy weights, in medians of the absolute residual
ERROR_TILES = 6  # tiles along each axis, whose sums give the errors
LEAST_ERROR = 0.01  # [cells] left by interpolation, in each direction and at the radius of gyration
_DIGITS = 9
"""Decimals of a rotation; a shift [m] has two more: rounded results are the same on any
processor."""
_INVERSIONS = 8  # rounds in which the height at a node of a tilted wall is found


class Motion(NamedTuple):
    """Rigid motion of a wall: rotation about a middle that comes to lie at a place."""

    flip: np.ndarray  # reflection (3, 3) of an orientation, which is a part of ``rotation``
    rotation: np.ndarray  # (3, 3), a reflection too where the flip is one
    middle: np.ndarray  # (x, y, z) [m]
    place: np.ndarray  # (x, y, z) [m]
    covariance: np.ndarray  # (3, 3) of the rotation about the normal [rad] and the shift (x, y) [m]

    def moved(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) [m] after the motion."""
        return _rotated(self.rotation, points - self.middle) + self.place

    def moved_back(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) [m] before the motion."""
        return _rotated(self.rotation.T, points - self.place) + self.middle

    def after(self, first: "Motion") -> "Motion":
        """Return the motion that is ``first`` and then this one, with the errors of this one."""
        flip = self.flip @ first.flip
        rotation = self.rotation @ first.rotation
        return Motion(flip, rotation, first.moved_back(self.middle), self.place, self.covariance)

    @property
    def angle(self) -> float:
        """Rotation in the plane [degrees], anticlockwise, from -180 to 180."""
        turn = self.rotation @ self.flip
        return math.degrees(math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))

    @property
    def tilt(self) -> float:
        """Inclination by which the wall was tilted [degrees]."""
        return math.degrees(math.acos(min(abs(self.rotation[2, 2]), 1.0)))

    def corner_distance(self, other: "Motion", reach: np.ndarray) -> float:
        """Return the largest distance [m] in the plan of the same corner after two motions.

        ``reach`` (x, y) [m] is half of the sides of the wall.
        """
        corners = np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
        points = self.middle + corners * [*reach, 0.0]
        between = self.moved(points) - other.moved(points)
        return float(np.hypot(between[:, 0], between[:, 1]).max())

    def difference_to(self, other: "Motion") -> np.ndarray:
        """Return the rotation [rad] and the shift of the middle (x, y) [m] to another motion."""
        turn = other.rotation @ self.rotation.T
        shift = other.place - self.moved(other.middle)
        return np.array([0.5 * (turn[1, 0] - turn[0, 1]), shift[0], shift[1]])

    def corner_error(self, reach: np.ndarray) -> float:
        """Return the standard error [m] in the plan of a corner, at half of the sides ``reach``."""
        angle, x, y = np.diag(self.covariance)
        return math.sqrt(angle * float(reach @ reach) + x + y)

    def standard_errors(self) -> tuple[float, float, float]:
        """Return the standard errors of angle [degrees] and shift (x, y) [m]."""
        angle, x, y = np.sqrt(np.diag(self.covariance)).tolist()
        return math.degrees(angle), x, y

    def record(self) -> dict[str, float | list[float]]:
        """Return angle and shift with their standard errors, for JSON."""
        angle, *errors = self.standard_errors()
        return {
            "rotation_degrees": self.angle,
            "rotation_error_degrees": angle,
            "tilt_degrees": self.tilt,
            "shift_mm_x_y": (1e3 * (self.place - self.middle)[:2]).tolist(),
            "shift_error_mm_x_y": [1e3 * error for error in errors],
        }

    def __str__(self) -> str:
        angle, *errors = self.standard_errors()
        shift = self.place - self.middle
        x, y = (f"{1e3 * d:.4f} +- {1e3 * e:.4f}" for d, e in zip(shift, errors, strict=False))
        return (
            f"turned by {self.angle:.3f} +- {angle:.3f} degrees in its plane and tilted by "
            f"{self.tilt:.2f} degrees (to which the inclinations of both scans to the plane of the "
            f"scanner contribute), its middle moved by ({x}, {y}) mm along (x, y), with "
            "standard errors"
        )


def flip_about_middle(points: np.ndarray, flip: np.ndarray) -> Motion:
    """Return the motion that only flips points (n, 3) [m] by an orientation, about their middle."""
    middle = np.append(0.5 * (points[:, :2].min(axis=0) + points[:, :2].max(axis=0)), 0.0)
    return Motion(flip, flip, middle, middle, np.zeros((3, 3)))


def laid_on_nodes(motion: Motion, scan: Scan, low: np.ndarray, most: float) -> Motion:
    """Return a motion displaced so that nodes of the moved grid lie on those of another grid.

    The other grid has a node at ``low`` (x, y) [m]. The motion is returned as it is if the grids
    are turned against each other, or a corner would move by more than ``most`` [m].
    """
    whole = np.rint(motion.rotation)
    if (np.abs(whole[:2]).sum(axis=1) != 1.0).any() or abs(whole[2, 2]) != 1.0:
        return motion
    steps = np.array(scan.spacing[::-1])
    first = np.array((scan.origin or (0.0, 0.0))[::-1])
    bare = motion._replace(rotation=whole)
    node = bare.moved_back(np.array([*low, motion.place[2]]))[:2]
    off = first + steps * np.rint((node - first) / steps) - node
    snapped = bare._replace(place=motion.place - _rotated(whole, np.append(off, 0.0)))
    reach = 0.5 * steps * (np.array(scan.heights.shape[::-1]) - 1.0)
    return snapped if motion.corner_distance(snapped, reach) <= most else motion


def moved_heights(
    scan: Scan, motion: Motion, slopes: tuple[float, float] = (0.0, 0.0)
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function of nodes (..., 2) [m]: heights of a moved grid by cubic splines, or NaN.

    ``slopes`` along x and y are those of the scan's mean plane, with which heights of steep scans
    are found.
    """
    holes = in_holes(np.isfinite(scan.heights))
    whole = fill_dropouts(scan.heights, holes)
    missing = (~np.isfinite(whole)).astype(float)
    spline = scipy.ndimage.spline_filter(fill_with_nearest(whole))
    first = np.array(scan.origin or (0.0, 0.0))
    steps = np.array(scan.spacing)
    back = motion.rotation[2]  # direction of the new z before the motion
    rise = back[2] - slopes[0] * back[0] - slopes[1] * back[1]

    def heights_at(nodes: np.ndarray) -> np.ndarray:
        """Find heights (...) [m] at nodes (..., 2): Newton's method with the slope of the plane."""
        points = np.concatenate([nodes, np.full((*nodes.shape[:-1], 1), motion.place[2])], axis=-1)
        for _ in range(_INVERSIONS):
            before = motion.moved_back(points)
            # rounded, so that nodes of both grids meet
            places = np.moveaxis(np.round((before[..., 1::-1] - first) / steps, 6), -1, 0)
            heights = _spline_values(spline, places)
            points[..., 2] += (heights - before[..., 2]) / rise
        lost = scipy.ndimage.map_coordinates(missing, places, order=1, cval=1.0)
        return np.where(lost > 1e-6, np.nan, points[..., 2])

    return heights_at


def _spline_values(spline: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the values of a cubic spline of coefficients ``spline`` at places (2, ...) [cells].

    The places are y, then x; the coefficients are those of `scipy.ndimage.spline_filter`.
    """
    return scipy.ndimage.map_coordinates(spline, places, prefilter=False, mode="mirror")


def _rotated(rotation: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points (..., 3) multiplied by a matrix, with the same bits on any processor."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in rotation], axis=-1)


def _rotation_matrix(*vector: float) -> np.ndarray:
    """Return the matrix (3, 3) of a rotation vector [rad]."""
    return scipy.spatial.transform.Rotation.from_rotvec(vector).as_matrix()


def levelling_rotation(slopes: tuple[float, float]) -> np.ndarray:
    """Return the smallest rotation that makes a plane of given slopes horizontal."""
    length = math.hypot(*slopes)
    angle = math.atan(length) / length if length > 0.0 else 0.0
    return _rotation_matrix(angle * -slopes[1], angle * slopes[0], 0.0)


class SlopeFit(NamedTuple):
    """Rotation [degrees] and shift (x, y) [m] of the upper wall with the best slope correlation."""

    orientation: str
    correlation: float
    angle: float
    shift: np.ndarray

    def differs_from(self, other: "SlopeFit") -> bool:
        """Return whether orientations differ, or angles by more than `DIFFERENT_ROTATIONS`."""
        return self.turned_from(other) > DIFFERENT_ROTATIONS

    def turned_from(self, other: "SlopeFit") -> float:
        """Return the difference of the angles [degrees], infinite for another orientation."""
        if self.orientation != other.orientation:
            return math.inf
        return abs((self.angle - other.angle + 180.0) % 360.0 - 180.0)

    def __str__(self) -> str:
        angle = self.angle - 360.0 if self.angle > 180.0 else self.angle  # as that of a motion
        return f"{self.orientation} {self.correlation:.2f} at {angle:g} degrees"


def _blocks(wall: np.ndarray, cells: int) -> np.ndarray:
    """Return means of the known heights in blocks of cells, NaN for blocks without any."""
    ny, nx = (size // cells for size in wall.shape)
    blocks = wall[: ny * cells, : nx * cells].reshape(ny, cells, nx, cells)
    known = np.isfinite(blocks).sum(axis=(1, 3))
    return np.where(known > 0, np.nansum(blocks, axis=(1, 3)) / np.maximum(known, 1), np.nan)


def compare_rotations(
    upper: Surface, lower: Surface, orientations: dict[str, np.ndarray], blocks: int
) -> list[SlopeFit]:
    """Return the best fit at each rotation and orientation of the upper wall, the best one first.

    There are ``blocks`` along the shorter side. Orientations change signs of x, y and z. Those of
    one plan differ by the sign of the heights, and correlate by opposite numbers, so that only two
    plans are compared: as scanned, and mirrored. Raise `InputError` if a comparison has too few
    heights.
    """
    cells = max(min(*upper.heights.shape, *lower.heights.shape) // blocks, 1)
    fixed, bare = (_blocks(s.heights - s.plane, cells) for s in (lower, upper))
    bare = bare - np.nanmean(bare)
    side = math.ceil(math.hypot(*bare.shape)) + 1
    y, x = np.indices((side, side)) - 0.5 * (side - 1)
    offset = 0.5 * (np.array(fixed.shape) - 1.0) - 0.5 * (side - 1)
    correlations = slope_correlations(fixed, (side, side), LEAST_OVERLAP)
    plans = {
        _is_mirrored(flip): np.diag([1.0, flip[0, 0] * flip[1, 1], 1.0])
        for flip in orientations.values()
    }
    angles = np.arange(0.0, 360.0, ROTATION_STEP)
    fits = {}
    for (mirrored, plan), angle in itertools.product(plans.items(), angles):
        turn = _rotation_matrix(0.0, 0.0, math.radians(angle)) @ plan
        places = [turn[0, k] * x + turn[1, k] * y + 0.5 * (bare.shape[1 - k] - 1) for k in (1, 0)]
        moved = scipy.ndimage.map_coordinates(bare, places, order=1, cval=np.nan)
        over = correlations(moved)
        if not np.isfinite(over).any():
            raise InputError("the scans have too few heights for a comparison")
        for name, flip in orientations.items():
            if _is_mirrored(flip) == mirrored:
                correlation, shift = _best_shift(flip[2, 2] * over)
                # a wall mirrored along x is one mirrored along y that is turned by half a circle
                turned = float(angle + (180.0 if flip[0, 0] < 0.0 else 0.0)) % 360.0
                between = cells * upper.spacing * (shift - offset)
                fits[name, turned] = SlopeFit(name, correlation, turned, between[::-1])
    in_order = [fits[place] for place in itertools.product(orientations, angles)]
    return sorted(in_order, key=lambda fit: -fit.correlation)


def _is_mirrored(flip: np.ndarray) -> bool:
    """Return whether a matrix (3, 3) that changes signs of axes mirrors the plan (x, y)."""
    return bool(flip[0, 0] * flip[1, 1] < 0.0)


def _best_shift(correlations: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the largest of `slope_correlations` (y, x), and its shift (2,) in cells."""
    place = np.unravel_index(int(np.nanargmax(correlations)), correlations.shape)
    shift = [i - n if i > n // 2 else i for i, n in zip(place, correlations.shape, strict=True)]
    return float(correlations[place]), np.array(shift, float)


def refined_motion(upper: Surface, lower: Surface, flip: np.ndarray, fit: SlopeFit) -> Motion:
    """Refine a fit by least squares of heights; the covariance is infinite if they find nothing.

    Walls are compared by means over fewer and fewer cells, as a fit to short waves finds the right
    place only from nearby. The fit with the smallest standard errors is returned, as it leaves out
    waves that do not mate.
    """
    turn = _rotation_matrix(0.0, 0.0, math.radians(fit.angle)) @ flip
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
    """Smoothed heights and slopes of the lower wall, which are interpolated between its cells."""

    spline: np.ndarray  # coefficients (y, x) of the cubic spline through its heights
    slopes: Sequence[np.ndarray]  # along y and along x (y, x)
    known: np.ndarray  # 1 where a height is known, else 0 (y, x)
    low: np.ndarray  # place (x, y) of the first cell [m]
    spacing: float  # [m]

    def cells_at(self, points: np.ndarray) -> np.ndarray:
        """Return places (2, n) in cells (y, x) of points (n, 3) [m]."""
        return ((points[:, :2] - self.low) / self.spacing).T[::-1]

    def knows(self, cells: np.ndarray) -> np.ndarray:
        """Return whether all heights around places (2, n) are known."""
        return scipy.ndimage.map_coordinates(self.known, cells, order=1) > 0.999

    def normals_at(self, cells: np.ndarray) -> np.ndarray:
        """Return vectors (n, 3) normal to the wall at places (2, n), with a z component of 1."""
        along_y, along_x = (
            scipy.ndimage.map_coordinates(slope, cells, order=1) for slope in self.slopes
        )
        return np.stack([-along_x, -along_y, np.ones(cells.shape[1])], axis=1)


def _smoothed_wall(wall: Surface, heights: np.ndarray) -> _SmoothedWall:
    """Prepare smoothed heights (y, x) [m] for interpolation; missing ones are their mean."""
    known = np.isfinite(heights)
    bare = np.where(known, heights, np.nanmean(heights))
    slopes = tuple(np.gradient(bare, wall.spacing))
    spline = scipy.ndimage.spline_filter(bare)
    return _SmoothedWall(spline, slopes, known.astype(float), wall.low, wall.spacing)


def _least_squares_fit(
    upper: Surface, lower: Surface, start: Motion, smoothing: float, long_waves: bool
) -> tuple[Motion, float] | None:
    """Move the smoothed upper wall to where its heights differ least from those of the lower one.

    Gauss-Newton iteration for a small rotation (times the radius of gyration [m]) and a shift [m]
    from ``start``. It differs from the textbook's in three ways. Residuals have the weights of a
    Cauchy distribution, renewed in each round (iteratively reweighted least squares), so that parts
    that do not mate count less. The first round sets the median residual to 0 by a shift along z. A
    step is at most twice the width of the smoothing, as slopes are those of the place no farther
    away. With ``long_waves`` the long waves have a term of their own (`_normal_equations`).

    Returns
    -------
    motion : Motion
        With the covariance of its rotation and shift in the plane.
    error : float
        Standard error [m] of a place at the radius of gyration.

    None is returned if too little of the walls overlaps.
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
    arms = _rotated(start.rotation, points - start.middle)
    radius = float(np.sqrt(np.mean(arms[:, 0] ** 2 + arms[:, 1] ** 2)))  # of gyration
    change = math.inf
    x = np.zeros(6)  # rotation vector times radius [m], shift [m]
    for _ in range(ROUNDS):
        turned = _rotated(_rotation_matrix(*x[:3] / radius), arms)
        at = turned + start.place + x[3:]
        places = wall.cells_at(at)
        inside = wall.knows(places)
        if inside.sum() < least:
            return None
        used = listed.copy()
        used[listed] = inside
        places = places[:, inside]
        turned = turned[inside]
        residual = at[inside, 2] - _spline_values(wall.spline, places)
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
    rotation = _rotation_matrix(*x[:3] / radius) @ start.rotation
    rotation = np.round(rotation, _DIGITS)
    place = np.round(start.place + x[3:], _DIGITS + 2)
    error = math.sqrt(covariance[0, 0] * radius**2 + covariance[1, 1] + covariance[2, 2])
    return Motion(start.flip, rotation, start.middle, place, covariance), error


def _normal_equations(
    columns: np.ndarray, used: np.ndarray, width: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the gradient (n, 6) of each point, and the inverse (6, 6) of the normal equations.

    ``columns`` (n, 7) are the derivatives of the residual with respect to rotation and shift, and
    the residual [m], at the ``used`` nodes of a grid (y, x). Residuals are divided by
    `CAUCHY_SCALE` times their median size and have the weights 1 / (1 + r^2). With a ``width``
    [nodes] they are split into Gaussian means over this width and the rest. Only the rest has these
    weights; the means are divided by `LONG_WAVE_WIDTH` times their own median size, so that long
    waves count however small their residuals are beside those of short ones.
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

    ``radius`` [m] is that of gyration. Errors of interpolation (`LEAST_ERROR`) are added.
    """
    covariance = _tiled_covariance(gradients, inverse, places)
    scaled = np.diag([1.0 / radius] * 3 + [1.0] * 3)
    covariance = (scaled @ covariance @ scaled)[2:5, 2:5]
    least_error = LEAST_ERROR * spacing
    return covariance + np.diag([least_error / radius, least_error, least_error]) ** 2


def _wide_means(columns: np.ndarray, used: np.ndarray, width: float) -> np.ndarray:
    """Return Gaussian means of columns (n, k) over the used points of a grid (y, x)."""
    weight = gaussian_sums(used.astype(float), width, 2.5)[used]
    means = np.empty_like(columns)
    field = np.zeros(used.shape)
    for number, values in enumerate(columns.T):
        field[used] = values
        means[:, number] = gaussian_sums(field, width, 2.5)[used] / weight
    return means


def _tiled_covariance(gradients: np.ndarray, inverse: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the covariance (6, 6) of a fit by its gradients (n, 6) at places (2, n).

    It is that of the sandwich estimator, inverse * sum(s s^T) * inverse, with gradients summed in
    `ERROR_TILES` x `ERROR_TILES` tiles, as neighbouring points have no independent errors, and with
    the factor n / (n - 6) for the tiles and the fitted parameters.
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

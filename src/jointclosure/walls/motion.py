"""Rigid motion that lays the scan of one wall on that of the other, in six degrees of freedom.

Rotations over the full circle are compared by the correlation of slopes over all shifts. Least
squares follow on walls that are smoothed less and less; the smoothing with the smallest standard
errors is used, because it leaves out waves that do not mate.
"""

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.walls import gridding
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.mating import slope_correlations
from jointclosure.walls.roughness import plane_through

LEAST_OVERLAP = 0.5  # least share of the smaller wall that overlaps; other shifts are not tried
BLOCKS = (48, 24)  # blocks along the shorter side for rotations; the second if the fit is unclear
STEP, APART = 3.0, 10.0  # step of rotations, and least difference of different ones [degrees]
CLEAR = 1.25  # ratio of the best correlation of slopes to the second from which a fit is clear
FARTHEST = 0.25  # largest distance of corners from the fit on blocks, over half of the longer side
KNOWN = 0.9  # smallest weight of known heights in a mean
WIDTHS = 20.0  # smallest side of a wall, in widths of the means, for which a fit is kept
WIDE = 4.0  # width of the means whose waves are compared apart, over that of the smoothing
WORTH = 0.7  # ratio of errors below which the fit with wide means apart is used
MOST_POINTS, ROUNDS = 20_000, 40  # most points of the upper wall, and rounds of least squares
CAUCHY = 3.5  # scale of the weights over the median residual
TILES = 6  # tiles along each axis, whose sums give the errors
LEAST_ERROR = 0.01  # [cells] left by interpolation, in each direction and at the radius of gyration
_DIGITS = 9  # decimals of a rotation, two less than of a shift [m]: same on any processor
_INVERSIONS = 8  # rounds in which the height at a node of a tilted wall is found


class Motion(NamedTuple):
    """Rigid motion of a wall: rotation about a middle that comes to lie at a place."""

    flip: np.ndarray  # reflection (3, 3) of an orientation, which comes first
    rotation: np.ndarray  # (3, 3)
    middle: np.ndarray  # (x, y, z) [m]
    place: np.ndarray  # (x, y, z) [m]
    covariance: np.ndarray  # (3, 3) of the rotation about the normal [rad] and the shift (x, y) [m]

    def forth(self, points: np.ndarray) -> np.ndarray:
        """Move points (..., 3)."""
        return _turned(self.rotation, points - self.middle) + self.place

    def back(self, points: np.ndarray) -> np.ndarray:
        """Move points (..., 3) back."""
        return _turned(self.rotation.T, points - self.place) + self.middle

    def after(self, first: "Motion") -> "Motion":
        """Return this motion after a first one; its errors are those of this one."""
        flip, rotation = self.flip @ first.flip, self.rotation @ first.rotation
        return Motion(flip, rotation, first.back(self.middle), self.place, self.covariance)

    @property
    def angle(self) -> float:
        """Rotation in the plane [degrees], anticlockwise, from -180 to 180."""
        turn = self.rotation @ self.flip
        return math.degrees(math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))

    @property
    def tilt(self) -> float:
        """Inclination by which the wall was tilted [degrees]."""
        return math.degrees(math.acos(min(abs(self.rotation[2, 2]), 1.0)))

    def apart(self, other: "Motion", reach: np.ndarray) -> float:
        """Return the largest distance in the plan of the corners after two motions [m]."""
        corners = np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
        points = self.middle + corners * [*reach, 0.0]
        between = self.forth(points) - other.forth(points)
        return float(np.hypot(between[:, 0], between[:, 1]).max())

    def until(self, other: "Motion") -> np.ndarray:
        """Return the rotation [rad] and the shift of the middle (x, y) [m] to another motion."""
        turn = other.rotation @ self.rotation.T
        shift = other.place - self.forth(other.middle)
        return np.array([0.5 * (turn[1, 0] - turn[0, 1]), shift[0], shift[1]])

    def error(self, reach: np.ndarray) -> float:
        """Return the standard error in the plan of the corners [m]."""
        angle, x, y = np.diag(self.covariance)
        return math.sqrt(angle * float(reach @ reach) + x + y)

    def errors(self) -> tuple[float, float, float]:
        """Return the standard errors of angle [degrees] and shift (x, y) [m]."""
        angle, x, y = np.sqrt(np.diag(self.covariance)).tolist()
        return math.degrees(angle), x, y

    def record(self) -> dict[str, float | list[float]]:
        """Return angle and shift with their standard errors, for JSON."""
        angle, *errors = self.errors()
        return {
            "rotation_degrees": self.angle,
            "rotation_error_degrees": angle,
            "tilt_degrees": self.tilt,
            "shift_mm_x_y": (1e3 * (self.place - self.middle)[:2]).tolist(),
            "shift_error_mm_x_y": [1e3 * error for error in errors],
        }

    def __str__(self) -> str:
        angle, *errors = self.errors()
        shift = self.place - self.middle
        x, y = (f"{1e3 * d:.4f} +- {1e3 * e:.4f}" for d, e in zip(shift, errors, strict=False))
        return (
            f"turned by {self.angle:.3f} +- {angle:.3f} degrees in its plane and tilted by "
            f"{self.tilt:.2f} degrees, its middle moved by ({x}, {y}) mm along (x, y)"
        )


def unmoved(points: np.ndarray, flip: np.ndarray) -> Motion:
    """Return the motion that lays points (n, 3) as an orientation says, about their middle."""
    middle = np.append(0.5 * (points[:, :2].min(axis=0) + points[:, :2].max(axis=0)), 0.0)
    return Motion(flip, flip, middle, middle, np.zeros((3, 3)))


def on_nodes(motion: Motion, scan: Scan, low: np.ndarray, most: float) -> Motion:
    """Lay nodes of a grid on those of another, one at ``low`` (x, y), if within ``most`` [m]."""
    whole = np.rint(motion.rotation)
    if (np.abs(whole[:2]).sum(axis=1) != 1.0).any() or abs(whole[2, 2]) != 1.0:
        return motion
    steps, first = np.array(scan.spacing[::-1]), np.array((scan.origin or (0.0, 0.0))[::-1])
    bare = motion._replace(rotation=whole)
    node = bare.back(np.array([*low, motion.place[2]]))[:2]
    off = first + steps * np.rint((node - first) / steps) - node
    snapped = bare._replace(place=motion.place - _turned(whole, np.append(off, 0.0)))
    reach = 0.5 * steps * (np.array(scan.heights.shape[::-1]) - 1.0)
    return snapped if motion.apart(snapped, reach) <= most else motion


def heights_after(
    scan: Scan, motion: Motion, slopes: tuple[float, float] = (0.0, 0.0)
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function of nodes (..., 2) [m]: heights of a moved grid by cubic splines, or NaN.

    ``slopes`` along x and y are those of the scan's mean plane, with which heights of steep scans
    are found.
    """
    holes = gridding.holes(np.isfinite(scan.heights))
    whole = gridding.without_dropouts(scan.heights, holes)
    missing = (~np.isfinite(whole)).astype(float)
    spline = scipy.ndimage.spline_filter(gridding.nearest_filled(whole))
    first, steps = np.array(scan.origin or (0.0, 0.0)), np.array(scan.spacing)
    back = motion.rotation[2]  # direction of the new z before the motion
    rise = back[2] - slopes[0] * back[0] - slopes[1] * back[1]

    def at(nodes: np.ndarray) -> np.ndarray:
        points = np.concatenate([nodes, np.full((*nodes.shape[:-1], 1), motion.place[2])], axis=-1)
        for _ in range(_INVERSIONS):
            before = motion.back(points)
            # rounded, so that nodes of both grids meet
            places = np.moveaxis(np.round((before[..., 1::-1] - first) / steps, 6), -1, 0)
            heights = _of_spline(spline, places)
            points[..., 2] += (heights - before[..., 2]) / rise
        lost = scipy.ndimage.map_coordinates(missing, places, order=1, cval=1.0)
        return np.where(lost > 1e-6, np.nan, points[..., 2])

    return at


def _of_spline(spline: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the values of a filtered cubic spline at places (2, ...) in cells."""
    return scipy.ndimage.map_coordinates(spline, places, prefilter=False, mode="mirror")


class Surface(NamedTuple):
    """Heights (y, x) [m], NaN where missing, of square cells, the first one at ``low`` (x, y)."""

    heights: np.ndarray
    low: np.ndarray
    spacing: float
    slopes: tuple[float, float]

    @property
    def middle(self) -> np.ndarray:
        """Middle (x, y, z) of the wall [m]."""
        size = np.array(self.heights.shape[::-1]) - 1.0
        return np.append(self.low + 0.5 * self.spacing * size, np.nanmean(self.heights))

    @property
    def plane(self) -> np.ndarray:
        """Heights (y, x) [m] of its plane, 0 at the first cell."""
        y, x = np.indices(self.heights.shape) * self.spacing
        return self.slopes[0] * x + self.slopes[1] * y

    def smoothed(self, width: float) -> np.ndarray:
        """Return Gaussian means (y, x) over so many cells, NaN with too few known heights."""
        level = self.heights - self.plane
        known, middle = np.isfinite(level), np.nanmean(level)
        weight = _gaussian(known.astype(float), width, 3.0)
        sums = _gaussian(np.where(known, level - middle, 0.0), width, 3.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            means = np.where(weight >= KNOWN, sums / weight, np.nan)
        return means + middle + self.plane


def surface_of(points: np.ndarray, spacing: float) -> Surface:
    """Return points (n, 3) [m], NaN where a height is missing, on a grid."""
    plane = plane_through(*points[np.isfinite(points[:, 2])].T)
    slopes, low = (plane.slope_x, plane.slope_y), points[:, :2].min(axis=0)
    bare = Surface(gridding.wall_on_grid(Cloud(points), spacing), low, spacing, slopes)
    offset = float(plane.at(low[0], low[1]))
    return bare._replace(heights=bare.heights + bare.plane + offset)


def _gaussian(values: np.ndarray, width: float, truncate: float) -> np.ndarray:
    return scipy.ndimage.gaussian_filter(values, width, mode="constant", truncate=truncate)


def _turned(rotation: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Multiply points (..., 3) by a matrix, with the same bits on any processor."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in rotation], axis=-1)


def _about(*vector: float) -> np.ndarray:
    """Return the matrix of a rotation vector [rad]."""
    return scipy.spatial.transform.Rotation.from_rotvec(vector).as_matrix()


def levelling_rotation(slopes: tuple[float, float]) -> np.ndarray:
    """Return the smallest rotation that makes a plane of given slopes horizontal."""
    length = math.hypot(*slopes)
    angle = math.atan(length) / length if length > 0.0 else 0.0
    return _about(angle * -slopes[1], angle * slopes[0], 0.0)


class Fit(NamedTuple):
    """Best correlation of slopes on blocks at an angle [degrees]; shift (x, y) [m] of middles."""

    orientation: str
    correlation: float
    angle: float
    shift: np.ndarray

    def far(self, other: "Fit") -> bool:
        """Return whether the orientations differ, or the angles by more than `APART`."""
        apart = abs((self.angle - other.angle + 180.0) % 360.0 - 180.0) > APART
        return apart or self.orientation != other.orientation

    def __str__(self) -> str:
        return f"{self.orientation} {self.correlation:.2f} at {self.angle:g} degrees"


def _blocks(wall: np.ndarray, cells: int) -> np.ndarray:
    """Return means of the known heights in blocks of cells, NaN for blocks without any."""
    ny, nx = (size // cells for size in wall.shape)
    blocks = wall[: ny * cells, : nx * cells].reshape(ny, cells, nx, cells)
    known = np.isfinite(blocks).sum(axis=(1, 3))
    return np.where(known > 0, np.nansum(blocks, axis=(1, 3)) / np.maximum(known, 1), np.nan)


def compared(
    upper: Surface, lower: Surface, orientations: dict[str, np.ndarray], blocks: int
) -> list[Fit]:
    """Compare rotations of the upper wall in all orientations; the best fit is the first."""
    cells = max(min(*upper.heights.shape, *lower.heights.shape) // blocks, 1)
    fixed, bare = (_blocks(s.heights - s.plane, cells) for s in (lower, upper))
    bare = bare - np.nanmean(bare)
    side = math.ceil(math.hypot(*bare.shape)) + 1
    y, x = np.indices((side, side)) - 0.5 * (side - 1)
    offset = 0.5 * (np.array(fixed.shape) - 1.0) - 0.5 * (side - 1)
    correlations = slope_correlations(fixed, (side, side), LEAST_OVERLAP)
    fits = []
    for (name, flip), angle in itertools.product(orientations.items(), np.arange(0.0, 360.0, STEP)):
        turn = _about(0.0, 0.0, math.radians(angle)) @ flip
        places = [turn[0, k] * x + turn[1, k] * y + 0.5 * (bare.shape[1 - k] - 1) for k in (1, 0)]
        moved = flip[2, 2] * scipy.ndimage.map_coordinates(bare, places, order=1, cval=np.nan)
        over = correlations(moved)
        if not np.isfinite(over).any():
            raise InputError("the scans have too few heights for a comparison")
        place = np.unravel_index(int(np.nanargmax(over)), over.shape)
        shift = [i - n if i > n // 2 else i for i, n in zip(place, over.shape, strict=True)]
        between = cells * upper.spacing * (np.array(shift, float) - offset)
        fits.append(Fit(name, float(over[place]), float(angle), between[::-1]))
    return sorted(fits, key=lambda fit: -fit.correlation)


def fitted(upper: Surface, lower: Surface, flip: np.ndarray, fit: Fit) -> Motion:
    """Refine a fit by least squares; the covariance is infinite if they find nothing."""
    turn = _about(0.0, 0.0, math.radians(fit.angle)) @ flip
    rotation = levelling_rotation(lower.slopes).T @ turn @ levelling_rotation(upper.slopes)
    place = lower.middle + np.append(fit.shift, 0.0)
    start = best = Motion(flip, rotation, upper.middle, place, np.full((3, 3), np.inf))
    error, side = math.inf, min(*upper.heights.shape, *lower.heights.shape)
    reach = 0.5 * upper.spacing * np.array(upper.heights.shape[::-1])
    widest = int(math.log2(max(side / 12.0, 1.0)))
    for smoothing in 2.0 ** np.arange(widest, -1, -1):
        for wide in (False, True)[: 2 if smoothing == 1.0 else 1]:
            refined = _least_squares(upper, lower, best, smoothing, wide)
            if refined is None or refined[0].apart(start, reach) > FARTHEST * reach.max():
                continue
            # tiles of few widths of a mean give too small errors: such a fit is only a start
            if refined[1] < (WORTH if wide else 1.0) * error or not math.isfinite(error):
                best, error = refined[0], refined[1] if smoothing <= side / WIDTHS else math.inf
    return best


def _least_squares(
    upper: Surface, lower: Surface, start: Motion, smoothing: float, wide: bool
) -> tuple[Motion, float] | None:
    """Move the smoothed upper wall to where it differs least; return the motion and its error [m].

    Gauss-Newton on the differences of heights, with weights of the Cauchy distribution. ``wide``
    compares means over `WIDE` smoothings apart from the rest, each over its size.
    """
    fine, heights = upper.smoothed(smoothing), lower.smoothed(smoothing)
    step = max(math.ceil(math.sqrt(fine.size / MOST_POINTS)), int(0.5 * smoothing))
    listed, known = np.isfinite(fine[::step, ::step]), np.isfinite(heights)
    row, column = step * np.array(np.nonzero(listed))
    xy = upper.low + upper.spacing * np.stack([column, row], axis=-1)
    points = np.column_stack([xy, fine[row, column]])
    least = LEAST_OVERLAP * 0.5 * min(len(points), known.sum() / step**2)
    if least < 50:
        return None
    arms = _turned(start.rotation, points - start.middle)
    reach = float(np.sqrt(np.mean(arms[:, 0] ** 2 + arms[:, 1] ** 2)))
    bare = np.where(known, heights, np.nanmean(heights))
    slopes = np.gradient(bare, lower.spacing)
    spline, share = scipy.ndimage.spline_filter(bare), known.astype(float)
    x, change = np.zeros(6), math.inf
    for _ in range(ROUNDS):
        turned = _turned(_about(*x[:3] / reach), arms)
        at = turned + start.place + x[3:]
        places = ((at[:, :2] - lower.low) / lower.spacing).T[::-1]
        inside = scipy.ndimage.map_coordinates(share, places, order=1) > 0.999
        if inside.sum() < least:
            return None
        used = listed.copy()
        used[listed] = inside
        places, turned = places[:, inside], turned[inside]
        residual = at[inside, 2] - _of_spline(spline, places)
        if change == math.inf:
            x[5], residual = -np.median(residual), residual - np.median(residual)
        along_y, along_x = (scipy.ndimage.map_coordinates(s, places, order=1) for s in slopes)
        normal = np.stack([-along_x, -along_y, np.ones(len(turned))], axis=1)
        columns = np.column_stack([np.cross(turned, normal) / reach, normal, residual])
        low = np.zeros_like(columns)
        if wide:
            low = _wide_means(columns, used, WIDE * smoothing / step)
        high = columns - low
        low /= WIDE * np.median(np.abs(low[:, 6])) + 1e-12
        high /= CAUCHY * np.median(np.abs(high[:, 6])) + 1e-12
        weighted = high / (1.0 + high[:, 6:] ** 2)
        inverse = np.linalg.pinv(weighted[:, :6].T @ high[:, :6] + low[:, :6].T @ low[:, :6])
        gradients = weighted[:, :6] * high[:, 6:] + low[:, :6] * low[:, 6:]
        if change < 1e-7 * lower.spacing:
            break
        taken = -inverse @ gradients.sum(axis=0)
        taken *= min(1.0, 2.0 * smoothing * lower.spacing / np.abs(taken).max())
        x, change = x + taken, np.abs(taken).max()
    covariance = _tiled_covariance(gradients, inverse, places)
    scaled = np.diag([1.0 / reach] * 3 + [1.0] * 3)
    covariance = (scaled @ covariance @ scaled)[2:5, 2:5]
    least_error = LEAST_ERROR * lower.spacing
    covariance += np.diag([least_error / reach, least_error, least_error]) ** 2
    rotation = _about(*x[:3] / reach) @ start.rotation
    rotation, place = np.round(rotation, _DIGITS), np.round(start.place + x[3:], _DIGITS + 2)
    error = math.sqrt(covariance[0, 0] * reach**2 + covariance[1, 1] + covariance[2, 2])
    return Motion(start.flip, rotation, start.middle, place, covariance), error


def _wide_means(columns: np.ndarray, used: np.ndarray, width: float) -> np.ndarray:
    """Return Gaussian means of columns (n, k) over the used points of a grid (y, x)."""
    weight = _gaussian(used.astype(float), width, 2.5)[used]
    means, field = np.empty_like(columns), np.zeros(used.shape)
    for number, values in enumerate(columns.T):
        field[used] = values
        means[:, number] = _gaussian(field, width, 2.5)[used] / weight
    return means


def _tiled_covariance(gradients: np.ndarray, inverse: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the covariance (6, 6) of a fit, gradients (n, 6) summed in tiles of places (2, n)."""
    low, high = places.min(axis=1, keepdims=True), places.max(axis=1, keepdims=True)
    row, column = np.minimum((places - low) / (high - low) * TILES, TILES - 1).astype(int)
    sums = np.stack([np.bincount(row * TILES + column, g, TILES**2) for g in gradients.T])
    count = int((np.abs(sums).sum(axis=0) > 0.0).sum())
    return inverse @ (sums @ sums.T) @ inverse * count / max(count - 6, 1)

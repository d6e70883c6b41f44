"""Rigid motion that lays the scan of one wall on that of the other, in six degrees of freedom."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.walls.gridding import Scan
from jointclosure.walls.missing_heights import fill_dropouts, fill_with_nearest, in_holes

_INVERSIONS = 8  # rounds of iteration in which the height of a tilted wall at a node is found


class Motion(NamedTuple):
    """Rigid motion of a scanned wall: rotation about its middle, which is moved to a place."""

    flip: np.ndarray  # matrix (3, 3) of an orientation's changes of sign; contained in ``rotation``
    rotation: np.ndarray  # matrix (3, 3), which also mirrors if the flip does
    middle: np.ndarray  # (x, y, z) [m], before the motion
    place: np.ndarray  # (x, y, z) [m] of the middle after the motion
    covariance: np.ndarray  # (3, 3) of (rotation about the normal [rad], shift along x, y [m])

    def moved(self, points: np.ndarray) -> np.ndarray:
        """Return where points (..., 3) [m] of the wall lie after the motion."""
        return rotated(self.rotation, points - self.middle) + self.place

    def moved_back(self, points: np.ndarray) -> np.ndarray:
        """Return where points (..., 3) [m] of the moved wall lay before the motion."""
        return rotated(self.rotation.T, points - self.place) + self.middle

    def after(self, first: "Motion") -> "Motion":
        """Return the motion that combines ``first`` and then this motion, whose errors it has."""
        flip = self.flip @ first.flip
        rotation = self.rotation @ first.rotation
        return Motion(flip, rotation, first.moved_back(self.middle), self.place, self.covariance)

    @property
    def angle(self) -> float:
        """Rotation of the wall in its plane [degrees], anticlockwise, from -180 to 180."""
        turn = self.rotation @ self.flip
        return math.degrees(math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))

    @property
    def tilt(self) -> float:
        """Angle [degrees] by which the motion tilts the normal of the wall; from 0 to 90."""
        return math.degrees(math.acos(min(abs(self.rotation[2, 2]), 1.0)))

    def corner_distance(self, other: "Motion", reach: np.ndarray) -> float:
        """Return how far apart [m], in the plan, two motions place a corner of the wall at most.

        ``reach`` (x, y) [m] is half of the sides of the wall.
        """
        corners = np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
        points = self.middle + corners * [*reach, 0.0]
        between = self.moved(points) - other.moved(points)
        return float(np.hypot(between[:, 0], between[:, 1]).max())

    def difference_to(self, other: "Motion") -> np.ndarray:
        """Return the difference (3,) of the ``other`` motion from this motion.

        It has a rotation [rad] about z, and the shift (x, y) [m] of the other motion's middle.
        """
        turn = other.rotation @ self.rotation.T
        shift = other.place - self.moved(other.middle)
        return np.array([0.5 * (turn[1, 0] - turn[0, 1]), shift[0], shift[1]])

    def corner_error(self, reach: np.ndarray) -> float:
        """Return the standard error [m], in the plan, of the place of a corner of the wall.

        ``reach`` (x, y) [m] is half of the sides of the wall.
        """
        angle, x, y = np.diag(self.covariance)
        return math.sqrt(angle * float(reach @ reach) + x + y)

    def standard_errors(self) -> tuple[float, float, float]:
        """Return the standard errors of rotation [degrees] and shift along x and y [m]."""
        angle, x, y = np.sqrt(np.diag(self.covariance)).tolist()
        return math.degrees(angle), x, y

    def record(self) -> dict[str, float | list[float]]:
        """Return rotation, tilt and shift of the motion, with standard errors, for JSON."""
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


NO_MOTION = Motion(np.eye(3), np.eye(3), np.zeros(3), np.zeros(3), np.zeros((3, 3)))
"""Motion that leaves a wall where it is."""


def flip_about_middle(points: np.ndarray, flip: np.ndarray) -> Motion:
    """Return the motion that only applies the matrix ``flip`` (3, 3) of an orientation to points.

    Points (n, 3) [m] are flipped about the middle of their bounding rectangle (x, y), at z = 0. The
    motion has no error.
    """
    middle = np.append(0.5 * (points[:, :2].min(axis=0) + points[:, :2].max(axis=0)), 0.0)
    return Motion(flip, flip, middle, middle, np.zeros((3, 3)))


def laid_on_nodes(motion: Motion, scan: Scan, low: np.ndarray, most: float) -> Motion:
    """Return a motion of a scanned grid, displaced so that the moved grid meets a node at ``low``.

    One of the nodes of the moved grid then lies at ``low`` (x, y) [m], a node of another grid; the
    rotation is rounded to whole quarter turns. The motion is returned as it is if it is no such
    turn even roughly, or if a corner would be displaced by more than ``most`` [m].
    """
    whole = np.rint(motion.rotation)
    if (np.abs(whole[:2]).sum(axis=1) != 1.0).any() or abs(whole[2, 2]) != 1.0:
        return motion
    steps = np.array(scan.spacing[::-1])
    first = np.array((scan.origin or (0.0, 0.0))[::-1])
    bare = motion._replace(rotation=whole)
    node = bare.moved_back(np.array([*low, motion.place[2]]))[:2]
    off = first + steps * np.rint((node - first) / steps) - node
    snapped = bare._replace(place=motion.place - rotated(whole, np.append(off, 0.0)))
    reach = 0.5 * steps * (np.array(scan.heights.shape[::-1]) - 1.0)
    return snapped if motion.corner_distance(snapped, reach) <= most else motion


def moved_heights(
    scan: Scan, motion: Motion, slopes: tuple[float, float] = (0.0, 0.0)
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function that interpolates the heights of a moved scanned grid by cubic splines.

    It takes nodes (..., 2) (x, y) [m] and returns heights (...) [m], NaN where the scan has none:
    outside, in holes, and beside missing heights that are no dropouts. ``slopes`` along x and y are
    those of the scan's mean plane; with them the search for heights of steep scans converges.
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
        """Return heights (...) [m] at nodes (..., 2) [m], by Newton's method with fixed slopes."""
        points = np.concatenate([nodes, np.full((*nodes.shape[:-1], 1), motion.place[2])], axis=-1)
        for _ in range(_INVERSIONS):
            before = motion.moved_back(points)
            # rounded, so that nodes of both grids meet
            places = np.moveaxis(np.round((before[..., 1::-1] - first) / steps, 6), -1, 0)
            heights = spline_values(spline, places)
            points[..., 2] += (heights - before[..., 2]) / rise
        lost = scipy.ndimage.map_coordinates(missing, places, order=1, cval=1.0)
        return np.where(lost > 1e-6, np.nan, points[..., 2])

    return heights_at


def spline_values(spline: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the values (...) of a cubic spline at places (2, ...) [cells], y before x.

    ``spline`` (y, x) has its coefficients, which `scipy.ndimage.spline_filter` returns.
    """
    return scipy.ndimage.map_coordinates(spline, places, prefilter=False, mode="mirror")


def rotated(rotation: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points (..., 3) multiplied by the matrix ``rotation`` (3, 3).

    It is computed by sums, which have the same bits on any processor.
    """
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in rotation], axis=-1)


def rotation_matrix(*vector: float) -> np.ndarray:
    """Return the matrix (3, 3) of the rotation about a vector, by its length [rad]."""
    return scipy.spatial.transform.Rotation.from_rotvec(vector).as_matrix()


def levelling_rotation(slopes: tuple[float, float]) -> np.ndarray:
    """Return the matrix (3, 3) of the smallest rotation that makes a plane horizontal.

    ``slopes`` are those of the plane along x and y.
    """
    length = math.hypot(*slopes)
    angle = math.atan(length) / length if length > 0.0 else 0.0
    return rotation_matrix(angle * -slopes[1], angle * slopes[0], 0.0)

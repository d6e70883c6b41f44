"""Rotations of the upper wall over the full circle, compared by the correlation of slopes."""

import itertools
import math
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.walls.mating import slope_correlations
from jointclosure.walls.motion import (
    rotation_matrix,
)
from jointclosure.walls.surfaces import Surface

# All constants were chosen. With them the errors of 40 pairs of known truth are those that
# docs/two_scans.md states (`python -m benchmarks.registration`).
LEAST_OVERLAP = 0.5  # least share of the smaller wall that must overlap at a shift that is tried
BLOCKS = (48, 24)
"""Numbers of blocks along the shorter side by whose means rotations are compared. The second number
is used if no fit with the first is clear."""
ROTATION_STEP = 3.0  # step [degrees] between the rotations that are compared
DIFFERENT_ROTATIONS = 10.0  # difference [degrees] above which two rotations count as two fits
CLEAR = 1.25  # least ratio of the best correlation to that of the next fit for a clear fit


class SlopeFit(NamedTuple):
    """Rotation and shift of the upper wall at which the slopes of both walls correlate best."""

    orientation: str  # a key of `registration_options.ORIENTATIONS`
    correlation: float  # of the slopes of both walls
    angle: float  # rotation in the plane [degrees], from 0 to 360
    shift: np.ndarray  # (x, y) [m] of the upper wall's middle from the lower wall's middle

    def differs_from(self, other: "SlopeFit") -> bool:
        """Return whether two fits differ in orientation, or by more than `DIFFERENT_ROTATIONS`."""
        return self.turned_from(other) > DIFFERENT_ROTATIONS

    def turned_from(self, other: "SlopeFit") -> float:
        """Return the difference [degrees] of the rotations of two fits, at most 180.

        It is infinite if their orientations differ.
        """
        if self.orientation != other.orientation:
            return math.inf
        return abs((self.angle - other.angle + 180.0) % 360.0 - 180.0)

    def __str__(self) -> str:
        angle = self.angle - 360.0 if self.angle > 180.0 else self.angle  # as that of a motion
        return f"{self.orientation} {self.correlation:.2f} at {angle:g} degrees"


def _blocks(wall: np.ndarray, cells: int) -> np.ndarray:
    """Return the mean known heights of a wall (y, x) in square blocks with ``cells`` along a side.

    Blocks without a known height are NaN. Cells at the ends that fill no block are left out.
    """
    ny, nx = (size // cells for size in wall.shape)
    blocks = wall[: ny * cells, : nx * cells].reshape(ny, cells, nx, cells)
    known = np.isfinite(blocks).sum(axis=(1, 3))
    return np.where(known > 0, np.nansum(blocks, axis=(1, 3)) / np.maximum(known, 1), np.nan)


def compare_rotations(
    upper: Surface, lower: Surface, orientations: dict[str, np.ndarray], blocks: int
) -> list[SlopeFit]:
    """Return the best shift at each rotation and orientation of the upper wall, the best fit first.

    Walls are compared by means in ``blocks`` along the shorter side. ``orientations`` are matrices
    (3, 3), by name, that change the signs of x, y and z. Orientations with the same plan differ
    only by the sign of heights, and so have opposite correlations. Therefore only two plans are
    compared: the plan as scanned, and mirrored. Raise `InputError` if a comparison has too few
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
        turn = rotation_matrix(0.0, 0.0, math.radians(angle)) @ plan
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
    """Return the largest of correlations (y, x) by shift, and its shift (y, x) in cells.

    The correlations are those of `slope_correlations`: indices beyond the middle are negative.
    """
    place = np.unravel_index(int(np.nanargmax(correlations)), correlations.shape)
    shift = [i - n if i > n // 2 else i for i, n in zip(place, correlations.shape, strict=True)]
    return float(correlations[place]), np.array(shift, float)

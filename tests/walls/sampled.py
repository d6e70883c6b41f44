"""Walls that are sampled more coarsely than they are rough, and scans of them."""

import numpy as np

import jointclosure as jc
from jointclosure.walls.gridding import Scan
from jointclosure.walls.planes import detrended
from tests.joints import SPACING


def sampled_walls():
    """Make walls of which every second cell is scanned, so that short waves appear as long ones."""
    fine = jc.wall_pair(
        8.0, (192, 192), SPACING / 2, 1, roll_off=None, mismatch_wavelength=1e-3,
        unusual_values=True,
    )  # fmt: skip
    return tuple(detrended(wall[::2, ::2]) for wall in fine)


def noisy(walls, noise):
    """Return walls with white noise of a standard deviation [m]."""
    random = np.random.default_rng(0)
    return tuple(wall + noise * random.standard_normal(wall.shape) for wall in walls)


def scan_of(wall):
    """Return heights (y, x) [m] as a scan with its first point at (0, 0)."""
    return Scan(wall, (SPACING, SPACING), (0.0, 0.0))

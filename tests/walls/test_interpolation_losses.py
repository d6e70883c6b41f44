"""Short waves that interpolation onto the grid of a joint takes from scanned walls."""

import numpy as np
import pytest
import scipy

import jointclosure as jc
from jointclosure.walls.gridding import Scan
from jointclosure.walls.planes import detrended
from jointclosure.walls.registration import registered

SPACING = 0.25e-3
FINE = SPACING / 10.0
UNEQUAL = 0.2e-3
"""Spacing of a lower scan of which few points lie on nodes of the joint."""


@pytest.fixture(scope="module")
def walls():
    """Walls (y, x) [m], z upwards, whose shortest waves have a length of four fine cells."""
    coarse = jc.wall_pair(
        12.0, (200, 200), 2.5 * FINE, 5, roll_off=None, mismatch_wavelength=1e-3,
        unusual_values=True,
    )  # fmt: skip
    upper, lower = (scipy.ndimage.zoom(wall, 2.5, mode="mirror") for wall in coarse)
    return 1e-3 - upper, lower


def scan(wall, spacing):
    """Scan of a wall of fine cells, at every so many of them."""
    step = round(spacing / FINE)
    return Scan(wall[::step, ::step], (spacing, spacing), (0.0, 0.0))


def slope(wall):
    steps = [np.diff(wall, axis=axis) for axis in (0, 1)]
    return np.sqrt(np.mean([np.mean(part**2) for part in steps])) / SPACING


def joined(walls, lower):
    upper = scan(walls[0], SPACING)
    stated = {"spacing": SPACING, "orientation": "common_frame", "shift": "scanned"}
    return registered(upper, lower, **stated, unusual_values=True)


def test_a_lower_scan_with_other_points_keeps_nearly_all_of_its_slope(walls):
    pair = joined(walls, scan(walls[1], UNEQUAL))
    step = round(SPACING / FINE)
    ny, nx = pair.lower.shape
    true = detrended(walls[1][::step, ::step][:ny, :nx])
    kept = slope(pair.lower) / slope(true)
    # linear interpolation keeps 0.87
    assert 0.93 < kept < 1.0


def test_the_slope_that_both_walls_lost_is_that_of_the_true_walls_less_theirs(walls):
    pair = joined(walls, scan(walls[1], UNEQUAL))
    step = round(SPACING / FINE)
    ny, nx = pair.lower.shape
    lost = slope(detrended(walls[1][::step, ::step][:ny, :nx])) ** 2 - slope(pair.lower) ** 2
    assert pair.lost_square_slope == pytest.approx(lost, rel=0.5)
    assert pair.errors.lost_square == pair.lost_square_slope * SPACING**2


def test_walls_whose_points_are_nodes_lose_nothing(walls):
    assert joined(walls, scan(walls[1], SPACING)).lost_square_slope == 0.0


def test_a_steep_lower_scan_keeps_nearly_all_of_its_slope(walls):
    """Its heights are turned until they lie level, and not interpolated on another grid before."""
    incline = np.deg2rad(8.0)
    lower = scan(walls[1], UNEQUAL)
    x = UNEQUAL * np.arange(lower.heights.shape[1])
    steep = lower._replace(heights=lower.heights + np.tan(incline) * x)
    pair = registered("flat", steep, spacing=SPACING)
    step = round(SPACING / FINE)
    # over an inclined plane, slopes along and across the dip are 1/cos^2 and 1/cos of the turned
    true = slope(walls[1][::step, ::step]) * np.cos(incline) ** 1.5
    assert 0.93 < slope(pair.lower) / true < 1.0

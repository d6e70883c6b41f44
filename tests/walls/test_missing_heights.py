"""Cells of a scan without a height: which are filled, how, and which are refused."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls.missing_heights import fill_dropouts, fill_missing, in_holes
from tests.joints import SPACING


@pytest.fixture
def wall():
    return jc.wall_pair(9.0, (40, 52), SPACING, seed=5)[0]


@pytest.fixture
def slope():
    y, x = np.indices((30, 30))
    return 2e-5 * x + 1e-5 * y


@pytest.fixture
def holed(slope):
    """A slope with a hole."""
    heights = slope.copy()
    heights[10:14, 20:23] = np.nan
    return heights


def test_linear_filling_follows_a_slope(holed, slope):
    np.testing.assert_allclose(fill_missing(holed, "linear"), slope, atol=1e-15)


def test_nearest_filling_does_not_follow_a_slope(holed, slope):
    near = fill_missing(holed, "nearest")
    assert np.isfinite(near).all()
    assert np.abs(near - slope).max() > 1e-5


def test_linear_filling_beyond_all_cells_takes_the_nearest_ones(holed):
    holed[:2] = np.nan
    assert np.isfinite(fill_missing(holed, "linear", 0.1)).all()


def test_missing_cells_may_be_refused_with_their_number(wall):
    wall[4, 7] = wall[4, 8] = np.nan
    with pytest.raises(jc.InputError, match=r"2 of 2080 cells .* first at \(y, x\) = \(4, 7\)"):
        fill_missing(wall, "refuse")


def test_missing_cells_that_are_to_be_avoided_stay(wall):
    wall[4, 7] = wall[4, 8] = np.nan
    assert fill_missing(wall, "avoid") is wall


def test_no_more_cells_are_filled_than_allowed(wall):
    wall[4, 7] = wall[4, 8] = wall[:4] = np.nan
    with pytest.raises(jc.InputError, match=r"210 of 2080 .* 0.101, at most 0.05 may be filled"):
        fill_missing(wall, "nearest")
    assert np.isfinite(fill_missing(wall, "nearest", 0.11)).all()


def test_a_strip_beside_the_rim_of_a_scan_is_not_filled_between_its_far_ends():
    wall = np.random.default_rng(0).standard_normal((12, 9)).cumsum(axis=0)
    wall[2:10, 0] = np.nan  # known at both ends of the column, with nothing beyond it
    wall[5, 4] = wall[8, 3:5] = np.nan
    whole = fill_dropouts(wall, in_holes(np.isfinite(wall)))
    np.testing.assert_array_equal(np.isnan(whole), np.isnan(wall) & (np.arange(9) == 0))

"""The bearing-area curve against sorting, and against heights whose curve is known."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.statistics.randomness import generator
from jointclosure.walls.roughness import bearing_depths, bearing_excess


def test_depths_are_those_of_sorted_heights():
    upper, lower = jc.wall_pair(8, (30, 40), 0.25e-3, 1)
    highest = np.sort((upper + lower).ravel())[::-1]
    for cells in (1, 2, 12, 600, 1200):
        found = bearing_depths(upper + lower, cells / 1200)
        assert found == pytest.approx(highest[0] - highest[cells - 1], abs=1e-18)


def test_a_plane_ramp_has_a_straight_curve_and_half_its_depth_as_excess():
    heights = generator(1).permutation(np.arange(1000.0)).reshape(20, 50)
    shares = np.array([0.001, 0.0105, 0.5, 1.0])
    np.testing.assert_allclose(bearing_depths(heights, shares), 1000 * shares - 1.0, rtol=1e-12)
    assert bearing_excess(heights, 0.101) == pytest.approx(50.0)
    assert bearing_depths(heights, 1e-6) == 0.0


def test_rigid_walls_overlap_in_that_share_at_that_closure():
    upper, lower = jc.wall_pair(8, (30, 40), 0.25e-3, 2)
    gap = (upper + lower).max() - (upper + lower)
    closure = bearing_depths(upper + lower, 0.05)
    assert np.mean(gap <= closure * (1 + 1e-12)) == pytest.approx(0.05, abs=0.5 / gap.size)

"""Bearing-area curve: the depths that hold given shares of the cells."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls.bearing_area import bearing_depths


def test_depths_are_those_of_sorted_heights():
    upper, lower = jc.wall_pair(8, (30, 40), 0.25e-3, 1)
    highest = np.sort((upper + lower).ravel())[::-1]
    for cells in (1, 2, 12, 600, 1200):
        found = bearing_depths(upper + lower, cells / 1200)
        assert found == pytest.approx(highest[0] - highest[cells - 1], abs=1e-18)


def test_depths_of_several_shares_are_those_of_each_up_to_all_cells():
    summed = sum(jc.wall_pair(8, (30, 40), 0.25e-3, 1))
    shares = [0.0, 0.0107, 0.05, 0.5003, 1.0]
    depths = bearing_depths(summed, shares)
    np.testing.assert_array_equal(depths, [bearing_depths(summed, share) for share in shares])
    assert depths[-1] == pytest.approx(np.ptp(summed))

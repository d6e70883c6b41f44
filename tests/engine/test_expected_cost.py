"""Cost of a large joint before it is closed."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engine.expected_cost import BYTES, SMALL, Cost, check_cells, expected_cost
from jointclosure.joint.conditions import Conditions
from tests.joints import DOLERITE, SPACING

CONDITIONS = Conditions(SPACING, DOLERITE, 1e6).checked()


def walls(cells):
    return jc.wall_pair(8.0, (cells, cells), SPACING, 1, mismatch_wavelength=1e-3)


def test_small_joints_are_closed_without_an_estimate():
    assert expected_cost(*walls(32), CONDITIONS, single=False) is None


def test_the_cost_grows_with_the_cells_and_with_the_range():
    upper, lower = walls(160)
    assert upper.size > SMALL
    one, several = (expected_cost(upper, lower, CONDITIONS, single) for single in (True, False))
    for cost in (one, several):
        assert 0.0 < cost.seconds[0] < cost.seconds[1]
    assert several.seconds[0] > 5.0 * one.seconds[0]
    text = Cost((140.0, 3900.0), 5e8).sentence(upper.shape, SPACING)
    assert "160 x 160 cells will take about 2 min to 1 h of processor time and 0.5 GB" in text
    larger = expected_cost(*(np.tile(wall, 2) for wall in (upper, lower)), CONDITIONS, single=True)
    assert larger.memory - one.memory == BYTES * upper.size


def test_many_cells_need_a_stated_spacing():
    check_cells((1000, 1000), SPACING, stated=False)
    check_cells((1001, 1000), SPACING, stated=True)
    with pytest.raises(jc.InputError, match=r"1000 x 1001 cells .* 1.5 mm"):
        check_cells((1001, 1000), SPACING, stated=False)

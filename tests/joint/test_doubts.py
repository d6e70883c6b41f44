"""Slips of units and orientation that `simulate` warns of."""

import warnings

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls.plausibility import doubts
from tests.joints import DOLERITE, SPACING


def mates():
    return jc.wall_pair(8.0, (24, 24), SPACING, seed=3, correlation=0.95, roll_off=None)


def test_walls_of_a_joint_raise_no_doubt():
    for correlation in (0.0, 0.5, 1.0):
        for seed in range(5):
            walls = jc.wall_pair(
                8.0, (24, 24), SPACING, seed, correlation=correlation, roll_off=None
            )
            assert doubts(*walls, SPACING) == []


def test_an_upper_wall_in_the_frame_of_the_lower_one_is_told():
    upper, lower = mates()
    (printed,) = doubts(-upper, lower, SPACING)
    assert "the walls are alike" in printed


@pytest.mark.parametrize(("axis", "name"), [(0, "y"), (1, "x")])
def test_a_wall_that_lies_the_other_way_round_is_told(axis, name):
    upper, lower = mates()
    (printed,) = doubts(np.flip(upper, axis), lower, SPACING)
    assert f"reversed along {name}" in printed


@pytest.mark.parametrize("factor", [1e3, 1e-4])
def test_heights_in_another_unit_than_the_spacing_are_told(factor):
    upper, lower = (factor * wall for wall in mates())
    printed = doubts(upper, lower, SPACING)
    assert len(printed) == 2
    assert all("rms slope" in line for line in printed)


def test_simulate_warns_once_unless_told_that_values_are_unusual():
    upper, lower = mates()
    stated = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6, "cycles": 1}
    stated["effects"] = jc.Effects(*[False] * 5)
    with pytest.warns(UserWarning, match="alike") as heard:
        jc.simulate(-upper, lower, **stated)
    assert [warning.filename for warning in heard] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jc.simulate(-upper, lower, unusual_values=True, **stated)
        jc.simulate(upper, lower, **stated)

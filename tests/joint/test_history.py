"""Closures and stresses read from steps of a history; stiffnesses do not depend on the steps."""

import itertools

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.engine.uncertainty import coarser
from jointclosure.joint.curves import (
    branch_of,
    crossing,
    net_responses,
    unloading_excess,
    values_at_stresses,
)
from tests.joints import SPACING, closed

STRESS = np.array([0.0, 1.0, 3.0, 2.0, 4.0])
CLOSURE = np.array([0.0, 10.0, 20.0, 30.0, 40.0])
UP, LOAD = [0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]


def history(closure, stress, steps):
    """A history whose numbers of steps of loading and unloading alternate."""
    cycle = np.repeat(np.arange(len(steps)) // 2 + 1, steps)
    branch = np.repeat([("loading", "unloading")[i % 2] for i in range(len(steps))], steps)
    along = {"closure": closure, "normal_stress": stress, "load_cycle": cycle, "branch": branch}
    return xr.Dataset({name: ("step", np.array(values)) for name, values in along.items()})


@pytest.mark.parametrize("level", [2.0, 0.0, 5.0])
def test_loading_takes_the_first_crossing_and_unloading_the_last(level):
    first = crossing(STRESS, CLOSURE, level)
    last = crossing(STRESS[::-1], CLOSURE[::-1], level, "unloading")
    expected = {2.0: 15.0, 0.0: 0.0, 5.0: np.nan}[level]
    np.testing.assert_array_equal([first, last], [expected] * 2)


@pytest.mark.parametrize("tolerance", [0.0, 1e-3])
def test_closures_are_read_on_each_branch_at_stresses_that_it_passed(tolerance):
    closure = [0.0, 1.0, 2.0, 1.5, 0.5, 1.5, 2.5, 0.7]
    stress = [0.0, 1.0, 2.0 / (1.0 + 0.5 * tolerance), 1.0, 0.0, 1.0, 2.0, 0.0]
    levels = np.array([0.0, 1.0, 2.0])
    closed = history(closure, stress, [3, 2, 2, 1])
    found = values_at_stresses(closed, closed.closure.values, 2, levels, tolerance)
    np.testing.assert_allclose(found[0], [[0.0, 1.0, 2.0], [0.5, 1.5, 2.0]])
    np.testing.assert_allclose(found[1], [[0.5, 1.5, 2.5], [0.7, 1.6, 2.5]])
    partly = history([0.0, 2.0, 1.5, 3.0], [0.0, 4.0, 2.001, 6.0], [2, 1, 1])
    levels = np.array([1.0, 2.0, 3.0])
    found = values_at_stresses(partly, partly.closure.values, 2, levels, 1e-3)
    assert np.isnan([found[0, 1, 0], found[1, 0, 0]]).all()
    assert found[0, 1, 1] == found[1, 0, 1] == 1.5  # landed on within the tolerance
    assert np.isfinite(found[:, :, 2][[0, 0, 1], [0, 1, 0]]).all()


@pytest.mark.parametrize(
    ("up", "down", "relief", "excess"),
    [
        (UP, [2.5, 1.5, 0.5], [2.75, 1.0, 0.0], 0.25),
        (UP, [2.5, 1.5, 0.5], [2.25, 1.0, 0.0], 0.0),
        ([1.0, 2.0, 3.0, 4.0], [0.5, 0.0], [0.75, 0.0], 0.75),  # below the start it counts in full
    ],
)
def test_the_excess_of_unloading_is_read_at_its_steps(up, down, relief, excess):
    closed = history([*up, *down], [*LOAD, *relief], [4, len(down)])
    np.testing.assert_allclose(unloading_excess(closed, [0.0, 0.0]), [excess, np.nan])


LARGEST, USUAL = 10.27e6, jc.Numerics(breakage="resolved")


@pytest.fixture(scope="module")
def stiff_joints():
    """Joints by the usual steps of resolved breakage, each with the same one by finer steps."""
    pairs = []
    for wavelength, strength in itertools.product((1.6e-3, 6e-3), (60e6, 173e6)):
        about = {"mismatch_wavelength": wavelength, "roll_off": None}
        walls = jc.wall_pair(8.0, (24, 24), SPACING, 1, **about)
        given = {"rock": jc.Rock(11e9, 0.25, strength), "seating_stress": 0.257e6}
        steps = USUAL, coarser(USUAL, 1.0 / 4.0)
        pairs.append([closed(walls, LARGEST, numerics=numerics, **given) for numerics in steps])
    return pairs


def test_stiffness_and_closure_of_stiff_joints_are_those_of_finer_steps(stiff_joints):
    for name, mean in (("stiffness_net", 0.03), ("max_closure_seated_net", 0.03)):
        read = np.array([[net_responses(one)[name] for one in pair] for pair in stiff_joints])
        ratios = read[:, 0] / read[:, 1]
        np.testing.assert_allclose(ratios.mean(axis=0), 1.0, atol=mean)
        assert ratios.std(axis=0).max() < 0.05


def test_every_branch_has_steps_enough_for_a_chord(stiff_joints):
    for usual, _ in stiff_joints:
        for cycle in (1, 2):
            for branch in ("loading", "unloading"):
                stress = usual.normal_stress.values[branch_of(usual, cycle, branch)]
                assert (stress > 0.5 * LARGEST).sum() >= 5

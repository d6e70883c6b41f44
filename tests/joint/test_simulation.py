"""Histories of one joint follow their conventions."""

import itertools
from unittest.mock import patch

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.history import history_of
from jointclosure.solvers.fast import FastSolver
from tests import joints
from tests.joints import ELASTIC, SPACING

TARGET = 4e6


@pytest.fixture(scope="module")
def walls():
    return jc.wall_pair(8.0, (24, 24), SPACING, seed=11)


@pytest.fixture(scope="module")
def closed(walls):
    return joints.closed(walls, TARGET, seating_stress=5e5)


def on(dataset, cycle, branch):
    """Closure and stress on one branch, its start included."""
    here = history_of(dataset).branch(cycle, branch).steps
    return dataset.closure.values[here], dataset.normal_stress.values[here]


@pytest.fixture(params=[1, 2])
def cycle(request, closed):
    """Number of a cycle, closure and stress of its loading, and those of its unloading."""
    number = request.param
    return number, on(closed, number, "loading"), on(closed, number, "unloading")


def test_loading_ends_at_the_target(closed, cycle):
    _, (_, stress), _ = cycle
    if not int(closed.status) & 1:  # did not jump
        assert stress[-1] == pytest.approx(TARGET, rel=1e-3)
    assert stress.max() == stress[-1]


def test_unloading_ends_at_last_contact(cycle):
    _, _, (_, relief) = cycle
    assert relief[-1] == 0.0 < relief[-2]


def test_closures_of_a_cycle_follow_the_conventions(closed, cycle):
    number, (closure, stress), (back, _) = cycle
    assert closed.residual_closure.values[number - 1] == back[-1]
    assert closed.max_closure.values[number - 1] == pytest.approx(closure[-1] - closure[0])
    seated = closure[-1] - np.interp(5e5, stress, closure)
    assert closed.max_closure_seated.values[number - 1] == pytest.approx(seated, rel=1e-6)


def test_unloading_lies_below_loading(closed, cycle):
    number, (closure, stress), (back, relief) = cycle
    inside = (back > closure[0]) & (back < closure[-1])
    assert np.all(relief[inside] <= np.interp(back[inside], closure, stress) + 1e-3 * TARGET)
    assert 0.0 <= closed.unloading_excess.values[number - 1] <= 1e-2 * TARGET


def test_last_contact_is_where_the_walls_as_they_are_only_just_touch(closed, walls):
    touch = (walls[0] + walls[1]).max() - float((closed.upper_final + closed.lower_final).max())
    assert closed.residual_closure.values[-1] == pytest.approx(touch, abs=1e-18)


@pytest.fixture(scope="module")
def unseated(walls):
    return joints.closed(walls, TARGET, seating_stress=0.0)


def test_seating_never_changes_the_history(closed, unseated):
    xr.testing.assert_equal(unseated.closure, closed.closure)


def test_closures_are_read_from_seating_on(closed, unseated):
    np.testing.assert_array_equal(unseated.max_closure_seated, unseated.max_closure)
    assert np.all(closed.max_closure_seated < closed.max_closure)


@pytest.fixture(scope="module")
def repeated(walls, closed):
    """Copies of the walls, and the same joint that was closed after they were made."""
    copies = [wall.copy() for wall in walls]
    return copies, joints.closed(walls, TARGET, seating_stress=5e5)


def test_the_same_call_gives_the_same_numbers(closed, repeated):
    xr.testing.assert_identical(repeated[1], closed)


def test_the_given_walls_are_left_alone(walls, repeated):
    np.testing.assert_array_equal(walls, repeated[0])


@pytest.mark.parametrize("breakage", [False, True])
def test_an_offset_of_the_heights_costs_no_digits(walls, breakage):
    offset = 2.0**8  # a million times the roughness
    upper, lower = (np.round(wall * 2.0**40) / 2.0**40 for wall in walls)
    assert np.array_equal(upper + offset - offset, upper)
    effects = jc.Effects(breakage=breakage, gouge=breakage)
    plain = joints.closed((upper, lower), TARGET, effects=effects)
    lifted = joints.closed((upper + offset, lower - offset), TARGET, effects=effects)
    np.testing.assert_array_equal(lifted.closure, plain.closure)
    np.testing.assert_array_equal(lifted.normal_stress, plain.normal_stress)
    np.testing.assert_allclose(lifted.upper_final, plain.upper_final + offset, rtol=1e-15)
    assert lifted.upper_final.attrs == plain.upper_final.attrs


@pytest.mark.parametrize("target", ["equilibrate", "interpolate"])
def test_every_step_of_unloading_counts_from_where_the_last_one_ended(walls, target):
    """Also the first after an interpolation, which lies before the step that overshot."""
    begun = []

    class Watched(FastSolver):
        def settle(self, joint, closure, breakage_step):
            begun.append((float(joint.closure), closure))
            return super().settle(joint, closure, breakage_step)

    with patch("jointclosure.solvers.fast.FastSolver", Watched):
        joint = joints.closed(walls, TARGET, target=target)
    for cycle in (1, 2):
        steps = on(joint, cycle, "unloading")[0]
        assert set(itertools.pairwise(steps)) <= set(begun)
        if target == "interpolate":  # the paper's meets the target exactly
            assert on(joint, cycle, "loading")[1][-1] == pytest.approx(TARGET, rel=1e-12)


@pytest.mark.parametrize("breakage", [False, True])
def test_a_tilted_ridge_is_flat_though_rounding_leaves_it_a_curvature(breakage):
    y, x = np.mgrid[:9, :9] * 1.0
    ridge = 1e-5 * (0.3 * y - np.abs(x - 4.0))  # straight along y; the other wall is as tilted
    curvature = np.diff(ridge[:, 4], 2)
    assert 0.0 < np.abs(curvature).max() < 1e-19  # all rounding
    effects = jc.Effects(breakage=breakage, gouge=False)
    joint = joints.closed(
        (ridge, -0.3e-5 * y), 1e7, spacing=1e-4, effects=effects, strength_bound="none"
    )
    assert float(joint.flat_share.max()) > 0.5


@pytest.mark.parametrize("stress", [3e6, 5e6, 30e6])
def test_seating_at_a_step_of_an_elastic_curve_makes_no_step_of_no_length(stress):
    """0.5 MPa is one of sixty stresses, but for rounding."""
    walls = jc.wall_pair(8.0, (8, 8), SPACING, seed=1)
    joint = joints.closed(walls, stress, cycles=1, effects=ELASTIC)
    loading = joint.normal_stress.values[joint.branch.values == "loading"]
    assert np.diff(loading).min() > 1e-3 * stress


@pytest.mark.filterwarnings("ignore:max_normal_stress .* is 5894 %")
def test_a_locked_contact_is_not_counted_as_flat_too():
    pair = 5e-5 * np.random.default_rng(1).standard_normal((2, 12, 12))
    joint = joints.closed((pair[0], pair[1]), 5e7, rock=jc.Rock(50e9, 0.25, 1e6))
    assert float(joint.locked_share.max()) == pytest.approx(1.0)
    assert float(joint.flat_share.max()) == 0.0

"""What is read of each cycle is what engineers are told of the same joint."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engineering.curves import cycle_table
from jointclosure.engineering.stiffness import landing_stress, secant_stiffness
from jointclosure.ensemble.quantities import QUANTITIES, ClosedJoint
from jointclosure.ensemble.responses import responses_of
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.simulation import close_walls
from jointclosure.parameters import Choices, Effects, Numerics

LARGEST, HALF = 20e6, 10e6
SLATE = jc.Rock(youngs_modulus=66e9, poisson_ratio=0.25, compressive_strength=159e6)
CONDITIONS = Conditions(0.25e-3, SLATE, LARGEST, 3, 0.5e6, Effects(), Choices(), Numerics())


@pytest.fixture(scope="module")
def joint():
    walls = jc.wall_pair(jrc=6.5, shape=(24, 24), spacing=0.25e-3, seed=4, roll_off=3e-3)
    closed = close_walls(*walls, CONDITIONS)
    return closed, responses_of(closed, CONDITIONS)


def test_stiffness_is_that_of_each_cycles_own_net_curve(joint):
    """Read off the steps about half of the stress: chords there bound what it can be."""
    closed, responses = joint
    assert closed.status < 16
    net = closed.closure - closed.bulk_indentation
    for cycle in (1, 2, 3):
        here = (closed.cycle == cycle) & (closed.branch == "loading")
        stress, closure = closed.normal_stress.values[here], net.values[here]
        below, above = closure[stress < HALF].max(), closure[stress >= HALF].min()
        last = stress == min(landing_stress(closed, cycle), stress.max())
        end, top = float(closure[last][0]), float(stress[last][0])
        read = responses["stiffness_net"][cycle - 1]
        assert (top - HALF) / (end - below) <= read <= (top - HALF) / (end - above)
    assert landing_stress(closed, 1) < closed.normal_stress.max() < landing_stress(closed, 2)
    # the second cycle is stiffer than the first
    assert responses["stiffness_net"][1] > 2.0 * responses["stiffness_net"][0]


def test_a_loading_that_jumped_over_its_maximum_is_read_to_where_it_came(joint):
    """Half of the stress that was asked for, not of what was reached: the same for all joints."""
    closed, _ = joint
    chord = secant_stiffness(closed, 2, 0.5 * LARGEST, LARGEST)
    assert secant_stiffness(closed, 2, 0.5 * LARGEST, 1.3 * LARGEST) == pytest.approx(
        chord, rel=1e-3
    )
    short = secant_stiffness(closed, 2, 0.65 * LARGEST, 1.3 * LARGEST)
    read = responses_of(closed, CONDITIONS._replace(max_normal_stress=1.3 * LARGEST))
    assert read["stiffness_net"][1] == short > chord


def test_responses_are_what_engineers_are_told_of_the_same_joint(joint):
    closed, responses = joint
    np.testing.assert_array_equal(responses["closure"], closed.max_closure)
    table = cycle_table(closed)
    for name, column in (
        ("closure_net", "max_closure_net_mm"),
        ("closure_seated_net", "closure_net_since_seating_mm"),
        ("residual_seated_net", "residual_net_at_seating_mm"),
    ):
        np.testing.assert_allclose(1e3 * responses[name], table[column], rtol=1e-12)
    bulk = closed.max_bulk_indentation
    np.testing.assert_allclose(responses["closure_net"], closed.max_closure - bulk)


def test_the_loop_is_how_far_unloading_lies_behind_loading_at_half_of_the_stress(joint):
    closed, _ = joint
    walls = closed.upper_final.values, closed.lower_final.values  # of which it reads nothing
    loops = QUANTITIES["loop"].rule(ClosedJoint(walls, closed, CONDITIONS))
    branches = (closed.branch.values == name for name in ("loading", "unloading"))
    steps = [np.flatnonzero((closed.cycle.values == 1) & branch) for branch in branches]
    loading, unloading = (
        np.interp(HALF, closed.normal_stress[here], closed.closure[here])
        for here in (steps[0], steps[1][::-1])
    )
    assert loops[0] == pytest.approx(unloading - loading, rel=1e-3)
    assert loops[0] > 0.1 * closed.max_closure[0]
    assert loops[1:].tolist() == [0.0, 0.0]

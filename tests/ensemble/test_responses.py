"""What is read of each cycle is what engineers are told of the same joint."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engineering.stiffness import landing_stress
from jointclosure.ensemble import responses as responses_module
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.responses import cycle_responses
from jointclosure.ensemble.settings import Conditions
from jointclosure.parameters import Choices, Effects, Numerics

LARGEST, HALF = 20e6, 10e6
SLATE = jc.Rock(youngs_modulus=66e9, poisson_ratio=0.25, compressive_strength=159e6)


@pytest.fixture(scope="module")
def joint():
    walls = jc.wall_pair(jrc=6.5, shape=(24, 24), spacing=0.25e-3, seed=4, roll_off=3e-3)
    conditions = Conditions(0.25e-3, SLATE, LARGEST, 3, 0.5e6, Effects(), Choices(), Numerics())
    return close_walls(*walls, conditions), cycle_responses(walls, conditions)


def test_stiffness_is_that_of_each_cycles_own_curve(joint):
    """Read off the steps about half of the stress: chords there bound what it can be."""
    closed, (status, responses) = joint
    assert status < 16
    for cycle in (1, 2, 3):
        here = (closed.cycle == cycle) & (closed.branch == "loading")
        stress, closure = (closed[name].values[here] for name in ("normal_stress", "closure"))
        below, above = closure[stress < HALF].max(), closure[stress >= HALF].min()
        last = stress == min(landing_stress(closed, cycle), stress.max())
        end, top = float(closure[last][0]), float(stress[last][0])
        read = responses["stiffness"][cycle - 1]
        assert (top - HALF) / (end - below) <= read <= (top - HALF) / (end - above)
        over = (stress.max() - HALF) / read
        assert responses["closure_above_half"][cycle - 1] == pytest.approx(over)
    assert landing_stress(closed, 1) < closed.normal_stress.max() < landing_stress(closed, 2)
    # the second cycle is stiffer than the first
    assert responses["stiffness"][1] > 2.0 * responses["stiffness"][0]


def test_net_stiffness_is_the_chord_of_the_same_stresses_less_the_bulk_indentation(joint):
    """Compliances add: that of the bulk is its indentation over the rise of stress."""
    closed, (_, responses) = joint
    for cycle in (1, 2, 3):
        here = (closed.cycle == cycle) & (closed.branch == "loading")
        stress, bulk = (closed[name].values[here] for name in ("normal_stress", "bulk_indentation"))
        top = min(landing_stress(closed, cycle), stress.max())
        rise = np.diff(np.interp([HALF, top], stress, bulk))[0]
        compliances = 1.0 / responses["stiffness"][cycle - 1] - rise / (top - HALF)
        assert responses["stiffness_net"][cycle - 1] == pytest.approx(1.0 / compliances, rel=0.01)


def test_closures_are_those_of_the_joint(joint):
    closed, (_, responses) = joint
    np.testing.assert_array_equal(responses["closure"], closed.max_closure)
    np.testing.assert_array_equal(responses["residual"], closed.residual_closure)
    np.testing.assert_array_equal(responses["closure_seated"], closed.max_closure_seated)
    bulk = closed.max_bulk_indentation
    np.testing.assert_allclose(responses["closure_net"], closed.max_closure - bulk)


def test_a_failed_simulation_has_no_responses(monkeypatch):
    walls = jc.wall_pair(jrc=6.5, shape=(24, 24), spacing=0.25e-3, seed=4, roll_off=3e-3)
    conditions = Conditions(0.25e-3, SLATE, 1e6, 2, 0.5e6, Effects(), Choices(), Numerics())
    closed = close_walls(*walls, conditions)
    failed = closed.assign(status=closed.status * 0 + 16)
    monkeypatch.setattr(responses_module, "close_walls", lambda *told: failed)
    status, responses = cycle_responses(walls, conditions)
    assert status == 16
    assert all(np.isnan(values).all() for values in responses.values())

"""What makes the solvers fast and right is at work: each part is taken away, and must be missed."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint import protocol
from jointclosure.joint.conditions import LoadCycle
from jointclosure.solvers.fast import FastSolver
from jointclosure.solvers.joint import Joint
from tests import joints
from tests.joints import DOLERITE, SPACING, pair


def closed(seed, cells=24, stress=4e6, largest_radius=20e-3, **stated):
    return joints.closed(pair(cells, seed), stress, largest_radius=largest_radius, **stated)


def test_a_stress_that_shorter_steps_reach_further_on_is_not_taken_for_a_jump(monkeypatch):
    """A long step may leave a joint at a higher force than shorter ones to the same closure do."""

    def jumped(seed):
        joint = closed(seed, largest_radius=None, breakage="resolved", strength_bound="none")
        return int(joint.status) & protocol.TARGET_JUMPED

    misled = (170, 233, 269, 297)  # of 450 seeds
    assert not any(jumped(seed) for seed in misled)
    monkeypatch.setattr(protocol, "_MISLED", 0.0)
    assert any(jumped(seed) for seed in misled)


@pytest.mark.parametrize(("breakage", "tolerance"), [("fixed_step", 1e-12), ("resolved", 1e-3)])
def test_a_cycle_that_could_be_replayed_and_is_closed_again_is_the_same(breakage, tolerance):
    """Equilibrium is unique, and what was found to hold on unloading holds on reloading.

    Without an end of the steps at the former maximum, and with breakage begun at an interaction
    that is extrapolated, single second cycles were off by up to 61 %. Resolved breakage lands on
    the stress within its tolerance.
    """
    compared = 0
    for seed in range(8):
        stated = {"seed": seed, "stress": 1e6, "breakage": breakage}
        replayed, again = (closed(**stated, replay=replay) for replay in (True, False))
        assert int(again.replayed_cycles) == 0
        if int(replayed.replayed_cycles) == 1:
            compared += 1
            assert int(again.newton_steps) > int(replayed.newton_steps)
            assert int(again.breakage_steps) == int(replayed.breakage_steps)
            np.testing.assert_allclose(again.max_closure, replayed.max_closure, rtol=tolerance)
    assert compared >= 5


def test_reloading_beyond_a_former_maximum_breaks_nothing_below_it():
    numerics, looked_at = jc.Numerics(), 0
    for seed in range(6):
        given = (DOLERITE, DOLERITE), jc.Effects(), jc.Choices(), numerics
        joint = Joint(*pair(32, seed), SPACING, *given)
        area = joint.upper.size * SPACING**2
        load = [LoadCycle(5e6 * area), LoadCycle(10e6 * area)]
        history = protocol.run_cycles(joint, FastSolver(), numerics, load)
        former = max(step.settled.closure for step in history.steps if step.cycle == 1)
        again = [step.settled for step in history.steps if step[:2] == (2, "loading")]
        if history.status & protocol.TARGET_JUMPED:
            continue
        looked_at += 1
        assert former in [each.closure for each in again]
        assert not any(each.effort.breakage_steps for each in again if each.closure <= former)
        assert any(each.effort.breakage_steps for each in again)
    assert looked_at >= 3


def test_steps_beyond_a_former_maximum_are_as_short_as_those_of_a_first_loading():
    numerics = jc.Numerics(breakage="resolved", tolerance=0.01)
    stated = {"numerics": numerics, "strength_bound": "base"}
    rises = []
    for load, cycle in (([4e6, 0.0, 8e6], 2), ([8e6], 1)):
        joint = joints.closed(pair(32, 0), load, **stated)
        here = (joint.load_cycle.values == cycle) & (joint.branch.values == "loading")
        stress = joint.normal_stress.values[here]
        rises.append(np.diff(stress)[stress[:-1] >= 4e6])
    assert rises[0].max() < 1.5 * rises[1].max()
    assert 0.5 < rises[0].size / rises[1].size < 2.0

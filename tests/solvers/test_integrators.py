"""What makes the solvers fast and right is at work: each part is taken away, and must be missed."""

import json

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint import protocol, step_control
from jointclosure.joint.conditions import LoadCycle
from jointclosure.solvers import elastic, fast
from jointclosure.solvers.conjugate_gradients import coarse_space, newton_direction, no_coarse_space
from jointclosure.solvers.fast import FastSolver
from jointclosure.solvers.interaction_operator import influence_of, influence_table
from jointclosure.solvers.joint import Joint
from tests import joints
from tests.joints import DOLERITE, ELASTIC, SPACING, pair

MODULUS = 4e10
NO_MATRIX = np.empty((0, 0))


def closed(seed, cells=24, stress=4e6, largest_radius=20e-3, **stated):
    return joints.closed(pair(cells, seed), stress, largest_radius=largest_radius, **stated)


def total(count, seeds, **stated):
    """A count of the effort, summed over surfaces."""
    return sum(int(closed(seed, **stated)[count]) for seed in range(seeds))


def test_breakage_begins_at_the_extrapolated_interaction(monkeypatch):
    """That of the step before is too low while a joint closes, and too much breaks (0006)."""
    now = [closed(seed, 40) for seed in range(8)]
    monkeypatch.setattr(fast, "_note_rates", lambda *_: None)
    before = [closed(seed, 40) for seed in range(8)]
    steps = [sum(int(joint.breakage_steps) for joint in runs) for runs in (now, before)]
    assert steps[0] < 0.98 * steps[1]
    closures = [np.mean([joint.max_closure[0] for joint in runs]) for runs in (now, before)]
    assert closures[0] < closures[1]


LARGE = {"cells": 40, "stress": 10e6}


@pytest.mark.parametrize(
    ("part", "without", "count", "seeds", "stated", "share"),
    [
        # the predictor knows the strength; without it displacement steps shrink
        ("strength_limits", None, "settled_states", 2, {}, 0.8),
        # predictions and steps begin at what is extrapolated, and not at a closure before
        ("_PathToRest.extrapolate", lambda *_: None, "solver_iterations", 3, LARGE, 0.95),
        # what is clear of its strength is solved without a stage between
        (
            "_PathToRest._is_clear_of_strength", lambda _: False, "equilibria", 8,
            LARGE | {"largest_radius": None}, 0.9,
        ),
    ],
)  # fmt: skip
def test_a_part_of_resolved_breakage_saves_what_it_is_for(
    monkeypatch, part, without, count, seeds, stated, share
):
    limits = fast.strength_limits
    now = total(count, seeds, breakage="resolved", **stated)
    blind = without or (lambda *given: np.inf * limits(*given))
    monkeypatch.setattr(f"jointclosure.solvers.fast.{part}", blind)
    assert now < share * total(count, seeds, breakage="resolved", **stated)


def test_the_estimated_error_shortens_displacement_steps(monkeypatch):
    """At coarse tolerances it seldom does: there the rise of the force sets the steps."""
    stated = {"breakage": "resolved", "tolerance": 0.001}
    now = total("settled_states", 3, **stated)
    monkeypatch.setattr(step_control, "_CORRECTION", 1e12)
    assert now > 1.03 * total("settled_states", 3, **stated)


def test_a_stress_that_shorter_steps_reach_further_on_is_not_taken_for_a_jump(monkeypatch):
    """A long step may leave a joint at a higher force than shorter ones to the same closure do."""

    def jumped(seed):
        joint = closed(seed, largest_radius=None, breakage="resolved")
        return int(joint.status) & protocol.TARGET_JUMPED

    misled = (93, 98, 114, 149)  # of 150 seeds
    assert not any(jumped(seed) for seed in misled)
    monkeypatch.setattr(protocol, "_MISLED", 0.0)
    assert any(jumped(seed) for seed in misled)


def system(shape=(42, 42), share=0.4):
    influence = influence_of(influence_table(*shape, 0.5 * SPACING, MODULUS, SPACING))
    rng = np.random.default_rng(7)
    cells = np.flatnonzero(rng.random(shape[0] * shape[1]) < share)
    return influence, cells, (0.5 + 0.5 * rng.random(cells.size)) * 0.5 * SPACING * MODULUS


def test_patches_save_products():
    influence, cells, stiffness = system()
    step = np.sin(np.arange(cells.size)) + 1.0
    used = []
    space = coarse_space(influence, cells, stiffness)
    for each in (space, no_coarse_space()):
        given = (each, step, 1.0 / stiffness, np.nan, 1e-8, np.zeros((42, 42)))
        used.append(newton_direction(influence, NO_MATRIX, cells, *given)[2])
    assert used[0] < 0.75 * used[1]


def test_the_patches_system_has_the_mean_influence_between_their_cells():
    influence, cells, stiffness = system((28, 28), 1.0)
    side = influence.patch
    space = coarse_space(influence, cells, stiffness)
    y, x = np.divmod(cells, 28)
    table = influence.table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
    patch = space.number[influence.patch_of[cells]]
    member = patch[:, None] == np.arange(space.inverse.shape[0])
    mean = member.T @ table @ member / side**4
    total = stiffness @ member
    expected = np.eye(total.size) + np.sqrt(np.outer(total, total)) * mean
    np.testing.assert_allclose(np.linalg.inv(space.inverse), expected, rtol=1e-9)


def test_the_elastic_curve_is_warm_started(monkeypatch):
    def curve():
        return joints.closed(pair(60, 2), 30e6, cycles=1, effects=ELASTIC)

    predicted = elastic._predicted

    def cold(_, *given):
        return predicted([], *given)

    warm = curve()
    monkeypatch.setattr(elastic, "_predicted", cold)
    started_cold = curve()
    np.testing.assert_allclose(warm.closure, started_cold.closure, rtol=1e-9)
    assert warm.solver_iterations < 0.85 * started_cold.solver_iterations
    # twenty stresses: what the README's time rests on
    assert warm.solver_iterations < 30 * 20


@pytest.mark.parametrize("radius", [None, 20e-3])
def test_what_was_chosen_is_written_into_the_result(radius):
    found = closed(3, 12, 1e5, radius, cycles=1, breakage="resolved")
    assert json.loads(found.attrs["choices"])["largest_radius"] == radius
    assert json.loads(found.attrs["numerics"])["breakage"] == "resolved"
    assert json.loads(found.attrs["effects"])["gouge"] is True


def test_where_unloading_breaks_nothing_later_cycles_are_its_curve_and_cost_nothing(monkeypatch):
    replayed = closed(3, force_tolerance=1e-11)
    assert int(replayed.replayed_cycles) == 1
    monkeypatch.setattr(protocol, "_repeat_elastic", lambda *_: None)
    ends_early = closed(3, force_tolerance=1e-11)
    assert ends_early.sizes["step"] < replayed.sizes["step"]
    assert int(ends_early.newton_steps) == int(replayed.newton_steps)


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


def test_a_target_that_was_jumped_over_or_interpolated_is_loaded_to_again():
    """There the maximum is not the end of a loading that the next cycle must repeat."""
    assert int(closed(3, target="interpolate").replayed_cycles) == 0

"""What makes the solvers fast and right is at work: each part is taken away, and must be missed."""

import json

import numpy as np
import pytest

import jointclosure as jc
from jointclosure import protocol
from jointclosure.solvers import elastic, fast
from jointclosure.solvers.coarse_space import CoarseSpace, coarse_space
from jointclosure.solvers.conjugate_gradients import newton_direction
from jointclosure.solvers.contacts import separate_equilibrium, separate_shift
from jointclosure.solvers.interaction_operator import influence_of, influence_table
from tests.conftest import DOLERITE, SPACING

MODULUS = 4e10
NO_MATRIX = np.empty((0, 0))


def closed(seed, cells=24, stress=4e6, **numerics):
    return jc.simulate(
        *jc.wall_pair(8.0, (cells, cells), SPACING, seed),
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=stress,
        choices=jc.Choices(largest_radius=20e-3),
        numerics=jc.Numerics(**numerics),
    )


def test_breakage_begins_at_the_extrapolated_interaction(monkeypatch):
    """That of the step before is too low while a joint closes, and too much breaks (0006)."""
    seeds = range(8)
    now = [closed(seed, 40) for seed in seeds]
    monkeypatch.setattr(fast, "_note_rates", lambda *_: None)
    before = [closed(seed, 40) for seed in seeds]
    steps = [sum(int(each.breakage_steps) for each in runs) for runs in (now, before)]
    assert steps[0] < 0.98 * steps[1]
    closures = [np.mean([each.max_closure[0] for each in runs]) for runs in (now, before)]
    assert closures[0] < closures[1]


def test_the_predictor_of_resolved_breakage_knows_the_strength(monkeypatch):
    now = closed(1, breakage="resolved")
    limits = fast.strength_limits
    monkeypatch.setattr(fast, "strength_limits", lambda *given: np.inf * limits(*given))
    blind = closed(1, breakage="resolved")
    # it misses the force, and the displacement steps shrink
    assert now.sizes["step"] < 0.8 * blind.sizes["step"]


def test_the_estimated_error_shortens_displacement_steps(monkeypatch):
    now = [closed(seed, breakage="resolved").sizes["step"] for seed in range(6)]
    monkeypatch.setattr(protocol, "_CORRECTION", 1e12)
    without = [closed(seed, breakage="resolved").sizes["step"] for seed in range(6)]
    assert sum(now) > sum(without)


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
    for each in (space, CoarseSpace(space.patch, NO_MATRIX)):
        given = (each, step, 1.0 / stiffness, np.nan, 1e-8, np.zeros((42, 42)))
        used.append(newton_direction(influence, NO_MATRIX, cells, *given)[2])
    assert used[0] < 0.75 * used[1]


def test_the_patches_system_has_the_mean_influence_between_their_cells():
    influence, cells, stiffness = system((28, 28), 1.0)
    side = influence.patch
    space = coarse_space(influence, cells, stiffness)
    y, x = np.divmod(cells, 28)
    table = influence.table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
    member = space.patch[:, None] == np.arange(space.inverse.shape[0])
    mean = member.T @ table @ member / side**4
    total = stiffness @ member
    expected = np.eye(total.size) + np.sqrt(np.outer(total, total)) * mean
    np.testing.assert_allclose(np.linalg.inv(space.inverse), expected, rtol=1e-9)


def test_the_elastic_curve_is_warm_started(monkeypatch):
    def curve():
        return jc.simulate(
            *jc.wall_pair(8.0, (60, 60), SPACING, seed=2),
            spacing=SPACING,
            rock=DOLERITE,
            max_normal_stress=30e6,
            cycles=1,
            effects=jc.Effects(breakage=False, gouge=False),
        )

    def cold(solved, target, contacts):
        closure = separate_shift(contacts, target)
        return separate_equilibrium(contacts, closure), closure

    warm = curve()
    monkeypatch.setattr(elastic, "_predicted", cold)
    started_cold = curve()
    np.testing.assert_allclose(warm.closure, started_cold.closure, rtol=1e-9)
    assert warm.solver_iterations < 0.85 * started_cold.solver_iterations
    # twenty stresses: what the README's time rests on
    assert warm.solver_iterations < 30 * 20


@pytest.mark.parametrize("radius", [None, 20e-3])
def test_what_was_chosen_is_written_into_the_result(small_joint, radius):
    found = jc.simulate(
        *small_joint,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=1e5,
        cycles=1,
        choices=jc.Choices(largest_radius=radius),
        numerics=jc.Numerics(breakage="resolved"),
    )
    assert json.loads(found.attrs["choices"])["largest_radius"] == radius
    assert json.loads(found.attrs["numerics"])["breakage"] == "resolved"
    assert json.loads(found.attrs["effects"])["gouge"] is True


def test_where_unloading_breaks_nothing_later_cycles_are_its_curve_and_cost_nothing(monkeypatch):
    """Reloading by equilibria of its own gives the same closures: equilibrium is unique."""
    replayed = closed(3, force_tolerance=1e-11)
    calls = []
    monkeypatch.setattr(protocol, "_repeat_elastic", lambda *given: calls.append(given))
    ends_early = closed(3, force_tolerance=1e-11)
    assert len(calls) == 1
    assert ends_early.sizes["step"] < replayed.sizes["step"]
    monkeypatch.undo()
    monkeypatch.setattr(protocol, "_is_elastic_from_here", lambda *_: False)
    stepped = closed(3, force_tolerance=1e-11)
    assert replayed.newton_steps < stepped.newton_steps
    assert replayed.max_closure.values == pytest.approx(stepped.max_closure.values, rel=1e-3)
    # what reloading breaks beyond the maximum is thrown away
    assert int(stepped.breakage_steps) >= int(replayed.breakage_steps)


def test_a_target_that_was_jumped_over_or_interpolated_is_loaded_to_again(monkeypatch):
    """There the maximum is not the end of a loading that the next cycle must repeat."""
    monkeypatch.setattr(protocol, "_repeat_elastic", lambda *_: pytest.fail("was replayed"))
    closed(3, target="interpolate")

"""Interaction is left out while it is idle, and only then."""

import json

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engine.joints import Reading, close_joint
from jointclosure.joint import protocol
from jointclosure.joint.conditions import Conditions, LoadCycle
from jointclosure.joint.protocol import LOADING, run_cycles
from jointclosure.solvers.interaction_operator import interaction_field
from jointclosure.solvers.joint import Joint
from jointclosure.solvers.registry import solver_named
from jointclosure.storage.text import read_csv
from studies.frame.config.configuration import configured, merged, merged_study
from tests.joints import DOLERITE, SPACING

SHARE = 0.05


@pytest.fixture(autouse=True)
def _small_joints_too(monkeypatch):
    monkeypatch.setattr(protocol, "_FEWEST_CONTACTS", 0)


def test_where_few_cells_touch_nothing_is_left_out(monkeypatch):
    """10 MPa of 165 MPa: 0.0606 of the cells at a pressure of the strength, 97 of 1600."""
    for fewest, idle in ((96, True), (98, False)):
        monkeypatch.setattr(protocol, "_FEWEST_CONTACTS", fewest)
        assert bool(closed(1, SHARE).idle_steps) is idle


def test_where_nearly_all_time_goes_into_what_breaks_nothing_is_left_out(monkeypatch):
    """10 MPa of 165 MPa: at a pressure of the strength 0.0606 of the cells carry it."""
    for most, idle in ((0.0605, False), (0.0607, True)):
        monkeypatch.setattr(protocol, "_MOST_CRUSHED", most)
        assert bool(closed(1, SHARE).idle_steps) is idle


def closed(seed, idle_interaction, cells=40, stress=10e6, **numerics):
    return jc.simulate(
        *jc.wall_pair(8.0, (cells, cells), SPACING, seed, roll_off=None),
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=stress,
        numerics=jc.Numerics(idle_interaction=idle_interaction, **numerics),
        seating_stress=0.0,
    )


def test_it_is_left_out_of_the_beginning_of_the_first_loading_alone():
    joint = closed(1, SHARE)
    indentation, loaded = joint.bulk_indentation.values, joint.normal_stress.values > 0.0
    idle = int(joint.idle_steps)
    assert 3 <= idle < int(np.argmax(joint.normal_stress.values))
    # step 0 is first touch
    assert not indentation[: idle + 1].any()
    assert (indentation[idle + 1 :][loaded[idle + 1 :]] > 0.0).all()
    assert float(joint.equilibrium_residual.max()) <= jc.Numerics().force_tolerance


@pytest.mark.parametrize("solver", ["fast", "reference"])
def test_no_contact_of_an_idle_step_would_be_displaced_by_more_than_the_share(solver):
    """The certificate, computed from the forces of each step by an influence of its own."""
    cells, share = 24, 0.01
    numerics = jc.Numerics(idle_interaction=share, solver=solver)
    rock = DOLERITE, DOLERITE
    joint = Joint(
        *jc.wall_pair(8.0, (cells, cells), SPACING, 1, roll_off=None),
        SPACING,
        rock,
        jc.Effects(),
        jc.Choices(),
        numerics,
    )
    shares = []

    def look(joint, step):
        if step.cycle == 1 and step.branch == LOADING and step.settled.closure > 0.0:
            y, x = np.nonzero(joint.force)
            table = joint.influence_table
            acting = table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
            displaced = acting @ joint.force[y, x]
            shares.append(displaced.max(initial=0.0) / step.settled.closure)

    load = [LoadCycle(10e6 * (cells * SPACING) ** 2)]
    history = run_cycles(joint, solver_named(solver), numerics, load, observers=[look])
    idle = history.idle_steps
    assert idle >= 3
    assert history.idle_displacement == pytest.approx(max(shares[:idle]), rel=1e-9)
    assert max(shares[:idle]) <= share
    assert max(shares) > share


def test_what_is_left_out_bounds_what_it_would_be():
    """On the same walls at the same closure: without interaction contacts carry more."""
    numerics, rock = jc.Numerics(), (DOLERITE, DOLERITE)
    for seed in range(4):
        walls = jc.wall_pair(8.0, (32, 32), SPACING, seed, roll_off=None)
        effects = jc.Effects(breakage=False, gouge=False)
        joint = Joint(*walls, SPACING, rock, effects, jc.Choices(), numerics)
        joint.interaction_acts = False
        solver_named("fast").settle(joint, 50e-6, numerics.breakage_step)
        bound = joint.interaction_left_out()
        joint.resume_interaction()
        solver_named("fast").settle(joint, 50e-6, numerics.breakage_step)
        field = interaction_field(joint.influence, joint.force)
        assert 0.0 < field[joint.force > 0.0].max() <= bound


def test_means_of_closure_stay_within_the_share_and_products_are_saved():
    seeds = range(10)
    full, less = ([closed(seed, share) for seed in seeds] for share in (0.0, SHARE))
    means = [np.mean([each.max_closure.values for each in runs], axis=0) for runs in (full, less)]
    assert np.abs(means[1] / means[0] - 1.0).max() <= SHARE
    products = [sum(int(each.solver_iterations) for each in runs) for runs in (full, less)]
    assert products[1] < 0.9 * products[0]


def test_without_a_share_nothing_is_left_out():
    joint = closed(1, 0.0, cells=16, stress=2e6)
    assert int(joint.idle_steps) == 0
    assert float(joint.idle_displacement) == 0.0
    assert (joint.bulk_indentation.values[1:6] > 0.0).all()


def test_it_acts_at_the_maximum_even_where_it_is_idle_up_to_there():
    joint = closed(1, 0.9, cells=16, stress=0.5e6)
    assert int(joint.idle_steps) > 0
    assert (joint.max_bulk_indentation.values > 0.0).all()


def test_a_scene_without_interaction_has_no_idle_steps():
    joint = jc.simulate(
        *jc.wall_pair(8.0, (16, 16), SPACING, 1, roll_off=None),
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=2e6,
        effects=jc.Effects(interaction=False),
        numerics=jc.Numerics(idle_interaction=SHARE),
    )
    assert int(joint.idle_steps) == 0


def test_a_simulation_that_ends_early_tells_its_scene_all_the_same():
    joint = closed(1, 0.9, cells=16, stress=2e6, most_steps=45)
    assert int(joint.status) >= 16
    assert json.loads(joint.attrs["effects"])["interaction"] is True


def test_the_results_of_a_study_bear_the_certificate():
    walls = jc.wall_pair(8.0, (40, 40), SPACING, 1, roll_off=None)
    numerics = jc.Numerics(idle_interaction=SHARE)
    stated = Conditions(SPACING, DOLERITE, 10e6, 2, 0.0, jc.Effects(), jc.Choices(), numerics)
    row = close_joint(walls, Reading(stated, ("idle_steps", "idle_displacement")))
    assert row["idle_steps"] >= 3
    assert 0.0 < row["idle_displacement"] <= SHARE


@pytest.mark.parametrize("share", [-0.1, np.nan])
def test_a_share_out_of_range_is_refused(share):
    with pytest.raises(jc.InputError, match="idle_interaction"):
        closed(1, share, cells=16)


@pytest.mark.parametrize(
    ("keys", "share"),
    [
        ({}, 0.0),
        ({"effects": {"auto": 0.05}}, 0.05),
        ({"effects": {"auto": 0.05}, "numerics": {"idle_interaction": 0.0}}, 0.0),
    ],
)
def test_a_study_leaves_it_out_where_effects_are_chosen_unless_told_otherwise(keys, share):
    stated = configured(merged(merged_study(), keys), read_csv).typed
    assert stated.numerics.idle_interaction == share

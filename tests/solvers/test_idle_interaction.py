"""Interaction is left out while it is idle, and only then."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint import protocol
from jointclosure.joint.conditions import LoadCycle
from jointclosure.joint.protocol import LOADING, run_cycles
from jointclosure.solvers.interaction_operator import interaction_field
from jointclosure.solvers.joint import Joint
from jointclosure.solvers.registry import solver_named
from tests import joints
from tests.joints import DOLERITE, ELASTIC, SPACING, pair

SHARE = 0.05


@pytest.fixture(autouse=True)
def _small_joints_too(monkeypatch):
    monkeypatch.setattr(protocol, "_FEWEST_CONTACTS", 0)


def closed(seed=1, share=SHARE, cells=40, stress=10e6, **stated):
    about = {"seating_stress": 0.0, "idle_interaction": share}
    return joints.closed(pair(cells, seed), stress, **about | stated)


def joint_of(cells, seed, numerics, effects=jc.Effects()):
    rocks = DOLERITE, DOLERITE
    return Joint(*pair(cells, seed), SPACING, rocks, effects, jc.Choices(), numerics)


def test_it_is_left_out_of_the_beginning_of_the_first_loading_alone():
    joint = closed()
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
    shares = []

    def look(joint, step):
        if step.cycle == 1 and step.branch == LOADING and step.settled.closure > 0.0:
            y, x = np.nonzero(joint.force)
            acting = joint.influence_table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
            displaced = acting @ joint.force[y, x]
            shares.append(displaced.max(initial=0.0) / step.settled.closure)

    load = [LoadCycle(10e6 * (cells * SPACING) ** 2)]
    joint = joint_of(cells, 1, numerics)
    history = run_cycles(joint, solver_named(solver), numerics, load, observers=[look])
    idle = history.idle_steps
    assert idle >= 3
    assert history.idle_displacement == pytest.approx(max(shares[:idle]), rel=1e-9)
    assert max(shares[:idle]) <= share < max(shares)


def test_what_is_left_out_bounds_what_it_would_be():
    """On the same walls at the same closure: without interaction contacts carry more."""
    numerics = jc.Numerics()
    for seed in range(4):
        joint = joint_of(32, seed, numerics, ELASTIC)
        joint.interaction_acts = False
        solver_named("fast").settle(joint, 50e-6, numerics.breakage_step)
        bound = joint.interaction_left_out()
        joint.resume_interaction()
        solver_named("fast").settle(joint, 50e-6, numerics.breakage_step)
        field = interaction_field(joint.influence, joint.force)
        assert 0.0 < field[joint.force > 0.0].max() <= bound


@pytest.mark.parametrize(
    ("bound", "value", "idle"),
    [
        # 10 MPa of 165 MPa: at a pressure of the strength 0.0606 of the cells, 97 of 1600, carry it
        ("_FEWEST_CONTACTS", 96, True),
        ("_FEWEST_CONTACTS", 98, False),
        ("_MOST_CRUSHED", 0.0605, False),
        ("_MOST_CRUSHED", 0.0607, True),
    ],
)
def test_where_few_cells_touch_or_most_are_crushed_nothing_is_left_out(
    monkeypatch, bound, value, idle
):
    monkeypatch.setattr(protocol, bound, value)
    assert bool(closed().idle_steps) is idle

"""Flow at every step of a history: what it adds, and what it leaves alone."""

import json

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.conditions import LoadCycle
from jointclosure.joint.flow import DIRECTIONS, FLOWS, flow_along
from jointclosure.joint.protocol import run_cycles
from jointclosure.joint.states import fields_of
from jointclosure.solvers.joint import Effort, Joint
from jointclosure.solvers.registry import solver_named
from tests.joints import DOLERITE, SPACING

ADDED = ["hydraulic_aperture", "flow_status", "flow_imbalance"]
SCENES = {"all": jc.Effects(), "elastic": jc.Effects(breakage=False, gouge=False)}
LOAD = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 5e6}


def walls():
    return jc.wall_pair(8.0, (20, 24), SPACING, seed=3, roll_off=None)


@pytest.fixture(scope="module", params=SCENES)
def joints(request):
    """A joint without flow and with it."""
    return [
        jc.simulate(*walls(), effects=SCENES[request.param], flow=on, **LOAD)
        for on in (False, True)
    ]


def test_flow_changes_no_bit_of_anything_else(joints):
    without, with_flow = joints
    assert set(ADDED) == set(with_flow.data_vars) - set(without.data_vars)
    xr.testing.assert_identical(without, with_flow.drop_vars([*ADDED, "direction"]))


def test_every_step_has_a_flow_in_both_directions_with_units(joints):
    closed = joints[1]
    assert closed.hydraulic_aperture.dims == ("step", "direction")
    assert tuple(closed.direction.values) == DIRECTIONS
    assert closed.hydraulic_aperture.attrs["units"] == "m"
    assert (closed.flow_status == FLOWS).all()
    assert float(closed.flow_imbalance.max()) < 1e-11
    assert np.isfinite(closed.hydraulic_aperture).all()


def test_a_joint_passes_less_the_farther_it_is_closed(joints):
    closed = joints[1]
    for branch in ("loading", "unloading"):
        here = (closed.branch == branch).values & (closed.cycle == 2).values
        order = np.argsort(closed.closure.values[here])
        apertures = closed.hydraulic_aperture.values[here][order]
        assert (np.diff(apertures, axis=0) < 0.0).all()


def test_at_first_touch_the_field_is_the_walls_distance(joints):
    upper, lower = walls()
    aperture = (upper + lower).max() - (upper + lower)
    for index, direction in enumerate(DIRECTIONS):
        expected = flow_along(aperture, direction).hydraulic_aperture
        assert joints[1].hydraulic_aperture.values[0, index] == pytest.approx(expected, rel=1e-12)


def test_what_an_observer_is_shown_is_the_joint_at_that_step(joints):
    closed, shown = joints[1], []

    def observe(joint, step):
        overlap = fields_of(joint, step.settled.closure).overlap
        aperture = np.where(overlap > 0.0, 0.0, -overlap)  # contacts pass nothing
        along = [flow_along(aperture, direction).hydraulic_aperture for direction in DIRECTIONS]
        shown.append((step.settled.closure, -overlap.mean(), (overlap > 0.0).mean(), *along))

    effects = jc.Effects(**json.loads(closed.attrs["effects"]))
    joint = Joint(*walls(), SPACING, (DOLERITE, DOLERITE), effects, jc.Choices(), jc.Numerics())
    force = LOAD["max_normal_stress"] * joint.upper.size * SPACING**2
    load = [LoadCycle(force)] * 2
    seating = closed.attrs["seating_stress_Pa"] * joint.upper.size * SPACING**2
    run_cycles(joint, solver_named("fast"), jc.Numerics(), load, seating, observers=[observe])
    closure, mean, contact, *along = np.array(shown).T
    assert np.array_equal(closure, closed.closure)
    assert np.allclose(mean, closed.mean_aperture, rtol=1e-9, atol=0.0)
    assert np.allclose(contact, closed.contact_fraction, rtol=1e-12, atol=0.0)
    assert np.allclose(np.transpose(along), closed.hydraulic_aperture, rtol=1e-9, atol=0.0)


def test_an_observer_of_a_replayed_cycle_is_shown_the_joint_at_each_of_its_steps():
    joint = Joint(
        *walls(), SPACING, (DOLERITE, DOLERITE), jc.Effects(), jc.Choices(), jc.Numerics()
    )
    seen = []
    history = run_cycles(
        joint,
        solver_named("fast"),
        jc.Numerics(),
        [LoadCycle(5e6 * joint.upper.size * SPACING**2)] * 3,
        observers=[lambda joint, step: seen.append((joint.force.sum(), step))],
    )
    replayed = [step.settled.effort == Effort() for step in history.steps if step.cycle == 3]
    assert all(replayed)
    assert len(seen) == len(history.steps)
    for total, step in seen:
        assert total == step.settled.total_force
    assert joint.force.sum() == 0.0


def test_a_replayed_cycle_costs_no_flow(monkeypatch):
    """The third cycle breaks nothing: its steps are those of the second."""
    solved = []

    def counted(aperture, direction):
        solved.append(direction)
        return flow_along(aperture, direction)

    monkeypatch.setattr("jointclosure.joint.flow.flow_along", counted)
    closed = jc.simulate(*walls(), flow=True, cycles=3, **LOAD)
    second, third = (
        closed.isel(step=np.flatnonzero((closed.cycle == cycle).values)) for cycle in (2, 3)
    )
    assert third.sizes["step"] > 3
    assert np.array_equal(
        third.hydraulic_aperture, second.hydraulic_aperture[-third.sizes["step"] :]
    )
    states = closed.sizes["step"] - third.sizes["step"]
    assert len(solved) <= len(DIRECTIONS) * states

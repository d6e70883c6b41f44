"""Flow and snapshots at the steps of a history: what they add, and what they leave alone."""

import itertools
import json

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.flow import DIRECTIONS, FLOWS, flow_along
from jointclosure.joint.result_tables import curve_table, cycle_table, stress_table
from tests import joints
from tests.joints import ELASTIC, SPACING, pair

SHAPE = (20, 24)


STRESS = 5e6


ASKED = [5e6, 0.0, 2e6]


AREA = 20 * 24 * SPACING**2


OFFSET = 0.3
"""Of the upper wall [m]: walls are told as they were given."""


def lifted():
    upper, lower = pair(SHAPE)
    return upper + OFFSET, lower


@pytest.fixture(
    scope="module", params=[jc.Effects(gouge=False), ELASTIC], ids=["broken", "elastic"]
)
def observed(request):
    """A joint, and the same one with flow and snapshots; what vanishes changes a wall's mean."""
    # without a bound of strength the second unloading breaks nothing, and is replayed
    about = {"effects": request.param, "strength_bound": "none", "cycles": 3}
    asked = {"flow": True, "snapshots": ASKED}
    return [joints.closed(lifted(), STRESS, **about, **more) for more in ({}, asked)]


def test_observers_change_no_bit_of_anything_else(observed):
    without, closed = observed
    added = set(closed.variables) - set(without.variables)
    flow = {"hydraulic_aperture", "smallest_hydraulic", "largest_hydraulic"}
    flow |= {"flow_status", "flow_imbalance", "direction"}
    others = {name for name in added if name.startswith("snapshot_") or name.endswith("_first")}
    assert added - others == flow
    xr.testing.assert_identical(without, closed.drop_vars(added))


def test_every_step_has_a_flow_that_falls_as_the_joint_closes(observed):
    closed = observed[1]
    assert closed.hydraulic_aperture.dims == ("step", "direction")
    assert tuple(closed.direction.values) == DIRECTIONS
    assert closed.hydraulic_aperture.attrs["units"] == "m"
    assert (closed.flow_status == FLOWS).all()
    assert float(closed.flow_imbalance.max()) < 1e-11
    for branch in ("loading", "unloading"):
        here = (closed.branch == branch).values & (closed.load_cycle == 2).values
        order = np.argsort(closed.closure.values[here])
        assert (np.diff(closed.hydraulic_aperture.values[here][order], axis=0) < 0.0).all()


def test_each_branch_is_shown_where_it_first_passes_each_stress_at_the_nearer_step(observed):
    closed = observed[1]
    at = (closed[f"snapshot_{name}"].values.tolist() for name in ("cycle", "branch", "stress"))
    up, down = [2e6, 5e6], [2e6, 0.0]
    assert list(zip(*at, strict=True)) == [
        (cycle, branch, stress)
        for cycle, branch, stresses in (
            (1, "loading", [0.0, *up]), (1, "unloading", down),
            (2, "loading", up), (2, "unloading", down),
            (3, "loading", up), (3, "unloading", down),
        )
        for stress in stresses
    ]  # fmt: skip
    stress = closed.normal_stress.values
    for snapshot in range(1, closed.sizes["snapshot"]):
        here = closed.isel(snapshot=snapshot)
        branch, asked = here.snapshot_branch.item(), here.snapshot_stress.item()
        own = (closed.load_cycle == here.snapshot_cycle.item()) & (closed.branch == branch)
        beyond = stress >= 0.999 * asked if branch == "loading" else stress <= 1.001 * asked
        after = int(np.flatnonzero(own.values & beyond)[0])
        nearer = min((after - 1, after), key=lambda step: abs(stress[step] - asked))
        assert here.snapshot_step.item() == nearer


def test_snapshots_have_the_means_of_their_step_also_of_a_replayed_cycle(observed):
    closed = observed[1]
    steps = closed.isel(step=closed.snapshot_step.values)
    force = closed.snapshot_force.sum(("y", "x")).values
    np.testing.assert_allclose(force / AREA, steps.normal_stress, rtol=1e-9, atol=1e-6)
    gap = closed.snapshot_gap
    for name, part in (("mean_aperture", gap), ("mean_overlap", -gap)):
        mean = part.where(part > 0.0, 0.0).mean(("y", "x")).values
        np.testing.assert_allclose(mean, steps[name], rtol=2e-3 if "over" in name else 1e-8)
    contact = (closed.snapshot_gap < 0.0).mean(("y", "x")).values
    np.testing.assert_allclose(contact, steps.contact_fraction, rtol=1e-12, atol=0.0)
    assert ((closed.snapshot_force > 0.0) == (closed.snapshot_gap < 0.0)).all()
    passed = [
        [flow_along(np.maximum(gap, 0.0), way).hydraulic_aperture for way in DIRECTIONS]
        for gap in closed.snapshot_gap.values
    ]
    np.testing.assert_allclose(steps.hydraulic_aperture, passed, rtol=1e-9)
    assert int(closed.replayed_cycles) > 0 or not json.loads(closed.attrs["effects"])["breakage"]


@pytest.mark.parametrize("breakage", [False, True])
def test_the_mean_aperture_is_the_void_that_is_left_however_far_contacts_overlap(breakage):
    """Mated walls in contact nearly everywhere, where the mean of signed distances is negative."""
    upper, _ = pair(12)
    noise = 1e-6 * np.random.default_rng(1).standard_normal(upper.shape)
    stress, effects = 60e6, jc.Effects(breakage=breakage, gouge=breakage)
    walls = upper, noise - upper
    closed = joints.closed(walls, stress, effects=effects, snapshots=[stress], flow=True)
    at = closed.isel(step=int(closed.snapshot_step[0]))
    gap = closed.snapshot_gap.isel(snapshot=0)
    assert float(at.contact_fraction) > 0.5
    assert float(gap.mean()) < 0.0
    void = float(gap.where(gap > 0.0, 0.0).mean())
    assert float(at.mean_aperture) == pytest.approx(void, rel=1e-6, abs=1e-12)
    assert (closed.mean_aperture >= 0.0).all()
    steps = curve_table(closed)
    area = SPACING**2 * upper.size
    np.testing.assert_allclose(steps.void_volume_mm3, 1e6 * area * steps.mean_aperture_mm)
    assert (steps.void_volume_mm3 >= 0.0).all()
    for table in (steps, stress_table(closed), cycle_table(closed)):
        apertures = table.filter(like="aperture").select_dtypes("number").fillna(0.0)
        assert (apertures >= 0.0).all(axis=None)
        ratios = table.filter(like="ratio").to_numpy()
        assert not np.isinf(ratios).any()


def test_walls_in_snapshots_run_from_the_given_to_the_final_ones(observed):
    closed = observed[1]
    for name, given in zip(("upper", "lower"), lifted(), strict=True):
        taken = closed[f"snapshot_{name}"].values
        np.testing.assert_array_equal(taken[0], given)
        np.testing.assert_array_equal(closed[f"{name}_first"], given)
        np.testing.assert_array_equal(taken[-1], closed[f"{name}_final"])


def test_the_broken_volume_is_what_walls_are_lower_by(observed):
    closed = observed[1]
    lost = sum(
        SPACING**2 * np.maximum(given - closed[f"snapshot_{name}"].values, 0.0).sum(axis=(1, 2))
        for name, given in zip(("upper", "lower"), lifted(), strict=True)
    )
    np.testing.assert_allclose(closed.snapshot_broken_volume, lost, rtol=1e-6, atol=1e-20)
    if json.loads(closed.attrs["effects"])["breakage"]:
        assert closed.snapshot_broken_volume.values[0] == 0.0
        assert all(a < b for a, b in itertools.pairwise(lost[:3]))
    else:
        assert (closed.snapshot_broken_volume == 0.0).all()


@pytest.mark.parametrize("wrong", [-1.0, 5.1e6, np.nan, np.inf])
def test_a_stress_that_cannot_be_reached_is_refused(wrong, small_joint):
    with pytest.raises(jc.InputError, match=r"snapshots: .* must be from 0 to the maximum"):
        joints.closed(small_joint, STRESS, snapshots=[1e6, wrong])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_maximum_that_is_reached_within_the_tolerance_is_shown(seed):
    walls = jc.wall_pair(8.0, (20, 24), SPACING, seed)
    closed = joints.closed(walls, 3e6, cycles=1, snapshots=[3e6], strength_bound="none")
    reached = float(closed.normal_stress.max()) >= 3e6 * (1.0 - jc.Numerics().stress_tolerance)
    shown = closed.snapshot_branch.values.tolist() == ["loading"]
    assert shown == reached

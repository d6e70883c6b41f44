"""The state of a joint at stresses that were asked for."""

import itertools

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.storage.netcdf import read_netcdf
from tests.joints import DOLERITE, SPACING

LOAD = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 5e6}
ASKED = [5e6, 0.0, 2e6]
SCENES = {"all": jc.Effects(), "elastic": jc.Effects(breakage=False, gouge=False)}
OFFSET = 0.3
"""Of the upper wall [m]: walls are told as they were given."""


def walls():
    upper, lower = jc.wall_pair(8.0, (20, 24), SPACING, seed=3, roll_off=None)
    return upper + OFFSET, lower


@pytest.fixture(scope="module", params=SCENES)
def joints(request):
    """A joint without snapshots and with them."""
    return [
        jc.simulate(*walls(), effects=SCENES[request.param], snapshots=asked, **LOAD)
        for asked in ((), ASKED)
    ]


def test_snapshots_change_no_bit_of_anything_else(joints):
    without, closed = joints
    added = [name for name in closed.variables if name not in without.variables]
    assert all(name.startswith("snapshot_") or name.endswith("_first") for name in added)
    xr.testing.assert_identical(without, closed.drop_vars(added))


def test_each_branch_is_shown_where_it_passes_each_stress(joints):
    closed = joints[1]
    stated = zip(
        closed.snapshot_cycle.values, closed.snapshot_branch.values, closed.snapshot_stress.values,
        strict=True,
    )  # fmt: skip
    assert [(int(cycle), branch, float(stress)) for cycle, branch, stress in stated] == [
        (1, "loading", 0.0), (1, "loading", 2e6), (1, "loading", 5e6),
        (1, "unloading", 2e6), (1, "unloading", 0.0),
        (2, "loading", 2e6), (2, "loading", 5e6), (2, "unloading", 2e6), (2, "unloading", 0.0),
    ]  # fmt: skip


def test_the_step_that_is_shown_is_the_nearer_one_of_the_first_pass(joints):
    closed = joints[1]
    stress = closed.normal_stress.values
    for snapshot in range(1, closed.sizes["snapshot"]):
        here = closed.isel(snapshot=snapshot)
        branch, asked = here.snapshot_branch.item(), here.snapshot_stress.item()
        own = (closed.cycle == here.snapshot_cycle.item()) & (closed.branch == branch)
        beyond = stress >= 0.999 * asked if branch == "loading" else stress <= 1.001 * asked
        after = int(np.flatnonzero(own.values & beyond)[0])
        nearer = min((after - 1, after), key=lambda step: abs(stress[step] - asked))
        assert here.snapshot_step.item() == nearer


def test_forces_gap_and_contacts_are_those_of_the_step(joints):
    closed = joints[1]
    steps = closed.isel(step=closed.snapshot_step.values)
    force = closed.snapshot_force.sum(("y", "x")).values
    area = 20 * 24 * SPACING**2
    np.testing.assert_allclose(force / area, steps.normal_stress, rtol=1e-9, atol=1e-6)
    gap = closed.snapshot_gap.mean(("y", "x")).values
    np.testing.assert_allclose(gap, steps.mean_aperture, rtol=1e-9, atol=0.0)
    contact = (closed.snapshot_gap < 0.0).mean(("y", "x")).values
    np.testing.assert_allclose(contact, steps.contact_fraction, rtol=1e-12, atol=0.0)
    assert ((closed.snapshot_force > 0.0) == (closed.snapshot_gap < 0.0)).all()


def test_the_first_walls_are_those_given_and_the_last_those_at_the_end(joints):
    closed = joints[1]
    for name, given in zip(("upper", "lower"), walls(), strict=True):
        taken = closed[f"snapshot_{name}"].values
        np.testing.assert_array_equal(taken[0], given)
        np.testing.assert_array_equal(closed[f"{name}_first"], given)
        np.testing.assert_array_equal(taken[-1], closed[f"{name}_final"])


def test_what_has_broken_is_what_walls_are_lower_by(joints):
    closed = joints[1]
    lost = [
        SPACING**2
        * sum(
            np.maximum(closed[f"{name}_first"] - closed[f"snapshot_{name}"][k], 0.0).values.sum()
            for name in ("upper", "lower")
        )
        for k in range(closed.sizes["snapshot"])
    ]
    np.testing.assert_allclose(closed.snapshot_broken_volume, lost, rtol=1e-6, atol=1e-20)
    if "true" in closed.attrs["effects"].partition("breakage")[2][:8]:
        assert closed.snapshot_broken_volume.values[0] == 0.0
        assert all(a < b for a, b in itertools.pairwise(lost[:3]))
    else:
        assert (closed.snapshot_broken_volume == 0.0).all()


def test_variables_have_units_and_come_back_from_a_file(joints, tmp_path):
    from jointclosure.storage.netcdf import write_netcdf

    write_netcdf(joints[1], tmp_path / "joint.nc")
    again = read_netcdf(tmp_path / "joint.nc")
    for name in ("upper", "lower", "force", "gap", "broken_volume"):
        assert again[f"snapshot_{name}"].attrs["units"]
        np.testing.assert_array_equal(again[f"snapshot_{name}"], joints[1][f"snapshot_{name}"])


@pytest.mark.parametrize("wrong", [-1.0, 5.1e6, np.nan, np.inf])
def test_a_stress_that_cannot_be_reached_is_refused(wrong, small_joint):
    with pytest.raises(jc.InputError, match=r"snapshots: .* must be from 0 to the maximum"):
        jc.simulate(*small_joint, snapshots=[1e6, wrong], **LOAD)


def test_the_command_keeps_and_draws_them_and_wants_a_file_for_them(tmp_path, capsys):
    words = ["simulate", "--rock", "slate", "--cells", "14x12", "--stress", "2"]
    words += ["--snapshots", "0.5,2"]
    assert cli.main([*words, "--output", str(tmp_path / "joint.nc")]) == 0
    assert read_netcdf(tmp_path / "joint.nc").sizes["snapshot"] >= 4
    assert (tmp_path / "joint.png").stat().st_size > 20000
    capsys.readouterr()
    assert cli.main(words) == 2
    assert "--snapshots: needs --output FILE.nc" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli.main([*words[:-1], "1;2"])
    assert "must be numbers with commas" in capsys.readouterr().err

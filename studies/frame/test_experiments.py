"""Points of an experiment, whose closed joints are tables of plain data."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.ensembles import simulation
from jointclosure.ensembles.quantities import QUANTITIES
from jointclosure.inputs import InputError
from jointclosure.joint.simulation import simulate_walls
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.conftest import points_of
from studies.frame.experiments import experiment_named
from studies.frame.joint_tables import as_table
from studies.frame.pilots import described_time, estimate_time, tried
from studies.frame.settings import joints_of
from studies.frame.simulation import close_points
from tests.studied import study_of

TINY = {
    "study": {"name": "points", "rocks": ["slate", "dolerite"]},
    "grid": {"cells_x": 10, "cells_y": 10},
    "assessment": {"joints": 2, "within": 0.05, "jrc": [4, 10], "stress_MPa": [0.7, 2]},
}


@pytest.fixture(scope="module")
def all_points():
    return points_of(experiment_named("assessment"), study_of(TINY))


@pytest.fixture(scope="module")
def points(all_points):
    """Points of one variant of each rock, at two roughnesses and two stresses."""
    variants = {"slate": "without breakage and gouge", "dolerite": "without interaction"}
    return [one for one in all_points if one.coordinates["variant"] == variants[rock_of(one)]]


def rock_of(point):
    return point.settings.case.rock


@pytest.fixture(scope="module")
def closed(points):
    return close_points(points, ("max_closure", "hysteresis"))


def test_every_joint_has_a_row_a_cycle_at_the_coordinates_of_its_point(points, closed):
    joints = as_table([closed])
    assert len(joints) == len(points) * 2 * 2
    at = ["rock", "jrc", "stress", "variant", "copy_of_walls", "realization", "cycle"]
    assert {*at, "status", "seconds", "max_closure", "hysteresis"} <= set(joints)
    assert "joint" not in joints  # its place in a file
    assert not joints.duplicated(at).any()
    assert joints.groupby("rock", sort=False).size().to_dict() == {"slate": 16, "dolerite": 16}
    assert (joints.seconds > 0.0).all()
    for point in points:
        here = (joints[list(point.coordinates)] == pd.Series(point.coordinates)).all(axis=1)
        assert joints[here].realization.tolist() == [0, 0, 1, 1]


@pytest.fixture(scope="module")
def stored(closed, tmp_path_factory):
    file = tmp_path_factory.mktemp("stored") / "joints.nc"
    write_netcdf(closed, file)
    return read_netcdf(file)


def test_joints_in_a_file_have_units_with_a_title(stored):
    assert stored.hysteresis.attrs["long_name"] == QUANTITIES["hysteresis"].title
    units = {name: stored[name].attrs.get("units") for name in ("max_closure", "hysteresis")}
    assert units == {"max_closure": "m", "hysteresis": "1"}


def test_a_table_of_joints_is_the_same_read_from_a_file(closed, stored):
    before = as_table([closed])
    after = as_table([stored])
    pd.testing.assert_frame_equal(after[before.columns], before, check_dtype=False)


def test_points_of_a_job_may_differ_in_their_number_of_cycles(points):
    once = points[0]._replace(settings=points[0].settings.under(cycles=1))
    joints = as_table([close_points([once, points[1]], ("max_closure",))])
    assert joints.groupby("realization").cycle.apply(list).tolist() == [[1, 1, 2]] * 2
    assert np.isfinite(joints.max_closure).all()


def test_a_joint_that_failed_is_kept_with_its_status_alone(points, monkeypatch):
    def failing(upper, lower, conditions, **options):
        closed = simulate_walls(upper, lower, conditions)
        closed["status"] = closed.status + 128
        return closed

    monkeypatch.setattr(simulation, "simulate_walls", failing)
    rows = as_table([close_points(points[:1], ("max_closure",))])
    assert len(rows) == 4
    assert (rows.status >= 128).all()
    assert rows.max_closure.isna().all()


def test_the_time_of_all_joints_is_estimated_from_a_few_of_each_kind(all_points, points):
    groups = tried(all_points)
    assert sum(joints for _, joints in groups) == joints_of(all_points)
    assert all(1 <= len(group) <= 3 for group, _ in groups)
    few = tried(points)
    lines = []
    table = estimate_time(few, lines.append)
    assert table.rock.tolist() == ["slate", "dolerite"]
    assert table.joints.tolist() == [8, 8]
    assert (table.cells == 100).all()
    assert (table[["seconds", "error"]] > 0.0).all(axis=None)
    assert len(lines) == 2
    assert described_time(table).startswith("16 joints will take about ")
    count = sum(len(group) for group, _ in few)
    assert described_time(table).endswith(f"(± standard error, from {count} joints)")
    alone, _ = few[0]
    assert "±" not in described_time(estimate_time([(alone[:1], 8)], lines.append), ["a note"])


def test_the_error_of_an_estimate_of_seconds_is_not_rounded_to_0():
    table = pd.DataFrame({"joints": [44], "tried": [3], "seconds": [2.04], "error": [0.3]})
    assert "about 2.04 ± 0.30 seconds" in described_time(table, ["a note"])
    minutes = table.assign(seconds=120.0, error=6.0)
    assert "about 2.00 ± 0.10 minutes" in described_time(minutes)
    assert described_time(table, ["a note"]).endswith("; a note")


@pytest.mark.parametrize(
    ("share", "words"),
    [
        (0.1, "about 10 % of this time, 6 min 0 s"),
        (1.11, "about as long again, 1 h 6 min"),
        (2.2, "about 2.2 times as long, 2 h 12 min"),
    ],
)
def test_the_time_of_the_assessment_is_stated_beside_that_of_the_joints(share, words):
    table = pd.DataFrame({"joints": [44], "tried": [3], "seconds": [3600.0], "error": [60.0]})
    text = described_time(table, ["a note"], share)
    assert text.endswith(f"; a note; the assessment of make report takes {words}")


def test_no_kernel_is_loaded_while_a_joint_is_timed(points, monkeypatch):
    closed = []

    def recorded(first, names, walls=None):
        closed.append(len(first))
        return close_points(first, names, walls=walls)

    monkeypatch.setattr("studies.frame.pilots.close_points", recorded)
    few, _ = tried(points)
    estimate_time([few, few], lambda line: None)  # groups with the same kernels
    assert closed == [1, len(few[0]), len(few[0])]


def test_scanned_walls_of_a_rock_are_those_of_its_estimate(points):
    wall = np.zeros((10, 10))
    few = tried(points)
    table = estimate_time(few[:1], lambda line: None, {"slate": [(wall, wall)]})
    assert table.rock.tolist() == ["slate"]


def test_a_folder_that_is_no_experiment_is_named():
    with pytest.raises(InputError, match=r"paper: must be an experiment \(assessment, "):
        experiment_named("paper")


def test_a_quantity_that_does_not_exist_is_refused_before_any_joint(monkeypatch):
    wrong = experiment_named("size")._replace(quantities=("max_closure", "heights_range"))
    monkeypatch.setattr("studies.size.study.EXPERIMENT", wrong)
    with pytest.raises(InputError, match=r"studies/size/study.py: quantities: 'heights_range'"):
        experiment_named("size")

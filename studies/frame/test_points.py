"""Points of an experiment: closed and read, and tables of them as plain data."""

import pandas as pd
import pytest

from jointclosure.engine import joints as closing
from jointclosure.engine.quantities import QUANTITIES
from jointclosure.joint.simulation import close_walls
from studies.frame.experiments import experiment_named
from studies.frame.points import as_dataset, as_table, close_points
from tests.studied import study_of

TINY = {
    "study": {"name": "points", "rocks": ["slate", "dolerite"]},
    "grid": {"cells_x": 10, "cells_y": 10},
    "assessment": {"joints": 2, "within": 0.05, "jrc": [4, 10], "stress_MPa": [0.7, 2]},
}


@pytest.fixture(scope="module")
def points():
    jobs = experiment_named("assessment").design(study_of(TINY)).jobs()
    variants = {"slate": "without_breakage_and_gouge", "dolerite": "without_interaction"}
    return [
        point
        for name in jobs
        for rock, variant in variants.items()
        for point in jobs[name]
        if name.startswith(rock) and name.endswith(variant)
    ]


@pytest.fixture(scope="module")
def joints(points):
    return close_points(points, ("max_closure", "hysteresis"))


def test_every_joint_has_a_row_a_cycle_at_the_coordinates_of_its_point(points, joints):
    assert len(joints) == len(points) * 2 * 2
    assert joints.columns.tolist() == [
        "rock", "jrc", "stress", "variant", "copy_of_walls", "realization", "cycle", "status",
        "seconds", "max_closure", "hysteresis",
    ]  # fmt: skip
    assert joints.groupby("rock", sort=False).size().to_dict() == {"slate": 16, "dolerite": 16}
    assert (joints.seconds > 0.0).all()


def test_a_table_is_the_same_after_it_was_a_dataset(joints):
    dataset = as_dataset(joints)
    assert dataset.hysteresis.attrs["long_name"] == QUANTITIES["hysteresis"].title
    units = {name: dataset[name].attrs.get("units") for name in ("max_closure", "hysteresis")}
    assert units == {"max_closure": "m", "hysteresis": "1"}
    pd.testing.assert_frame_equal(as_table(dataset), joints, check_dtype=False)


def test_a_joint_that_failed_is_kept_with_its_status_and_without_readings(points, monkeypatch):
    def failing(upper, lower, conditions, **options):
        closed = close_walls(upper, lower, conditions)
        closed["status"] = closed.status + 128
        return closed

    monkeypatch.setattr(closing, "close_walls", failing)
    rows = close_points(points[:1], ("max_closure",))
    assert len(rows) == 4
    assert (rows.status >= 128).all()
    assert rows.max_closure.isna().all()

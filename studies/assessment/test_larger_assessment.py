"""The assessment by `make assess` in the report of a study, of made-up joints."""

import itertools

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.assessment.assessed_results import JUDGED, STIFFNESS
from jointclosure.assessment.verdicts import NEEDED_AS_FAILS
from studies.assessment.larger_assessment import base_conditions, with_larger
from studies.assessment.report_tables import ALL_ROCKS, EFFECTS, NEEDED, assessed_table, cost_table
from studies.assessment.test_report_tables import EFFECTS as ACTING
from studies.assessment.test_report_tables import PLAN, ROCKS, bias_of, dataset, joints_of, row_of
from tests.studied import study_of

STUDY = study_of({"study": {"rocks": list(ROCKS)}})
CHANGES = {
    "the paper's steps": (2.0, 1.0),
    "tolerance 0.02": (0.0, 0.0),
    "without interaction": (1.0, 0.5),
    "without gouge": (30.0, 2.0),
}
"""Change [%] of net closure without each variant, and half of its 95 % interval."""


def larger_table(conditions, joints=8):
    """Return a table of `make assess` with known changes; without breakage joints fail."""
    rows = []
    for rock, (variant, change), quantity, cycle in itertools.product(
        conditions,
        [*CHANGES.items(), ("without breakage", (np.nan, np.inf))],
        (*JUDGED, STIFFNESS),
        (1, 2),
    ):
        setting = not variant.startswith("without")
        value, half = change if quantity == JUDGED[0] or setting else (3.0, 1.0)
        fails = np.isnan(change[0])
        row = {"rock": rock, "jrc": 8.0, "stress_MPa": 30.0, "variant": variant}
        row["reference"] = "tolerance 0.02" if setting else "the paper's steps"
        row |= {"seconds": 2.0 if setting else 1.0, "quantity": quantity, "cycle": cycle}
        row |= {"value_percent": np.nan if fails else value}
        row |= {"low_percent": value - half, "high_percent": value + half}
        row |= {"verdict": NEEDED_AS_FAILS if fails else "", "needed_by": ""}
        rows.append(row | {"joints": joints, "study_key": conditions[rock].key})
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def conditions():
    return base_conditions(STUDY)


@pytest.fixture
def small():
    """The table of two joints of each rock."""
    study = dataset().assign(status=(("case", "realization"), np.zeros((2, 3), dtype=int)))
    return assessed_table(study, {rock: joints_of(rock) for rock in ROCKS}, PLAN, ACTING, 0.05)


@pytest.fixture
def replaced(small, conditions):
    return with_larger(small, larger_table(conditions), conditions, PLAN.stated, 0.05)


def test_more_joints_of_the_same_study_take_the_place_of_few(replaced):
    table, joints = replaced
    assert joints == 8
    row = row_of(table, "slate", "without interaction")
    assert (row.joints, row.change_percent, row.change_percent_high) == (8, 1.0, 1.5)
    assert (row.verdict, row.gross_percent, row.time_percent) == ("can be left out", 3.0, -50.0)
    row = row_of(table, "slate", "without gouge")
    assert (row.verdict, row.needed_by) == ("needed", "net closure (cycles 1, 2)")
    assert row_of(table, "slate", "the paper's steps").verdict == "within"
    assert row_of(table, "slate", "tolerance 0.02").verdict == "reference"


def test_errors_of_times_are_those_of_more_joints(small, conditions):
    larger = larger_table(conditions)
    larger["seconds_standard_error"] = 0.1 * larger.seconds
    table, _ = with_larger(small, larger, conditions, PLAN.stated, 0.05)
    stated = row_of(table, "slate", "the paper's steps")
    assert (stated.seconds, stated.seconds_standard_error) == (2.0, pytest.approx(0.2))
    assert (stated.time_percent, stated.time_percent_standard_error) == (0.0, 0.0)
    other = row_of(table, "slate", "without gouge")
    assert other.time_percent == -50.0
    assert other.time_percent_standard_error == pytest.approx(50.0 * 0.1 * np.sqrt(2.0))
    together = row_of(table, ALL_ROCKS, "without gouge")
    assert together.seconds_standard_error == pytest.approx(0.1 / np.sqrt(2.0))
    fails = row_of(table, "slate", "without breakage")
    assert np.isnan([fails.seconds_standard_error, fails.time_percent_standard_error]).all()


def test_a_table_of_an_earlier_version_has_no_errors_of_times(replaced):
    other = row_of(replaced[0], "slate", "without gouge")
    assert (other.seconds, other.time_percent) == (1.0, -50.0)
    assert np.isnan([other.seconds_standard_error, other.time_percent_standard_error]).all()


def test_all_rocks_together_have_the_interval_of_a_mean_of_independent_rocks(replaced):
    row = row_of(replaced[0], ALL_ROCKS, "the paper's steps")
    assert (row.joints, row.change_percent) == (16, 2.0)
    assert row.change_percent_high == pytest.approx(2.0 + 1.0 / np.sqrt(2.0))


def test_effects_are_those_of_both_tables_once(replaced):
    table = replaced[0]
    fails = row_of(table, "slate", "without breakage")
    assert (fails.verdict, fails.state) == (NEEDED_AS_FAILS, NEEDED)
    assert np.isnan([fails.seconds, fails.time_percent]).all()
    rows = table[(table.kind == EFFECTS) & (table.rock == "slate")]
    assert not rows.duplicated(["variant", "cycle"]).any()
    states = rows.drop_duplicates("variant").set_index("variant").state
    assert states["without gouge"] == ""  # it was not tested by few joints
    assert states["without substrate"] == NEEDED


@pytest.mark.parametrize("change", ["fewer", "other walls", "one rock", "older"])
def test_joints_that_are_no_more_or_of_another_study_take_no_place(change, small, conditions):
    larger = larger_table(conditions, 2 if change == "fewer" else 8)
    if change == "other walls":
        other = study_of({"study": {"rocks": list(ROCKS), "root_seed": 5}})
        conditions = base_conditions(other)
    elif change == "one rock":
        larger = larger[larger.rock == "slate"]
    elif change == "older":
        larger = larger.drop(columns=["study_key", "joints"])
    table, joints = with_larger(small, larger, conditions, PLAN.stated, 0.05)
    assert joints == 0
    assert table is small


def test_the_number_of_assessed_joints_changes_no_key(conditions):
    changes = {"study": {"rocks": list(ROCKS)}, "assessment": {"joints": 20, "within": 0.1}}
    assert base_conditions(study_of(changes)) == conditions
    brittle = study_of({"study": {"rocks": list(ROCKS)}, "effects": {"gouge": False}})
    assert base_conditions(brittle)["slate"].key != conditions["slate"].key
    assert STUDY.rocks["slate"].effects == jc.Effects()


def test_the_headline_is_of_the_larger_assessment(replaced):
    study = dataset()
    table = replaced[0].replace("tolerance 0.02", "tolerance 0.004")
    cost = cost_table([study], {rock: joints_of(rock) for rock in ROCKS}, PLAN)
    cost["joints_of_make_assess"] = replaced[1]
    words = bias_of({"study_assessment": table, "study_assessment_cost": cost})
    assert "net closure since seating 2.0 (1.3 to 2.7) % on cycle 1 and" in words
    assert "against tolerance 0.004 on the same walls" in words
    assert "16 joints of Slate, Dolerite" in words
    assert "share that remains" not in words


def test_all_rocks_together_decrease_by_no_more_than_all(small, conditions):
    larger = larger_table(conditions)
    wide = larger.assign(low_percent=-300.0, high_percent=300.0)
    table, _ = with_larger(small, wide, conditions, PLAN.stated, 0.05)
    pooled = table[(table.rock == ALL_ROCKS) & table.change_percent.notna()]
    assert len(pooled)
    assert (pooled.change_percent_low == -100.0).all()

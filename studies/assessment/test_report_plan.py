"""Which joints the assessment in a report closes: a share of the study's expected time."""

import pytest

from jointclosure.joint.status import BREAKAGE_NOT_AT_REST
from jointclosure.uncertainty import expected_cost
from jointclosure.uncertainty.expected_cost import relative_cost
from studies.assessment.report_plan import (
    COSTLY,
    ENOUGH,
    FEWEST_JOINTS,
    LEAST_SECONDS,
    ends_variant,
    planned,
    study_seconds,
)
from studies.frame.cases import base_case, block_settings, closed_keys, seconds_by_paper
from studies.frame.settings import Point, seeds_of
from studies.frame.yaml_files import read_plain
from tests.studied import ROOT, study_of

CONFIGURATIONS = sorted(
    path.name for path in (ROOT / "config").glob("*.yaml") if path.name != "measured_wall.yaml"
)
SMALL = {"study": {"realizations": 3, "pool": None, "rocks": ["slate"]}}


def expected(study, plan):
    """Return the expected time [s] of the joints of a plan."""
    points = [point for points in plan.points.values() for point in points]
    costs = (
        relative_cost(one.settings.conditions.effects, one.settings.conditions.numerics)
        for one in points
    )
    return plan.joints * seconds_by_paper(study) * sum(costs)


@pytest.mark.parametrize(
    ("variant", "status", "ends"),
    [
        ("without interaction", BREAKAGE_NOT_AT_REST, True),
        ("without interaction", 0, False),
        ("tolerance 0.1", BREAKAGE_NOT_AT_REST, False),
    ],
)
def test_joints_without_an_effect_end_after_one_that_was_given_up(variant, status, ends):
    assert ends_variant(Point({"variant": variant}, None), {"status": status}) == ends


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_joints_take_no_more_than_their_share_or_it_says_so(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    study = study_of(read_plain(f"config/{name}"))
    plan = planned(study)
    assert plan.joints >= FEWEST_JOINTS
    assert plan.points
    assert plan.seconds == pytest.approx(expected(study, plan))
    assert plan.study_seconds == pytest.approx(study_seconds(study))
    assert plan.within == (plan.seconds <= 0.1 * plan.study_seconds)
    if not plan.within:  # few joints, without which nothing would be decided
        assert plan.joints * len(plan.points) <= ENOUGH
        assert plan.seconds <= LEAST_SECONDS


def test_the_default_study_is_assessed_in_all_rocks_within_a_tenth_of_its_time():
    study = study_of()
    plan = planned(study)
    assert list(plan.points) == list(study.rocks)
    assert plan.within
    assert plan.stated != plan.ladder[-1]  # something finer is compared


def test_a_small_study_compares_the_cheapest_setting_and_a_finer_one():
    """The cheapest one takes little time, and may suffice."""
    plan = planned(study_of(SMALL | {"numerics": {"breakage": "resolved"}}))
    assert plan.ladder == ("the paper's steps", "tolerance 0.02", "tolerance 0.004")
    assert plan.stated == "tolerance 0.02"
    assert plan.omitted == ("tolerance 0.1",)


def test_a_larger_share_closes_more():
    few, many = (planned(study_of({"assessment": {"share": share}})) for share in (0.05, 0.5))
    assert few.seconds < many.seconds <= 0.5 * many.study_seconds
    assert set(few.ladder) < set(many.ladder)


def test_no_more_joints_are_closed_than_stated():
    assert planned(study_of({"assessment": {"share": 0.99, "joints": 3}})).joints == 3


def test_no_more_joints_are_closed_than_the_study_has():
    changes = {"study": {"realizations": 2, "pool": 1000}, "assessment": {"share": 0.99}}
    assert planned(study_of(changes)).joints == 2


def test_null_closes_none():
    assert planned(study_of({"assessment": None})) is None


def test_few_joints_of_a_long_study_are_not_assessed_beyond_the_share():
    plan = planned(study_of(SMALL, {"grid": {"cells_x": 600, "cells_y": 600}}))
    assert plan.points == {}
    assert plan.seconds > max(LEAST_SECONDS, plan.share * plan.study_seconds)


def test_a_short_study_has_enough_joints_for_an_interval_although_they_exceed_the_share():
    plan = planned(study_of(SMALL, {"study": {"realizations": 10}}))
    assert not plan.within
    assert list(plan.points) == ["slate"]
    assert plan.joints == ENOUGH


def test_enough_joints_are_no_more_than_the_study_has():
    assert planned(study_of(SMALL)).joints == SMALL["study"]["realizations"] < ENOUGH


def test_joints_that_would_take_longer_stay_the_fewest():
    plan = planned(
        study_of(SMALL, {"study": {"realizations": 40}, "grid": {"cells_x": 220, "cells_y": 220}})
    )
    assert plan.joints < ENOUGH
    assert plan.joints / ENOUGH * LEAST_SECONDS < plan.seconds


def test_the_joints_are_the_first_ones_of_the_base_case_of_the_study():
    study = study_of()
    for rock, points in planned(study).points.items():
        base = base_case(study, rock)
        own = seeds_of(block_settings(study, base, range(FEWEST_JOINTS)))
        for point in points:
            settings = point.settings
            assert seeds_of(settings) == own
            assert settings.conditions.rock == base.checked_conditions.rock
            assert settings.conditions != base.checked_conditions  # which the study has closed


def test_joints_are_closed_again_where_the_study_closes_others():
    """Effects that are chosen later, and flow, whose time does not count."""
    for changes in ({"effects": {"auto": 0.02}}, {"flow": True}):
        plan = planned(study_of(changes))
        for points in plan.points.values():
            assert plan.stated in {point.coordinates["variant"] for point in points}
            assert not any(point.settings.conditions.flow for point in points)


def test_a_study_in_which_nothing_breaks_compares_effects_only():
    elastic = {"breakage": False, "gouge": False}
    plan = planned(study_of({"effects": elastic}))
    names = {point.coordinates["variant"] for points in plan.points.values() for point in points}
    assert len(plan.ladder) == 1
    assert names == {
        "without interaction",
        "without substrate and interaction",
        "without soft peaks",
    }


def test_the_dataset_does_not_depend_on_the_assessment():
    keys = [closed_keys(study_of(one).stated) for one in ({}, {"assessment": None})]
    assert keys[0] == keys[1]


def test_an_effect_without_which_a_joint_takes_long_is_compared_where_the_share_allows_all(
    monkeypatch,
):
    monkeypatch.setattr(expected_cost, "NO_GOUGE_COST", 2.0 * COSTLY)
    few, many = (
        {point.coordinates["variant"] for points in plan.points.values() for point in points}
        for plan in (planned(study_of({"assessment": {"share": share}})) for share in (0.02, 0.1))
    )
    assert many - few >= {"without gouge"}

"""Points near the strength: found without walls, timed apart, and named in the estimate."""

import pytest

import jointclosure as jc
from jointclosure.joint.simulation import NEAR_STRENGTH, Simulation
from studies.frame.cases import cases_of
from studies.frame.experiments import case_point
from studies.frame.near_strength import (
    notes_near_strength,
    share_of_strength,
    tried_by_strength,
)
from studies.frame.pilots import tried
from studies.frame.settings import walls_of
from tests.studied import study_of

BOUNDED = {"choices": {"strength_bound": "base"}, "grid": {"cells_x": 12, "cells_y": 12}}
WEAK = {"study": {"rocks": ["slate"], "realizations": 3, "pool": None},
        "statistics": {"control_variates": None},
        "rocks": {"slate": {"max_normal_stress_MPa": 30, "levels": {
            "compressive_strength_MPa": [42, 300], "poisson_ratio": None}}}}  # fmt: skip


def points_of_study(*changes):
    study = study_of(BOUNDED, WEAK, *changes)
    return [case_point(study, case, range(3)) for case in cases_of(study)]


@pytest.mark.parametrize("numerics", [{}, {"numerics": {"breakage": "resolved"}}])
def test_the_share_is_that_of_a_joint(numerics):
    for point in points_of_study(numerics):
        conditions = point.settings.conditions
        walls = next(iter(walls_of(point.settings)))
        of_joint = Simulation(*walls, conditions).share_of_strength
        assert share_of_strength(conditions) == pytest.approx(of_joint)


def test_cases_near_the_strength_are_timed_apart():
    """Their time is not that of others, and of one case two joints are tried."""
    points = points_of_study()
    groups = tried_by_strength(points)
    labels = [[point.settings.case.label for point in group] for group, _ in groups]
    near = "slate-compressive_strength-low"
    assert labels[1] == [near, near]
    assert near not in labels[0]
    assert [joints for _, joints in groups] == [3 * (len(points) - 1), 3]
    first, second = (next(iter(walls_of(point.settings)))[0] for point in groups[1][0])
    assert (first != second).any()


def test_the_note_names_the_cases_with_their_share():
    (note,) = notes_near_strength(points_of_study())
    assert note.startswith("near the strength: slate-compressive_strength-low (84 %) of the stress")


def test_every_case_counts_but_few_are_named():
    """The base case and all levels but the strongest one are near the strength."""
    weak = {"rocks": {"slate": {"compressive_strength_MPa": 45}}}
    (note,) = notes_near_strength(points_of_study(weak))
    assert "slate-base (79 %)" in note
    assert "more of the stress that all cells together carry" in note


@pytest.mark.parametrize(
    "change", [{"choices": {"strength_bound": "none"}}, {"rocks": {"slate": {"levels": {
        "compressive_strength_MPa": [143, 175]}}}}],
)  # fmt: skip
def test_a_study_far_from_the_strength_is_estimated_as_before(change):
    points = points_of_study(change)
    assert notes_near_strength(points) == []
    assert tried_by_strength(points) == tried(points)
    assert max(share_of_strength(point.settings.conditions) for point in points) < NEAR_STRENGTH


def test_a_joint_in_which_nothing_breaks_has_no_strength():
    conditions = points_of_study()[0].settings.conditions
    elastic = jc.Effects(breakage=False, gouge=False)
    assert share_of_strength(conditions._replace(effects=elastic)) == 0.0

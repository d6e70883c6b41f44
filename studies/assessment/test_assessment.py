"""Assessments of a study's rocks: which joints are closed, and the tables of them."""

import numpy as np

import jointclosure as jc
from jointclosure.engine.assess import LADDER
from jointclosure.engine.walls import COPIES, MAKERS, walls_of
from studies.assessment.study import EXPERIMENT
from studies.frame.files import read_plain
from tests.studied import ROOT, checked_study

TINY = {
    "study": {"name": "tiny_assessment", "rocks": ["slate"]},
    "grid": {"cells_x": 12, "cells_y": 12},
    "assessment": {"joints": 2, "within": 0.05, "stress_MPa": [1, 5]},
}


def test_joints_are_those_of_assess_with_the_same_walls(design, tables, joints):
    (stated, ladder) = design.parameters["ladders"]["slate"]
    assert (stated, ladder) == ("the paper's steps", list(LADDER))
    settings = next(iter(design.jobs.values()))[0].settings
    conditions = settings.conditions()._replace(flow=False)
    found = jc.assess(list(walls_of(settings.surfaces)), conditions=conditions, workers=1)
    here = tables["assessment"].query("stress_MPa == 1")
    for column in ("value", "low", "high"):
        expected = 100.0 * found.differences[column].to_numpy()
        np.testing.assert_allclose(here[f"{column}_percent"], expected, rtol=1e-6, atol=1e-9)
    assert len(tables["hardness"]) == 4
    of_copies = joints[joints.variant == stated].copy_of_walls
    assert set(of_copies) == set(COPIES)
    (pair,) = walls_of(settings.surfaces._replace(realizations=1))
    for name, copy in COPIES.items():
        copied = next(MAKERS["copied"](settings, copy=name))
        np.testing.assert_array_equal(copied, [copy(wall) for wall in pair])
    assert found.sentences[0] in tables["assessment.md"]


def test_the_worst_joint_is_first(tables):
    order = tables["hardness"].verdict.map(["not stable", "hard", "easy"].index)
    assert order.is_monotonic_increasing


def test_a_study_without_the_section_is_assessed_by_the_usual_one():
    study = checked_study(read_plain(ROOT / "workflow/usual_assessment.yaml"))
    points = [point for job in EXPERIMENT.design(study).jobs.values() for point in job]
    assert {point.coordinates["rock"] for point in points} == set(study.typed.rocks)
    assert {point.settings.surfaces.realizations for point in points} == {8}

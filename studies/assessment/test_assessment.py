"""Assessments of a study's rocks: which joints are closed, and the tables of them."""

import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.engine.assess import COPIES, LADDER
from studies.assessment.study import EXPERIMENT, ladders_of
from studies.conftest import tables_of
from studies.frame.points import close_points
from studies.frame.settings import walls_of
from studies.frame.yaml_files import read_plain
from tests.studied import ROOT, study_of, tiny

TINY = tiny("assessment")


def test_joints_are_those_of_assess_with_the_same_walls(design, tables, joints):
    stated, ladder = ladders_of(study_of(TINY))["slate"]
    assert (stated, ladder) == ("the paper's steps", list(LADDER))
    settings = next(iter(design.jobs().values()))[0].settings
    conditions = settings.conditions._replace(flow=False)
    found = jc.assess(list(walls_of(settings)), conditions=conditions, workers=1)
    here = tables["assessment"].query("stress_MPa == 1")
    for column in ("value", "low", "high"):
        expected = 100.0 * found.differences[column].to_numpy()
        np.testing.assert_allclose(here[f"{column}_percent"], expected, rtol=1e-6, atol=1e-9)
    assert len(tables["hardness"]) == 4
    here = tables["hardness"].query("stress_MPa == 1").drop(columns=["rock", "jrc", "stress_MPa"])
    pd.testing.assert_frame_equal(here.reset_index(drop=True), found.hardness, rtol=1e-6)
    assert found.sentences[0] in tables["assessment.md"]


def test_scanned_rocks_are_assessed_on_copies_of_their_windows(monkeypatch):
    monkeypatch.chdir(ROOT)
    section = {"joints": 8, "within": 0.05, "jrc": [5, 9]}
    small = {"study": {"realizations": 2}, "grid": TINY["grid"], "assessment": section}
    study = study_of(read_plain("config/measured_wall.yaml"), small)
    points = EXPERIMENT.design(study).points()
    made = tables_of("assessment", study, close_points(points, EXPERIMENT.quantities))
    assert len(made["hardness"]) == 2
    assert "Granite, scanned, 10 MPa" in made["assessment.md"]
    copied = (points[0]._replace(options=points[0].options | {"copy": name}) for name in COPIES)
    plain, _, mirrored, _ = (np.array(next(point.walls())) for point in copied)
    np.testing.assert_array_equal(mirrored, plain[:, :, ::-1])


def test_the_worst_joint_is_first(tables):
    order = tables["hardness"].verdict.map(["not stable", "hard", "easy"].index)
    assert order.is_monotonic_increasing


def test_a_study_without_the_section_is_assessed_by_the_usual_one():
    study = study_of(read_plain(ROOT / "workflow/usual_assessment.yaml"))
    points = EXPERIMENT.design(study).points()
    assert {point.coordinates["rock"] for point in points} == set(study.rocks)
    assert {point.settings.realizations for point in points} == {8}

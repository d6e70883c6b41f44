"""Assessments of a study's rocks, from the joints that are closed to their tables."""

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.assessment.assess import COPIES
from jointclosure.assessment.assessed_results import JUDGED
from jointclosure.assessment.numerical_settings import LADDER
from studies.assessment.larger_assessment import BaseCondition, base_conditions
from studies.assessment.study import (
    EXPERIMENT,
    draw_assessment_effects,
    draw_assessment_hardness,
    draw_assessment_price,
    ladders_of,
    tabulate_assessment,
)
from studies.conftest import points_of, tables_of
from studies.frame.joint_tables import as_table
from studies.frame.settings import walls_of
from studies.frame.simulation import close_points
from studies.frame.yaml_files import read_plain
from tests.studied import ROOT, study_of, tiny

TINY = tiny("assessment")


def test_joints_are_those_of_assess_with_the_same_walls(jobs, tables):
    stated, ladder = ladders_of(study_of(TINY))["slate"]
    assert (stated, ladder) == ("the paper's steps", list(LADDER))
    settings = next(iter(jobs.values()))[0].settings
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


@pytest.fixture(scope="module")
def table(study, joints):
    """The table, with the condition at 1 MPa as that of the base case."""
    base = BaseCondition(base_conditions(study)["slate"].jrc, 1.0, "key")
    settings = EXPERIMENT.settings(study) | {"base_conditions": {"slate": base}}
    return tabulate_assessment(joints, settings)


def test_the_table_has_the_number_of_joints(table):
    assert set(table.joints) == {2}


def test_the_table_has_the_standard_errors_of_times(table, joints):
    """Of joints as they are, whose mean time is in the table."""
    for row in table.drop_duplicates(["stress_MPa", "variant"]).itertuples():
        rows = joints[(joints.variant == row.variant) & (joints.copy_of_walls == "as it is")]
        of_joints = rows[np.isclose(1e-6 * rows.stress, row.stress_MPa) & (rows.cycle == 1)].seconds
        assert row.seconds == pytest.approx(of_joints.mean())
        assert row.seconds_standard_error == pytest.approx(of_joints.std() / np.sqrt(2))


def test_the_description_names_the_settings_of_the_hardness(tables):
    assert "copies with the paper's steps; the force" in tables["assessment.md"]
    assert "as it is with tolerance 0.004" in tables["assessment.md"]


def test_only_conditions_of_base_cases_have_their_key(table):
    keys = table.groupby("stress_MPa").study_key.unique()
    assert (list(keys[1.0]), list(keys[5.0])) == (["key"], [""])


def test_scanned_rocks_are_assessed_on_copies_of_their_windows(monkeypatch):
    monkeypatch.chdir(ROOT)
    section = {"joints": 8, "within": 0.05, "jrc": [5, 9]}
    small = {"study": {"realizations": 2}, "grid": TINY["grid"], "assessment": section}
    study = study_of(read_plain("config/measured_wall.yaml"), small)
    points = points_of(EXPERIMENT, study)
    joints = as_table([close_points(points, EXPERIMENT.quantities)])
    made = tables_of(EXPERIMENT, study, joints)
    assert len(made["hardness"]) == 2
    assert "Granite, scanned, 10 MPa" in made["assessment.md"]
    copied = (points[0]._replace(options=points[0].options | {"copy": name}) for name in COPIES)
    plain, _, mirrored, _ = (np.array(next(point.walls())) for point in copied)
    np.testing.assert_array_equal(mirrored, plain[:, :, ::-1])


def test_errors_are_drawn_with_their_95_percent_intervals(tables):
    table = tables["assessment"]
    figure = draw_assessment_price(tables, {"within": 0.05, "titles": {"slate": "Slate"}})
    shown = table[table.quantity.isin(JUDGED) & (table.variant != table.reference)]
    shown = shown[shown.verdict == ""]
    columns = [f"{name}_percent" for name in ("value", "low", "high")]
    expected = sorted(map(tuple, shown[columns].to_numpy()))
    drawn = []
    for container in (one for axes in figure.axes for one in axes.containers):
        point, _, (bar,) = container.lines
        low, high = bar.get_segments()[0][:, 1]
        drawn.append((point.get_ydata()[0], low, high))
    np.testing.assert_allclose(sorted(drawn), expected)
    assert min(values[0] for values in drawn) < 0.0
    for axes in figure.axes:
        assert axes.get_ylim()[0] < shown.low_percent.min()
        assert axes.get_ylim()[1] > shown.high_percent.max()


@pytest.fixture(scope="module")
def two_rocks(tables):
    """Figure of the hardness of two rocks, and entries of its legend by label."""
    hardness = tables["hardness"].assign(verdict="easy")
    other = hardness.assign(rock="dolerite", verdict="hard")
    titles = {"slate": "A slate", "dolerite": "A dolerite"}
    figure = draw_assessment_hardness(
        {"hardness": pd.concat([hardness, other])}, {"within": 0.05, "titles": titles}
    )
    return figure, {one.get_label(): one for one in figure.legends[0].legend_handles}


def test_the_legend_has_the_verdicts_that_joints_have(two_rocks):
    _, handles = two_rocks
    assert "not stable" not in handles
    assert handles["easy"].get_markerfacecolor() != handles["hard"].get_markerfacecolor()


def test_each_rock_has_panels_with_its_joints_marked_by_verdict(two_rocks, tables):
    figure, handles = two_rocks
    panels = list(zip(figure.axes, ["A slate"] * 2 + ["A dolerite"] * 2, strict=True))
    for axes, title in panels:
        verdict = "easy" if title == "A slate" else "hard"
        stresses = tables["hardness"].stress_MPa.nunique()
        drawn = axes.lines[1 : 1 + stresses]  # in front of the hard cases
        assert axes.get_title() == title
        assert sum(len(line.get_xdata()) for line in drawn) == len(tables["hardness"])
        hollow = handles[verdict].get_markerfacecolor() == "none"
        assert {line.get_markerfacecolor() == "none" for line in drawn} == {hollow}


def test_joints_have_the_colour_and_the_shape_of_their_stress(tables):
    hardness = tables["hardness"].assign(verdict="easy")
    figure = draw_assessment_hardness(
        {"hardness": hardness}, {"within": 0.05, "titles": {"slate": "A slate"}}
    )
    handles = {one.get_label(): one for one in figure.legends[0].legend_handles}
    stresses = sorted(hardness.stress_MPa.unique())
    assert len(stresses) == 2
    colours = [one.get_color() for one in figure.axes[0].lines[1:3]]
    assert colours == [handles[f"{stress:g} MPa"].get_color() for stress in stresses]
    assert colours[0] != colours[1]
    shapes = [one.get_marker() for one in figure.axes[0].lines[1:3]]
    assert shapes == [handles[f"{stress:g} MPa"].get_marker() for stress in stresses]
    assert shapes[0] != shapes[1]


def test_marks_of_one_setting_lie_beside_each_other_above_its_time(tables):
    figure = draw_assessment_price(tables, {"within": 0.05, "titles": {"slate": "Slate"}})
    figure.draw_without_rendering()
    table = tables["assessment"]
    settings = table[(table.verdict == "") & (table.variant != table.reference)]
    for axes, (_, part) in zip(figure.axes, settings.groupby("stress_MPa"), strict=True):
        seconds = part.groupby("variant").seconds.first()
        seconds = seconds[[name for name in LADDER if name in seconds]]
        labels = [text.get_text() for text in axes.get_xticklabels()]
        names = [f"{name.removeprefix('the ')}\n{value:.2g} s" for name, value in seconds.items()]
        assert labels == names
        marks = [one.lines[0] for one in axes.containers]
        for shape in {one.get_marker() for one in marks}:
            places = [one.get_xdata()[0] for one in marks if one.get_marker() == shape]
            assert len(places) == 4
            assert len({round(place) for place in places}) == 1
            at = np.sort(axes.transData.transform([(place, 0.0) for place in places])[:, 0])
            assert np.diff(at).min() > 4.5 * figure.dpi / 72.0  # the size of a mark


def test_a_scene_that_fails_has_a_word_in_its_row(tables):
    table = tables["assessment"].copy()
    gone = table.variant == "without gouge"
    table.loc[gone, ["value_percent", "low_percent", "high_percent"]] = np.nan
    figure = draw_assessment_effects(
        {"assessment": table}, {"within": 0.05, "titles": {"slate": "A slate"}}
    )
    rows = list(dict.fromkeys(table.variant[table.variant.str.startswith("without")]))
    for axes in figure.axes:
        assert [text.get_text() for text in axes.texts] == ["no result"]
        assert axes.texts[0].get_position() == (0.0, rows.index("without gouge"))
        assert axes.get_title().startswith("A slate, JRC 6.5, ")
    assert "logarithmic" in figure.get_supxlabel()


def test_the_worst_joint_is_first(tables):
    order = tables["hardness"].verdict.map(["not stable", "hard", "easy"].index)
    assert order.is_monotonic_increasing


def test_a_study_without_the_section_is_assessed_by_the_usual_one():
    study = study_of(read_plain(ROOT / "studies/assessment/usual.yaml"))
    points = points_of(EXPERIMENT, study)
    assert {point.coordinates["rock"] for point in points} == set(study.rocks)
    assert {point.settings.realizations for point in points} == {8}

"""Figures of a study: curves that are drawn, their ends, and their texts."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.cbook import is_math_text
from matplotlib.text import Text

from jointclosure.plotting.style import subplots
from jointclosure.statistics.repetitions import Design
from studies.frame.cases import pool_of
from studies.frame.joint_tables import since_seating
from studies.paper import figures as plotting
from studies.paper.closure_tables import fit_table, indifference_table, max_closure_table
from studies.paper.predictive import lengths_dataset, predictive
from studies.paper.tables_1_to_3 import (
    figure_text,
)
from studies.paper.test_measured_fit import like
from studies.paper.test_measured_fit import study as three_surfaces
from tests.studied import study_of
from tests.world import world


def drawn_branches(study, seating=None, history=lambda *joint: None):
    """Generate the lines (x, y) of loading and of unloading in the panel of each cycle.

    The last line is that of the chosen surface. Stresses of a line ascend.
    """
    most = float(study.max_normal_stress[0])
    rock = study_of().rocks["slate"]._replace(max_normal_stress=most)
    figure = plotting.closure_figure(study, {"one": rock}, seating, 1.5, history=history)
    surfaces = study.sizes["realization"]
    for axes in figure.axes:
        lines = [line.get_xydata() for line in axes.lines[: 2 * (surfaces + 1)]]
        yield lines[: surfaces + 1], lines[surfaces + 1 :]


def test_the_surface_closest_to_the_mean_is_that_of_the_middle_curve():
    assert plotting.closest_to_mean(three_surfaces(), "one-base", 5e5) == 11
    assert plotting.closest_to_mean(three_surfaces((0, 16, 0)), "one-base", 5e5) != 11


@pytest.mark.parametrize("most", [2e6, 1.9e6])  # the second is between two stored stresses
def test_every_branch_has_the_ends_of_its_cycle(most):
    study = three_surfaces().assign_coords(max_normal_stress=("case", [most]))
    study["closure"] = study.closure.where(study.stress <= most)
    start = study.residual_closure.shift(cycle=1, fill_value=0.0)
    gross = study.max_closure, study.residual_closure - start
    seated = study.max_closure_seated_net, study.residual_closure_seated_net
    for seating, (maximum, end) in ((None, gross), (5e5, seated)):
        for number, branches in enumerate(drawn_branches(study, seating)):
            for lines, least in zip(branches, (0.0 * end, end), strict=True):
                for line, surface in zip(lines, (0, 1, 2, 1), strict=True):
                    at = {"case": 0, "realization": surface, "cycle": number}
                    lowest, highest = (1e3 * float(one.isel(at)) for one in (least, maximum))
                    np.testing.assert_allclose(line[0], (lowest, 1e-6 * (seating or 0.0)))
                    np.testing.assert_allclose(line[-1], (highest, 1e-6 * most))


def test_no_straight_line_joins_zero_stress_to_the_first_stored_one():
    for branches in drawn_branches(three_surfaces()):
        for line in (line for lines in branches for line in lines):
            assert np.isnan(line[1, 0])
            assert np.isfinite(np.delete(line, 1, axis=0)).all()


def test_a_joint_that_jumped_over_its_maximum_is_not_drawn_up_to_it():
    study = three_surfaces((0, 0, 1)).assign_coords(max_normal_stress=("case", [1.9e6]))
    study["closure"] = study.closure.where(study.stress <= 1.9e6)
    for loading, _ in drawn_branches(study):
        assert np.isfinite([loading[0][-1], loading[1][-1]]).all()
        assert np.isnan(loading[2][-1, 0])


def test_the_legend_of_one_rock_is_below_its_panels():
    """Beside them it would lie outside of the screen of a phone."""
    rock = study_of().rocks["slate"]._replace(max_normal_stress=2e6)
    figure = plotting.closure_figure(
        three_surfaces(), {"one": rock}, 5e5, 1.5, history=lambda *joint: None
    )
    figure.draw_without_rendering()
    legend = figure.legends[0].get_window_extent()
    assert legend.y1 <= min(axes.get_window_extent().y0 for axes in figure.axes)
    assert legend.x0 >= 0.0
    assert legend.x1 <= figure.bbox.width


def test_the_title_says_among_how_many_joints_the_best_one_is():
    rock = study_of().rocks["slate"]._replace(max_normal_stress=2e6)
    curves = {"one": like(0)}
    measured = plotting.Measurements(curves, fit_table(three_surfaces(), curves, 5e5))
    figure = plotting.closure_figure(
        three_surfaces(), {"one": rock}, 5e5, 1.5, measured, lambda *joint: None
    )
    assert "RMS misfit of the best of 3 joints:" in figure.axes[0].get_title()


@pytest.mark.parametrize("seating", [None, 5e5])
def test_closure_since_seating_has_the_mean_over_all_surfaces(seating):
    study = three_surfaces()
    rock = study_of().rocks["slate"]._replace(max_normal_stress=2e6)
    figure = plotting.closure_figure(
        study, {"one": rock}, seating, 1.5, history=lambda *joint: None
    )
    words = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert ("mean of all joints, loading and unloading" in words) == (seating is not None)
    assert not any("unchecked" in one for one in words)
    for number, axes in enumerate(figure.axes if seating else ()):
        means = [line for line in axes.lines if line.get_linewidth() == 1.5]
        assert len(means) == 2
        for line, branch in zip(means, ("loading", "unloading"), strict=True):
            curve = 1e3 * since_seating(study).isel(case=0, cycle=number).sel(branch=branch)
            shown = curve.stress.values > seating
            expected = curve.mean("realization").values[shown]
            np.testing.assert_allclose(line.get_xdata()[1:], expected)
            np.testing.assert_allclose(line.get_ydata()[1:], 1e-6 * curve.stress.values[shown])


def test_the_trends_of_one_rock_are_in_the_unit_of_the_property(slate):
    study, closed, closures, *_ = slate
    figure = plotting.trend_figure(closures, closed, study.rocks)
    drawn = {
        axes.get_xlabel(): np.asarray(axes.containers[0].lines[0].get_xdata(), dtype=float)
        for axes in figure.axes
    }
    np.testing.assert_allclose(drawn["Young's modulus (GPa)"], [60.0, 66.0, 72.0])
    np.testing.assert_allclose(drawn["Compressive strength (MPa)"], [143.0, 159.0, 175.0])
    np.testing.assert_allclose(drawn["JRC"], [5.0, 6.5, 8.0])


FORMULA = "Slate of $ 5 {x_1"
"""A title with as many dollar signs as a formula, and one sign more than it may have."""


@pytest.fixture(scope="module")
def slate():
    """Study of slate in the known world: configuration, dataset, and tables that are drawn."""
    study = study_of({"study": {"rocks": ["slate"], "pool": None}})
    closed = world(study)
    intervals = indifference_table(closed, study.statistics, 1)
    lengths = lengths_dataset(predictive(world(pool_of(study)), Design(), 100, 1, pools=0))
    return study, closed, max_closure_table(closed), intervals, lengths


@pytest.mark.parametrize("title", [f"{FORMULA} $", FORMULA, r"\frac{1 $$", r"\$ $", "a"])
def test_a_text_of_a_figure_is_drawn_as_the_title_is_written(title):
    figure, axes = subplots(figsize=(8.0, 3.0))
    text = axes.text(0.0, 0.0, figure_text(title))
    figure.draw_without_rendering()  # a formula that is none is an error here
    assert not is_formula(text)
    assert plain(text) == title
    assert figure_text("_a").lstrip() == "_a"
    assert not figure_text("_a").startswith("_")  # left out of legends
    assert figure_text(60 * "very ") == f"{(8 * 'very ')[:39]}…"


def test_every_figure_shows_a_title_as_it_is_written(slate):
    study, closed, closures, intervals, lengths = slate
    title = f"{FORMULA} $"
    rocks = {"slate": study.rocks["slate"]._replace(title=title)}
    paper = intervals.assign(paper_percent=1.0)
    figures = {
        "closure": plotting.closure_figure(closed, rocks, None, 1.5, history=lambda *joint: None),
        "trends": plotting.trend_figure(closures, closed, rocks),
        "intervals": plotting.interval_figure(intervals, rocks),
        "predictive": plotting.predictive_figure(lengths, paper, rocks, 20),
        "walls": plotting.wall_pair_figure(np.eye(3), np.eye(3), 1e-3, title),
    }
    for name, figure in figures.items():
        figure.draw_without_rendering()  # a formula that is none is an error here
        texts = figure.findobj(Text)
        assert any(title in plain(text) for text in texts), name
        assert not any(is_formula(text) for text in texts)


def plain(text):
    return text.get_text().replace(r"\$", "$")


def is_formula(text):
    return text.get_parse_math() and is_math_text(text.get_text())


def test_the_share_of_lengths_below_the_axis_is_written_at_its_end(slate):
    study, *_, lengths = slate
    short = lengths.copy(deep=True)
    short["percent"][:, ::4] = 0.0
    paper = pd.DataFrame(columns=["rock", "parameter", "cycle", "paper_percent"])
    shown, usual = (
        [text.get_text() for text in figure.findobj(Text) if text.get_text().startswith("←")]
        for figure in (
            plotting.predictive_figure(one, paper, study.rocks, 20) for one in (short, lengths)
        )
    )
    assert set(shown) == {"← 25 %"}
    assert not usual


def test_the_figure_of_predicted_lengths_says_of_how_many_joints_a_study_is(slate):
    study, *_, lengths = slate
    paper = pd.DataFrame(columns=["rock", "parameter", "cycle", "paper_percent"])
    figure = plotting.predictive_figure(lengths, paper, study.rocks, 20)
    words = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert "studies of 20 pairs of walls, unpaired t test" in words


def test_the_range_of_predicted_lengths_is_drawn_inside_its_axis(slate):
    study, *_, lengths = slate
    wide = lengths.copy(deep=True)
    wide["percent"] = wide.percent * 1e6
    paper = pd.DataFrame(columns=["rock", "parameter", "cycle", "paper_percent"])
    figure = plotting.predictive_figure(wide, paper, study.rocks, 20)
    lines = [line.get_data() for axes in figure.axes for line in axes.lines]
    level = [x for x, y in lines if len(x) == 2 and y[0] == y[1]]
    assert level
    # up to the end of the axis, beyond which stands the share without a root
    assert all((np.array(x) >= 0.5).all() and (np.array(x) <= 500.0).all() for x in level)

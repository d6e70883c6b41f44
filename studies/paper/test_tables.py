"""Tables 1 to 3 in the paper's layout."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.cbook import is_math_text
from matplotlib.text import Text

from jointclosure.inputs import InputError
from jointclosure.joint.status import FAILURE
from jointclosure.parameters import PROPERTIES
from jointclosure.plotting.style import subplots
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.walls.jrc import z2_of_jrc
from studies.frame.cases import block_settings, cases_of, joint_grid, pool_of, synthesis
from studies.frame.configuration import merged, model, resolved
from studies.frame.keys import json_schema
from studies.frame.settings import walls_of
from studies.frame.tables import since_seating
from studies.frame.yaml_files import PAPER_TABLE_3, provenance
from studies.paper import figures as plotting
from studies.paper.closure_tables import indifference_table, max_closure_table
from studies.paper.covariates import (
    Covariates,
    as_dataset,
    covariates_of_pair,
    known_covariates,
    measure_covariates,
)
from studies.paper.predictive import lengths_dataset, predictive
from studies.paper.report import content as report
from studies.paper.report.page import sheet
from studies.paper.tables_1_to_3 import (
    case_table,
    closure_lines,
    figure_text,
    interval_text,
    property_heading,
    rock_table,
    table_3,
    table_3_markdown,
    with_paper,
)
from studies.paper.test_measured_fit import study as three_surfaces
from tests.studied import DEFAULT, ROOT, keys_of, study_of
from tests.world import world


@pytest.fixture(scope="module")
def equal_lengths():
    """Table 3 of two rocks, all of whose lengths are the same."""
    same = {"length": 1.5, "percent": 15.0, "length_net": 1.0, "percent_net": 10.0, "samples": 20}
    columns = [(rock, name, cycle) for rock in "ab" for name in PROPERTIES for cycle in (1, 2)]
    return pd.DataFrame(columns, columns=["rock", "parameter", "cycle"]).assign(**same)


TITLES = {"a": "Rock A", "b": r"\input{/etc/passwd} 50 % & $x_1^2$"}


def test_table_3_runs_no_command_of_a_title(equal_lengths):
    markdown = table_3_markdown(equal_lengths, TITLES)
    assert r"| \\input\{/etc/passwd\} 50 % \& \$x\_1^2\$, cycle 1 |" in markdown


def test_table_3_marks_its_lengths(equal_lengths):
    markdown = table_3_markdown(equal_lengths, TITLES)
    assert markdown.count("1.50 (15%)") == len(equal_lengths)
    assert markdown.count("1.00 (10%)") == len(equal_lengths)
    endless = equal_lengths.assign(length_high=float("inf"), extrapolated=True)
    assert "1.50*‡ (15%)" in table_3_markdown(endless, TITLES)


@pytest.fixture(scope="module")
def with_a_curve():
    """The default rocks, of which one has a measured curve."""
    measured = {"file": "a.csv", "stress_unit": "MPa"}
    return study_of({"rocks": {"slate": {"measured": measured}}}).rocks


def test_table_1_names_the_file_of_a_measured_curve(with_a_curve):
    table = rock_table(with_a_curve).set_index("rock")
    assert table.measured["slate"] == "a.csv"
    assert table.measured.isna().sum() == 3
    assert table.youngs_modulus_GPa["siltstone"] == 28.5


def test_table_2_has_every_level(with_a_curve):
    table = case_table(with_a_curve)
    assert len(table) == 4 * 4 * 3
    own = table[(table.rock == "siltstone") & (table.parameter == "youngs_modulus")]
    assert own.value.tolist() == [25, 28.5, 32]
    assert own.level.tolist() == ["low", "base", "high"]
    assert set(own.unit) == {"GPa"}


@pytest.mark.parametrize("title", ['=HYPERLINK("a")', "\t=1"])
def test_a_title_in_table_1_is_no_formula_of_a_spreadsheet(with_a_curve, title):
    slate = with_a_curve["slate"]._replace(title=title)
    assert rock_table({"slate": slate}).title.tolist() == ["'" + title]


def test_a_study_of_other_rocks_has_no_columns_of_the_paper():
    own = pd.DataFrame([{"rock": "slate", "parameter": "jrc", "cycle": 1, "length": 1.5}])
    paper = own.drop(columns="length").assign(paper_length=0.726, paper_percent=11)
    assert with_paper(own, paper).paper_length.item() == 0.726
    other = own.assign(rock="granite")
    pd.testing.assert_frame_equal(with_paper(other, paper), other)


# The page of a study


KEYS = keys_of(
    {"study": {"name": "made_up", "rocks": ["slate", "granite"], "realizations": 8}},
    {"rocks": {"granite": merged(DEFAULT["rocks"]["slate"], {"title": "Granite", "jrc": 9})}},
)


def test_the_first_screen_has_the_numbers_of_the_tables():
    """In every case one joint failed."""
    study = world(resolved(KEYS))
    study.status[:, 3] = 16
    study = study.assign(stiffness_net=1e6 / study.max_closure)
    study = study.assign_coords(scene=("case", ["all"] * study.sizes["case"]))
    study.attrs = {"references": "the paper"} | provenance(KEYS)
    checks = pd.DataFrame([PASSED, FAILED], columns=COLUMNS)
    tables = {"max_closure": max_closure_table(study), "checks": checks}
    paper = read_csv(PAPER_TABLE_3)
    schema = json_schema(model())
    shown = report.content(report.Material(study, tables, paper, DEFAULT, schema, {}))
    row = shown["frames"]["in_short"].iloc[0]
    base = tables["max_closure"].query("parameter == 'base' and rock == 'slate'").set_index("cycle")
    assert row["Net closure since seating, cycle 2 (mm)"] == base.max_closure_seated_net_mean_mm[2]
    stays = base.residual_closure_seated_net_mean_mm[1] / base.max_closure_seated_net_mean_mm[1]
    assert row[report.STAYS] == pytest.approx(100.0 * stays)
    case = study.sel(case="slate-base", cycle=1)
    compliance = (1e9 / case.stiffness_net).where(case.status < 16).mean()
    assert row["Net kn, cycle 1 (MPa/mm)"] == pytest.approx(1.0 / float(compliance))
    # the headline: means of both rocks, each with half of its 95 % interval by 7 joints
    closes = report.CLOSES.format(cycle=2)
    error = base.max_closure_seated_net_mean_mm_standard_error[2]
    assert row[f"{closes}_half_width"] == pytest.approx(2.447 * error, rel=1e-3)  # Student's t
    assert shown["ranges"]["joints"] == "7"
    low, high = (rounded(*one) for one in ends_of(shown["frames"]["in_short"], closes))
    assert shown["ranges"][closes] == f"{low} to {high}"
    assert " ± " in shown["ranges"][report.STAYS]
    assert shown["bias"].endswith("the study was not assessed; make report does so.")


def ends_of(frame, column):
    """Return the smallest and the largest number of a column, with their half-widths."""
    columns = frame[[column, f"{column}_half_width"]].sort_values(column)
    return columns.to_numpy()[[0, -1]].tolist()


def test_a_number_of_the_headline_without_an_error_is_only_rounded():
    """As of one joint."""
    numbers = pd.DataFrame({"Joints (n)": [1], "a": [0.12345], "a_half_width": [np.nan]})
    ranges = report.ranges_over_rocks(numbers, resolved(KEYS))
    assert (ranges["a"], ranges["joints"]) == ("0.12", "1")


def test_the_last_lines_of_a_run_have_half_of_the_95_percent_interval():
    name = "max_closure_seated_net_mean_mm"
    row = {"rock": "slate", "parameter": "base", "cycle": 1, "samples": 2}
    lines = closure_lines(pd.DataFrame([row | {name: 0.5, f"{name}_standard_error": 0.01}]))
    assert lines == [
        "slate: mean net closure since seating 0.50 ± 0.13 mm on cycle 1 "
        "(± half of the 95 % interval, 2 joints)"
    ]


def test_settings_that_differ_from_the_papers_are_found():
    schema = json_schema(model())
    assert report.departures(report.setting_rows(DEFAULT, DEFAULT, schema)) == []
    rows = report.setting_rows(KEYS, DEFAULT, schema)
    found = report.departures(rows)
    assert {"study.realizations", "rocks.granite.jrc"} <= set(found)
    assert not any(key.startswith("rocks.slate") for key in found)
    assert not any(key.startswith("rocks.dolerite") for key in rows.key)  # not in the study
    assert rows.meaning.str.len().min() > 5  # every key is explained


@pytest.mark.parametrize(
    ("of_slate", "of_dolerite", "error", "samples", "verdict"),
    [
        (-1.0, -1.1, 0.02, 60, "stands"),
        (-1.0, -1.1, 0.2, 4, "undecided"),
        (-1.0, -1.0, 0.101, 600, "undecided"),  # beyond the tolerance alone, but not in both rocks
        (-1.0, -1.0, 0.090, 600, "stands"),
        (-1.0, -0.65, 0.005, 60, "no difference"),
        (-1.0, -0.2, 0.02, 60, "falls"),
    ],
)
def test_the_headline_says_no_more_than_its_verdict(of_slate, of_dolerite, error, samples, verdict):
    table = pd.DataFrame({
        "rock": ["slate", "slate", "dolerite", "dolerite"],
        "parameter": 2 * ["youngs_modulus", "compressive_strength"],
        "elasticity": [of_slate, 0.6, of_dolerite, 0.6], "elasticity_standard_error": error,
        "cycle": 2, "samples": samples,
    })  # fmt: skip
    assert report.most_sensitive(table, "youngs_modulus") == verdict
    about = {"property": "Young's modulus", "rocks": 2, "cycle": 2, "verdict": verdict}
    assert report.headline(table) == about


# Covariates belong to the joints that were closed, and are alike in all cases of a study


SMALL = {
    "study": {"rocks": ["slate", "dolerite"], "realizations": 4, "pool": None},
    "grid": {"cells_x": 24, "cells_y": 20},
}


def made_by(configuration):
    """Return grid and synthesis of the walls of a study."""
    return joint_grid(configuration), synthesis(configuration)


def test_covariates_are_those_of_the_walls_that_were_closed():
    configuration = study_of(SMALL)
    values = measure_covariates(world(configuration), *made_by(configuration))
    for i, case in enumerate(cases_of(configuration)):
        z2 = z2_of_jrc(case.jrc, configuration.grid.spacing, configuration.surface.hurst)
        walls = walls_of(block_settings(configuration, case, range(4)))
        for j, (upper, lower) in enumerate(walls):
            expected = covariates_of_pair(upper, lower, z2)
            np.testing.assert_array_equal(values[i, j], expected)
            # of 480 cells 1 % end between the fourth and fifth highest, 5 % at the 24th
            highest = np.sort((upper + lower).ravel())[::-1]
            depth = highest[0] - highest[[3, 4]]
            at_five = highest[0] - highest[23]
            assert depth[0] <= z2 * expected[0] <= depth[1]
            assert z2 * expected[1] == pytest.approx(at_five, rel=1e-12)


@pytest.mark.parametrize("normalise", ["wall", "expectation"])
def test_covariates_of_one_noise_are_the_same_at_every_jrc(normalise):
    changes = {"study": {"draws": "common"}, "surface": {"normalise": normalise}}
    configuration = study_of(SMALL, changes)
    study = world(configuration)
    values = measure_covariates(study, *made_by(configuration))
    for rock in ("slate", "dolerite"):
        here = (study.rock == rock).values
        own = values[here]
        assert len(set(study.jrc.values[here])) == 3
        np.testing.assert_allclose(own, np.broadcast_to(own[0], own.shape), rtol=1e-10)


def test_means_are_known_within_the_error_that_they_tell():
    configuration = study_of(SMALL)
    one, other = (known_covariates(400, seed, *made_by(configuration)) for seed in (1, 2))
    off = one.means - other.means
    error = np.sqrt(sum(np.diag(each.covariance) / each.surfaces for each in (one, other)))
    assert np.all((off != 0.0) & (np.abs(off) < 4.0 * error))
    assert np.all(error < 0.05 * one.means)


def test_covariates_come_back_from_their_file(tmp_path):
    configuration = study_of(SMALL)
    study = world(configuration)
    known = known_covariates(20, 1, *made_by(configuration))
    values = measure_covariates(study, *made_by(configuration))
    study.attrs["key"] = "of this study"
    file = tmp_path / "covariates.nc"
    write_netcdf(as_dataset(Covariates(values, known), study), file)
    with pytest.raises(InputError, match=f"{file}: is not of this study"):
        read_covariates(file, study.assign_attrs(key="of another one"))
    again = read_covariates(file, study)
    np.testing.assert_array_equal(again.values, values)
    for one, other in zip(again.known, known, strict=True):
        np.testing.assert_array_equal(one, other)
    first = again.of_cycle(1)
    later = again.of_cycle(2)
    assert (first.values.shape[-1], later.values.shape[-1]) == (2, 1)
    assert first.known.means.tolist() == known.means[:2].tolist()
    assert later.known.covariance.tolist() == [[known.covariance[2, 2]]]


def test_a_page_has_columns_of_adjusted_numbers_only_where_something_is_adjusted():
    names = "rock mean_mm adjusted_mean_mm"
    table = pd.DataFrame({"rock": ["slate"], "mean_mm": [0.2], "adjusted_mean_mm": [np.nan]})
    assert sheet(table, names).titles == ["Rock", "Mean mm"]
    assert sheet(table.assign(adjusted_mean_mm=0.21), names).titles[2:] == ["Adjusted mean mm"]
    # other numbers that are not known keep their column
    assert sheet(table.assign(mean_mm=np.nan), names).titles == ["Rock", "Mean mm"]


# Checks: a failed one ends the run, after its table is written


COLUMNS = ["ensemble", "check", "required", "found", "passed"]
PASSED = ("cases", "least force", "not negative", "0", True)
FAILED = ("pool", "volume", "at most 1e-12", "2e-9 of it", False)


def require_checks(table, note):
    """Run the script of the rule `require_checks`."""
    rule = SimpleNamespace(input=[str(table)], output=[str(note)], log=[f"{note}.log"])
    script = ROOT / "workflow/scripts/require_checks.py"
    runpy.run_path(str(script), {"snakemake": rule}, "__main__")


@pytest.fixture
def failed_check(tmp_path):
    """Table of checks of which one failed, the note on those that pass, and the log's end."""
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"
    pd.DataFrame([PASSED, FAILED], columns=COLUMNS).to_csv(table, index=False)
    with pytest.raises(SystemExit):
        require_checks(table, note)
    return table, note, Path(f"{note}.log").read_text().splitlines()[-1]


def test_a_failed_check_ends_the_run_naming_it(failed_check):
    table, _, last = failed_check
    assert last.startswith(f"failed: InputError: {table}: results fail their checks: ")
    assert last.endswith(" volume (pool): 2e-9 of it, required at most 1e-12")
    assert "least force" not in last


def test_a_failed_check_leaves_no_note(failed_check):
    assert not failed_check[1].exists()


def test_checks_that_pass_leave_a_note(tmp_path):
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"
    pd.DataFrame([PASSED, PASSED], columns=COLUMNS).to_csv(table, index=False)
    require_checks(table, note)
    assert note.read_text() == "2 checks that have a limit passed\n"


# Figures are drawn from a made-up study; what they show is looked at by people


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


@pytest.mark.parametrize("seating", [None, 5e5])
def test_closure_since_seating_has_the_mean_over_all_surfaces(seating):
    study = three_surfaces()
    rock = study_of().rocks["slate"]._replace(max_normal_stress=2e6)
    figure = plotting.closure_figure(
        study, {"one": rock}, seating, 1.5, history=lambda *joint: None
    )
    words = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert ("mean of all surfaces, loading and unloading" in words) == (seating is not None)
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


def test_means_on_common_surfaces_are_drawn_with_the_errors_of_their_changes():
    for draws, smaller in (("common", True), ("independent", False)):
        study = study_of({"study": {"draws": draws, "rocks": ["slate"], "pool": None}})
        closed = world(study)
        table = max_closure_table(closed)
        figure = plotting.trend_figure(table, closed, study.rocks)
        for axes, cycle in zip(
            figure.axes[:: len(study.rocks["slate"].levels)], (1, 2), strict=True
        ):
            (bars,) = (one.lines[2][0].get_segments() for one in axes.containers)
            halves = [0.5 * (bar[1, 1] - bar[0, 1]) for bar in bars]
            here = table[(table.cycle == cycle) & table.parameter.isin(["base", "poisson_ratio"])]
            scatter = here.max_closure_mean_mm_standard_error
            if not smaller:
                np.testing.assert_allclose(sorted(halves), sorted(scatter))
                continue
            low, high = (
                closed.max_closure.sel(case=f"slate-poisson_ratio-{level}", cycle=cycle)
                - closed.max_closure.sel(case="slate-base", cycle=cycle)
                for level in ("low", "high")
            )
            errors = [1e3 * float(one.std(ddof=1)) / np.sqrt(one.size) for one in (low, high)]
            np.testing.assert_allclose(sorted(halves), sorted([0.0, *errors]), atol=1e-12)
            assert max(halves) < 0.1 * scatter.min()


def test_a_failed_joint_takes_its_surface_out_of_the_change_on_common_surfaces():
    study = study_of({"study": {"draws": "common", "rocks": ["slate"], "pool": None}})
    closed = world(study)
    at = {"case": "slate-jrc-low", "cycle": 1}
    changes = closed.max_closure.sel(at) - closed.max_closure.sel(at | {"case": "slate-base"})
    closed["status"] = closed.status.broadcast_like(closed.max_closure[..., 0]).copy()
    closed.status.loc[{"case": "slate-base", "realization": 3}] = FAILURE
    row = max_closure_table(closed).set_index(["case", "cycle"]).loc["slate-jrc-low", 1]
    left = 1e3 * float(changes.where(changes.realization != 3).mean())
    assert row.max_closure_change_mm == pytest.approx(left)


def test_lengths_have_the_digits_that_are_not_doubtful():
    assert interval_text(1.2345, 12.3, "*") == "1.23* (12%)"
    assert interval_text(1.2345, 12.3, "", 0.2) == "1.23 ± 0.20 (12%)"
    assert interval_text(1.2345, 12.3, "", np.inf) == "1.2 (12%)"
    assert interval_text(np.nan, np.nan) == "–"


@pytest.mark.parametrize(
    ("status", "text"),
    [({}, "1.50* (15%)"), ({"status": "negative deviation at the root"}, "1.50† (15%)")],
)
def test_lengths_are_marked_by_what_is_doubtful_of_them(status, text):
    same = {"rock": "a", "length": 1.5, "percent": 15.0, "extrapolated": True} | status
    columns = [(name, cycle) for name in PROPERTIES for cycle in (1, 2)]
    table = pd.DataFrame(columns, columns=["parameter", "cycle"]).assign(**same)
    assert set(table_3(table, {"a": "A"}).to_numpy().ravel()) == {text}


def test_the_heading_of_a_property_has_its_symbol_and_unit_and_of_the_roughness_its_name():
    assert property_heading("compressive_strength") == "Compressive strength σc (MPa)"
    assert property_heading("jrc") == "Joint roughness coefficient (JRC)"


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

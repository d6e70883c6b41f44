"""Tables 1 to 3 in the paper's layout."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.parameters import PROPERTIES
from jointclosure.storage.files import read_csv
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.walls.roughness import z2_of_jrc
from studies.frame.cases import block_settings, cases_of
from studies.frame.configuration import merged, model, resolved
from studies.frame.keys import json_schema
from studies.frame.plan import inputs_of, settings_of
from studies.frame.products import make_files
from studies.frame.settings import walls_of
from studies.frame.yaml_files import PAPER_TABLE_3, provenance
from studies.paper import figures as plotting
from studies.paper import needs  # noqa: F401
from studies.paper import responses as measured
from studies.paper.closures import max_closure_table
from studies.paper.layout import case_table, rock_table, table_3_markdown, with_paper
from studies.paper.products import PRODUCTS
from studies.paper.report import content as report
from studies.paper.responses import Covariates, known_covariates, measure_covariates
from studies.paper.test_table_3 import study as three_surfaces
from tests.studied import DEFAULT, ROOT, keys_of, study_of
from tests.world import world


def test_table_3_marks_its_lengths_and_runs_no_command_of_a_title():
    same = {"length": 1.5, "percent": 15.0, "length_net": 1.0, "percent_net": 10.0, "samples": 20}
    columns = [(rock, name, cycle) for rock in "ab" for name in PROPERTIES for cycle in (1, 2)]
    table = pd.DataFrame(columns, columns=["rock", "parameter", "cycle"]).assign(**same)
    titles = {"a": "Rock A", "b": r"\input{/etc/passwd} 50 % & $x_1^2$"}
    markdown = table_3_markdown(table, titles)
    assert r"| \\input\{/etc/passwd\} 50 % \& \$x\_1^2\$, cycle 1 |" in markdown
    assert markdown.count("1.50 (15%)") == len(table)
    assert markdown.count("1.00 (10%)") == len(table)
    endless = table.assign(length_high=float("inf"), extrapolated=True)
    assert "1.50*‡ (15%)" in table_3_markdown(endless, titles)


def test_tables_1_and_2_have_every_level_and_the_file_of_a_measured_curve():
    rocks = study_of({"rocks": {"slate": {"measured": {"file": "a.csv", "stress_unit": "MPa"}}}})
    table = rock_table(rocks.rocks).set_index("rock")
    assert table.measured["slate"] == "a.csv"
    assert table.measured.isna().sum() == 3
    assert table.youngs_modulus_GPa["siltstone"] == 28.5
    table = case_table(rocks.rocks)
    assert len(table) == 4 * 4 * 3
    own = table[(table.rock == "siltstone") & (table.parameter == "youngs_modulus")]
    assert own.value.tolist() == [25, 28.5, 32]
    assert own.level.tolist() == ["low", "base", "high"]
    assert set(own.unit) == {"GPa"}
    for title in ('=HYPERLINK("a")', "\t=1"):  # is no formula of a spreadsheet
        slate = rocks.rocks["slate"]._replace(title=title)
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
    paper, schema = read_csv(PAPER_TABLE_3), json_schema(model())
    shown = report.content(report.Material(study, tables, paper, DEFAULT, schema, {}))
    row = shown["frames"]["in_short"].iloc[0, 1:]
    base = tables["max_closure"].query("parameter == 'base' and rock == 'slate'").set_index("cycle")
    assert row["Net closure since seating, cycle 2 (mm)"] == base.max_closure_seated_net_mean_mm[2]
    stays = base.residual_closure_seated_net_mean_mm[1] / base.max_closure_seated_net_mean_mm[1]
    assert row[report.STAYS] == pytest.approx(100.0 * stays)
    case = study.sel(case="slate-base", cycle=1)
    compliance = (1e9 / case.stiffness_net).where(case.status < 16).mean()
    assert row["Net kn, cycle 1 (MPa/mm)"] == pytest.approx(1.0 / float(compliance))


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


def test_covariates_are_those_of_the_walls_that_were_closed():
    configuration = study_of(SMALL)
    values = measure_covariates(world(configuration), configuration.grid, configuration.surface)
    for i, case in enumerate(cases_of(configuration)):
        z2 = z2_of_jrc(case.jrc, configuration.grid.spacing, configuration.surface.hurst)
        walls = walls_of(block_settings(configuration, case, range(4)))
        for j, (upper, lower) in enumerate(walls):
            expected = measured.covariates_of_pair(upper, lower, z2)
            np.testing.assert_array_equal(values[i, j], expected)
            # of 480 cells 1 % end between the fourth and fifth highest, 5 % at the 24th
            highest = np.sort((upper + lower).ravel())[::-1]
            depth, at_five = highest[0] - highest[[3, 4]], highest[0] - highest[23]
            assert depth[0] <= z2 * expected[0] <= depth[1]
            assert z2 * expected[1] == pytest.approx(at_five, rel=1e-12)


@pytest.mark.parametrize("normalise", ["wall", "expectation"])
def test_covariates_of_one_noise_are_the_same_at_every_jrc(normalise):
    changes = {"study": {"draws": "common"}, "surface": {"normalise": normalise}}
    configuration = study_of(SMALL, changes)
    study = world(configuration)
    values = measure_covariates(study, configuration.grid, configuration.surface)
    for rock in ("slate", "dolerite"):
        here = (study.rock == rock).values
        own = values[here]
        assert len(set(study.jrc.values[here])) == 3
        np.testing.assert_allclose(own, np.broadcast_to(own[0], own.shape), rtol=1e-10)


def test_means_are_known_within_the_error_that_they_tell():
    configuration = study_of(SMALL)
    grid, surface = configuration.grid, configuration.surface
    one, other = (known_covariates(400, seed, grid, surface) for seed in (1, 2))
    off = one.means - other.means
    error = np.sqrt(sum(np.diag(each.covariance) / each.surfaces for each in (one, other)))
    assert np.all((off != 0.0) & (np.abs(off) < 4.0 * error))
    assert np.all(error < 0.05 * one.means)


def test_covariates_come_back_from_their_file(tmp_path):
    configuration = study_of(SMALL)
    study = world(configuration)
    known = known_covariates(20, 1, configuration.grid, configuration.surface)
    values = measure_covariates(study, configuration.grid, configuration.surface)
    write_netcdf(measured.as_dataset(Covariates(values, known), study), tmp_path / "covariates.nc")
    again = measured.from_dataset(read_netcdf(tmp_path / "covariates.nc"))
    np.testing.assert_array_equal(again.values, values)
    for one, other in zip(again.known, known, strict=True):
        np.testing.assert_array_equal(one, other)
    first, later = again.of_cycle(1), again.of_cycle(2)
    assert (first.values.shape[-1], later.values.shape[-1]) == (2, 1)
    assert first.known.means.tolist() == known.means[:2].tolist()
    assert later.known.covariance.tolist() == [[known.covariance[2, 2]]]


# Products of a study: made of what they read, and again only when that changes


COLUMNS = ["ensemble", "check", "required", "found", "passed"]
PASSED = ("cases", "least force", "not negative", "0", True)
FAILED = ("pool", "volume", "at most 1e-12", "2e-9 of it", False)
CURVE = {"rocks": {"slate": {"measured": {"file": "config/my_rock_measured.csv"}}}}


def test_a_parameter_that_a_product_cannot_read_is_named():
    misspelt = PRODUCTS["draw_figures"]._replace(make=lambda fineness: None)
    with pytest.raises(ValueError, match="parameter 'fineness' is no table of its study"):
        settings_of(misspelt, study_of())


RANDOM = {"find_indifference_intervals", "predict_table_3", "judge_claims", "measure_covariates"}
TITLED = {"write_tables", "draw_figures", "draw_pool_figures"}


@pytest.mark.parametrize(
    ("change", "made_again"),
    [
        ({"statistics": {"bootstrap_resamples": 77}}, {"find_indifference_intervals"}),
        ({"statistics": {"repetitions": 777}}, {"predict_table_3", "judge_claims"}),
        ({"statistics": {"control_variates": 777}}, {"measure_covariates"}),
        ({"output": {"wall_strength_ratio": 7.0}}, {"draw_figures"}),
        ({"numerics": {"force_tolerance": 1e-8}}, {"check_results"}),
        ({"study": {"root_seed": 77}}, RANDOM),
        ({"study": {"pool": 77}}, {"check_results"}),
        ({"rocks": {"slate": {"title": "Another slate"}}}, TITLED),
        (CURVE, TITLED | {"fit_measured"}),
        ({"choices": {"peak_modulus_ratio": 0.1}}, set()),
        ({"study": {"cycles": 3, "realizations_per_job": 7}}, set()),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",  # sets have no order
)
def test_settings_change_of_the_products_that_read_a_key_and_of_no_other(change, made_again):
    studies = study_of(), study_of(change)
    before, after = ([settings_of(each, study) for each in PRODUCTS.values()] for study in studies)
    changed = {name for name, *two in zip(PRODUCTS, before, after, strict=True) if two[0] != two[1]}
    assert changed == made_again | {"state_configuration"}


def test_a_failed_check_ends_the_run_naming_it_and_leaves_no_note(tmp_path):
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"
    lines: list[str] = []
    given = PRODUCTS["require_checks"].make, {"checks": str(table)}, {}, [str(note)]
    pd.DataFrame([PASSED, FAILED], columns=COLUMNS).to_csv(table, index=False)
    with pytest.raises(SystemExit) as ended:
        make_files(*given, log=lines.append)
    assert "volume (pool): 2e-9 of it, required at most 1e-12" in str(ended.value)
    assert "least force" not in str(ended.value)
    assert not note.exists()
    pd.DataFrame([PASSED, PASSED], columns=COLUMNS).to_csv(table, index=False)
    make_files(*given, log=lines.append)
    assert note.read_text() == "2 checks passed\n"
    assert lines == [f"wrote {note}"]


def test_tables_of_other_studies_are_read_by_the_study_of_their_model_only(monkeypatch):
    monkeypatch.chdir(ROOT)
    for name, expected in (("paper", 4), ("mine", 0)):
        inputs = inputs_of(PRODUCTS["conclude"], study_of({"study": {"name": name}}))
        beside = (inputs[key] for key in ("jrc_range", "readings", "choices", "margins"))
        assert sum(map(bool, beside)) == expected


# Figures are drawn from a made-up study; what they show is looked at by people


def test_closures_are_drawn_of_the_surface_closest_to_the_mean_since_seating_or_first_touch():
    study = three_surfaces()
    assert plotting.closest_to_mean(study, "one-base", 5e5) == 11
    assert plotting.closest_to_mean(three_surfaces((0, 16, 0)), "one-base", 5e5) != 11
    rock = study_of().rocks["slate"]._replace(max_normal_stress=2e6)
    for seating, lowest, last, left in (
        (5e5, (0.0, 0.5), [0.1, 0.01], 7e-3),
        # the paper's figure is gross: 0.03 mm of bulk indentation at the maximum
        (None, (0.0, 0.0), [0.2 + 0.03], 0.16),
    ):
        figure = plotting.closure_figure(study, {"one": rock}, seating, 1.5)
        for axes, end in zip(figure.axes, last, strict=False):  # each cycle has a panel
            loading, unloading = [line for line in axes.lines if line.get_linewidth() == 2.0]
            assert (loading.get_xdata()[0], loading.get_ydata()[0]) == lowest
            np.testing.assert_allclose(loading.get_xdata()[-1], end)
            # unloading ends at seating, with the residual closure
            np.testing.assert_allclose(unloading.get_xdata()[0], left)
            assert unloading.get_ydata()[0] == lowest[1]

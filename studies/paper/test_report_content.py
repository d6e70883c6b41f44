"""Content of the page of a study: first screen, headline, settings and columns."""

import functools
import html
import json
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.parameters import Numerics
from jointclosure.statistics.number_texts import rounded
from jointclosure.storage.files import read_csv
from studies.frame.configuration import merged, model, read_stored
from studies.frame.keys import json_schema
from studies.frame.yaml_files import PAPER_TABLE_3, provenance
from studies.paper.closure_tables import max_closure_table
from studies.paper.report import content as report
from studies.paper.report.page_rendering import render, sheet
from studies.paper.report.page_tables import About, base_closures, hardest
from studies.paper.tables_1_to_3 import (
    closure_lines,
)
from studies.paper.test_required_checks import COLUMNS, FAILED, PASSED
from tests.studied import DEFAULT, keys_of
from tests.world import world

KEYS = keys_of(
    {"study": {"name": "made_up", "rocks": ["slate", "granite"], "realizations": 8}},
    {"rocks": {"granite": merged(DEFAULT["rocks"]["slate"], {"title": "Granite", "jrc": 9})}},
)


@functools.cache
def material():
    """Dataset and tables of a study in every case of which one joint failed."""
    study = world(read_stored(KEYS))
    study.status[:, 3] = 16
    study = study.assign(stiffness_net=1e6 / study.max_closure)
    study = study.assign_coords(scene=("case", ["all"] * study.sizes["case"]))
    study.attrs = {"references": "the paper"} | provenance(KEYS)
    checks = pd.DataFrame([PASSED, FAILED], columns=COLUMNS)
    tables = {"max_closure": max_closure_table(study), "checks": checks}
    paper = read_csv(PAPER_TABLE_3)
    return report.Material(study, tables, paper, DEFAULT, json_schema(model()), {})


def test_the_first_screen_has_the_numbers_of_the_tables():
    study, tables = material()[:2]
    shown = report.content(material())
    row = shown["frames"]["in_short"].iloc[0]
    base = tables["max_closure"].query("parameter == 'base' and rock == 'slate'").set_index("cycle")
    assert row["Net closure since seating, cycle 2 (mm)"] == base.max_closure_seated_net_mean_mm[2]
    stays = base.residual_closure_seated_net_mean_mm[1] / base.max_closure_seated_net_mean_mm[1]
    assert row[report.STAYS] == pytest.approx(100.0 * stays)
    case = study.sel(case="slate-base", cycle=1)
    compliance = (1e9 / case.stiffness_net).where(case.status < 16).mean()
    assert row["Net chord stiffness, cycle 1 (MPa/mm)"] == pytest.approx(1.0 / float(compliance))
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
    ranges = report.ranges_over_rocks(numbers, read_stored(KEYS))
    assert (ranges["a"], ranges["joints"]) == ("0.12", "1")


def test_the_last_lines_of_a_run_have_half_of_the_95_percent_interval():
    name = "max_closure_seated_net_mean_mm"
    row = {"rock": "slate", "parameter": "base", "cycle": 1, "samples": 2}
    lines = closure_lines(pd.DataFrame([row | {name: 0.5, f"{name}_standard_error": 0.01}]))
    assert lines == [
        "slate: mean net closure since seating 0.50 ± 0.13 mm on cycle 1 "
        "(± half of the 95 % interval, 2 joints)"
    ]


def test_measured_closures_stand_beside_those_of_the_model():
    fits = pd.DataFrame({
        "rock": "slate", "cycle": ["1", "2", "all"], "largest_closure_mm": [0.236, 0.0623, 0.236],
    })  # fmt: skip
    numbers = pd.DataFrame({"Rock": ["Slate"]})
    for cycle, (mean, half) in enumerate([(0.34, 0.12), (0.0153, 0.0026)], start=1):
        numbers[report.CLOSES.format(cycle=cycle)] = mean
        numbers[report.CLOSES.format(cycle=cycle) + report.HALF_WIDTH] = half
    (sentence,) = report.measured_closures(fits, numbers, {"slate": "Slate"})
    assert sentence.startswith(
        "The measured joint of Slate closes by 0.24 mm and 0.062 mm on cycle 1 and cycle 2, the "
        "joints of the model by 0.34 ± 0.12 mm and 0.0153 ± 0.0026 mm"
    )
    assert report.measured_closures(None, numbers, {}) == []


def test_claims_are_folded_where_no_rock_is_the_papers():
    shown = report.content(material())
    claims = pd.DataFrame({
        "number": ["1"], "claim": ["closure"], "verdict": ["stands"], "found": [""],
        "found_here": ["yes"],
    })  # fmt: skip
    page = shown | {"frames": shown["frames"] | {"claims": claims}}
    assert "<details>" in render(page | {"compared": []})
    assert "<details>" not in render(page | {"compared": ["Slate"]})


def test_the_report_has_the_sentences_by_which_effects_were_chosen():
    reasons = ["without interaction the mean closure changes by 61 %: kept (tolerance 5 %)"]
    study = material().study
    assert report.chosen_effects(study, {"slate": "Slate"}) == {}
    chosen = {"slate": {"cases": {"slate-base": {"reasons": reasons}}}}
    study = study.assign_attrs(effects_chosen=json.dumps(chosen))
    page = render(report.content(material()._replace(study=study)))
    assert report.chosen_effects(study, {"slate": "Slate"}) == {"Slate": reasons}
    assert reasons[0] in page


def test_pictures_follow_the_first_paragraph():
    page = render(report.content(material()))
    first = page.index("half of the 95 % interval.</p>")
    assert first < page.index('class="panels"') < page.index("Closure is net:")


def test_a_second_study_is_advised_with_smaller_errors_than_those_of_the_study():
    """Of a study that resolves breakage, to resolve it would advise the same study again."""
    numerics = Numerics()
    assert report.finer_numerics(numerics._replace(breakage="fixed_step")) == (
        "numerics: {breakage: resolved}"
    )
    resolved = numerics._replace(breakage="resolved", tolerance=0.02)
    words = "numerics: {breakage: resolved, tolerance: 0.004}"
    assert report.finer_numerics(resolved) == words
    assert words in render(report.content(material()) | {
        "finer_numerics": words,
        "frames": report.content(material())["frames"] | {"table_3": pd.DataFrame({"a": [1]})},
    })  # fmt: skip


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
    least, most = (report.rounded(value, error) for value in sorted((of_slate, of_dolerite)))
    about = {"property": "Young's modulus", "rocks": 2, "cycle": 2, "verdict": verdict}
    about["elasticity"] = f"{least} to {most}"
    difference = min(abs(of_slate), abs(of_dolerite)) - 0.6
    nearest = {"other": "compressive strength", "of": "gross closure", "is_equal": False}
    nearest["rock"] = "dolerite" if abs(of_dolerite) < abs(of_slate) else "slate"
    nearest["difference"] = report.rounded(difference, np.hypot(error, error))
    assert report.headlines(table) == [about | nearest]
    first = table.assign(cycle=1, elasticity=table.elasticity[::-1].to_numpy())
    others = report.headlines(pd.concat([first, table]))
    assert [one["cycle"] for one in others] == [1, 2]
    assert others[1] == about | nearest


def two_rocks(**columns):
    """Elasticities with respect to two properties in two rocks."""
    about = {
        "rock": ["slate", "slate", "dolerite", "dolerite"],
        "parameter": 2 * ["youngs_modulus", "compressive_strength"],
        "elasticity": [-1.0, 0.5, -1.0, 0.5], "elasticity_standard_error": 0.01,
        "cycle": 1, "samples": 20,
    }  # fmt: skip
    return pd.DataFrame(about | columns)


def test_equal_elasticities_are_said_to_be_equal():
    """Their standard error may be large: no number of joints would show a difference."""
    table = two_rocks(elasticity=[-1.0, 1.0, -1.0, 0.2], elasticity_standard_error=0.3)
    (headline,) = report.headlines(table)
    assert headline["is_equal"]
    assert (headline["rock"], headline["verdict"]) == ("slate", "undecided")
    assert "have the same size" in shown([headline])


def test_properties_that_not_all_rocks_vary_are_not_compared():
    parameters = ["youngs_modulus", "jrc", "compressive_strength", "jrc"]
    table = two_rocks(parameter=parameters, elasticity=[-1.0, 0.5, 1.0, 0.5])
    (headline,) = report.headlines(table)
    assert headline["verdict"] == report.NOT_VARIED
    assert "because not all rocks vary" in shown([headline])


def test_the_headline_is_of_net_closure_since_seating_where_this_is_known():
    seated = {report.SEATED: [-0.5, 0.9, -0.5, 0.9], f"{report.SEATED}_standard_error": 0.01}
    (headline,) = report.headlines(two_rocks(**seated))
    assert headline["of"] == "net closure since seating"
    assert (headline["property"], headline["verdict"]) == ("compressive strength", "stands")


@pytest.mark.parametrize(
    ("elasticity", "error", "words"),
    [
        ([-1.0, 0.5, -1.0, 0.5], 0.01, "depends most on Young's modulus in both rocks"),
        ([-1.0, 0.5, -0.5, 1.0], 0.01, "is not the same in all rocks"),
        ([-1.0, 0.95, -1.0, 0.95], 0.001, "a difference below 0.1 counts as none"),
        ([-1.0, 0.95, -1.0, 0.9], 0.1, "differ by 0.05 ± 0.14 in Slate"),
    ],
)
def test_the_headline_says_what_the_elasticities_show(elasticity, error, words):
    table = two_rocks(elasticity=elasticity, elasticity_standard_error=error)
    text = shown(report.headlines(table))
    assert words in text
    assert "so few joints" not in text


def shown(headlines):
    """The headlines in words, without tags."""
    page = render(report.content(material()) | {"headlines": headlines})
    part = page[page.index("in-short-head") : page.index('class="note"')]
    return " ".join(re.sub("<[^>]*>", "", html.unescape(part)).split())


def test_a_page_has_columns_of_adjusted_numbers_only_where_something_is_adjusted():
    names = "rock mean_mm adjusted_mean_mm"
    table = pd.DataFrame({"rock": ["slate"], "mean_mm": [0.2], "adjusted_mean_mm": [np.nan]})
    assert sheet(table, names).titles == ["Rock", "Mean mm"]
    assert sheet(table.assign(adjusted_mean_mm=0.21), names).titles[2:] == ["Adjusted mean mm"]
    # other numbers that are not known keep their column
    assert sheet(table.assign(mean_mm=np.nan), names).titles == ["Rock", "Mean mm"]


def test_adjusted_means_are_shown_only_where_their_errors_are_smaller():
    mean, adjusted = "max_closure_mean_mm", "max_closure_adjusted_mean_mm"
    table = pd.DataFrame({
        "parameter": "base", "cycle": [1, 2],
        mean: 1.0, f"{mean}_standard_error": 0.1,
        adjusted: 1.0, f"{adjusted}_standard_error": [0.02, 0.2],
    })  # fmt: skip
    shown = base_closures(table)
    assert shown[adjusted].notna().tolist() == [True, False]
    assert shown[mean].notna().all()


def test_hard_joints_are_named_by_the_study_although_an_older_table_has_no_names():
    study = xr.Dataset(
        coords={
            "case": ["slate-base", "slate-jrc-low"],
            "rock": ("case", ["slate", "slate"]),
            "parameter": ("case", ["base", "jrc"]),
            "level": ("case", ["base", "low"]),
            "value": ("case", [np.nan, 6.0]),
        }
    )
    table = pd.DataFrame({
        "rock": "slate", "parameter": ["jrc", "base"], "level": ["low", "base"],
        "joint": [3, 4], "verdict": ["", np.nan], "reason": "",
    })  # fmt: skip
    shown = hardest(table, study, About({"slate": "Slate"}, set()))
    assert shown.Changed.tolist() == ["JRC 6", "as it is"]
    assert set(shown.Verdict) == {"no remark"}

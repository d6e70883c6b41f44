"""Parts of the page: cells, captions, settings, curves."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from jointclosure.config.keys.configuration import ConfigurationKeys
from jointclosure.config.schema import json_schema
from jointclosure.report import curves, findings, summary
from jointclosure.report.captions import read_caption
from jointclosure.report.curves import MOST_JOINTS, explorer_data
from jointclosure.report.settings import departures, setting_rows
from jointclosure.report.sheets import Cell, Sheet, cell, number_text
from tests.report.conftest import FAILED, JOINTS, JUMPED

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1.0, "1.000"), (123.456, "123.5"), (-0.0123456, "-0.01235"),
     (2.55e-17, "2.550e-17"), (1.5e7, "1.500e+07"), (float("inf"), "∞"), (float("-inf"), "−∞")],
)  # fmt: skip
def test_numbers_are_shown_to_four_figures(value, text):
    assert number_text(value) == text
    assert cell(value) == Cell(text, value)


def test_cells_of_other_kinds():
    assert cell(float("nan")) == cell(None) == cell("") == Cell("–", "")
    assert cell(np.int64(20200827)) == Cell("20200827", 20200827)
    assert cell(np.bool_(True)) == cell(True) == Cell("yes", "yes")
    assert cell(Cell("as it is", 1.0)) == Cell("as it is", 1.0)


def test_a_column_of_numbers_may_lack_some():
    rows = [[cell(1.0), cell("a"), cell("w" * 40)], [cell(None), cell(2.0), cell("")]]
    assert Sheet("x", "", ["", "", ""], rows).kinds == ["number", "word", "text"]


def test_a_caption_says_what_the_configuration_says():
    text = ".. title: A\n.. alt: B\n   over two lines\n\n"
    text += 'Of {{ snakemake.config["n"] }}\njoints.\n\nMore.\n'
    assert read_caption(text, {"n": 4}) == ("A", "B over two lines", ["Of 4 joints.", "More."])


@pytest.mark.parametrize(
    ("text", "lacking"),
    [
        (".. title: A\n\nText.\n", "alt"),
        (".. alt: A\n\nText.\n", "title"),
        (".. title: A\n.. alt: B\n", "its text"),
    ],
)
def test_a_caption_that_lacks_something_is_refused(text, lacking):
    with pytest.raises(ValueError, match=f"lacks {lacking}"):
        read_caption(text, {})


def test_settings_that_differ_from_the_papers_are_found(configuration, default):
    schema = json_schema(ConfigurationKeys)
    assert departures(setting_rows(default, default, schema)) == []
    rows = setting_rows(configuration, default, schema)
    found = departures(rows)
    assert "study.realizations" in found
    assert "rocks.granite.jrc" in found
    assert not any(key.startswith("rocks.slate") for key in found)
    assert not any(key.startswith("rocks.dolerite") for key in rows.key)  # not in the study
    assert rows.meaning.str.len().min() > 5  # every key is explained


@pytest.fixture
def explored(study):
    return explorer_data(study, {"slate": "Slate", "granite": "Granite"}, 0.5e6)


def test_means_are_those_of_all_joints_that_are_used(explored, study):
    case = explored["rocks"][0]["cases"][0]
    good = study.sel(case="slate-base").isel(realization=[i for i in range(JOINTS) if i != FAILED])
    mean = 1e3 * good.closure.mean("realization").sel(cycle=1, branch="loading").values
    shown = np.array(case["mean"][0][0][0], dtype=float)
    # a mean ends where a joint jumped over the stress: the others are no fair sample
    assert case["mean"][0][0][0][-1] is None
    np.testing.assert_allclose(shown[:-1], mean[:-1], rtol=1e-4, atol=1e-9)
    deviation = 1e3 * good.closure.std("realization", ddof=1).sel(cycle=1, branch="loading").values
    np.testing.assert_allclose(
        np.array(case["deviation"][0][0][0][:-1], dtype=float), deviation[:-1], rtol=1e-2, atol=1e-5
    )
    assert (case["used"], case["of"]) == (JOINTS - 1, JOINTS)


def test_closures_from_seating_are_less_by_the_closure_at_seating(explored, study):
    case = explored["rocks"][0]["cases"][0]
    numbers = [joint["number"] for joint in case["joints"]]
    assert len(numbers) == MOST_JOINTS
    assert FAILED not in numbers
    assert JUMPED in numbers
    own = study.sel(case="slate-base", realization=0)
    first = 1e3 * float(own.max_closure[0] - own.max_closure_seated[0])
    assert case["joints"][0]["seats"][0] == pytest.approx(first, rel=1e-3)
    second = 1e3 * float(own.residual_closure[0] + own.max_closure[1] - own.max_closure_seated[1])
    assert case["joints"][0]["seats"][1] == pytest.approx(second, rel=1e-3)


def test_a_rock_has_its_own_levels_and_stresses(explored):
    slate, granite = explored["rocks"]
    assert (slate["stress"][-1], granite["stress"][-1]) == (30.0, 20.0)
    assert [p["name"] for p in granite["parameters"]] == ["youngs_modulus", "jrc"]
    moduli = [
        c["values"]["youngs_modulus"]
        for c in granite["cases"]
        if c["parameter"] == "youngs_modulus"
    ]
    assert moduli == ["50 GPa", "55 GPa", "65 GPa", "70 GPa"]


def test_means_do_not_depend_on_how_many_joints_are_read_at_a_time(explored, study, monkeypatch):
    monkeypatch.setattr(curves, "_BLOCK", 7)
    case = curves.explorer_data(study, {"slate": "Slate"}, 0.5e6)["rocks"][0]["cases"][0]
    whole = explored["rocks"][0]["cases"][0]
    for measure in ("mean", "deviation"):
        for own, other in zip(flat(case[measure]), flat(whole[measure]), strict=True):
            assert own == other or own == pytest.approx(other, abs=2e-4)


def flat(values):
    return [x for v in values for x in flat(v)] if isinstance(values, list) else [values]


def test_a_case_of_which_nothing_succeeded_has_no_curves(study):
    failed = study.isel(case=[0]).assign(status=study.status.isel(case=[0]) * 0 + 16)
    case = explorer_data(failed, {"slate": "Slate"}, 0.5e6)["rocks"][0]["cases"][0]
    assert case["joints"] == []
    assert {value for branch in case["mean"][0][0] for value in branch} == {None}


def test_a_cycle_has_its_own_closure_where_it_counts_from_its_start(study, explored):
    case = explored["rocks"][0]["cases"][0]
    own = study.isel(case=0)
    good = own.isel(realization=np.flatnonzero(own.status.values < 16))
    for index in range(study.sizes["cycle"]):
        curve = case["mean"][2][index][0]
        reached = [closure for closure in curve if closure is not None]
        expected = 1e3 * float(good.max_closure.isel(cycle=index).mean())
        assert reached[-1] == pytest.approx(expected, rel=0.3)
    touch = [closure for closure in case["mean"][0][1][0] if closure is not None][-1]
    assert touch > 1.5 * [closure for closure in case["mean"][2][1][0] if closure is not None][-1]


def concluded() -> pd.DataFrame:
    """Two claims with what they rest on: one tried in all ways, one in none."""
    shares = ("found_share", "found_error", "found_low", "found_high")
    known = dict(zip(shares, (0.9, 0.01, 0.88, 0.92), strict=True))
    tried = {"number": "2a", "claim": "it matters", "said_in": "Abstract", "verdict": "stands"}
    tried |= known | {f"jrc_{name}": value for name, value in known.items()}
    tried |= {"jrc_half_width": 2.0, "conclusion": "cannot be told"}
    tried |= {"readings_stand": 4, "readings_fall": 0, "readings_equal": 2, "readings_open": 1}
    tried |= {"partial_stand": 0, "partial_fall": 0, "partial_equal": 0, "partial_open": 0}
    tried |= {"choices_share": 0.7, "choices_share_low": 0.47, "choices_share_high": 0.93}
    tried |= {"opposed_by": "", "opened_by": "H = 0.4", "moved_by": "the ratio (18 to 72 %)"}
    bare = tried | {"number": "6a", "opened_by": np.nan, "moved_by": np.nan, "opposed_by": np.nan}
    bare |= dict.fromkeys([name for name in tried if name.startswith(("read", "part", "choi"))])
    return pd.DataFrame([tried, bare])


def test_what_was_not_tried_is_said_and_a_share_has_its_interval():
    sheet = findings.conclusion_sheet(concluded())
    tried, bare = (dict(zip(sheet.titles, row, strict=True)) for row in sheet.rows)
    whole = tried["Readings of all rocks: stands, falls, no difference, open"]
    some = tried["Readings of some rocks: true there, false, no difference, open"]
    assert (whole.text, some.text) == ("4, 0, 2, 1", "none")
    assert tried["True for so many open choices"].text == "70 % (47 to 93)"
    assert [cell.text for cell in list(bare.values())[5:8]] == ["not tried"] * 3


def test_a_claim_that_nothing_moves_is_not_among_those_that_something_does():
    sheet = findings.moved_sheet(concluded())
    assert [row[0].text for row in sheet.rows] == ["2a"]
    assert [cell.text for cell in sheet.rows[0][2:5]] == ["–", "H = 0.4", "the ratio (18 to 72 %)"]


def elasticities(of_modulus: dict, error: float, samples: int = 60) -> pd.DataFrame:
    """Elasticities to Young's modulus by rock, and one of 0.6 to strength, on cycle 2."""
    rows = [
        {"rock": rock, "parameter": name, "cycle": 2, "samples": samples,
         "elasticity": value, "elasticity_standard_error": error}
        for rock, modulus in of_modulus.items()
        for name, value in (("youngs_modulus", modulus), ("compressive_strength", 0.6))
    ]  # fmt: skip
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("table", "verdict"),
    [
        (elasticities({"slate": -1.0, "dolerite": -1.1}, 0.02), "stands"),
        (elasticities({"slate": -1.0, "dolerite": -1.1}, 0.2, samples=4), "cannot be told"),
        (elasticities({"slate": -1.0, "dolerite": -0.65}, 0.005), "no difference"),
        (elasticities({"slate": -1.0, "dolerite": -0.2}, 0.02), "falls"),
    ],
)
def test_the_headline_says_no_more_than_its_verdict(table, verdict):
    assert summary.most_sensitive(table, "youngs_modulus") == verdict
    sentence = summary.sensitivity_sentence(table)
    assert ("is most sensitive to Young's modulus in all 2 rocks" in sentence) == (
        verdict == "stands"
    )

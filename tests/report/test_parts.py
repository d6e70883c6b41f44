"""Parts of the page: cells, captions, settings, curves."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.config.keys.configuration import ConfigurationKeys
from jointclosure.config.schema import json_schema
from jointclosure.report import curves, summary
from jointclosure.report.curves import MOST_JOINTS, explorer_data
from jointclosure.report.settings import departures, setting_rows
from jointclosure.report.sheets import sheet
from tests.report.conftest import FAILED, JOINTS, JUMPED


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


def test_means_do_not_depend_on_how_many_joints_are_read_at_a_time(explored, study, monkeypatch):
    monkeypatch.setattr(curves, "_BLOCK", 7)
    case = curves.explorer_data(study, {"slate": "Slate"}, 0.5e6)["rocks"][0]["cases"][0]
    whole = explored["rocks"][0]["cases"][0]
    for measure in ("mean", "deviation"):
        for own, other in zip(flat(case[measure]), flat(whole[measure]), strict=True):
            assert own == other or own == pytest.approx(other, abs=2e-4)


def flat(values):
    return [x for v in values for x in flat(v)] if isinstance(values, list) else [values]


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
        (elasticities({"slate": -1.0, "dolerite": -1.1}, 0.2, samples=4), "undecided"),
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


def test_a_number_is_rounded_to_its_error_where_the_table_has_one():
    table = pd.DataFrame(
        {"x": [0.08312, np.nan], "x_standard_error": [0.0042, np.nan], "y": [0.08312, 2.0]}
    )
    rows = sheet("name", "caption", table, {"x": "X", "y": "Y"}).rows
    assert [[cell.text for cell in row] for row in rows] == [
        ["0.083 ± 0.004", "0.08312"],
        ["–", "2.000"],
    ]
    assert rows[0][0].key == 0.08312  # by which a reader sorts

"""The page of a study."""

import re

import pandas as pd
import pytest

from studies.frame.configuration import model
from studies.frame.keys import json_schema
from studies.paper.report.content import (
    STAYS,
    content,
    departures,
    headline,
    most_sensitive,
    setting_rows,
)
from studies.paper.report.page import render


@pytest.fixture(scope="module")
def page(material):
    return content(material)


def test_the_first_screen_has_the_numbers_of_the_tables(page, material):
    row = page["frames"]["in_short"].iloc[0, 1:].map(lambda cell: cell.key)
    closures = material.tables["max_closure"]
    base = closures[closures.parameter == "base"]
    own = base[base.rock == base.rock.iloc[0]].set_index("cycle")
    assert row["Net closure since seating, cycle 2 (mm)"] == own.max_closure_seated_net_mean_mm[2]
    stays = own.residual_closure_seated_net_mean_mm[1] / own.max_closure_seated_net_mean_mm[1]
    assert row[STAYS] == pytest.approx(100.0 * stays)
    study = material.study
    case = study.sel(case=study.case[study.parameter == "base"][0], cycle=1)
    compliance = (1e9 / case.stiffness_net).where(case.status < 16).mean()
    assert row["Net kn, cycle 1 (MPa/mm)"] == pytest.approx(1.0 / float(compliance))


def test_settings_that_differ_from_the_papers_are_found(configuration, default):
    schema = json_schema(model())
    assert departures(setting_rows(default, default, schema)) == []
    rows = setting_rows(configuration, default, schema)
    found = departures(rows)
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
    rows = [
        {"rock": rock, "parameter": name, "cycle": 2, "samples": samples, "elasticity": value}
        for rock, modulus in (("slate", of_slate), ("dolerite", of_dolerite))
        for name, value in (("youngs_modulus", modulus), ("compressive_strength", 0.6))
    ]
    table = pd.DataFrame(rows).assign(elasticity_standard_error=error)
    assert most_sensitive(table, "youngs_modulus") == verdict
    about = {"property": "Young's modulus", "rocks": 2, "cycle": 2, "verdict": verdict}
    assert headline(table) == about


def test_closures_of_a_joint_are_given_since_seating_and_as_in_the_paper_and_else_not(page):
    headings = re.findall(r"<th[^>]*>([^<]*)", render(page))
    shown = {head.strip() for head in headings if "closure" in head.lower() and "(mm)" in head}
    own = {head for head in shown if "measured" not in head.lower()}
    assert own == {
        "Net closure since seating, cycle 1 (mm)",
        "Net closure since seating, cycle 2 (mm)",
        "Maximum closure, mean (mm)",
    }

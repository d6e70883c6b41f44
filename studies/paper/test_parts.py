"""Parts of the page: cells, captions, settings, curves."""

import numpy as np
import pandas as pd
import pytest

from studies.frame.config.model import model
from studies.frame.config.schema import json_schema
from studies.paper.report import content as summary
from studies.paper.report.content import departures, setting_rows
from studies.paper.report.sheets import sheet


def test_settings_that_differ_from_the_papers_are_found(configuration, default):
    schema = json_schema(model())
    assert departures(setting_rows(default, default, schema)) == []
    rows = setting_rows(configuration, default, schema)
    found = departures(rows)
    assert "study.realizations" in found
    assert "rocks.granite.jrc" in found
    assert not any(key.startswith("rocks.slate") for key in found)
    assert not any(key.startswith("rocks.dolerite") for key in rows.key)  # not in the study
    assert rows.meaning.str.len().min() > 5  # every key is explained


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

"""The table of docs/validation.md is what its script makes."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "workflow/scripts")
    spec = importlib.util.spec_from_file_location(
        "validation_table", ROOT / "workflow/scripts/validation_table.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_has_a_row_for_each_kind_of_walls_with_every_column(script):
    page = script.PAGE.read_text(encoding="utf-8")
    block = page.partition("<!-- model -->")[2].partition("<!-- end -->")[0]
    rows = [line for line in block.splitlines() if line.startswith("| ")]
    assert [row.split(" | ")[0].removeprefix("| ") for row in rows[1:]] == list(script.CASES)
    assert all(row.count("|") == len(script.COLUMNS) + 4 for row in rows)
    assert all(column in rows[0] for column in script.COLUMNS.values())


def test_the_models_rock_is_as_soft_as_the_measured_one(script):
    assert 10e9 <= script.ROCK.youngs_modulus <= 12e9


def test_mating_walls_close_less_and_net_closures_are_smaller_and_stiffer(script):
    small = {"cells": 24, "number": 3}
    cases = {
        name: script.CASES[name]._replace(**small)
        for name in ("independent", "mating beyond 1.5 mm")
    }
    table = script.model_table(cases)
    for kind in ("net", "gross"):
        independent, mating = table[f"seated_{kind}"]["mean"]
        assert mating < independent
        soft, stiff = table[f"kn_{kind}"]["mean"]
        assert stiff > soft
    assert (table["seated_net"]["mean"] < table["seated_gross"]["mean"]).all()
    assert (table["kn_net"]["mean"] > table["kn_gross"]["mean"]).all()
    assert (table["stays_net"]["mean"] > table["stays_gross"]["mean"]).all()
    assert np.isfinite(table.to_numpy(dtype=float)).all()
    assert "| independent | 6 | 3 | " in script.as_markdown(table, cases)

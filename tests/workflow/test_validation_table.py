"""The table of docs/validation.md is what its script makes."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location(
        "validation_table", ROOT / "workflow/scripts/validation_table.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_has_a_row_for_each_kind_of_walls_with_every_column(script):
    page = script.PAGE.read_text(encoding="utf-8")
    block = page.partition(script.START)[2].partition(script.END)[0]
    rows = [line for line in block.splitlines() if line.startswith("| ")]
    assert [row.split(" | ")[0].removeprefix("| ") for row in rows[1:]] == list(script.WALLS)
    assert all(row.count("|") == len(script.COLUMNS) + 2 for row in rows)
    assert all(column in rows[0] for column in script.COLUMNS.values())


def test_a_new_table_replaces_the_old_one_and_nothing_else(script):
    page = f"before\n{script.START}\nold\n{script.END}\nafter\n"
    assert script.put_in(page, "new") == f"before\n{script.START}\nnew\n{script.END}\nafter\n"


def test_mating_walls_close_less_and_are_stiffer_than_independent_ones(script, monkeypatch):
    few = {name: script.WALLS[name] for name in ("independent", "mating beyond 1.5 mm")}
    monkeypatch.setattr(script, "WALLS", few)
    table = script.model_table(24, range(3))
    independent, mating = table["closure"]["mean"]
    assert mating < independent
    soft, stiff = table["kn"]["mean"]
    assert stiff > soft
    assert np.isfinite(table.to_numpy(dtype=float)).all()
    text = script.as_markdown(table, 24, 3)
    assert script._plain(independent, table["closure"]["std"].iloc[0]) in text
    assert script._plain(0.5531, 0.16) == "0.55 ± 0.16"
    assert script._plain(56.3, 28.0) == "56 ± 28"

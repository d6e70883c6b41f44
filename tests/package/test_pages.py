"""Pages of docs/ are templates: what they show comes from docs/results, and it is all there."""

import json
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "docs/site"))
import publish
import stored
import templates
from content import conclusions, markdown, numbers, results
from content.markdown import MOST, Table, titled, value_of

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md"))
ORIGIN = {"run", "commit", "stored_at", "version", "root_seed", "date", "configuration"}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_page_is_filled_from_stored_results(page):
    text = templates.filled(page.read_text(encoding="utf-8"), page.name)
    for table in re.findall(r"(?:^\|.*\n)+", text, re.M):
        assert "nan" not in re.findall(r"[\w.]+", table)
        assert len({len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}) == 1


@pytest.mark.parametrize(
    ("expression", "reason"),
    [
        ("size.colour()", "has no attribute 'colour'"),
        ("sizes.exponents()", "'sizes' is undefined"),
        ('number("the number")', "KeyError: 'the number'"),
    ],
)
def test_an_unknown_name_fails_with_page_line_and_expression(expression, reason):
    with pytest.raises(templates.PageError, match=r"a\.md, line 2") as failed:
        templates.filled(f"# A page\n{{{{ {expression} }}}}\n", "a.md")
    assert expression in str(failed.value)
    assert reason in str(failed.value)


def test_a_file_or_a_column_that_lacks_fails_with_its_name(tmp_path, monkeypatch):
    shutil.copytree(stored.STORED / "mismatch", tmp_path / "mismatch")
    monkeypatch.setattr(stored, "STORED", tmp_path)
    monkeypatch.setattr(stored, "ROOT", tmp_path)
    table = pd.read_csv(tmp_path / "mismatch/mismatch.csv").drop(columns="hysteresis")
    table.to_csv(tmp_path / "mismatch/mismatch.csv", index=False)
    with pytest.raises(templates.PageError, match=r"mismatched\(\).*'hysteresis'"):
        templates.filled("{{ mismatch.mismatched() }}", "a.md")
    (tmp_path / "mismatch/mismatch_shifts.csv").unlink()
    with pytest.raises(templates.PageError, match=r"mismatch_shifts\.csv is not stored"):
        templates.filled("{{ mismatch.unmated() }}", "a.md")


def test_what_is_stored_is_what_pages_show(monkeypatch):
    """No file of docs/results is read by no page, and none that is read is missing from RUNS."""
    read = set()

    def path_of(run, table, given=stored.path_of):
        read.add((run, table))
        return given(run, table)

    monkeypatch.setattr(stored, "path_of", path_of)
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    filled = "\n".join(templates.filled(text, "page") for text in texts)
    kept = stored.RUNS.items()
    assert read | {("paper", "table_1_rocks")} == {
        (run, table) for run, of in kept for table in (*of.tables, *of.shipped)
    }
    filled += (ROOT / "README.md").read_text(encoding="utf-8")
    for run, of in kept:
        names = {f"{name}.csv" for name in of.tables} | {f"{name}.png" for name in of.figures}
        folder = stored.STORED / run
        assert {path.name for path in folder.iterdir()} == names | {stored.ORIGIN}
        assert all(f"results/{run}/{name}.png)" in filled for name in of.figures)
        assert stored.origin(run).keys() >= ORIGIN
    assert {path.name for path in stored.STORED.iterdir()} == set(stored.RUNS)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Results of a run, and a place where they are stored."""
    monkeypatch.setattr(stored, "ROOT", tmp_path)
    for module in (stored, publish):
        monkeypatch.setattr(module, "STORED", tmp_path / "stored")
    shutil.copytree(ROOT / "docs/results/mismatch", tmp_path / "mismatch/tables")
    return tmp_path / "mismatch"


def test_results_that_are_not_complete_are_refused_and_what_was_stored_stays(run):
    folder = publish.publish(run, "mismatch")
    (run / "tables/mismatch_shifts.csv").unlink()
    with pytest.raises(stored.StoredError, match=r"not complete, mismatch_shifts\.csv lacks"):
        publish.publish(run, "mismatch")
    assert (folder / "mismatch_shifts.csv").is_file()


def test_results_are_stored_with_what_made_them(run):
    (run.parent / "stored/mismatch").mkdir(parents=True)
    (run.parent / "stored/mismatch/old.csv").touch()
    folder = publish.publish(run, "mismatch")
    names = {"mismatch.csv", "mismatch_shifts.csv", "mismatch.png", stored.ORIGIN}
    assert {path.name for path in folder.iterdir()} == names
    for name in names - {stored.ORIGIN}:
        assert (folder / name).read_bytes() == (run / "tables" / name).read_bytes()
    origin = json.loads((folder / stored.ORIGIN).read_text(encoding="utf-8"))
    assert origin.keys() >= ORIGIN
    assert origin["configuration"]["file"] == "config/mismatch.yaml"
    assert origin["configuration"]["differs"]["mismatch.tolerance"] == 0.1
    assert "numerics.solver" not in origin["configuration"]["differs"]


def test_a_run_that_no_page_shows_is_refused(run):
    with pytest.raises(stored.StoredError, match="none of the runs that pages show"):
        publish.publish(run, "mine")


def test_what_effects_add_is_summed_up_when_it_is_stored(tmp_path):
    table = pd.DataFrame(
        {
            "effect": "gouge",
            "cycle": 1,
            "stress_MPa": 3.0,
            "max_closure_added_percent": [1, 4, None],
        }
    ).assign(residual_closure_added_percent=2.0, hysteresis_added_percent=3.0, time_ratio=[1, 2, 9])
    (tmp_path / "tables").mkdir()
    table.to_csv(tmp_path / "tables/effects.csv", index=False)
    (row,) = publish.contributions(tmp_path).to_dict("records")
    assert (row["known"], row["conditions"]) == (2, 3)
    assert (row["max_closure"], row["max_closure_least"], row["max_closure_largest"]) == (2.5, 1, 4)
    assert row["time_ratio_largest"] == 9


def test_errors_without_effects_are_summed_up_by_stress_over_strength(tmp_path):
    changes = {
        f"without_{effect}_percent": [1.0, 3.0, np.inf, 8.0]
        for effect in ("interaction", "soft_peaks", "gouge", "breakage", "substrate")
    }
    times = {name.replace("percent", "time"): 0.5 for name in changes}
    table = pd.DataFrame({"scene": range(4)} | changes).assign(**times)
    table = table.assign(compressive_strength=1e8, max_normal_stress=[2e5, 3e5, 4e5, 5e7])
    # a scene has a row for each tolerance
    pd.concat([table, table]).to_csv(tmp_path / "effects_auto.csv", index=False)
    rows = publish.regions(tmp_path).set_index("to")
    assert rows.conditions.tolist() == [0, 3, 0, 1]
    row = rows.loc[0.01]
    assert (row.interaction, row.interaction_least, row.interaction_largest) == (2.0, 1.0, 3.0)
    assert row.interaction_failed == 1
    assert rows.loc[1.0].interaction == 8.0


@pytest.fixture
def table(monkeypatch):
    """A stored table of three rows."""
    table = pd.DataFrame(
        {"rock": ["b", "a", "b"], "cycle": [1, 1, 2], "x": [1234.5, None, 3.0], "e": [20.0, 1, 0.1]}
    )
    monkeypatch.setattr(markdown, "stored", lambda run, name: table)
    return table


@pytest.mark.usefixtures("table")
def test_cells_are_written_by_format_or_function_and_what_is_absent_is_empty():
    columns = {"rock": "{rock}", "x": "{x!k}", "±": "{x±e}", "y": lambda group: group["cycle"]}
    assert Table("a/b", columns)().splitlines() == [
        "| rock | x | ± | y |",
        "| --- | --- | --- | --- |",
        "| b | 1,230 | 1234 ± 20 | 1 |",
        "| a |  |  | 1 |",
        "| b | 3 | 3.00 ± 0.10 | 2 |",
    ]
    with pytest.raises(KeyError, match="y"):
        Table("a/b", {"y": "{y:.1f}"})()


@pytest.mark.usefixtures("table")
def test_groups_keep_their_order_and_headings_that_of_their_titles():
    shown = Table(
        "a/b",
        {"all": "{x min:g} to {x max:g}"},
        rows={"rock": "{rock}"},
        across="{title}",
        cell="{x:g}",
        prepare=lambda table: titled(table, {(2,): "second", (1,): "first"}, "cycle"),
    )
    assert shown().splitlines() == [
        "| rock | second | first | all |",
        "| --- | --- | --- | --- |",
        "| b | 3 | 1234.5 | 3 to 1234.5 |",
        "| a |  |  |  |",
    ]


def test_a_number_is_the_span_of_the_rows_that_are_named(monkeypatch):
    table = pd.DataFrame(
        {"cycle": [1, 1, 2, 2], "n": [8, 9, 8, 9], "v": [1.0, 2.0, 3.0, 5.0], "e": [0.1] * 4}
    )
    monkeypatch.setattr(markdown, "stored", lambda run, name: table)
    for rows, text in (
        ({"cycle": 1}, "1.00 ± 0.10 to 2.00 ± 0.10"),
        ({"cycle": 2, "n": MOST}, "5.00 ± 0.10"),
    ):
        monkeypatch.setitem(numbers.NUMBERS, "v", numbers.span("a/b", "v", "e", **rows))
        assert numbers.number("v") == text
    with pytest.raises(ValueError, match="no row has"):
        value_of("a/b", "{v}", cycle=3)


def test_no_measured_number_of_the_conclusions_was_typed():
    """Outside of expressions a number has no decimal place but settings have."""
    page = (ROOT / "docs/conclusions.md").read_text(encoding="utf-8")
    assert set(re.findall(r'number\("(.+?)"\)', page)) == set(numbers.NUMBERS)
    typed = re.findall(r"\d+\.\d+|± ?\d+", re.sub(r"\{\{.*?\}\}", "", page))
    assert set(typed) == {"0.8", "±2", "0.1"}  # Hurst exponent, half-width, elasticities alike


def test_readings_that_were_not_run_again_are_those_of_before_and_called_so(monkeypatch):
    earlier = pd.DataFrame({"number": ["2a", "6b"], "readings_stand": [4, 3]}).assign(
        readings_fall=0, readings_open=0, partial_stand=1, partial_fall=2, partial_open=3
    )
    monkeypatch.setattr(conclusions, "stored", lambda run, table: earlier)
    now = pd.DataFrame({"No.": ["2a", "2c"], "Conclusion": ["falls", "stands"]}).assign(
        **{"Readings of all rocks: stands, falls, no difference, open": "not tried"}
    )
    shown = conclusions._with_earlier(now)
    assert shown.columns[2] == "Readings of all rocks: stands, falls, open, earlier run"
    assert shown.iloc[:, 2].tolist() == ["4, 0, 0", "not tried"]
    assert shown["Conclusion"].tolist() == ["falls", "stands"]


def test_the_readmes_outcome_is_that_of_the_stored_study():
    """README.md is read as it is: its p of all entries and its counts of claims are typed."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    headline = results.headline()
    assert headline["p"] in text
    (sentence,) = re.findall(r"^.*?(?=\(\[conclusions\])", text, re.M)
    assert re.findall(r"\d+", sentence) == [headline[name] for name in ("claims", "stand", "fall")]

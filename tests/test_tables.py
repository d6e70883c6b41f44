import pandas as pd
import pytest

from jointclosure.tables import (
    interval_text,
    rock_table,
    significant,
    table_3_latex,
    table_3_markdown,
    with_paper,
)


@pytest.mark.parametrize(
    ("value", "figures", "text"),
    [(12.70, 3, "12.7"), (0.1401, 3, "0.140"), (0.09899, 3, "0.0990"), (94.4, 2, "94"),
     (4.47, 2, "4.5"), (130.2, 2, "130"), (9.996, 3, "10.0"), (0.0, 3, "0")],
)  # fmt: skip
def test_numbers_are_rounded_as_the_paper_prints_them(value, figures, text):
    assert significant(value, figures) == text


def test_no_root_is_a_dash():
    assert interval_text(float("nan"), float("nan")) == "–"
    assert interval_text(12.7, 16.3) == "12.7 (16%)"
    assert interval_text(12.7, 16.3, "*") == "12.7* (16%)"


def test_table_3_has_the_papers_layout():
    rows = [
        {"rock": rock, "parameter": parameter, "cycle": cycle, "length": 1.5, "percent": 15.0,
         "length_net": 1.0, "percent_net": 10.0, "paper_length": float("nan"),
         "paper_percent": float("nan"), "in_paper": True, "samples": 20}
        for rock in ("a", "b") for parameter in ("poisson_ratio", "jrc") for cycle in (1, 2)
    ]  # fmt: skip
    table, titles = pd.DataFrame(rows), {"a": "Rock A", "b": "Rock B"}
    markdown = table_3_markdown(table, titles)
    assert "| Parameter | Rock A, cycle 1 | Rock B, cycle 1 | Rock A, cycle 2 |" in markdown
    assert markdown.count("1.50 (15%)") == markdown.count("1.00 (10%)") == 8
    assert "1.50* (15%)" in table_3_markdown(table.assign(extrapolated=True), titles)
    assert "1.00† (10%)" in table_3_markdown(
        table.assign(status_net="fitted deviation is negative at the root"), titles
    )
    latex = table_3_latex(table, titles)
    assert r"\multicolumn{2}{c}{First loading cycle}" in latex
    assert latex.count(r"1.50 (15\%)") == 8
    assert "n = 20" in markdown
    table.loc[3, "samples"] = 17
    assert "n = 17 to 20 successful realisations" in table_3_markdown(table, titles)


def test_a_title_is_no_command_of_latex():
    row = {"rock": "a", "parameter": "jrc", "cycle": 1, "length": 1.5, "percent": 15.0,
           "samples": 20}  # fmt: skip
    latex = table_3_latex(pd.DataFrame([row]), {"a": r"\input{/etc/passwd} 50 % & $x_1^2$"})
    assert r"\input" not in latex
    assert r"\textbackslash{}input\{/etc/passwd\} 50 \% \& \$x\_1\textasciicircum{}2\$" in latex


def test_a_title_is_no_mark_of_markdown():
    row = {"rock": "a", "parameter": "jrc", "cycle": 1, "length": 1.5, "percent": 15.0,
           "length_net": 1.0, "percent_net": 10.0, "samples": 20}  # fmt: skip
    markdown = table_3_markdown(pd.DataFrame([row]), {"a": "A | <b>*x*</b>\n[y](z)"})
    heading = r"| Parameter | A \| \<b\>\*x\*\</b\> \[y\](z), cycle 1 |"
    assert heading in markdown.splitlines()


@pytest.mark.parametrize("title", ["=1+1", "+1", "-1", "@SUM(A1)"])
def test_a_title_is_no_formula_of_a_spreadsheet(title):
    rock = {"title": title, "youngs_modulus_GPa": 50.0, "levels": {}}
    table = rock_table({"study": {"rocks": ["a"]}, "rocks": {"a": rock}})
    assert table.title.item() == f"'{title}"
    assert table.youngs_modulus_GPa.item() == 50.0


KEYS = {"parameter": "jrc", "length": 1.5, "percent": 15.0, "length_net": 1.0, "percent_net": 10.0}
KEYS |= {"samples": 20}
PAPER = pd.DataFrame(
    [{"rock": "slate", "parameter": "jrc", "cycle": 1, "paper_length": 0.726, "paper_percent": 11}]
)


def test_a_study_of_other_rocks_has_no_columns_of_the_paper():
    table = pd.DataFrame([{"rock": "granite", "cycle": 1} | KEYS])
    own = with_paper(table, PAPER)
    pd.testing.assert_frame_equal(own, table)
    markdown = table_3_markdown(own, {"granite": "Granite"})
    assert "The paper" not in markdown
    assert "1.50 (15%)" in markdown


def test_the_papers_part_shows_the_papers_rocks_alone():
    table = pd.DataFrame([{"rock": rock, "cycle": 1} | KEYS for rock in ("granite", "slate")])
    both = with_paper(table, PAPER)
    assert both.in_paper.tolist() == [False, True]
    ours, paper = table_3_markdown(both, {"granite": "Granite", "slate": "Slate"}).split(
        "**The paper**"
    )
    assert "| Granite, cycle 1 | Slate, cycle 1 |" in ours
    assert "| Parameter | Slate, cycle 1 |" in paper
    assert "0.726 (11%)" in paper
    assert "Granite" not in paper


def test_a_study_that_varies_nothing_says_so():
    nothing = pd.DataFrame(columns=["rock", "parameter", "cycle", "length"])
    assert "No parameter is varied" in table_3_markdown(nothing, {"a": "A"})
    assert "No parameter is varied" in table_3_latex(nothing, {"a": "A"})


def test_the_table_of_rocks_names_the_file_of_a_measured_curve():
    rock = {"title": "A", "jrc": 8, "levels": {"jrc": [6, 9]}}
    settings = {
        "study": {"rocks": ["a", "b"]},
        "rocks": {"a": rock, "b": rock | {"measured": {"file": "a.csv", "stress_unit": "MPa"}}},
    }
    table = rock_table(settings)
    assert table.measured.tolist()[1] == "a.csv"
    assert "levels" not in table

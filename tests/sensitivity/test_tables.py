import re

import pandas as pd
import pytest

from jointclosure.sensitivity.tables import (
    case_table,
    closure_lines,
    interval_text,
    rock_table,
    significant,
    table_3_latex,
    table_3_markdown,
    with_paper,
)
from jointclosure.storage.text import write_csv
from tests.studied import study_of


@pytest.mark.parametrize(
    ("value", "figures", "text"),
    [(12.70, 3, "12.7"), (0.1401, 3, "0.140"), (0.09899, 3, "0.0990"), (94.4, 2, "94"),
     (4.47, 2, "4.5"), (130.2, 2, "130"), (9.996, 3, "10.0"), (0.0, 3, "0")],
)  # fmt: skip
def test_numbers_are_rounded_as_the_paper_prints_them(value, figures, text):
    assert significant(value, figures) == text


def test_closures_of_rocks_as_they_are_have_their_errors_and_numbers():
    mean = "max_closure_seated_net_mean_mm"
    rows = [
        {"rock": "a", "parameter": parameter, "cycle": cycle, "samples": 20, mean: value,
         f"{mean}_standard_error": 0.002}
        for parameter, cycle, value in (("base", 1, 0.2003), ("base", 2, 0.0197), ("jrc", 1, 9.0))
    ]  # fmt: skip
    assert closure_lines(pd.DataFrame(rows)) == [
        "a: mean net closure since seating 0.2003 ± 0.0020 mm on cycle 1, 0.0197 ± 0.0020 mm on "
        "cycle 2 (20 joints)"
    ]


def test_no_root_is_a_dash():
    assert interval_text(float("nan"), float("nan")) == "–"
    assert interval_text(12.7, 16.3) == "12.7 (16%)"
    assert interval_text(12.7, 16.3, "*") == "12.7* (16%)"
    assert interval_text(12.7, 16.3, "", float("inf")) == "13 (16%)"


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
    endless = table.assign(length_high=float("inf"), extrapolated=True)
    assert "1.50*‡ (15%)" in table_3_markdown(endless, titles)
    assert r"1.50$^*$$^\ddagger$ (15\%)" in table_3_latex(endless, titles)
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


def test_a_title_does_not_end_a_line_of_latex():
    row = {"rock": "a", "parameter": "jrc", "cycle": 1, "length": 1.5, "percent": 15.0,
           "samples": 20}  # fmt: skip
    latex = table_3_latex(pd.DataFrame([row]), {"a": "wet\n\n<'a'> | b"})
    inside = r"wet \textless{}'a'\textgreater{} \textbar{} b \\"
    assert f" & {inside}\n" in latex


def test_a_title_neither_splits_a_markdown_table_nor_marks_it_up():
    row = {"rock": "a", "parameter": "jrc", "cycle": 1, "length": 1.5, "percent": 15.0,
           "length_net": 1.0, "percent_net": 10.0, "samples": 20}  # fmt: skip
    title = "wet|dry\n<script>alert(1)</script> *a* _b_ `c` [d](e) \\| $f$"
    lines = table_3_markdown(pd.DataFrame([row]), {"a": title}).splitlines()
    head = next(line for line in lines if line.startswith("| Parameter"))
    assert head.endswith(", cycle 1 |")
    # what Markdown ends a cell at, or takes for a mark, is preceded by a backslash
    assert len(re.findall(r"(?<!\\)(?:\\\\)*\|", head)) == 3
    inside = head.removeprefix("| Parameter | ").removesuffix(" |")
    assert not re.search(r"(?<!\\)(?:\\\\)*[<>*_`\[\]$]", inside)
    assert re.sub(r"\\(.)", r"\1", inside) == title.replace("\n", " ") + ", cycle 1"


def titled(title):
    """Slate under another title."""
    rocks = study_of({"study": {"rocks": ["slate"]}, "rocks": {"slate": {"title": title}}}).rocks
    return {"slate": rocks["slate"]}


@pytest.mark.parametrize("title", ['=HYPERLINK("a")', "+1", "-1", "@SUM(A1)", "\t=1"])
def test_a_title_is_no_formula_of_a_spreadsheet(title):
    assert rock_table(titled(title)).title.tolist() == ["'" + title]


def test_a_title_with_commas_and_lines_is_one_cell_of_a_csv(tmp_path):
    write_csv(rock_table(titled('a, "b"\nc')), tmp_path / "rocks.csv")
    again = pd.read_csv(tmp_path / "rocks.csv")
    assert again.title.tolist() == ['a, "b"\nc']
    assert again.jrc.tolist() == [6.5]


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
        "**The paper, unpaired t test**"
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
    told = {"rocks": {"slate": {"measured": {"file": "a.csv", "stress_unit": "MPa"}}}}
    table = rock_table(study_of(told).rocks).set_index("rock")
    assert table.measured["slate"] == "a.csv"
    assert table.measured.isna().sum() == 3
    assert table.youngs_modulus_GPa["siltstone"] == 28.5
    assert "levels" not in table


def test_the_table_of_cases_has_every_level_in_the_unit_that_it_was_written_in():
    table = case_table(study_of().rocks)
    assert len(table) == 4 * 4 * 3
    own = table[(table.rock == "siltstone") & (table.parameter == "youngs_modulus")]
    assert own.value.tolist() == [25, 28.5, 32]
    assert own.level.tolist() == ["low", "base", "high"]
    assert set(own.unit) == {"GPa"}

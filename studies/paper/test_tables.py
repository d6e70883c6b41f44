import pandas as pd
import pytest

from jointclosure.statistics.standard_errors import significant
from studies.paper.layout import (
    case_table,
    closure_lines,
    rock_table,
    table_3_latex,
    table_3_markdown,
    with_paper,
)
from tests.studied import study_of


@pytest.mark.parametrize(
    ("value", "figures", "text"),
    [
        (12.70, 3, "12.7"),
        (0.1401, 3, "0.140"),
        (4.47, 2, "4.5"),
        (130.2, 2, "130"),
        (9.996, 3, "10.0"),
        (0.0, 3, "0"),
    ],
)
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


def titled(title):
    """Slate under another title."""
    rocks = study_of({"study": {"rocks": ["slate"]}, "rocks": {"slate": {"title": title}}}).rocks
    return {"slate": rocks["slate"]}


@pytest.mark.parametrize("title", ['=HYPERLINK("a")', "\t=1"])
def test_a_title_is_no_formula_of_a_spreadsheet(title):
    assert rock_table(titled(title)).title.tolist() == ["'" + title]


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


def test_the_table_of_rocks_names_the_file_of_a_measured_curve():
    stated = {"rocks": {"slate": {"measured": {"file": "a.csv", "stress_unit": "MPa"}}}}
    table = rock_table(study_of(stated).rocks).set_index("rock")
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

"""Tables 1 to 3 in the paper's layout."""

import pandas as pd
import pytest

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.standard_errors import significant
from studies.paper.layout import (
    case_table,
    rock_table,
    table_3_latex,
    table_3_markdown,
    with_paper,
)
from tests.studied import study_of


@pytest.mark.parametrize(
    ("value", "figures", "text"),
    [(12.70, 3, "12.7"), (0.1401, 3, "0.140"), (130.2, 2, "130"), (9.996, 3, "10.0"), (0, 3, "0")],
)
def test_numbers_are_rounded_as_the_paper_prints_them(value, figures, text):
    assert significant(value, figures) == text


def test_table_3_marks_its_lengths_and_runs_no_command_of_a_title():
    same = {"length": 1.5, "percent": 15.0, "length_net": 1.0, "percent_net": 10.0, "samples": 20}
    columns = [(rock, name, cycle) for rock in "ab" for name in PROPERTIES for cycle in (1, 2)]
    table = pd.DataFrame(columns, columns=["rock", "parameter", "cycle"]).assign(**same)
    titles = {"a": "Rock A", "b": r"\input{/etc/passwd} 50 % & $x_1^2$"}
    latex = table_3_latex(table, titles)
    assert r"\input" not in latex
    assert r"\textbackslash{}input\{/etc/passwd\} 50 \% \& \$x\_1\textasciicircum{}2\$" in latex
    markdown = table_3_markdown(table, titles)
    assert latex.count(r"1.50 (15\%)") == markdown.count("1.50 (15%)") == len(table)
    assert markdown.count("1.00 (10%)") == len(table)
    endless = table.assign(length_high=float("inf"), extrapolated=True)
    assert "1.50*‡ (15%)" in table_3_markdown(endless, titles)
    assert r"1.50$^*$$^\ddagger$ (15\%)" in table_3_latex(endless, titles)


def test_tables_1_and_2_have_every_level_and_the_file_of_a_measured_curve():
    rocks = study_of({"rocks": {"slate": {"measured": {"file": "a.csv", "stress_unit": "MPa"}}}})
    table = rock_table(rocks.rocks).set_index("rock")
    assert table.measured["slate"] == "a.csv"
    assert table.measured.isna().sum() == 3
    assert table.youngs_modulus_GPa["siltstone"] == 28.5
    table = case_table(rocks.rocks)
    assert len(table) == 4 * 4 * 3
    own = table[(table.rock == "siltstone") & (table.parameter == "youngs_modulus")]
    assert own.value.tolist() == [25, 28.5, 32]
    assert own.level.tolist() == ["low", "base", "high"]
    assert set(own.unit) == {"GPa"}


@pytest.mark.parametrize("title", ['=HYPERLINK("a")', "\t=1"])
def test_a_title_is_no_formula_of_a_spreadsheet(title):
    rocks = study_of({"study": {"rocks": ["slate"]}, "rocks": {"slate": {"title": title}}}).rocks
    assert rock_table({"slate": rocks["slate"]}).title.tolist() == ["'" + title]


def test_a_study_of_other_rocks_has_no_columns_of_the_paper():
    at = {"rock": "slate", "parameter": "jrc", "cycle": 1}
    paper = pd.DataFrame([at | {"paper_length": 0.726, "paper_percent": 11}])
    own = pd.DataFrame([at | {"length": 1.5, "percent": 15.0, "samples": 20}])
    assert with_paper(own, paper).paper_length.item() == 0.726
    other = own.assign(rock="granite")
    pd.testing.assert_frame_equal(with_paper(other, paper), other)

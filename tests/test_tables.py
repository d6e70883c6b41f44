import pandas as pd
import pytest

from jointclosure.tables import interval_text, significant, table_3_latex, table_3_markdown


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
         "paper_percent": float("nan"), "samples": 20}
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

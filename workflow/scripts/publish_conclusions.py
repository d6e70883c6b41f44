"""Renew docs/conclusions.md: its table, each number of its text, and where each comes from.

Run by hand after `make conclusions`, with `make readings` and `make global-sensitivity` before it.
A number of the text stands between ``<!-- n:name -->`` and ``<!-- /n -->``.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from markers import fill
from publish_measured import markdown

from jointclosure.claims.table import OURS
from jointclosure.report.findings import conclusion_sheet, moved_sheet
from jointclosure.report.sheets import Sheet
from jointclosure.sensitivity.conclusions import (
    COUNTS,
    DEPENDS,
    JUDGED_ELSEWHERE,
    ONLY_CONFIGURED,
)
from jointclosure.statistics.standard_errors import rounded
from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, FALLS, NO_DIFFERENCE, STANDS
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/conclusions.md"
PAPER, READINGS = "results/paper/tables", "results/readings/tables"
TOGETHER = "results/global_sensitivity/tables"
METHODS = "src/jointclosure/config/accuracy_methods.csv"
MOST = "the most"
WITH_NET = (
    ("2a", 1, "2b"), ("2a", 2, "2a"), ("2c", 2, "2c"), ("3", 1, "3, cycle 1"),
    ("3", 2, "3, cycle 2"), ("3b", 2, "3b"), ("1a", 1, "1a, cycle 1"), ("1a", 2, "1a, cycle 2"),
    ("4", 2, "4"), ("5a", 1, None), ("5a", 2, "5a"), ("5b", 2, "5b"),
)  # fmt: skip
"""Conclusions asked with and without bulk indentation: number and cycle in the study of choices,
and as a claim."""


class Number(NamedTuple):
    """A number of the text: of rows of a table, made into words by ``text``."""

    table: str
    rows: dict
    column: str
    text: Callable[[pd.DataFrame], str]


def chosen(table: pd.DataFrame, rows: dict) -> pd.DataFrame:
    """Rows whose columns have these values; MOST stands for the largest one there is."""
    for name, value in rows.items():
        table = table[table[name] == (table[name].max() if value == MOST else value)]
    if table.empty:
        raise SystemExit(f"no row has {rows}")
    return table


def span(table: str, value: str, error: str, scale: float = 1.0, **rows) -> Number:
    """Least and largest value of a column over rows, each with its error."""

    def text(own: pd.DataFrame) -> str:
        own = own.sort_values(value)
        low, high = (
            rounded(scale * own[value].iloc[end], scale * own[error].iloc[end]) for end in (0, -1)
        )
        return low if len(own) == 1 else f"{low} to {high}"

    return Number(table, rows, value, text)


def _elasticity(parameter: str, cycle: int, net: str = "") -> Number:
    name = f"elasticity{net}"
    table = f"{PAPER}/elasticities.csv"
    return span(table, name, f"{name}_standard_error", parameter=parameter, cycle=cycle)


def _index(name: str, cycle: int) -> Number:
    table = f"{TOGETHER}/global_sensitivity_indices.csv"
    rows = {"input": name, "response": "closure", "cycle": cycle, "rows": MOST}
    return span(table, "total", "total_error", **rows)


def _choices(number: str, response: str, cycle: int) -> Number:
    table = f"{TOGETHER}/global_sensitivity_conclusions.csv"
    rows = {"number": number, "response": response, "cycle": cycle, "rock": "all"}
    return span(table, "share", "share_error", 100.0, **rows)


def _joint(entries: str, kind: str = "p") -> Number:
    return span(f"{PAPER}/table_3_joint_tests.csv", kind, f"{kind}_error", entries=entries)


def _mean(cycle: int) -> Number:
    name = "max_closure_mean_mm"
    rows = {"parameter": "base", "cycle": cycle}
    return span(f"{PAPER}/max_closure.csv", name, f"{name}_standard_error", **rows)


def _jrc(parameter: str, cycle: int, half_width: float) -> Number:
    rows = {"parameter": parameter, "cycle": cycle, "half_width": half_width}
    return span(f"{PAPER}/jrc_range.csv", "value", "standard_error", **rows)


def _found(number: str) -> Number:
    return span(f"{PAPER}/claims.csv", "found_share", "found_error", 100.0, number=number)


def _steps(cycle: int) -> Number:
    """What the paper's steps are off by, with 95 % intervals, for each rock."""

    def text(own: pd.DataFrame) -> str:
        return " and ".join(
            f"{row.bias_percent:+.1f} % ({row.bias_low:+.1f} to {row.bias_high:+.1f})"
            for row in own.sort_values("bias_percent").itertuples()
        )

    rows = {"response": "mean", "method": "paper", "control_variates": False, "cycle": cycle}
    return Number(METHODS, rows, "bias_percent", text)


def _count(*conclusions: str) -> Number:
    """How many claims of the paper have such a conclusion: a count has no error, and may be 0."""

    def text(own: pd.DataFrame) -> str:
        return str(int((own.conclusion.isin(conclusions) & (own.said_in != OURS)).sum()))

    column = f"rows of conclusion = {' or '.join(conclusions)}, said_in not {OURS}"
    return Number(f"{PAPER}/conclusions.csv", {}, column, text)


def _claims() -> Number:
    """How many claims the paper makes."""
    column = f"rows of said_in not {OURS}"
    return Number(
        f"{PAPER}/conclusions.csv", {}, column, lambda own: str(int((own.said_in != OURS).sum()))
    )


def _readings(kind: str) -> Number:
    """How many readings that the paper allows closed all rocks (readings), or some (partial)."""
    columns = [f"{kind}_{name}" for name in COUNTS]

    def text(own: pd.DataFrame) -> str:
        counts = own[columns].iloc[0]
        return "" if counts.isna().any() else f"{counts.sum():.0f}"

    return Number(f"{PAPER}/conclusions.csv", {"number": "2a"}, " + ".join(columns), text)


def _share_of_rows(number: str, cycle: int) -> Number:
    """At how many rows a conclusion is true of the row's own changes, over rocks."""

    def text(own: pd.DataFrame) -> str:
        of_rocks = own[own.rock != "all"].rows_true
        return f"{of_rocks.min()} to {of_rocks.max()}"

    rows = {"number": number, "response": "closure", "cycle": cycle}
    return Number(f"{TOGETHER}/global_sensitivity_conclusions.csv", rows, "rows_true", text)


def _margin(name: str, response: str = "closure") -> Number:
    """Share of the margin of Young's modulus on the second cycle that goes with an input."""
    rows = {"number": "2a", "response": response, "cycle": 2, "input": name}
    return Number(
        f"{TOGETHER}/global_sensitivity_margins.csv", rows, "share",
        lambda own: f"{100 * own.share.min():.0f} to {100 * own.share.max():.0f} %",
    )  # fmt: skip


def _rows() -> Number:
    """Rows of the design of global sensitivity: a choice, without error."""
    rows = {"rows": MOST}
    return Number(
        f"{TOGETHER}/global_sensitivity_indices.csv",
        rows,
        "rows",
        lambda own: str(own.rows.iloc[0]),
    )


def _tilted(cycle: int) -> Number:
    """What the largest tilt changes of independent walls."""
    rows = {"wavelength_mm": float("inf"), "rotation_degrees": 0.0, "tilt_degrees": MOST}
    rows |= {"response": "closure", "cycle": cycle}
    table = "results/misalignment/tables/misalignment.csv"
    return span(table, "change_percent", "change_error", **rows)


def _larger(cycle: int) -> Number:
    """Ratio of the net closure since seating of the largest patch to that of the smallest."""
    rows = {"spectrum": "roll_off_3mm", "reading": "closure_seated_net"}
    rows |= {"cycle": cycle, "to_mm": MOST}
    return span("results/size/tables/size_barton_bandis.csv", "ratio", "error", **rows)


def _continuum(cycle: int) -> Number:
    """Closure of a continuum whose pressure is limited over that of the asperity model."""
    rows = {"model": "continuum, hardness at breakage (own)"}
    rows |= {"reading": f"closure_{cycle}_um"}
    return span("results/continuum/tables/continuum.csv", "ratio", "ratio_error", **rows)


NUMBERS = {
    "tilt 1": _tilted(1),
    "tilt 2": _tilted(2),
    "larger 1": _larger(1),
    "larger 2": _larger(2),
    "continuum 1": _continuum(1),
    "continuum 2": _continuum(2),
    "rows": _rows(),
    "stand": _count(STANDS),
    "fall": _count(FALLS),
    "depend": _count(DEPENDS),
    "alike": _count(NO_DIFFERENCE),
    "untold": _count(CANNOT_BE_TOLD),
    "configured only": _count(*ONLY_CONFIGURED.values()),
    "elsewhere": _count(JUDGED_ELSEWHERE),
    "claims": _claims(),
    "readings of all rocks": _readings("readings"),
    "readings of some rocks": _readings("partial"),
    "rows of 5a": _share_of_rows("5a", 2),
    "rows of 5b": _share_of_rows("5b", 2),
    "rows of 5c": _share_of_rows("5c", 1),
    "2a goes with the ratio": _margin("peak_modulus"),
    "2a goes with the rule for peaks": _margin("peaks"),
    "2a goes with JRC": _margin("jrc"),
    "e(E) 2, net": _elasticity("youngs_modulus", 2, "_net"),
    "e(E) 1, net": _elasticity("youngs_modulus", 1, "_net"),
    "e(sigma_c) 2, net": _elasticity("compressive_strength", 2, "_net"),
    "found 2b": _found("2b"),
    "choices 2b": _choices("2a", "closure", 1),
    "mean 1": _mean(1),
    "mean 2": _mean(2),
    "scatter 1": _jrc("base", 1, 0.0),
    "scatter 2": _jrc("base", 2, 0.0),
    "scatter 1, JRC to 2": _jrc("base", 1, 2.0),
    "p": _joint("all"),
    "p of no effect, cycle 1 without JRC": _joint("cycle 1 without JRC", "null_p"),
    "p, cycle 1 without JRC": _joint("cycle 1 without JRC"),
    "e(E) 2": _elasticity("youngs_modulus", 2),
    "e(E) 1": _elasticity("youngs_modulus", 1),
    "e(sigma_c) 1": _elasticity("compressive_strength", 1),
    "e(sigma_c) 2": _elasticity("compressive_strength", 2),
    "e(JRC) 1": _elasticity("jrc", 1),
    "e(JRC) 2": _elasticity("jrc", 2),
    "e(nu) 1": _elasticity("poisson_ratio", 1),
    "e(nu) 2": _elasticity("poisson_ratio", 2),
    "length of E 2": _jrc("youngs_modulus", 2, 0.0),
    "ratio on 2": _index("peak_modulus", 2),
    "ratio on 1": _index("peak_modulus", 1),
    "roll-off on 1": _index("roll_off", 1),
    "JRC on 1": _index("jrc", 1),
    "stress on 1": _index("stress", 1),
    "choices 2a": _choices("2a", "closure", 2),
    "choices 2a, net": _choices("2a", "closure_net", 2),
    "choices 1a 1": _choices("1a", "closure", 1),
    "choices 1a 2": _choices("1a", "closure", 2),
    "found 1a 1": _found("1a, cycle 1"),
    "found 2a": _found("2a"),
    "steps 1": _steps(1),
    "steps 2": _steps(2),
}


def numbers() -> dict[str, str]:
    """The text of each number whose table was made, and has it."""
    return {
        name: text
        for name, each in NUMBERS.items()
        if (ROOT / each.table).is_file()
        and (text := each.text(chosen(read_csv(ROOT / each.table), each.rows)))
    }


def on_page(page: str) -> dict[str, str]:
    """The text of each number that a page has."""
    return dict(re.findall(r"<!-- n:(.+?) -->(.*?)<!-- /n -->", page))


def filled(page: str, found: dict[str, str]) -> str:
    """A page with its numbers; an error where it asks for one that is not of `NUMBERS`.

    Where a number's table was not made, that of an earlier run stays.
    """
    for name in on_page(page).keys() - NUMBERS.keys():
        raise SystemExit(f"{PAGE}: there is no number {name!r}")

    def put(match: re.Match) -> str:
        return f"<!-- n:{match[1]} -->{found.get(match[1], match[2])}<!-- /n -->"

    return re.sub(r"<!-- n:(.+?) -->(.*?)<!-- /n -->", put, page)


def table(of: Callable[[pd.DataFrame], Sheet], part: str, page: str) -> str:
    """A table of the report on what claims rest on; what was not run is kept from the page."""
    conclusions = read_csv(ROOT / PAPER / "conclusions.csv")
    sheet = of(conclusions)
    rows = [[cell.text for cell in row] for row in sheet.rows]
    frame = pd.DataFrame(rows, columns=sheet.titles)
    for column, heads in BESIDE:
        if not conclusions[column].notna().any():
            frame = with_earlier(frame, page_table(page, part), heads)
    return markdown(frame)


def page_table(page: str, part: str) -> pd.DataFrame:
    """A table between the markers of a page, as it stands."""
    text = page.split(f"<!-- {part} -->")[1].split("<!-- end -->")[0]
    head, _, *rows = (
        [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        for line in text.strip().splitlines()
    )
    return pd.DataFrame(rows, columns=head)


def with_earlier(frame: pd.DataFrame, before: pd.DataFrame, heads: tuple[str, ...]) -> pd.DataFrame:
    """Columns whose titles begin so as the page has them, which says that they are of before."""
    earlier = before.set_index(before.columns[0])
    for head in heads:
        own = [name for name in frame if name.startswith(head)]
        old = [name for name in earlier if name.startswith(head)]
        if own and old:
            title = old[0] if old[0].endswith(EARLIER) else f"{old[0]}{EARLIER}"
            cells = frame[frame.columns[0]].map(earlier[old[0]]).fillna("not tried")
            frame = frame.assign(**{own[0]: cells}).rename(columns={own[0]: title})
    return frame


EARLIER = ", earlier run"
BESIDE = (
    ("readings_stand", ("Readings of all", "Readings of some", "Contradicted by", "Left open by")),
    ("choices_share", ("True for so many", "Over the open choices")),
)
"""Of readings and of choices: a column that is empty where they were not run, and how titles begin
of what they give."""


def net(page: str) -> str:
    """Conclusions with and without bulk indentation: choices, and verdict as configured."""
    if not (ROOT / TOGETHER / "global_sensitivity_conclusions.csv").is_file():
        return markdown(page_table(page, "net"))
    shares = read_csv(ROOT / TOGETHER / "global_sensitivity_conclusions.csv")
    shares = shares[shares.rock == "all"]
    verdicts = read_csv(ROOT / PAPER / "conclusions.csv").set_index("number").verdict
    rows = []
    for number, cycle, claim in WITH_NET:
        own = shares[(shares.number == number) & (shares.cycle == cycle)]
        row = {"conclusion": own.conclusion.iloc[0], "cycle": cycle}
        for response, said, suffix in (("closure", "", ""), ("closure_net", ", net", ", net")):
            (each,) = own[own.response == response].itertuples()
            row[f"as configured{said}"] = verdicts.get(f"{claim}{suffix}", "not judged")
            value, low, high = 100 * each.share, 100 * each.share_low, 100 * each.share_high
            row[f"choices{said} (%)"] = f"{value:.0f} ({low:.0f} to {high:.0f})"
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def origins(page: str, found: dict[str, str]) -> str:
    """A row for each number that the text has: where it comes from."""
    rows = []
    for name, text in on_page(page).items():
        table, chosen_by, column, _ = NUMBERS[name]
        where = ", ".join(f"{key} = {value}" for key, value in chosen_by.items())
        source = f"`{table}`" if name in found else f"`{table}`{EARLIER}"
        row = {"number": name, "is": text, "table": source, "column": f"`{column}`"}
        rows.append(row | {"rows": where or "all"})
    return markdown(pd.DataFrame(rows))


def main() -> None:
    """Fill the page."""
    found = numbers()
    page = filled(PAGE.read_text(encoding="utf-8"), found)
    PAGE.write_text(page, encoding="utf-8")
    parts = {
        "conclusions": table(conclusion_sheet, "conclusions", page),
        "moved": table(moved_sheet, "moved", page),
        "net": net(page),
    }
    fill(PAGE, parts | {"origins": origins(page, found)})


if __name__ == "__main__":
    main()

"""Tables of docs/conclusions.md; its numbers are those of content.numbers."""

from collections.abc import Callable

import pandas as pd
from stored import stored

from content.global_sensitivity import percents
from content.markdown import Group, Table, markdown, rows_of
from jointclosure.report.findings import NOT_TRIED, conclusion_sheet, moved_sheet
from jointclosure.report.sheets import ABSENT, Sheet

WITH_NET = (
    ("2a", 1, "2b"), ("2a", 2, "2a"), ("2c", 2, "2c"), ("3", 1, "3, cycle 1"),
    ("3", 2, "3, cycle 2"), ("3b", 2, "3b"), ("1a", 1, "1a, cycle 1"), ("1a", 2, "1a, cycle 2"),
    ("4", 2, "4"), ("5a", 1, None), ("5a", 2, "5a"), ("5b", 2, "5b"),
)  # fmt: skip
"""Conclusions asked with and without bulk indentation: number and cycle in the study of choices,
and as a claim."""
EARLIER = {
    "Readings of all rocks: stands, falls, open":
        ("readings_stand", "readings_fall", "readings_open"),
    "Readings of some rocks: true there, false, open":
        ("partial_stand", "partial_fall", "partial_open"),
    "Contradicted by the reading": ("opposed_by",),
    "Left open by the readings": ("opened_by",),
}  # fmt: skip
"""Columns of the earlier run of the readings, by what their numbers are called in tables."""


def conclusions() -> str:
    """Tabulate what claims rest on, and what is left of them."""
    return _sheet(conclusion_sheet)


def moved() -> str:
    """Tabulate what moves the verdicts."""
    return _sheet(moved_sheet)


def _sheet(of: Callable[[pd.DataFrame], Sheet]) -> str:
    """Write a table of the report; where readings were not run again, with those of before."""
    table = stored("paper", "conclusions").astype({"opposed_by": object, "opened_by": object})
    sheet = of(table)
    rows = [[cell.text for cell in row] for row in sheet.rows]
    frame = pd.DataFrame(rows, columns=sheet.titles)
    return markdown(frame if table.readings_stand.notna().any() else _with_earlier(frame))


def _with_earlier(frame: pd.DataFrame) -> pd.DataFrame:
    """Replace columns on readings by those of the earlier run, and name them so."""
    earlier = stored("conclusions", "earlier_readings").set_index("number")
    for title, columns in EARLIER.items():
        for name in [name for name in frame if name.startswith(title.partition(":")[0])]:
            texts = [_earlier(earlier[list(columns)], number) for number in frame["No."]]
            frame = frame.assign(**{name: texts}).rename(columns={name: f"{title}, earlier run"})
    return frame


def _earlier(table: pd.DataFrame, number: str) -> str:
    """Write what the earlier run has of a claim: counts of readings, or their titles."""
    if number not in table.index:
        return NOT_TRIED
    values = table.loc[number]
    if len(values) == 1:
        return ABSENT if pd.isna(values.iloc[0]) else values.iloc[0]
    return NOT_TRIED if values.isna().any() else ", ".join(f"{value:.0f}" for value in values)


def net() -> str:
    """Tabulate conclusions with and without bulk indentation: choices, verdict as configured."""
    shares = rows_of(stored("global_sensitivity", "global_sensitivity_conclusions"), rock="all")
    verdicts = stored("paper", "conclusions").set_index("number").verdict
    rows = []
    for number, cycle, claim in WITH_NET:
        of_claim = rows_of(shares, number=number, cycle=cycle)
        row = {"conclusion": of_claim.conclusion.iloc[0], "cycle": cycle}
        for response, suffix in (("closure", ""), ("closure_net", ", net")):
            row[f"as configured{suffix}"] = verdicts.get(f"{claim}{suffix}", "not judged")
            row[f"choices{suffix} (%)"] = percents(Group(rows_of(of_claim, response=response)))
        rows.append(row)
    return markdown(pd.DataFrame(rows))


readings = Table(
    "readings_average/readings_average",
    {
        "reading": "{title}",
        "weight": "{weight±weight, error}",
        "by cycle 1 only": "{weight by cycle 1±weight by cycle 1, error}",
        "by cycle 2 only": "{weight by cycle 2±weight by cycle 2, error}",
    },
)
readings_tests = Table(
    "readings_average/readings_average_tests",
    {"entries tested": "{tested}", "entries that give the weights": "{seen}", "p": "{p±p_error}"},
)
readings_claims = Table(
    "readings_average/readings_average_claims",
    {
        "No.": "{number}",
        "claim": "{claim}",
        "least margin": "{margin±margin_error} ({rock})",
        "share of the reading in its variance": "{share_of_reading:.0%}",
        "weight of readings where it is true": "{weight_true±weight_true_error}",
        "verdict": "{verdict}",
    },
)

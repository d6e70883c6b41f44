"""Tables of docs/conclusions.md; its numbers are those of content.numbers."""

from collections.abc import Callable

import pandas as pd
from stored import stored

from content.global_sensitivity import percents
from content.markdown import Group, Table, markdown, rows_of, value_of
from jointclosure.claims.table import CLAIMS, OURS, Claim
from jointclosure.report.findings import NOT_TRIED, conclusion_sheet, moved_sheet
from jointclosure.report.sheets import ABSENT, Sheet
from jointclosure.sensitivity.conclusions import ONLY_CONFIGURED
from jointclosure.statistics.standard_errors import rounded

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
AVERAGED = "Averaged over readings"
NOT_ASKED = "not asked"
MARGINS = {
    "1a": "smallest of the other three elasticities, less that to Poisson's ratio",
    "1b": "0.02 less the largest relative change of the closure",
    "2a": "elasticity to E, less the largest of the other three",
    "2c": "elasticity to E, cycle 2 less cycle 1",
    "3": "smallest lead of the ranking: E over strength, strength over the other two",
    "3b": "elasticity to strength, cycle 2 less cycle 1",
    "3c": "change of the closure with 5 % of strength, over the smallest that 20 joints show",
    "4": "elasticity to JRC, cycle 1 less cycle 2",
    "5a": "elasticity to E with opposite sign, smallest between two levels",
    "5b": "elasticity to strength, smallest between two levels",
    "5c": "elasticity to JRC, smallest between two levels",
    "6a": "loop over the closure, smaller one of both cycles",
}
"""Margins in words, by number of the statement; elasticities by magnitude where not signed."""


def conclusions() -> str:
    """Tabulate what claims rest on, what is left of them, and the verdict of the average."""
    averaged = _averages().verdict
    return _sheet(
        conclusion_sheet,
        lambda frame: frame.assign(**{AVERAGED: frame["No."].map(averaged).fillna(NOT_ASKED)}),
    )


def _averages() -> pd.DataFrame:
    """Read the claims under the average over readings, by number."""
    return stored("readings_average", "readings_average_claims").set_index("number")


def averaged(verdict: str) -> str:
    """Count the claims with a verdict under the average over readings."""
    return str((_averages().verdict == verdict).sum())


def averaged_p(tested: str) -> str:
    """Give p of some entries under the average; of a part, by weights from the others."""
    form, file = "{p±p_error}", "readings_average/readings_average_tests"
    seen = tested if tested == "all" else f"all but {tested}"
    return value_of(file, form, tested=tested, seen=seen)


def largest_share_of_reading() -> str:
    """Give the largest share [%] of the reading in the variance of a margin."""
    return f"{100.0 * _averages().share_of_reading.max():.0f}"


def differing() -> str:
    """Tabulate the claims of the paper whose conclusion and average differ, with the reason."""
    table = stored("paper", "conclusions")
    table = table[table.section != OURS].set_index("number")
    table = table.join(_averages().add_suffix("_averaged"))
    as_configured = {text: verdict for verdict, text in ONLY_CONFIGURED.items()}
    lines = []
    for row in table.dropna(subset=["verdict_averaged"]).reset_index().to_dict("records"):
        if as_configured.get(row["conclusion"], row["conclusion"]) != row["verdict_averaged"]:
            lines.append(
                {
                    "No.": row["number"],
                    "claim": row["claim"],
                    "conclusion": row["conclusion"],
                    "under the average": row["verdict_averaged"],
                    "why they differ": _why(row),
                }
            )
    return markdown(pd.DataFrame(lines)) if lines else "They differ in no claim."


def _why(row: dict) -> str:
    """State why the conclusion on a claim is not the verdict of the average."""
    margin = rounded(row["margin_averaged"], row["margin_error_averaged"])
    needed = threshold(row["number"])
    if row["verdict"] == row["verdict_averaged"]:
        share, low, high = (100.0 * row[f"choices_share{end}"] for end in ("", "_low", "_high"))
        true = f"true for {share:.0f} % ({low:.0f} to {high:.0f}) of them"
        return f"open choices, which the average does not vary: {true}"
    return f"{row['verdict']} as configured; margin of the average {margin}, {needed}"


def _claim(number: str) -> Claim:
    return next(claim for claim in CLAIMS if claim.number == number)


def threshold(number: str) -> str:
    """State for which margins a claim is true, and which differences count as none."""
    claim = _claim(number)
    above = claim.judged_by.true_above()
    text = f"true {'up to' if claim.negated else 'above'} {above:g}"
    alike = claim.judged_by.alike
    return text if alike is None else f"{text}, no difference within ±{alike:g}"


def moved() -> str:
    """Tabulate what moves the verdicts."""
    return _sheet(moved_sheet)


def _sheet(
    of: Callable[[pd.DataFrame], Sheet],
    more: Callable[[pd.DataFrame], pd.DataFrame] = lambda frame: frame,
) -> str:
    """Write a table of the report; where readings were not run again, with those of before."""
    table = stored("paper", "conclusions").astype({"opposed_by": object, "opened_by": object})
    sheet = of(table)
    rows = [[cell.text for cell in row] for row in sheet.rows]
    frame = more(pd.DataFrame(rows, columns=sheet.titles))
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
        for response, suffix in (("max_closure", ""), ("max_closure_net", ", net")):
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
        "margin": lambda group: MARGINS[_claim(group["number"]).judged_by.number],
        "least margin": "{margin±margin_error} ({rock})",
        "needed": lambda group: threshold(group["number"]),
        "share of the reading in its variance": "{share_of_reading:.0%}",
        "weight of readings where it is true": "{weight_true±weight_true_error}",
        "verdict": "{verdict}",
    },
)

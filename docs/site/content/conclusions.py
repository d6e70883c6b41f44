"""Tables of docs/conclusions.md; its numbers are those of content.numbers."""

import pandas as pd
from stored import stored

from content.markdown import Table, markdown, value_of
from jointclosure.statistics.standard_errors import rounded
from studies.paper.claims import CLAIMS, OURS, Claim
from studies.paper.conclusions import ONLY_CONFIGURED
from studies.paper.report.findings import conclusion_sheet

AVERAGED = "Averaged over readings"
NOT_ASKED = "not asked"
COLUMNS = ["No.", "Claim", "As configured", "Studies that find it", "True for so many open choices",
           AVERAGED, "Conclusion"]  # fmt: skip
"""Columns of the report's table that are shown, with the verdict of the average."""


def conclusions() -> str:
    """Tabulate what claims rest on, what is left of them, and the verdict of the average."""
    sheet = conclusion_sheet(stored("paper", "conclusions"))
    rows = [[cell.text for cell in row] for row in sheet.rows]
    frame = pd.DataFrame(rows, columns=sheet.titles)
    averaged = frame["No."].map(_averages().verdict).fillna(NOT_ASKED)
    return markdown(frame.assign(**{AVERAGED: averaged})[COLUMNS])


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


readings = Table(
    "readings_average/readings_average",
    {
        "reading": "{title}",
        "weight": "{weight±weight, error}",
        "by cycle 1 only": "{weight by cycle 1±weight by cycle 1, error}",
        "by cycle 2 only": "{weight by cycle 2±weight by cycle 2, error}",
    },
)

"""Tables and numbers of the paper's page that are not just rows of a stored table."""

import pandas as pd

from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED
from studies.paper.claims import OURS
from studies.paper.conclusions import UNJUDGED
from studies.paper.report.page_rendering import text
from studies.paper.report.page_tables import concluded, probability
from studies.paper.tables_1_to_3 import markdown_rows, table_3

COLUMNS = ["number", "claim", "verdict", "found", "choices", "conclusion"]
VERDICT_WORDS = {
    STANDS: "stand",
    FALLS: "fall",
    UNDECIDED: "undecided",
    NO_DIFFERENCE: "no difference",
}
REST = "not judged"


def intervals(table: list[dict], rocks: list[dict], of: str = "") -> str:
    """Return Table 3 as Markdown: that of the study, or of the paper if ``of`` is "paper_".

    ``table`` are the rows of the table of intervals, ``rocks`` rows with names and titles.
    """
    titles = {rock["rock"]: rock["title"] for rock in rocks}
    return "\n".join(markdown_rows(table_3(pd.DataFrame(table), titles, of)))


def conclusions(table: list[dict]) -> list[list[str]]:
    """Return the cells of the table of conclusions, row by row; texts end before a bracket."""
    shown = concluded(pd.DataFrame(table))[COLUMNS].map(text)
    return shown.map(lambda words: words.partition(" (")[0]).to_numpy().tolist()


def verdicts(table: list[dict], averages: list[dict]) -> dict[str, list[int]]:
    """Return three numbers of the paper's claims, by verdict.

    They count the verdicts of the study as configured, the conclusions with open choices varied,
    and the verdicts by closures averaged over readings (``averages``). ``table`` are the rows of
    the table of conclusions. Claims that this study has added do not count.
    """
    claims = pd.DataFrame(table).set_index("number")
    claims = claims[claims.section != OURS]
    averaged = pd.DataFrame(averages).set_index("number").verdict
    columns = (
        claims.verdict.mask(claims.index.isin(UNJUDGED)),
        claims.conclusion,
        averaged.reindex(claims.index),
    )
    counts = [column.map(VERDICT_WORDS).fillna(REST).value_counts() for column in columns]
    return {
        word: [int(of.get(word, 0)) for of in counts] for word in (*VERDICT_WORDS.values(), REST)
    }


def p(row: dict, name: str = "p") -> str:
    """Format the probability ``name`` of a row with its standard error."""
    return probability(row[name], row[f"{name}_error"])

"""Tables of the paper's page that are more than rows of a stored table."""

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
    """Return Table 3 of the study, or (``of`` = "paper_") of the paper, as Markdown."""
    titles = {rock["rock"]: rock["title"] for rock in rocks}
    return "\n".join(markdown_rows(table_3(pd.DataFrame(table), titles, of)))


def conclusions(table: list[dict]) -> list[list[str]]:
    """Return the cells of the table of conclusions by row."""
    shown = concluded(pd.DataFrame(table))[COLUMNS].map(text)
    return shown.map(lambda words: words.partition(" (")[0]).to_numpy().tolist()


def verdicts(table: list[dict], averages: list[dict]) -> dict[str, list[int]]:
    """Count the paper's claims by verdict.

    The three numbers of a verdict are those of the study as configured, of the conclusions with
    choices varied, and of closures averaged over readings (``averages``).
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

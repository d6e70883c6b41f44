"""Tables and numbers of docs/results.md, and the outcome of the default study in short."""

import pandas as pd
from stored import stored

from content.markdown import Form, Table, markdown, rows_of, value_of
from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED
from studies.paper.claims import OURS
from studies.paper.conclusions import UNJUDGED
from studies.paper.layout import markdown_rows, table_3
from studies.paper.report.findings import probability


def _table_3(of: str) -> pd.DataFrame:
    """Table 3 of the study (""), or of the paper ("paper_"): parameters by (cycle, rock)."""
    rocks = stored("paper", "table_1_rocks")
    titles = dict(zip(rocks.rock, rocks.title, strict=True))
    return table_3(stored("paper", "table_3_indifference"), titles, of)


def intervals(of: str = "") -> str:
    """Tabulate Table 3 of the study, or ("paper_") of the paper."""
    return "\n".join(markdown_rows(_table_3(of)))


def _probability(name: str) -> Form:
    return lambda group: probability(group[name], group[f"{name}_error"]).text


def _beside_study(table: pd.DataFrame) -> pd.DataFrame:
    """Add the p of the study's smaller pool."""
    of_study = stored("paper", "table_3_joint_tests")[["entries", "p", "p_error"]]
    names = {"p": "study_p", "p_error": "study_p_error"}
    return table.merge(of_study.rename(columns=names), on="entries")


joint_tests = Table(
    "large_pool/table_3_joint_tests",
    {
        "entries": "{entries}",
        "number": "{number}",
        "p of this model": _probability("p"),
        "p without any effect": _probability("null_p"),
        "p of this model, 60 surfaces": _probability("study_p"),
    },
    prepare=_beside_study,
)


def scatter(cycle: int) -> str:
    """Give S/mean [%] of the rocks as they are, least to largest, with the largest error."""
    form = "{value min:.0f} to {value max:.0f} (± {standard_error max:.1g}) %"
    return value_of("jrc_range/jrc_range", form, parameter="base", half_width=0.0, cycle=cycle)


def surfaces() -> str:
    """Count the surfaces of the pool."""
    return value_of("paper/elasticities", "{samples max}")


def flagged() -> str:
    """Count simulations that are flagged as outside the model's range, of all."""
    flag = "simulations flagged outside_model_range"
    counts = rows_of(stored("paper", "checks"), check=flag).found.str.split(" of ", expand=True)
    return " of ".join(counts.astype(int).sum().astype(str))


def study_p(entries: str) -> str:
    """Give p of some entries from the pool of the study."""
    return value_of("paper/table_3_joint_tests", _probability("p"), entries=entries)


VERDICTS = {
    STANDS: "stand",
    FALLS: "fall",
    UNDECIDED: "undecided",
    NO_DIFFERENCE: "no difference",
}
REST = "not judged"


def verdicts() -> str:
    """Tabulate the claims of the paper by verdict: of the study, of the choices, averaged."""
    claims = stored("paper", "conclusions").set_index("number")
    claims = claims[claims.section != OURS]
    averaged = stored("readings_average", "readings_average_claims").set_index("number").verdict
    columns = {
        "as configured": claims.verdict.mask(claims.index.isin(UNJUDGED)),
        "open choices varied": claims.conclusion,
        "readings averaged": averaged.reindex(claims.index),
    }
    words = [*VERDICTS.values(), REST]
    counts = {
        title: of.map(VERDICTS).fillna(REST).value_counts().reindex(words, fill_value=0)
        for title, of in columns.items()
    }
    table = pd.DataFrame(counts).rename_axis("claims").reset_index()
    return markdown(table.rename(columns={"claims": f"of {len(claims)} claims"}))


def headline() -> dict[str, str]:
    """Numbers of the outcome in short: p of all entries, and what is left of the paper's claims."""
    tests = "large_pool/table_3_joint_tests"
    claims = stored("paper", "conclusions")
    claims = claims[claims.section != OURS]
    left = claims.conclusion.value_counts()
    return {
        "p": value_of(tests, _probability("p"), entries="all"),
        "p of the study": study_p("all"),
        "claims": str(len(claims)),
        "stand": str(left.get(STANDS, 0)),
        "fall": str(left.get(FALLS, 0)),
    }

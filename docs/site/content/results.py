"""Tables and numbers of docs/results.md, and the outcome of the default study in short."""

import numpy as np
import pandas as pd
from stored import origin, stored

from content.markdown import Form, Table, markdown, rows_of, value_of
from jointclosure.claims.table import OURS
from jointclosure.report.findings import found_text, probability, verdict_text
from jointclosure.sensitivity.conclusions import UNJUDGED
from jointclosure.sensitivity.tables import markdown_rows, table_3
from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED


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
claims = Table(
    "paper/claims",
    {
        "": "{number}",
        "claim": "{claim}",
        "place in the paper": "{section}",
        "true of the model": verdict_text,
        "studies that find it": found_text,
        "in the paper's Table 3": "{paper_finds}",
    },
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


AIM = 0.02
"""Standard error of p that was wanted."""


def fall() -> str:
    """Give the power of the number of surfaces with which the error of p fell between the pools."""
    errors = [
        rows_of(stored(run, "table_3_joint_tests"), entries="all").p_error.iloc[0]
        for run in ("large_pool", "paper")
    ]
    ratio = _large_pool() / int(study_surfaces())
    return f"{np.log(errors[0] / errors[1]) / np.log(ratio):.1f}"


def study_surfaces() -> str:
    """Count the surfaces of the study's pool."""
    return value_of("paper/table_3_predictive", "{pool max:.0f}")


def _large_pool() -> int:
    return origin("large_pool")["configuration"]["differs"]["study.pool"]


def _pools_wanted() -> float:
    """Compute how many of the large pools would give p of all entries to `AIM`."""
    table = rows_of(stored("large_pool", "table_3_joint_tests"), entries="all")
    return (table.p_error.iloc[0] / AIM) ** 2


def wanted_surfaces() -> str:
    """Count the surfaces that p to `AIM` takes, to two figures."""
    return f"{float(f'{_large_pool() * _pools_wanted():.2g}'):,.0f}"


def wanted_hours() -> str:
    """Give the core-hours that p to `AIM` takes, by those of the large pool."""
    return f"{origin('large_pool')['cpu_minutes'] * _pools_wanted() / 60.0:.0f}"


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
        "study": claims.verdict.mask(claims.index.isin(UNJUDGED)),
        "open choices too": claims.conclusion,
        "readings averaged": averaged.reindex(claims.index),
    }
    words = [*VERDICTS.values(), REST]
    counts = {
        title: of.map(VERDICTS).fillna(REST).value_counts().reindex(words, fill_value=0)
        for title, of in columns.items()
    }
    table = pd.DataFrame(counts).rename_axis("claims").reset_index()
    return markdown(table.rename(columns={"claims": f"of {len(claims)} claims"}))


def unasked() -> str:
    """Name the claims that stand and were not asked of the earlier readings."""
    claims = stored("paper", "conclusions")
    standing = claims[(claims.conclusion == STANDS) & (claims.section != OURS)].number
    *first, last = standing[~standing.isin(stored("conclusions", "earlier_readings").number)]
    return f"{', '.join(first)} and {last}"


def headline() -> dict[str, str]:
    """Numbers of the outcome in short: p of all entries, and what is left of the paper's claims."""
    tests = "large_pool/table_3_joint_tests"
    claims = stored("paper", "conclusions")
    claims = claims[claims.section != OURS]
    left = claims.conclusion.value_counts()
    return {
        "p": value_of(tests, _probability("p"), entries="all"),
        "p of the study": study_p("all"),
        "p of no effect": value_of(tests, _probability("null_p"), entries="all"),
        "claims": str(len(claims)),
        "stand": str(left.get(STANDS, 0)),
        "fall": str(left.get(FALLS, 0)),
    }

"""Tables and numbers of docs/results.md, and the outcome of the default study in short."""

import pandas as pd
from stored import stored

from content.markdown import first_row, listed, markdown, rows_of
from jointclosure.claims.table import OURS
from jointclosure.config.properties import PROPERTIES
from jointclosure.report.findings import percent_text, probability
from jointclosure.sensitivity.conclusions import JUDGED_ELSEWHERE
from jointclosure.sensitivity.tables import markdown_rows, table_3
from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, FALLS, NO_DIFFERENCE, STANDS

EXCLUDED = 0.05
"""Joint p below which Table 3 is said to exclude the model (decision 0013)."""
VERDICTS = {
    STANDS: "are true of the model",
    FALLS: "are false",
    NO_DIFFERENCE: "rest on no difference",
    CANNOT_BE_TOLD: "cannot be told",
}


def _table_3(of: str) -> pd.DataFrame:
    """Table 3 of the study (""), or of the paper ("paper_"): parameters by (cycle, rock)."""
    rocks = stored("paper", "table_1_rocks")
    titles = dict(zip(rocks.rock, rocks.title, strict=True))
    return table_3(stored("paper", "table_3_indifference"), titles, of)


def intervals(of: str = "") -> str:
    """Tabulate Table 3 of the study, or ("paper_") of the paper."""
    return "\n".join(markdown_rows(_table_3(of)))


def short_table() -> str:
    """Tabulate Table 3 without percentages: the study's lengths / the paper's, by rock."""
    study, paper = _table_3(""), _table_3("paper_")
    rows = []
    for name in study.index:
        for cycle in dict.fromkeys(cycle for cycle, _ in study.columns):
            row = {"property": PROPERTIES[name].label, "cycle": cycle}
            for rock, length in study.loc[name][cycle].items():
                pair = (length, paper.loc[name][cycle][rock])
                row[rock] = " / ".join(text.split(" (")[0] for text in pair)
            rows.append(row)
    return markdown(pd.DataFrame(rows))


def joint_tests() -> str:
    """Tabulate whether the paper's entries together exclude the model."""
    columns = {
        "entries": "{entries}",
        "number": "{number}",
        "p of this model": lambda row: probability(row["p"], row["p_error"]).text,
        "p without any effect": lambda row: probability(row["null_p"], row["null_p_error"]).text,
    }
    return listed(stored("paper", "table_3_joint_tests"), columns)


def claims() -> str:
    """Tabulate the paper's claims: true of the model, found by studies, and in its Table 3."""
    columns = {
        "": "{number}",
        "claim": "{claim}",
        "said in": "{said_in}",
        "true of the model": "{verdict}",
        "studies that find it": lambda row: percent_text(
            *(row[f"found_{part}"] for part in ("share", "error", "low", "high"))
        ),
        "in the paper's Table 3": "{paper_finds}",
    }
    return listed(stored("paper", "claims"), columns)


def scatter(cycle: int) -> str:
    """Give S/mean [%] of the rocks' own cases, least to largest, with the largest error."""
    table = rows_of(stored("paper", "jrc_range"), parameter="base", half_width=0.0, cycle=cycle)
    low, high, error = table.value.min(), table.value.max(), table.standard_error.max()
    return f"{low:.0f} to {high:.0f} (± {error:.1g}) %"


def surfaces() -> int:
    """Count the surfaces of the pool."""
    return int(stored("paper", "elasticities").samples.max())


def flagged() -> str:
    """Count simulations that are flagged as outside the model's range, of all."""
    checks = rows_of(stored("paper", "checks"), check="simulations flagged outside_model_range")
    counts = checks.found.str.split(" of ", expand=True).astype(int).sum()
    return f"{counts[0]} of {counts[1]}"


def headline() -> dict[str, str]:
    """Numbers of the outcome in short: p values, claims by verdict, and what is left of them."""
    whole = first_row(rows_of(stored("paper", "table_3_joint_tests"), entries="all"))
    judged = stored("paper", "conclusions")
    judged = judged[(judged.said_in != OURS) & (judged.conclusion != JUDGED_ELSEWHERE)]
    verdicts, left = judged.verdict.value_counts(), judged.conclusion.value_counts()
    return {
        "entries": str(whole.number),
        "excluded": "exclude" if whole.p < EXCLUDED else "do not exclude",
        "p": probability(whole.p, whole.p_error).text,
        "no effect excluded": "exclude" if whole.null_p < EXCLUDED else "do not exclude",
        "p of no effect": probability(whole.null_p, whole.null_p_error).text,
        "claims": str(len(judged)),
        "verdicts": ", ".join(f"{verdicts.get(key, 0)} {text}" for key, text in VERDICTS.items()),
        "stand": str(left.get(STANDS, 0)),
        "fall": str(left.get(FALLS, 0)),
    }

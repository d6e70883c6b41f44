"""Renew the numbers of README.md and docs/results.md from results/paper, between their markers.

Run by hand after `make study`, so that what they show is what a study gave.
"""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
from markers import fill

from jointclosure.claims.table import OURS
from jointclosure.config.properties import PROPERTIES
from jointclosure.joint.protocol import FAILURE
from jointclosure.report.findings import percent_text, probability
from jointclosure.sensitivity.conclusions import JUDGED_ELSEWHERE
from jointclosure.sensitivity.tables import UNPAIRED_TEST, markdown_rows, table_3
from jointclosure.statistics.standard_errors import variation_of
from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, FALLS, NO_DIFFERENCE, STANDS
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
PAPER = ROOT / "results/paper"
EXCLUDED = 0.05
"""Joint p below which the README says that Table 3 excludes the model (decision 0013)."""


VERDICTS = {
    STANDS: "are true of the model",
    FALLS: "are false",
    NO_DIFFERENCE: "rest on no difference",
    CANNOT_BE_TOLD: "cannot be told",
}
SHOWN = {"This study": "", "The paper": "paper_"}
"""Tables that are shown, by the prefix of their columns."""


def interval_tables() -> dict[str, pd.DataFrame]:
    """Table 3, ours and the paper's: parameters by (cycle, rock)."""
    intervals = read_csv(PAPER / "tables/table_3_indifference.csv")
    rocks = read_csv(PAPER / "tables/table_1_rocks.csv")
    titles = dict(zip(rocks.rock, rocks.title, strict=True))
    return {name: table_3(intervals, titles, column) for name, column in SHOWN.items()}


def interval_table() -> str:
    """Table 3 of ours and the paper's, one below the other."""
    return "\n".join(
        f"{name}, {UNPAIRED_TEST}:\n\n" + "\n".join(markdown_rows(table)) + "\n"
        for name, table in interval_tables().items()
    )


def short_table() -> str:
    """Table 3: a row for each property and cycle, a column for each rock, ours and the paper's."""
    ours, papers = interval_tables().values()
    rocks = list(dict.fromkeys(title for _, title in ours.columns))
    cycles = sorted({cycle for cycle, _ in ours.columns})
    rows = ["| property | cycle | " + " | ".join(rocks) + " |", "|---" * (2 + len(rocks)) + "|"]
    for name in ours.index:
        for cycle in cycles:
            shown = [
                " / ".join(
                    table.loc[name, [(cycle, title)]].iloc[0].split(" (")[0]
                    for table in (ours, papers)
                )
                for title in rocks
            ]
            rows.append(f"| {PROPERTIES[name].label} | {cycle} | " + " | ".join(shown) + " |")
    return "\n".join(rows) + "\n"


def claim_table() -> str:
    """Claims: who says so, true of the model, found by studies, and in the paper's own table."""
    claims = read_csv(PAPER / "tables/claims.csv")
    rows = []
    for row in claims.itertuples():
        found = percent_text(row.found_share, row.found_error, row.found_low, row.found_high)
        own = "" if pd.isna(row.paper_finds) else row.paper_finds
        rows.append(
            f"| {row.number} | {row.claim} | {row.said_in} | {row.verdict} | {found} | {own} |"
        )
    heads = ["", "claim", "said in", "true of the model", "studies that find it"]
    heads += ["in the paper's Table 3"]
    head = f"| {' | '.join(heads)} |\n"
    return head + "|---" * len(heads) + "|\n" + "\n".join(rows) + "\n"


def picture() -> str:
    """The figure of repetitions, which leads."""
    return (
        "![The paper's Table 3 among repetitions of this study]"
        "(docs/images/table_3_predictive.png)\n\n"
        "*The paper's indifference intervals (diamonds) among those that repetitions of this study "
        "would publish (curves), and among those of properties without any effect (grey).*\n"
    )


def joint_tests() -> str:
    """The paper's entries together, and whether they exclude the model."""
    joint = read_csv(PAPER / "tables/table_3_joint_tests.csv")
    rows = [
        f"| {row.entries} | {row.number} | {probability(row.p, row.p_error).text} | "
        f"{probability(row.null_p, row.null_p_error).text} |"
        for row in joint.itertuples()
    ]
    head = "| entries | number | p of this model | p without any effect |\n|---|---|---|---|\n"
    return head + "\n".join(rows) + "\n"


def outcome() -> str:
    """All entries together, and what is true of the paper's claims: the finding in short."""
    whole = read_csv(PAPER / "tables/table_3_joint_tests.csv").iloc[0]
    excluded = "exclude" if whole.p < EXCLUDED else "do not exclude"
    nothing = "exclude" if whole.null_p < EXCLUDED else "do not exclude"
    asked = read_csv(PAPER / "tables/conclusions.csv")
    asked = asked[(asked.said_in != OURS) & (asked.conclusion != JUDGED_ELSEWHERE)]
    configured = asked.verdict.value_counts()
    verdicts = ", ".join(f"{configured.get(word, 0)} {words}" for word, words in VERDICTS.items())
    left = asked.conclusion.value_counts()
    return (
        f"Together the paper's {whole.number} entries {excluded} this model "
        f"(p {_sign(whole.p, whole.p_error)}). They {nothing} that the properties have no effect "
        f"(p {_sign(whole.null_p, whole.null_p_error)}), which supports no model. Of "
        f"{len(asked)} claims of the paper on "
        f"sensitivity and cycles, as configured, {verdicts}. With what the paper leaves open "
        f"varied, {left.get(STANDS, 0)} still stand and {left.get(FALLS, 0)} fall "
        f"([conclusions](docs/conclusions.md)).\n"
    )


def _sign(value: float, error: float) -> str:
    text = probability(value, error).text
    return text if text.startswith("<") else f"= {text}"


def facts() -> str:
    """Scatter over surfaces, and flags."""
    study = read_netcdf(PAPER / "study.nc")
    pool = read_netcdf(PAPER / "pool.nc")
    base = pool.max_closure[(pool.parameter == "base").values].where(pool.status < FAILURE)
    lines = []
    for cycle in (1, 2):
        found = [variation_of(row[np.isfinite(row)]) for row in base.sel(cycle=cycle).values]
        values = [100 * each.value for each in found]
        error = 100 * max(each.standard_error for each in found)
        lines.append(f"{min(values):.0f} to {max(values):.0f} (± {error:.1g}) % in cycle {cycle}")
    joints = np.concatenate([study.status.values.ravel(), pool.status.values.ravel()])
    flagged = int(((joints & 2) > 0).sum())
    return (
        f"The standard deviation over {pool.sizes['realization']} surfaces is {', '.join(lines)} "
        f"of the mean maximum closure; {flagged} of {joints.size} simulations, those "
        "of the pool among them, are flagged as outside the model's range "
        "(contacts that cannot break carry over 10 % of the force).\n"
    )


def main() -> None:
    """Fill both documents and copy their figures."""
    fill(
        ROOT / "README.md",
        {"picture": picture(), "short table": short_table(), "outcome": outcome()},
    )
    parts = {"intervals": interval_table(), "joint tests": joint_tests()}
    fill(ROOT / "docs/results.md", parts | {"claims": claim_table(), "facts": facts()})
    for figure in ("fig_5_closure", "table_3_predictive"):
        shutil.copy(PAPER / f"figures/{figure}.png", ROOT / f"docs/images/{figure}.png")


if __name__ == "__main__":
    main()

"""Renew the numbers of the README from results/paper, between its markers.

Run by hand after `make study`, so that what the README shows is what a study gave.
"""

import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
from markers import fill

from jointclosure.protocol import FAILURE
from jointclosure.report.findings import percent_text
from jointclosure.statistics.standard_errors import variation_of
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
PAPER = ROOT / "results/paper"
EXCLUDED = 0.05
"""Joint p below which the README says that Table 3 excludes the model (decision 0013)."""


def interval_table() -> str:
    """Table 3 of ours and the paper's, without its note."""
    text = (PAPER / "tables/table_3_indifference.md").read_text(encoding="utf-8")
    parts = re.split(r"\*\*(.+?)\*\*\n\n", text)[1:]
    tables = dict(zip(parts[::2], parts[1::2], strict=True))
    shown = ("This study", "The paper")
    return "\n".join(
        f"{name}:\n\n" + "\n".join(row for row in tables[name].splitlines() if row.startswith("|"))
        + "\n"
        for name in shown
    )  # fmt: skip


def claim_table() -> str:
    """Claims: true of the model, found by how many studies, and by the paper's own table."""
    claims = read_csv(PAPER / "tables/claims.csv")
    rows = []
    for row in claims.itertuples():
        known = not pd.isna(row.found_share)
        found = percent_text(row.found_share, row.found_error) if known else ""
        own = "" if pd.isna(row.paper_finds) else row.paper_finds
        rows.append(f"| {row.number} | {row.claim} | {row.verdict} | {found} | {own} |")
    head = "| | claim | true of the model | studies that find it | in the paper's Table 3 |\n"
    return head + "|---|---|---|---|---|\n" + "\n".join(rows) + "\n"


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
        f"| {row.entries} | {row.number} | {_p(row.p)} | {_p(row.null_p)} |"
        for row in joint.itertuples()
    ]
    head = "| entries | number | p of this model | p without any effect |\n|---|---|---|---|\n"
    whole = joint.iloc[0]
    outcome = "exclude" if whole.p < EXCLUDED else "do not exclude"
    said = (
        f"Together the paper's {whole.number} entries {outcome} this model as configured "
        f"(p {_sign(whole.p)}):\n\n"
    )
    return said + head + "\n".join(rows) + "\n"


def _sign(value: float) -> str:
    text = _p(value)
    return text if text.startswith("<") else f"= {text}"


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else f"{value:.2g}"


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
    flagged = int(((study.status.values & 2) > 0).sum())
    return (
        f"The standard deviation over {pool.sizes['realization']} surfaces is {', '.join(lines)} "
        f"of the mean maximum closure; {flagged} of {study.status.size} simulations are flagged as "
        f"outside the model's range (contacts that cannot break carry over 10 % of the force).\n"
    )


def main() -> None:
    """Fill the README and copy its figures."""
    parts = {"intervals": interval_table(), "claims": claim_table(), "facts": facts()}
    parts |= {"picture": picture(), "joint tests": joint_tests()}
    fill(ROOT / "README.md", parts)
    for figure in ("fig_5_closure", "table_3_predictive"):
        shutil.copy(PAPER / f"figures/{figure}.png", ROOT / f"docs/images/{figure}.png")


if __name__ == "__main__":
    main()

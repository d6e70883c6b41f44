"""Renew the numbers of the README from results/paper, between its markers.

Run by hand after `make study`, so that what the README shows is what a study gave.
"""

import re
import shutil
from pathlib import Path

import pandas as pd
from markers import fill

from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
PAPER = ROOT / "results/paper"


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
    """Claims and verdicts."""
    claims = read_csv(PAPER / "tables/claims.csv")
    rows = [f"| {row.number} | {row.claim} | {row.verdict} |" for row in claims.itertuples()]
    return "| | claim | verdict |\n|---|---|---|\n" + "\n".join(rows) + "\n"


def facts() -> str:
    """Scatter over surfaces, flags, and the time of a simulation."""
    study = read_netcdf(PAPER / "study.nc")
    closures = read_csv(PAPER / "tables/max_closure.csv")
    base = closures[closures.parameter == "base"]
    scatter = base.max_closure_standard_deviation_mm / base.max_closure_mean_mm
    lines = []
    for cycle in (1, 2):
        part = 100 * scatter[base.cycle == cycle]
        lines.append(f"{part.min():.0f} to {part.max():.0f} % in cycle {cycle}")
    flagged = int(((study.status.values & 2) > 0).sum())
    seconds = pd.Series(study.timing_simulation.values.ravel())
    return (
        f"In this study the standard deviation over surfaces is {', '.join(lines)} of the mean "
        f"maximum closure; {flagged} of {study.status.size} simulations are flagged as outside the "
        f"model's range (contacts that cannot break carry over 10 % of the force); a simulation "
        f"took {seconds.median():.1f} s (median).\n"
    )


def main() -> None:
    """Fill the README and copy its figure."""
    parts = {"intervals": interval_table(), "claims": claim_table(), "facts": facts()}
    fill(ROOT / "README.md", parts)
    shutil.copy(PAPER / "figures/fig_5_closure.png", ROOT / "docs/images/fig_5_closure.png")


if __name__ == "__main__":
    main()

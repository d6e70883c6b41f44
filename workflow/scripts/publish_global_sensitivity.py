"""Renew docs/global_sensitivity.md from results/global_sensitivity and results/paper.

Run by hand after `make global-sensitivity`, `make jrc-range` and
`snakemake estimate_together --configfile config/global_sensitivity_full.yaml`.
"""

import shutil
from pathlib import Path

import pandas as pd
from markers import fill
from publish_measured import markdown

from jointclosure.statistics.standard_errors import rounded
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results/global_sensitivity"
FULL = ROOT / "results/global_sensitivity_full"
PAPER = ROOT / "results/paper"
ENOUGH = 0.1
"""Standard error of a share that would settle it."""
SHOWN = (
    ("closure", 1, "closure, cycle 1"),
    ("closure", 2, "closure, cycle 2"),
    ("closure_net", 2, "net closure, cycle 2"),
    ("residual", 1, "residual closure"),
    ("compliance", 2, "compliance, cycle 2"),
)


def span(values: pd.Series, errors: pd.Series, digits: int = 2) -> str:
    """Least and largest, and the largest standard error."""
    return f"{values.min():.{digits}f} to {values.max():.{digits}f} (± {errors.max():.{digits}f})"


def indices() -> str:
    """Total indices of each input, and the Shapley effect on the second cycle."""
    table = read_csv(RESULTS / "tables/global_indices.csv")
    table = table[table.rows == table.rows.max()]
    rows = []
    for name in dict.fromkeys(table.input):
        own = table[table.input == name]
        row = {"input": own.title.iloc[0]}
        for response, cycle, title in SHOWN:
            part = own[(own.response == response) & (own.cycle == cycle)]
            row[title] = span(part.total, part.total_error)
        part = own[(own.response == "closure") & (own.cycle == 1)]
        for column, title in (
            ("shapley", "Shapley, cycle 1"),
            ("shapley_dependent", "the same, E and σc correlated"),
        ):
            known = part[column].notna().any()
            row[title] = span(part[column], part[f"{column}_error"]) if known else ""
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def elasticities() -> str:
    """Elasticities of the closure by property, cycle and rock, and how they vary."""
    table = read_csv(RESULTS / "tables/global_elasticities.csv")
    titles = read_csv(RESULTS / "tables/global_indices.csv").groupby("input").title.first()
    rows = []
    for response, said in (("closure", ""), ("closure_net", ", net of bulk indentation")):
        for cycle in (1, 2):
            for name in dict.fromkeys(table.input):
                own = table[(table.response == response) & (table.cycle == cycle)]
                own = own[own.input == name]
                row = {"property": titles[name], "of the closure of": f"cycle {cycle}{said}"}
                for each in own.itertuples():
                    row[each.rock] = rounded(each.elasticity, each.elasticity_error)
                row["varies by"] = span(own.spread, own.spread_error)
                rows.append(row)
    return markdown(pd.DataFrame(rows))


def conclusions() -> str:
    """Shares of choices for which conclusions hold: the least of a rock, and in all rocks."""
    table = read_csv(RESULTS / "tables/global_conclusions.csv")
    rows = []
    for (number, said), own in table.groupby(["number", "conclusion"], sort=False):
        row = {"": number, "conclusion": said}
        for cycle in (1, 2):
            for response, net in (("closure", ""), ("closure_net", ", net")):
                part = own[(own.cycle == cycle) & (own.response == response)]
                whole = part[part.rock == "all"].iloc[0]
                least = part[part.rock != "all"].sort_values("share").iloc[0]
                row[f"cycle {cycle}{net} (%)"] = (
                    f"{_percent(least.share, least.share_error)}; all "
                    f"{_percent(whole.share, whole.share_error)}"
                )
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def _percent(share: float, error: float) -> str:
    return f"{100.0 * share:.0f} ± {100.0 * error:.0f}"


def jrc_range() -> str:
    """S/mean and median lengths at each half-width of the JRC, least and largest of the rocks."""
    table = read_csv(PAPER / "tables/jrc_range.csv")
    rows = []
    names = {"base": "S/mean (%)", "joint p": "p of the paper's Table 3"}
    for (name, cycle), own in table.groupby(["parameter", "cycle"], sort=False):
        if name not in ("base", "jrc", "youngs_modulus", "joint p"):
            continue
        title = names.get(name, f"median length of {name.replace('_', ' ')} (%)")
        row = {"": title, "cycle": cycle or ""}
        for half_width, part in own.groupby("half_width"):
            title = f"JRC ± {half_width:g}" if half_width else "JRC known"
            digits = 2 if name == "joint p" else 1
            row[title] = (
                span(part.value, part.standard_error, digits)
                if len(part) > 1
                else rounded(part.value.iloc[0], part.standard_error.iloc[0])
            )
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def jrc_claims() -> str:
    """How often studies of 20 draws find each claim."""
    table = read_csv(PAPER / "tables/jrc_range_claims.csv").dropna(subset=["found_share"])
    rows = []
    for (number, said), own in table.groupby(["number", "claim"], sort=False):
        row = {"": number, "claim": said}
        for each in own.itertuples():
            title = f"JRC ± {each.half_width:g} (%)" if each.half_width else "JRC known (%)"
            row[title] = _percent(each.found_share, each.found_error)
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def more_rows() -> str:
    """How far the least certain share is known, and what it costs to know it to 10 %."""
    shares = read_csv(RESULTS / "tables/global_conclusions.csv")
    rows = int(read_csv(RESULTS / "tables/global_indices.csv").rows.max())
    minutes = read_csv(RESULTS / "tables/global_estimate.csv").core_minutes.sum()
    worst = shares.loc[shares.share_error.idxmax()]
    enough = rows
    while worst.share_error * (rows / enough) ** 0.5 > ENOUGH:
        enough *= 2
    net = ", net of bulk indentation" if worst.response.endswith("net") else ""
    return (
        f'The least certain share is that of "{worst.conclusion}" on cycle {worst.cycle}{net}: '
        f"{_percent(worst.share, worst.share_error)} %. Errors fall as one over the square root of "
        f"the rows: {enough:,} rows would bring it to {100 * ENOUGH:.0f} %, and take "
        f"{minutes * enough / rows / 60:.0f} core-hours where these {rows} took "
        f"{minutes / 60:.1f}.\n"
    )


def full_size() -> str:
    """What the design at full size takes, by its own estimate."""
    table = read_csv(FULL / "tables/global_estimate.csv")
    rows = [
        {
            "rock": row.rock,
            "simulations": f"{row.simulations:,}",
            "seconds each": f"{row.seconds:.2f}",
            "core-hours": rounded(row.core_minutes / 60, row.error / 60),
        }
        for row in table.itertuples()
    ]
    error = float((table.error**2).sum() ** 0.5)
    whole = {
        "rock": "all",
        "simulations": f"{table.simulations.sum():,}",
        "core-hours": rounded(table.core_minutes.sum() / 60, error / 60),
    }
    return markdown(pd.DataFrame([*rows, whole]))


def main() -> None:
    """Fill the document, and copy its figures."""
    parts = {"indices": indices(), "elasticities": elasticities(), "conclusions": conclusions()}
    parts |= {"more rows": more_rows(), "full size": full_size()}
    parts |= {"jrc range": jrc_range(), "jrc claims": jrc_claims()}
    fill(ROOT / "docs/global_sensitivity.md", parts)
    for figure in ("indices", "conclusions", "convergence"):
        source = RESULTS / f"figures/global_{figure}.png"
        shutil.copy(source, ROOT / f"docs/images/global_{figure}.png")


if __name__ == "__main__":
    main()

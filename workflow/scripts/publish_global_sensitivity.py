"""Renew docs/global_sensitivity.md from results/global_sensitivity and results/paper.

Run by hand after `make global-sensitivity`, `make jrc-range` and
`.venv/bin/snakemake estimate_global_sensitivity --configfile config/global_sensitivity_full.yaml`.
"""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from markers import fill
from publish_measured import markdown

from jointclosure.config.properties import PARAMETERS
from jointclosure.report.findings import percent_text
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
    ("residual_seated_net", 1, "residual closure"),
    ("compliance", 1, "net compliance, cycle 1"),
    ("compliance", 2, "net compliance, cycle 2"),
)
CASES = (
    (1, "closure", "cycle 1"),
    (1, "closure_net", "cycle 1, net"),
    (2, "closure", "cycle 2"),
    (2, "closure_net", "cycle 2, net"),
)
"""Cycle and response that conclusions are about."""
SHOWN_FROM = 0.1
"""Share of a margin's variance from which on an input is shown."""


def span(values: pd.Series, errors: pd.Series, digits: int = 2) -> str:
    """Least and largest, and the largest standard error."""
    return f"{values.min():.{digits}f} to {values.max():.{digits}f} (± {errors.max():.{digits}f})"


def whole() -> pd.DataFrame:
    """Indices of all rows."""
    table = read_csv(RESULTS / "tables/global_sensitivity_indices.csv")
    return table[table.rows == table.rows.max()]


def indices(kind: str) -> str:
    """First or total indices of each input."""
    rows = []
    for title, own in whole().groupby("title", sort=False):
        row = {"input": title}
        for response, cycle, name in SHOWN:
            part = own[(own.response == response) & (own.cycle == cycle)]
            known = part[kind].notna().any()
            row[name] = span(part[kind], part[f"{kind}_error"]) if known else ""
        if any(list(row.values())[1:]):
            rows.append(row)
    return markdown(pd.DataFrame(rows))


def shapley() -> str:
    """Shapley effects on the closures, with and without dependent inputs."""
    table = whole()[lambda own: (own.response == "closure") & own.shapley.notna()]
    rows = []
    for title, own in table.groupby("title", sort=False):
        row = {"input": title}
        for cycle, part in own.groupby("cycle"):
            for column, name in (
                ("shapley", f"cycle {cycle}"),
                ("shapley_dependent", f"cycle {cycle}, E and σc correlated"),
            ):
                row[name] = span(part[column], part[f"{column}_error"])
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def cost() -> str:
    """Size of the design, and the processor time that its jobs took."""
    simulations = read_csv(RESULTS / "tables/global_sensitivity_estimate.csv").joints.sum()
    files = (RESULTS / "benchmarks").rglob("*.tsv")
    minutes = sum(pd.read_csv(file, sep="\t").cpu_time.sum() for file in files) / 60.0
    return (
        f"{whole().rows.max():.0f} rows, {simulations:,} joints of 64 x 64 cells, {minutes:.0f} "
        f"minutes of processor time. Least to largest of the four rocks, with the largest "
        f"standard error.\n"
    )


def convergence() -> str:
    """How the largest index of the first cycle goes with the rows, and what the fit has."""
    table = read_csv(RESULTS / "tables/global_sensitivity_indices.csv")
    own = table[(table.response == "closure") & (table.cycle == 1) & (table.input == "roll_off")]
    of_rocks = "; ".join(
        f"{rock} {', '.join(f'{value:.2f}' for value in part.sort_values('rows').total)}"
        for rock, part in own.groupby("rock", sort=False)
    )
    rows = ", ".join(f"{each:.0f}" for each in sorted(own.rows.unique()))
    last = own[own.rows == own.rows.max()]
    fits = whole().drop_duplicates(["rock", "response", "cycle"])
    shares = []
    for response, cycle, name in SHOWN:
        part = fits[(fits.response == response) & (fits.cycle == cycle)].fit_share
        shares.append(f"{name}: {part.min():.2f} to {part.max():.2f}")
    return (
        f"The largest index of the first cycle, the roll-off's, from {rows} rows: {of_rocks}. "
        f"From all rows it is known to ± {100 * (last.total_error / last.total).max():.0f} % of "
        f"itself or better; {min(own.rows):.0f} rows "
        f"are too few. The fitted polynomial has this much of the variance found (1: all of it; "
        f"above 1 where the rows found less than it has): {'; '.join(shares)}.\n"
    )


def elasticities() -> str:
    """Elasticities of the closure by property, cycle and rock, and how they vary."""
    table = read_csv(RESULTS / "tables/global_sensitivity_elasticities.csv")
    titles = (
        read_csv(RESULTS / "tables/global_sensitivity_indices.csv").groupby("input").title.first()
    )
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
                fit = own.fit_over_noise
                row["fit over noise"] = f"{fit.min():.1f} to {fit.max():.1f}"
                rows.append(row)
    return markdown(pd.DataFrame(rows))


def conclusions() -> str:
    """Shares of choices for which conclusions hold: the least of a rock, and in all rocks."""

    def shares(part: pd.DataFrame) -> str:
        together = part[part.rock == "all"].iloc[0]
        least = part[part.rock != "all"].sort_values("share").iloc[0]
        return f"{_between(least)}; all {_between(together)}"

    return _by_case(shares, " (%)")


def single_rows() -> str:
    """At how many rows a conclusion is true of the row's own changes."""

    def counts(part: pd.DataFrame) -> str:
        of_rocks = part[part.rock != "all"].rows_true
        return f"{of_rocks.min()} to {of_rocks.max()}"

    return _by_case(counts)


def _by_case(cell: Callable[[pd.DataFrame], str], unit: str = "") -> str:
    """A row for each conclusion, with a cell for each cycle and closure of which it is."""
    table = read_csv(RESULTS / "tables/global_sensitivity_conclusions.csv")
    rows = []
    for (number, said), own in table.groupby(["number", "conclusion"]):
        row = {"": number, "conclusion": said}
        for cycle, response, name in CASES:
            part = own[(own.cycle == cycle) & (own.response == response)]
            row[name + unit] = cell(part) if len(part) else ""
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def ranking() -> str:
    """Shares of the variance of a ranking's margin over the choices, by input and rock."""
    table = read_csv(RESULTS / "tables/global_sensitivity_margins.csv")
    table = table[(table.cycle == 2) & table.number.isin(["1a", "2a"])]
    rows = []
    for (number, said), own in table.groupby(["number", "conclusion"]):
        for title, part in own.groupby("title", sort=False):
            row = {"": number, "conclusion": said, "varies with": title}
            for each in part.itertuples():
                net = ", net" if each.response == "closure_net" else ""
                row[f"{each.rock}{net}"] = f"{each.share:.2f} ± {each.share_error:.2f}"
            if part.share.max() >= SHOWN_FROM:
                rows.append(row)
    return markdown(pd.DataFrame(rows))


def _between(row: pd.Series) -> str:
    """A share in percent, and its 95 % interval."""
    return f"{100 * row.share:.0f} ({100 * row.share_low:.0f} to {100 * row.share_high:.0f})"


def _percent(share: float, error: float) -> str:
    return f"{100.0 * share:.0f} ± {100.0 * error:.0f}"


def jrc_range() -> str:
    """S/mean, median lengths and the share of dashes at each half-width of the JRC, over rocks."""
    table = read_csv(PAPER / "tables/jrc_range.csv")
    rows = []
    names = {"base": "S/mean (%)", "joint p": "p of the paper's Table 3"}
    for (name, cycle), own in table.groupby(["parameter", "cycle"], sort=False):
        title = names.get(name, f"median length of {name.replace('_', ' ')}, unpaired t test (%)")
        row, dashes = {"": title, "cycle": cycle or ""}, {"": "its dashes (%)", "cycle": cycle}
        for half_width, part in own.groupby("half_width"):
            title = f"JRC ± {half_width:g}" if half_width else "JRC known"
            row[title] = _lengths(part, digits=2 if name == "joint p" else 1)
            without = 100.0 * part.share_without_root
            dashes[title] = f"{without.min():.0f} to {without.max():.0f}"
        rows += [row, dashes] if name in PARAMETERS else [row]
    return markdown(pd.DataFrame(rows))


def _lengths(part: pd.DataFrame, digits: int) -> str:
    """Least and largest of the rocks; an infinite median is a dash, as in Table 3."""
    if len(part) == 1:
        return rounded(part.value.iloc[0], part.standard_error.iloc[0])
    known = part[np.isfinite(part.value)]
    if known.empty:
        return "–"
    text = span(known.value, known.standard_error, digits)
    return text if len(known) == len(part) else f"{text}; {len(part) - len(known)} –"


def jrc_claims() -> str:
    """How often studies of 20 draws find each claim."""
    table = read_csv(PAPER / "tables/jrc_range_claims.csv").dropna(subset=["found_share"])
    rows = []
    for (number, said), own in table.groupby(["number", "claim"], sort=False):
        row = {"": number, "claim": said}
        for each in own.itertuples():
            title = f"JRC ± {each.half_width:g}" if each.half_width else "JRC known"
            interval = (each.found_low, each.found_high)
            row[title] = percent_text(each.found_share, each.found_error, *interval)
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def more_rows() -> str:
    """How far the least certain share is known, and what it costs to know it to 10 %."""
    shares = read_csv(RESULTS / "tables/global_sensitivity_conclusions.csv")
    rows = int(read_csv(RESULTS / "tables/global_sensitivity_indices.csv").rows.max())
    minutes = read_csv(RESULTS / "tables/global_sensitivity_estimate.csv").seconds.sum() / 60
    worst = shares.loc[shares.share_error.idxmax()]
    enough = rows
    while worst.share_error * (rows / enough) ** 0.5 > ENOUGH:
        enough *= 2
    net = ", net of bulk indentation" if worst.response.endswith("net") else ""
    return (
        f'The least certain share is that of "{worst.conclusion}" on cycle {worst.cycle}{net}: '
        f"{_percent(worst.share, worst.share_error)} %. Errors fall as one over the square root of "
        f"the rows: {enough:,} rows would bring it below {100 * ENOUGH:.0f} %, and take "
        f"{minutes * enough / rows / 60:.0f} core-hours where these {rows} took "
        f"{minutes / 60:.1f}.\n"
    )


def full_size() -> str:
    """What the design at full size takes, by its own estimate."""
    table = read_csv(FULL / "tables/global_sensitivity_estimate.csv")
    rows = [
        {
            "rock": row.job,
            "simulations": f"{row.joints:,}",
            "seconds each": f"{row.seconds / row.joints:.2f}",
            "core-hours": rounded(row.seconds / 3600, row.error / 3600),
        }
        for row in table.itertuples()
    ]
    error = float((table.error**2).sum() ** 0.5)
    whole = {
        "rock": "all",
        "simulations": f"{table.joints.sum():,}",
        "core-hours": rounded(table.seconds.sum() / 3600, error / 3600),
    }
    return markdown(pd.DataFrame([*rows, whole]))


def main() -> None:
    """Fill the document, and copy its figures."""
    parts = {"cost": cost(), "indices": indices("total"), "first": indices("first")}
    parts |= {"shapley": shapley(), "convergence": convergence()}
    parts |= {"elasticities": elasticities(), "conclusions": conclusions()}
    parts |= {"single rows": single_rows(), "ranking": ranking()}
    parts |= {"more rows": more_rows(), "full size": full_size()}
    parts |= {"jrc range": jrc_range(), "jrc claims": jrc_claims()}
    fill(ROOT / "docs/global_sensitivity.md", parts)
    for figure in ("indices", "conclusions", "convergence"):
        source = RESULTS / f"figures/global_sensitivity_{figure}.png"
        shutil.copy(source, ROOT / f"docs/images/global_sensitivity_{figure}.png")


if __name__ == "__main__":
    main()

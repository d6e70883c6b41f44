"""Tables and numbers of docs/global_sensitivity.md."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from stored import origin, stored

from content.markdown import (
    MOST,
    first_row,
    grouped,
    listed,
    markdown,
    rows_of,
    span,
    titled,
    with_error,
)
from jointclosure.config.properties import PARAMETERS
from jointclosure.report.findings import percent_text
from jointclosure.statistics.standard_errors import rounded

RUN = "global_sensitivity"
ENOUGH = 0.1
"""Standard error of a share that would settle it."""
SHOWN = {
    ("closure", 1): "closure, cycle 1",
    ("closure", 2): "closure, cycle 2",
    ("closure_net", 2): "net closure, cycle 2",
    ("residual_seated_net", 1): "residual closure",
    ("compliance", 1): "net compliance, cycle 1",
    ("compliance", 2): "net compliance, cycle 2",
}
"""Responses whose indices are shown."""
CASES = {
    (1, "closure"): "cycle 1",
    (1, "closure_net"): "cycle 1, net",
    (2, "closure"): "cycle 2",
    (2, "closure_net"): "cycle 2, net",
}
"""Cycle and response that conclusions are about."""
SHOWN_FROM = 0.1
"""Share of a margin's variance from which on an input is shown."""


def _indices() -> pd.DataFrame:
    """Read indices of all rows."""
    return rows_of(stored(RUN, "global_indices"), rows=MOST)


def indices(kind: str) -> str:
    """Tabulate indices ("first" or "total") of inputs."""
    table = _indices().dropna(subset=[kind]).rename(columns={"title": "of"})
    return grouped(
        titled(table, SHOWN, "response", "cycle"),
        {"input": "of"},
        across="title",
        cell=lambda part: span(part[kind], part[f"{kind}_error"]),
    )


def shapley() -> str:
    """Tabulate Shapley effects on the closures, with and without dependent inputs."""
    table = _indices()
    table = table[(table.response == "closure") & table.shapley.notna()]

    def effect(column: str, cycle: int) -> Callable:
        def cell(part: pd.DataFrame) -> str:
            part = part[part.cycle == cycle]
            return span(part[column], part[f"{column}_error"])

        return cell

    columns = {}
    for cycle in sorted(table.cycle.unique()):
        columns[f"cycle {cycle}"] = effect("shapley", cycle)
        columns[f"cycle {cycle}, E and σc correlated"] = effect("shapley_dependent", cycle)
    return grouped(table, {"input": "title"}, columns)


def rows() -> int:
    """Count rows of the design."""
    return int(_indices().rows.max())


def simulations() -> str:
    """Count the joints that were closed."""
    return f"{stored(RUN, 'global_estimate').simulations.sum():,}"


def minutes() -> str:
    """Give the processor time [min] that the jobs took."""
    return f"{origin(RUN)['cpu_minutes']:.0f}"


def largest_index() -> str:
    """List the roll-off's total index on the first closure by rock, from few to all rows."""
    return "; ".join(
        f"{rock} {', '.join(part.total.map('{:.2f}'.format))}"
        for rock, part in _of_roll_off().groupby("rock", sort=False)
    )


def fewer_rows() -> str:
    """List the numbers of rows from which indices were estimated."""
    return ", ".join(f"{count:.0f}" for count in _of_roll_off().rows.unique())


def index_error() -> str:
    """Give the largest relative error [%] of the roll-off's total index from all rows."""
    table = rows_of(_of_roll_off(), rows=MOST)
    return f"{100 * (table.total_error / table.total).max():.0f}"


def _of_roll_off() -> pd.DataFrame:
    table = rows_of(stored(RUN, "global_indices"), response="closure", cycle=1, input="roll_off")
    return table.sort_values("rows", kind="stable")


def fit_shares() -> str:
    """List what share of the variance the fitted polynomials have, by response."""
    fits = _indices().drop_duplicates(["rock", "response", "cycle"])
    return "; ".join(
        f"{title}: {part.fit_share.min():.2f} to {part.fit_share.max():.2f}"
        for title, part in titled(fits, SHOWN, "response", "cycle").groupby("title")
    )


def elasticities() -> str:
    """Tabulate elasticities of the closure by property, cycle and rock, and how they vary."""
    table = stored(RUN, "global_elasticities")
    names = stored(RUN, "global_indices").groupby("input").title.first()
    cases = {(response, cycle): f"cycle {cycle}{net}"
             for response, net in (("closure", ""), ("closure_net", ", net of bulk indentation"))
             for cycle in (1, 2)}  # fmt: skip
    table = titled(table, cases, "response", "cycle").sort_values("title", kind="stable")

    def elasticity(part: pd.DataFrame) -> str:
        row = first_row(part)
        return rounded(row.elasticity, row.elasticity_error)

    def over_noise(part: pd.DataFrame) -> str:
        return f"{part.fit_over_noise.min():.1f} to {part.fit_over_noise.max():.1f}"

    return grouped(
        table.assign(property=table.input.map(names)),
        {"property": "property", "of the closure of": "title"},
        {"varies by": lambda part: span(part.spread, part.spread_error),
         "fit over noise": over_noise},
        across="rock",
        cell=elasticity,
    )  # fmt: skip


def conclusions() -> str:
    """Tabulate shares of choices with a conclusion: the least of a rock, and in all rocks."""

    def shares(part: pd.DataFrame) -> str:
        together = part[part.rock == "all"].iloc[0]
        least = part[part.rock != "all"].sort_values("share").iloc[0]
        return f"{percents(least)}; all {percents(together)}"

    return _by_case(shares, " (%)")


def single_rows() -> str:
    """Tabulate at how many rows a conclusion is true of the row's own changes."""

    def counts(part: pd.DataFrame) -> str:
        of_rocks = part[part.rock != "all"].rows_true
        return f"{of_rocks.min()} to {of_rocks.max()}"

    return _by_case(counts)


def _by_case(cell: Callable[[pd.DataFrame], str], unit: str = "") -> str:
    """Tabulate conclusions in rows, cycles and closures that they are about in columns."""
    cases = {key: title + unit for key, title in CASES.items()}
    table = titled(stored(RUN, "global_conclusions"), cases, "cycle", "response")
    table = table.sort_values(["number", "conclusion"], kind="stable")
    return grouped(table, {"": "number", "conclusion": "conclusion"}, across="title", cell=cell)


def percents(row: pd.Series) -> str:
    """Write a share in percent, and its 95 % interval."""
    return f"{100 * row.share:.0f} ({100 * row.share_low:.0f} to {100 * row.share_high:.0f})"


def ranking() -> str:
    """Tabulate shares of the variance of a ranking's margin over the choices, by input and rock."""
    table = stored(RUN, "global_margins")
    table = table[(table.cycle == 2) & table.number.isin(["1a", "2a"])]
    table = table.sort_values(["number", "conclusion"], kind="stable")
    net = table.response.map({"closure_net": ", net"}).fillna("")
    largest = table.groupby(["number", "title"]).share.transform("max")
    return grouped(
        table.assign(of=table.rock + net)[largest >= SHOWN_FROM],
        {"": "number", "conclusion": "conclusion", "varies with": "title"},
        across="of",
        cell=lambda part: f"{part.share.iloc[0]:.2f} ± {part.share_error.iloc[0]:.2f}",
    )


def jrc_range() -> str:
    """Tabulate S/mean, median lengths and dashes at half-widths of the JRC, over rocks."""
    names = {"base": "S/mean (%)", "joint p": "p of the paper's Table 3"}
    lines = []
    for (name, cycle), group in stored("paper", "jrc_range").groupby(
        ["parameter", "cycle"], sort=False
    ):
        title = names.get(name, f"median length of {name.replace('_', ' ')}, unpaired t test (%)")
        line, dashes = {"": title, "cycle": cycle or ""}, {"": "its dashes (%)", "cycle": cycle}
        for half_width, part in group.groupby("half_width"):
            without = 100.0 * part.share_without_root
            line[_known(half_width)] = _lengths(part, digits=2 if name == "joint p" else 1)
            dashes[_known(half_width)] = f"{without.min():.0f} to {without.max():.0f}"
        lines += [line, dashes] if name in PARAMETERS else [line]
    return markdown(pd.DataFrame(lines))


def _known(half_width: float) -> str:
    return f"JRC ± {half_width:g}" if half_width else "JRC known"


def _lengths(part: pd.DataFrame, digits: int) -> str:
    """Write the least and the largest of the rocks; an infinite median is a dash, as in Table 3."""
    if len(part) == 1:
        return rounded(first_row(part).value, first_row(part).standard_error)
    known = part[np.isfinite(part.value)]
    if known.empty:
        return "–"
    text = span(known.value, known.standard_error, digits)
    return text if len(known) == len(part) else f"{text}; {len(part) - len(known)} –"


def jrc_claims() -> str:
    """Tabulate how often studies of 20 draws find claims."""
    table = stored("paper", "jrc_range_claims").dropna(subset=["found_share"])

    def share(part: pd.DataFrame) -> str:
        row = first_row(part)
        return percent_text(row.found_share, row.found_error, row.found_low, row.found_high)

    return grouped(
        table.assign(known=table.half_width.map(_known)),
        {"": "number", "claim": "claim"},
        across="known",
        cell=share,
    )


def least_certain() -> str:
    """State the share of the choices that is known least."""
    row = _least_certain()
    net = ", net of bulk indentation" if row.response.endswith("net") else ""
    share, error = 100.0 * row.share, 100.0 * row.share_error
    return f'"{row.conclusion}" on cycle {row.cycle}{net}: {share:.0f} ± {error:.0f} %'


def _least_certain() -> pd.Series:
    shares = stored(RUN, "global_conclusions")
    return shares.loc[shares.share_error.idxmax()]


def enough_rows() -> int:
    """Count the rows, doubled and doubled again, that would settle that share."""
    enough = rows()
    while _least_certain().share_error * (rows() / enough) ** 0.5 > ENOUGH:
        enough *= 2
    return enough


def hours(count: int, digits: int = 0) -> str:
    """Give the core-hours of a design of so many rows, by the estimate of this one."""
    hours_of_all = stored(RUN, "global_estimate").core_minutes.sum() / 60
    return f"{hours_of_all * count / rows():.{digits}f}"


def full_size() -> str:
    """Tabulate what the design at full size takes, by its own estimate."""
    table = stored("global_sensitivity_full", "global_estimate")
    whole = table[["simulations", "core_minutes"]].sum()
    whole = whole.to_dict() | {"rock": "all", "error": (table.error**2).sum() ** 0.5}
    columns = {
        "rock": "{rock}",
        "simulations": "{simulations:,.0f}",
        "seconds each": "{seconds:.2f}",
        "core-hours": with_error("core_minutes", "error", 1 / 60),
    }
    return listed(pd.concat([table, pd.DataFrame([whole])]), columns)

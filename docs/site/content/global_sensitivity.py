"""Tables and numbers of docs/global_sensitivity.md."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from stored import origin, stored

from content.markdown import MOST, Form, Group, Table, markdown, rows_of, titled, written
from jointclosure.config.properties import PARAMETERS
from jointclosure.plotting.global_sensitivity import SHOWN
from jointclosure.report.findings import found_text

RUN = "global_sensitivity"
ENOUGH = 0.08
"""Standard error of a share that would settle it."""
CASES = {
    (1, "max_closure"): "cycle 1",
    (1, "max_closure_net"): "cycle 1, net",
    (2, "max_closure"): "cycle 2",
    (2, "max_closure_net"): "cycle 2, net",
}
"""Cycle and response that conclusions are about."""
SHOWN_FROM = 0.1
"""Share of a margin's variance from which on an input is shown."""


def _span(name: str, digits: int = 2) -> str:
    """Form of the least and the largest value, and the largest standard error."""
    ends = f"{{{name} min:.{digits}f}} to {{{name} max:.{digits}f}}"
    return f"{ends} (± {{{name}_error max:.{digits}f}})"


def _from_all(table: pd.DataFrame) -> pd.DataFrame:
    """Choose indices from all rows but those with a failed simulation."""
    rows = table.rows + table.left_out
    return table[rows == rows.max()]


def indices(kind: str) -> str:
    """Tabulate indices ("first" or "total") of inputs."""

    def prepare(table: pd.DataFrame) -> pd.DataFrame:
        table = _from_all(table).dropna(subset=[kind])
        return titled(table.assign(of=table.title), SHOWN, "response", "cycle")

    rows = {"input": "{of}"}
    return Table(f"{RUN}/global_sensitivity_indices", {}, rows, "{title}", _span(kind), prepare)()


def _effects(table: pd.DataFrame) -> pd.DataFrame:
    """Put Shapley effects with and without dependent inputs below each other."""
    table = rows_of(_from_all(table), response="max_closure").dropna(subset=["shapley"])
    dependent = table.assign(
        shapley=table.shapley_dependent, shapley_error=table.shapley_dependent_error
    )
    parts = [table.assign(how=""), dependent.assign(how=", E and σc correlated")]
    return pd.concat(parts).sort_values("cycle", kind="stable")


shapley = Table(
    f"{RUN}/global_sensitivity_indices",
    rows={"input": "{title}"},
    across="cycle {cycle}{how}",
    cell=_span("shapley"),
    prepare=_effects,
)
elasticities = Table(
    f"{RUN}/global_sensitivity_elasticities",
    {"varies by": _span("spread"),
     "fit over noise": "{fit_over_noise min:.1f} to {fit_over_noise max:.1f}"},
    rows={"property": "{property}", "of the closure of": "{case}"},
    across="{rock}",
    cell="{elasticity±elasticity_error}",
    prepare=lambda table: table.assign(
        property=table.input.map(
            stored(RUN, "global_sensitivity_indices").groupby("input").title.first()
        ),
        case="cycle " + table.cycle.astype(str)
        + table.response.map({"max_closure": "", "max_closure_net": ", net of bulk indentation"}),
    ).dropna(subset=["case"]).sort_values(["response", "cycle"], kind="stable"),
)  # fmt: skip


def percents(row: Group) -> str:
    """Write a share in percent, and its 95 % interval."""
    value, low, high = (100 * row[f"share{part}"] for part in ("", "_low", "_high"))
    return f"{value:.0f} ({low:.0f} to {high:.0f})"


def _shares(group: Group) -> str:
    """Write the least share of a rock, and that of all rocks at once."""
    together = group.rows.rock == "all"
    least = Group(group.rows[~together].sort_values("share"))
    return f"{percents(least)}; all {percents(Group(group.rows[together]))}"


def _by_case(cell: Form, unit: str, keep: Callable = lambda table: table) -> Table:
    """Table of conclusions in rows, cycles and closures that they are about in columns."""
    cases = {key: title + unit for key, title in CASES.items()}
    return Table(
        f"{RUN}/global_sensitivity_conclusions",
        rows={"": "{number}", "conclusion": "{conclusion}"},
        across="{title}",
        cell=cell,
        prepare=lambda table: titled(keep(table), cases, "cycle", "response").sort_values(
            ["number", "conclusion"], kind="stable"
        ),
    )


conclusions = _by_case(_shares, " (%)")
single_rows = _by_case(
    "{rows_true min} to {rows_true max}", "", lambda table: table[table.rock != "all"]
)


def _rankings(table: pd.DataFrame) -> pd.DataFrame:
    """Choose margins of rankings on the second cycle, and inputs that matter to them."""
    table = table[(table.cycle == 2) & table.number.isin(["1a", "2a"])]
    largest = table.groupby(["number", "title"]).share.transform("max")
    net = table.response.map({"max_closure": "", "max_closure_net": ", net"})
    table = table.assign(of=table.rock + net)[largest >= SHOWN_FROM]
    return table.sort_values(["number", "conclusion"], kind="stable")


ranking = Table(
    f"{RUN}/global_sensitivity_margins",
    rows={"": "{number}", "conclusion": "{conclusion}", "varies with": "{title}"},
    across="{of}",
    cell="{share:.2f} ± {share_error:.2f}",
    prepare=_rankings,
)


def _known(group: Group) -> str:
    return f"JRC ± {group['half_width']:g}" if group["half_width"] else "JRC known"


def jrc_range() -> str:
    """Tabulate S/mean, median lengths and dashes at half-widths of the JRC, over rocks."""
    names = {"base": "S/mean (%)", "joint p": "p of the paper's Table 3"}
    lines = []
    table = stored("jrc_range", "jrc_range").rename(columns={"standard_error": "value_error"})
    for (name, cycle), rows in table.groupby(["parameter", "cycle"], sort=False):
        title = names.get(name, f"median length of {name.replace('_', ' ')}, unpaired t test (%)")
        line, dashes = {"": title, "cycle": cycle or ""}, {"": "its dashes (%)", "cycle": cycle}
        for _, part in rows.groupby("half_width"):
            without = 100.0 * part.share_without_root
            line[_known(Group(part))] = _lengths(part, digits=2 if name == "joint p" else 1)
            dashes[_known(Group(part))] = f"{without.min():.0f} to {without.max():.0f}"
        lines += [line, dashes] if name in PARAMETERS else [line]
    return markdown(pd.DataFrame(lines))


def _lengths(part: pd.DataFrame, digits: int) -> str:
    """Write the least and the largest of the rocks; an infinite median is a dash, as in Table 3."""
    known = part[np.isfinite(part.value)]
    if len(part) == 1 or known.empty:
        return "–" if known.empty else written("{value±value_error}", Group(part))
    dashes = "" if len(known) == len(part) else f"; {len(part) - len(known)} –"
    return written(_span("value", digits), Group(known)) + dashes


jrc_claims = Table(
    "jrc_range/jrc_range_claims",
    rows={"": "{number}", "claim": "{claim}"},
    across=_known,
    cell=found_text,
    prepare=lambda table: table.dropna(subset=["found_share"]),
)
full_size = Table(
    "global_sensitivity_full/global_sensitivity_estimate",
    {
        "rock": "{job}",
        "simulations": "{joints:,.0f}",
        "seconds each": "{each:.2f}",
        "core-hours": "{hours±error}",
    },
    prepare=lambda table: _with_sum(
        table.assign(
            hours=table.seconds / 3600, error=table.error / 3600, each=table.seconds / table.joints
        )
    ),
)


def _with_sum(table: pd.DataFrame) -> pd.DataFrame:
    """Add a row of all rocks."""
    whole = table[["joints", "hours"]].sum().to_dict()
    whole |= {"job": "all", "error": (table.error**2).sum() ** 0.5}
    return pd.concat([table, pd.DataFrame([whole])])


def rows() -> int:
    """Count rows of the design."""
    return int(stored(RUN, "global_sensitivity_indices").rows.max())


def simulations() -> str:
    """Count the joints that were closed."""
    return f"{stored(RUN, 'global_sensitivity_estimate').joints.sum():,}"


def minutes() -> str:
    """Give the processor time [min] that the jobs took."""
    return f"{origin(RUN)['cpu_minutes']:.0f}"


def _of_largest() -> pd.DataFrame:
    """Choose the total indices on the first closure of the input with the largest one."""
    table = stored(RUN, "global_sensitivity_indices").sort_values("rows", kind="stable")
    table = rows_of(table[table.input != "surfaces"], response="max_closure", cycle=1)
    return table[table.input == table.loc[_from_all(table).total.idxmax()].input]


def largest_input() -> str:
    """Name the input with the largest total index on the first closure."""
    return _of_largest().title.iloc[0]


def largest_index() -> str:
    """List the largest total index on the first closure by rock, from few to all rows."""
    rocks = stored(RUN, "global_sensitivity_estimate").job
    totals = [rows_of(_of_largest(), rock=rock).total.map("{:.2f}".format) for rock in rocks]
    return "; ".join(f"{rock} {', '.join(of)}" for rock, of in zip(rocks, totals, strict=True))


def fewer_rows() -> str:
    """List the numbers of rows from which indices were estimated."""
    return ", ".join(f"{count:.0f}" for count in _of_largest().rows.unique())


def index_error() -> str:
    """Give the largest relative error [%] of that index from all rows."""
    table = _from_all(_of_largest())
    return f"{100 * (table.total_error / table.total).max():.0f}"


def fit_shares() -> str:
    """List what share of the variance the fitted polynomials have, by response."""
    fits = titled(_from_all(stored(RUN, "global_sensitivity_indices")), SHOWN, "response", "cycle")
    return "; ".join(
        f"{title}: {part.fit_share.min():.2f} to {part.fit_share.max():.2f}"
        for title, part in fits.groupby("title")
    )


def least_certain() -> str:
    """State the share of the choices that is known least."""
    row = Group(rows_of(stored(RUN, "global_sensitivity_conclusions"), share_error=MOST))
    net = ", net of bulk indentation" * row["response"].endswith("net")
    share = f"{100 * row['share']:.0f} ± {100 * row['share_error']:.0f} %"
    return f'"{row["conclusion"]}" on cycle {row["cycle"]}{net}: {share}'


def enough_rows() -> int:
    """Count the rows, doubled and doubled again, that would settle that share."""
    enough, error = rows(), stored(RUN, "global_sensitivity_conclusions").share_error.max()
    while error * (rows() / enough) ** 0.5 > ENOUGH:
        enough *= 2
    return enough


def hours(count: int, digits: int = 0) -> str:
    """Give the core-hours of a design of so many rows, by the estimate of this one."""
    hours_of_all = stored(RUN, "global_sensitivity_estimate").seconds.sum() / 3600
    return f"{hours_of_all * count / rows():.{digits}f}"

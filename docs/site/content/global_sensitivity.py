"""Tables and numbers of docs/global_sensitivity.md."""

import numpy as np
import pandas as pd
from stored import origin, stored

from content.markdown import Group, Table, markdown, rows_of, titled, written
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.standard_errors import rounded
from studies.global_sensitivity.figures import SHOWN

RUN = "global_sensitivity"
LEAST_SHOWN = 0.02
"""Share of the variance below which, with two standard errors, none is shown."""
CASES = {
    (1, "max_closure"): "cycle 1",
    (1, "max_closure_net"): "cycle 1, net",
    (2, "max_closure"): "cycle 2",
    (2, "max_closure_net"): "cycle 2, net",
}
"""Cycle and response that conclusions are about."""


def _span(name: str, digits: int = 2) -> str:
    """Form of the least and the largest value, and the largest standard error."""
    ends = f"{{{name} min:.{digits}f}} to {{{name} max:.{digits}f}}"
    return f"{ends} (± {{{name}_error max:.{digits}f}})"


def _from_all(table: pd.DataFrame) -> pd.DataFrame:
    """Choose indices from all rows but those with a failed simulation."""
    rows = table.rows + table.left_out
    return table[rows == rows.max()]


def _total(group: Group) -> str:
    """Write the total indices of the rocks, unless they are all below `LEAST_SHOWN`."""
    small = (group.rows.total + 2.0 * group.rows.total_error).max() < LEAST_SHOWN
    return "–" if small else written(_span("total"), group)


indices = Table(
    f"{RUN}/global_sensitivity_indices",
    rows={"input": "{of}"},
    across="{title}",
    cell=_total,
    prepare=lambda table: titled(
        _from_all(table).dropna(subset=["total"]).assign(of=lambda rows: rows.title),
        SHOWN,
        "response",
        "cycle",
    ),
)
elasticities = Table(
    f"{RUN}/global_sensitivity_elasticities",
    {
        "varies by": _span("spread"),
        "fit over noise": "{fit_over_noise min:.1f} to {fit_over_noise max:.1f}",
    },
    rows={"property": "{property}", "cycle": "{cycle}"},
    across="{rock}",
    cell="{elasticity±elasticity_error}",
    prepare=lambda table: rows_of(table, response="max_closure").assign(
        property=table.input.map(
            stored(RUN, "global_sensitivity_indices").groupby("input").title.first()
        )
    ),
)


def percents(row: Group) -> str:
    """Write a share in percent, and its 95 % interval."""
    value, low, high = (100 * row[f"share{part}"] for part in ("", "_low", "_high"))
    return f"{value:.0f} ({low:.0f} to {high:.0f})"


def _shares(group: Group) -> str:
    """Write the least share of a rock, and that of all rocks at once."""
    together = group.rows.rock == "all"
    least = Group(group.rows[~together].sort_values("share"))
    return f"{percents(least)}; all {percents(Group(group.rows[together]))}"


conclusions = Table(
    f"{RUN}/global_sensitivity_conclusions",
    rows={"": "{number}", "conclusion": "{conclusion}"},
    across="{title} (%)",
    cell=_shares,
    prepare=lambda table: titled(table, CASES, "cycle", "response").sort_values(
        ["number", "conclusion"], kind="stable"
    ),
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
        lines += [line, dashes] if name in PROPERTIES else [line]
    return markdown(pd.DataFrame(lines))


def _lengths(part: pd.DataFrame, digits: int) -> str:
    """Write the least and the largest of the rocks; an infinite median is a dash, as in Table 3."""
    known = part[np.isfinite(part.value)]
    if len(part) == 1 or known.empty:
        return "–" if known.empty else written("{value±value_error}", Group(part))
    dashes = "" if len(known) == len(part) else f"; {len(part) - len(known)} –"
    return written(_span("value", digits), Group(known)) + dashes


def rows() -> int:
    """Count rows of the design."""
    return int(stored(RUN, "global_sensitivity_indices").rows.max())


def simulations() -> str:
    """Count the joints that were closed."""
    return f"{stored(RUN, 'global_sensitivity_estimate').joints.sum():,}"


def minutes() -> str:
    """Give the processor time [min] that the jobs took."""
    return f"{origin(RUN)['cpu_minutes']:.0f}"


def hours() -> str:
    """Give the core-hours of the design at full size, by its estimate."""
    table = stored("global_sensitivity_full", "global_sensitivity_estimate")
    return rounded(table.seconds.sum() / 3600.0, (table.error**2).sum() ** 0.5 / 3600.0)

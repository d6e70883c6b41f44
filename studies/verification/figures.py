"""One page with the closure curves of all hard cases."""

from textwrap import fill

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from jointclosure.plotting.style import styled, subplots
from studies.frame.panels import key, legend_below, point_key

COLUMNS = 10
METHODS = {"fixed_step": ("#0072b2", "-"), "resolved": ("#000000", "--")}
MARKS = {
    "holds": "#009e73",
    "holds, with a remark": "#e6a700",
    "holds: refused, or fails by name as it must": "#8c8c8c",
    "does not hold": "#d62728",
}
_METRES, _PASCALS = EngFormatter("m", places=1), EngFormatter("Pa", places=1)


@styled
def hard_case_page(table: pd.DataFrame, curves: pd.DataFrame) -> Figure:
    """Draw the closure curves of all hard cases, with different scales."""
    table = table.assign(panel=table.name.str.removesuffix("_resolved"))
    panels = list(dict.fromkeys(table.panel))
    rows = -(-len(panels) // COLUMNS)
    figure, grid = subplots(rows, COLUMNS, figsize=(2.1 * COLUMNS, 1.75 * rows + 1.4))
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    for axes, panel in zip(grid.flat, panels, strict=False):
        _draw(axes, panel, table[table.panel == panel], curves)
    figure.suptitle(
        f"{int(table.holds.sum())} of {len(table)} hard cases hold\n"
        "nominal stress over closure, all cycles, with different scales in the panels; "
        "text: largest closure and stress, or the status of a case without a curve",
        fontsize=15,
    )
    keys = [point_key(name, "s", ms=10, color=colour) for name, colour in MARKS.items()]
    for name, (colour, style) in METHODS.items():
        without = ", or none" if name == "fixed_step" else ""
        keys.append(key(f"breakage: {name}{without}", color=colour, ls=style))
    legend_below(figure, keys, 6, fontsize=12)
    return figure


def _draw(axes, panel: str, rows: pd.DataFrame, curves: pd.DataFrame) -> None:
    for place, row in enumerate(rows.itertuples()):
        colour, style = METHODS["resolved" if row.name != panel else "fixed_step"]
        curve = curves[curves.case == row.name]
        text = row.status.replace("_", " ")
        if len(curve) > 1:
            axes.plot(curve.closure_m, curve.normal_stress_Pa, style, color=colour, lw=0.8)
            text = f"{_METRES(curve.closure_m.max())}, {_PASCALS(curve.normal_stress_Pa.max())}"
        height, on = 0.91 - 0.13 * place, {"transform": axes.transAxes}
        axes.plot(0.05, height, "s", ms=7, color=MARKS[_mark(row)], zorder=5, **on)
        axes.text(0.1, height, text, color=colour, va="center", fontsize=7, **on)
    axes.set(xticks=[], yticks=[])
    axes.margins(x=0.06, y=0.12)
    axes.set_title(fill(panel.replace("_", " "), 30), fontsize=8)


def _mark(row) -> str:
    if not row.holds:
        return "does not hold"
    if row.status == "success":
        return "holds"
    if row.status in ("target_jumped", "outside_model_range", "target_jumped outside_model_range"):
        return "holds, with a remark"
    return "holds: refused, or fails by name as it must"

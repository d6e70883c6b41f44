"""One page with the closure curves of all hard cases."""

from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
import seaborn as sns
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


FLOOR, CEILING = 1e-17, 1e2
"""Errors beyond are drawn here: none at all in double precision, or formulas without a number."""

_OURS, _PRINTED = "C0", ("C3", "C1", "C4")
_PANELS = {
    "cubic": ("stiffness ratio g = γ δ$_S^{1/2}$", "error of δ$_a$, Eqs. (11), (13)"),
    "far field": ("distance ζ/r", "error of the displacement, Eq. (17)"),
    "quartic": ("half range of the levels / p$_M$", "error of the interval's length, Eq. (29)"),
    "convergence": ("sweeps, or products with the interaction", "residual of equilibrium"),
}
_TITLES = {
    "cubic": "one contact",
    "far field": "interaction",
    "quartic": "indifference interval",
    "convergence": "1024 polished cells in touch, r = h",
}
_LEGENDS: dict[str, dict[str, Any]] = {
    "cubic": {"loc": "center right", "bbox_to_anchor": (1.0, 0.6)},
    "far field": {"loc": "center left", "bbox_to_anchor": (0.03, 0.75)},
    "quartic": {"loc": "center left", "bbox_to_anchor": (0.03, 0.45)},
    "convergence": {"loc": "lower left"},
}


@styled
def numerics_figure(numerics: pd.DataFrame) -> Figure:
    """Draw errors against 50 digits, and the sweep against the fast solver."""
    figure, panels = subplots(2, 2, figsize=(11.0, 8.6))
    for axes, (subject, (at, error)) in zip(panels.flat, _PANELS.items(), strict=True):
        part = numerics[numerics.subject == subject]
        if subject == "convergence":
            _draw_convergence(axes, part)
        else:
            _draw_errors(axes, part)
        axes.set(xscale="log", yscale="log", ylim=(0.4 * FLOOR, 2.5 * CEILING))
        axes.set(xlabel=at, ylabel=error, title=_TITLES[subject])
        powers = np.arange(-17, 3, 3)
        labels = [f"$10^{{{power}}}$" for power in powers]
        if subject != "convergence":
            labels[0] = f"$\\leq{labels[0][1:]}"
            rounding = {"ls": (0, (4, 3)), "label": "rounding of one number, $2^{-52}$"}
            axes.axhline(np.finfo(float).eps, color="0.6", lw=0.9, zorder=0, **rounding)
        axes.set_yticks(10.0**powers, labels)
        axes.minorticks_off()
        axes.legend(frameon=False, fontsize=8, **_LEGENDS[subject])
    sns.despine(figure)
    return figure


def _draw_errors(axes, part: pd.DataFrame) -> None:
    printed, fill = iter(_PRINTED), iter((_OURS, "none"))
    for name, series in part.groupby("series", sort=False):
        error = np.clip(series["error"].to_numpy(), FLOOR, CEILING)
        if name.startswith("jointclosure"):
            style = {"color": _OURS, "marker": "o", "ms": 3.0, "lw": 0.8, "mfc": next(fill)}
        else:
            style = {"color": next(printed), "marker": ".", "ms": 4.0, "lw": 1.2}
        axes.plot(series["at"], error, label=name, **style)
    if (part["error"] > CEILING).any():
        style = {"transform": axes.get_yaxis_transform(), "fontsize": 7.5, "color": "0.4"}
        axes.text(0.02, 0.1 * CEILING, "on top: larger, or no number", **style)


def _draw_convergence(axes, part: pd.DataFrame) -> None:
    stop = {"color": _PRINTED[0], "marker": "X", "ms": 10, "ls": ""}
    styles = {
        "all contacts at once": {"color": _PRINTED[1], "lw": 0.6},
        "contact by contact": {"color": _PRINTED[0], "lw": 1.6},
        "contact by contact, stopped at 1 %": stop,
        "jointclosure": {"color": _OURS, "marker": "o", "ms": 4.0, "lw": 1.2},
    }
    for name, style in styles.items():
        series = part[part.series == name]
        axes.plot(series["at"], np.clip(series["error"], FLOOR, CEILING), label=name, **style)

"""The figure of numerical stability: errors and convergence in, a figure out."""

from typing import Any

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.figure import Figure

from jointclosure.plotting.style import styled, subplots

FLOOR = 1e-17
"""Errors below are drawn here: no error at all, in double precision."""
CEILING = 1e2
"""Errors above are drawn here, and formulas that gave no number."""

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
    """Errors against 50 digits, and the sweep against the fast solver.

    Parameters
    ----------
    numerics : DataFrame
        Columns subject (cubic, far field, quartic, convergence), series, at
        and error (relative; infinite where there is no number).

    Notes
    -----
    Axes end at `FLOOR` and `CEILING`; what lies beyond is drawn on them.
    """
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
            axes.axhline(
                np.finfo(float).eps,
                color="0.6",
                lw=0.9,
                ls=(0, (4, 3)),
                zorder=0,
                label="rounding of one number, $2^{-52}$",
            )
        axes.set_yticks(10.0**powers, labels)
        axes.minorticks_off()
        axes.legend(frameon=False, fontsize=8, **_LEGENDS[subject])
    sns.despine(figure)
    return figure


def _draw_errors(axes, part: pd.DataFrame) -> None:
    printed = iter(_PRINTED)
    ours = 0
    for name, series in part.groupby("series", sort=False):
        error = np.clip(series["error"].to_numpy(), FLOOR, CEILING)
        if name.startswith("jointclosure"):
            style = {"color": _OURS, "marker": "o", "ms": 3.0, "lw": 0.8}
            style["mfc"] = "none" if ours else _OURS
            ours += 1
        else:
            style = {"color": next(printed), "marker": ".", "ms": 4.0, "lw": 1.2}
        axes.plot(series["at"], error, label=name, **style)
    if (part["error"] > CEILING).any():
        axes.text(
            0.02,
            0.1 * CEILING,
            "on top: larger, or no number",
            transform=axes.get_yaxis_transform(),
            fontsize=7.5,
            color="0.4",
        )


def _draw_convergence(axes, part: pd.DataFrame) -> None:
    styles = {
        "all contacts at once": {"color": _PRINTED[1], "lw": 0.6},
        "contact by contact": {"color": _PRINTED[0], "lw": 1.6},
        "contact by contact, stopped at 1 %": {
            "color": _PRINTED[0],
            "marker": "X",
            "ms": 10,
            "ls": "",
        },
        "jointclosure": {"color": _OURS, "marker": "o", "ms": 4.0, "lw": 1.2},
    }
    for name, style in styles.items():
        series = part[part.series == name]
        axes.plot(series["at"], np.clip(series["error"], FLOOR, CEILING), label=name, **style)

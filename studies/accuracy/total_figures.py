"""Work-precision diagram: total error over core-minutes, for every method."""

import pandas as pd
import seaborn as sns
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.plotting.style import (
    decimal_ticks,
    key,
    legend_below,
    panel_grid,
    styled,
    ticks_at,
)
from jointclosure.statistics.total_error import front

_TITLES = {"mean": "Mean closure", "interval": "Indifference interval"}
_NAMES = {
    "elastic": "elastic model",
    "paper": "the paper's steps",
    "quick": "preset quick",
    "accurate": "preset accurate",
}
_RANGE = (0.3, 1000.0)
"""Range of errors [%], the same in every panel."""
_MARKED = (2, 20, 200, 2000)
"""Numbers of surfaces that are marked on solid lines."""


@styled
def total_error_figure(points: pd.DataFrame) -> Figure:
    """Draw total error over core-minutes, with a panel for each response and cycle.

    Parameters
    ----------
    points : DataFrame
        As from `studies.accuracy.total.point_table`.

    Notes
    -----
    A line is a method with an increasing number of surfaces; with control variates (dashed) it
    has the best number of measured surfaces at each time. Grey is the Pareto front, the smallest
    error at each time. A method without any split within the range of the axis is named in the
    title of the panel.
    """
    shown = list(points.groupby(["response", "cycle"], sort=False))
    methods = list(points.method.unique())
    colours = dict(zip(methods, sns.color_palette("colorblind", len(methods)), strict=True))
    figure, panels = panel_grid(1, len(shown), (2.9, 3.4), (0.4, 0.6), sharex=True, sharey=True)
    for axes, ((response, cycle), part) in zip(panels[0], shown, strict=True):
        _style(axes, points)
        missing = _draw(axes, part, colours, _RANGE[1])
        names = ", ".join(_NAMES.get(name, name) for name in missing)
        beyond = f"\n({names}: beyond {_RANGE[1]:g} %)" if missing else ""
        axes.set_title(f"{_TITLES[response]}, cycle {cycle}{beyond}", fontsize="medium")
        axes.set_xlabel("core-minutes")
    panels[0, 0].set_ylabel("total error (%)")
    legend_below(figure, _key(colours), 3)
    sns.despine(figure)
    return figure


def _draw(axes: Axes, part: pd.DataFrame, colours: dict, most: float) -> list[str]:
    """Draw lines of a panel up to an error [%], and return the methods that are beyond it."""
    shown = part[part.total_percent <= most]
    best = shown[shown.best].sort_values("core_minutes")
    axes.plot(
        best.core_minutes, best.total_percent, color="0.75", lw=6, alpha=0.7, zorder=0,
        drawstyle="steps-post",
    )  # fmt: skip
    missing = []
    for method, colour in colours.items():
        line_of_method = shown[shown.method == method]
        if line_of_method.empty and (part.method == method).any():
            missing.append(method)
        for adjusted, line in line_of_method.groupby("control_variates"):
            kept = front(line.core_minutes.to_numpy(), line.total_percent.to_numpy())
            line = line.iloc[kept]
            axes.plot(
                line.core_minutes, line.total_percent, color=colour, lw=1.4,
                ls="--" if adjusted else "-",
            )  # fmt: skip
            if not adjusted:
                marked = _nearest(line)
                axes.plot(marked.core_minutes, marked.total_percent, "o", color=colour, ms=4)
    return missing


def _nearest(line: pd.DataFrame) -> pd.DataFrame:
    """Return points of a line nearest to the marked numbers of surfaces."""
    near = [(line.surfaces / count - 1.0).abs() for count in _MARKED]
    return line.loc[[off.idxmin() for off in near if off.min() < 0.15]]


def _style(axes: Axes, points: pd.DataFrame) -> None:
    axes.set(xscale="log", yscale="log", ylim=_RANGE)
    axes.set_xlim(0.8 * points.core_minutes.min(), 2000.0)
    decimal_ticks(axes.xaxis, subs=(1.0,), numticks=6)
    ticks_at(axes.yaxis, [0.3, 1, 3, 10, 30, 100, 300, 1000])


def _key(colours: dict) -> list[Artist]:
    """Return entries of the legend, outside of the panels."""
    lines = [key(color=colour, label=_NAMES.get(name, name)) for name, colour in colours.items()]
    marks = ", ".join(f"{count:g}" for count in _MARKED)
    return [
        *lines,
        key(color="0.3", ls="--", label="with control variates"),
        key(color="0.3", marker="o", ms=4, ls="", label=f"{marks} surfaces"),
        key(color="0.75", lw=6, alpha=0.7, label="smallest error at each time"),
    ]

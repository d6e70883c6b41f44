"""The work-precision diagram: total error against core-minutes, for every way to a result."""

import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, StrMethodFormatter

from jointclosure.plotting.style import styled, subplots
from jointclosure.statistics.total_error import front

_TITLES = {"mean": "Mean closure", "interval": "Indifference interval"}
_LEAST, _MOST = 0.3, 100.0
"""Range of errors [%] that is drawn."""
_MARKED = (2, 20, 200, 2000)
"""Surfaces that are marked on plain lines."""


@styled
def total_error_figure(points: pd.DataFrame) -> Figure:
    """Total error against core-minutes, a panel for each response and cycle.

    Parameters
    ----------
    points : DataFrame
        As from `jointclosure.studies.accuracy.total.point_table`.

    Notes
    -----
    A line is a method, with more and more surfaces; of those with control variates (dashed), the
    best number of measured surfaces at each time. Grey: what no way beats in both, the best split
    of each budget. A method of which no split is within the range of the axis is named in the
    title of the panel.
    """
    responses, cycles = points.response.unique(), sorted(points.cycle.unique())
    methods = list(points.method.unique())
    colours = dict(zip(methods, sns.color_palette("colorblind", len(methods)), strict=True))
    figure, panels = subplots(
        len(responses),
        len(cycles),
        figsize=(4.4 * len(cycles), 3.3 * len(responses) + 0.9),
        layout="constrained",
        sharex=True,
        sharey=True,
        squeeze=False,
    )
    for row, response in zip(panels, responses, strict=True):
        for axes, cycle in zip(row, cycles, strict=True):
            part = points[(points.response == response) & (points.cycle == cycle)]
            missing = _draw(axes, part, colours)
            title = f"{_TITLES[response]}, cycle {cycle}"
            beyond = f"\n(beyond {_MOST:g} %: {', '.join(missing)})" if missing else ""
            axes.set_title(title + beyond)
    for axes in panels[-1]:
        axes.set_xlabel("core-minutes")
    for row in panels:
        row[0].set_ylabel("total error (%)")
    _style(panels[0, 0], points)
    figure.legend(handles=_key(colours), loc="outside lower center", ncols=4, frameon=False)
    sns.despine(figure)
    return figure


def _draw(axes: Axes, part: pd.DataFrame, colours: dict) -> list[str]:
    """Lines of a panel; the methods that are not in its range."""
    best = part[part.best].sort_values("core_minutes")
    axes.plot(
        best.core_minutes, best.total_percent, color="0.75", lw=6, alpha=0.7, zorder=0,
        drawstyle="steps-post",
    )  # fmt: skip
    missing = []
    for method, colour in colours.items():
        own = part[part.method == method]
        if own.empty:
            continue
        if own.total_percent.min() > _MOST:
            missing.append(method)
            continue
        for adjusted, line in own.groupby("control_variates"):
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
    """Points of a line that are nearest to the numbers of surfaces that are marked."""
    return line.loc[[(line.surfaces - count).abs().idxmin() for count in _MARKED]]


def _style(axes: Axes, points: pd.DataFrame) -> None:
    axes.set(xscale="log", yscale="log", ylim=(_LEAST, _MOST))
    axes.set_xlim(0.8 * points.core_minutes.min(), 2000.0)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_major_locator(FixedLocator([0.3, 1, 3, 10, 30, 100]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def _key(colours: dict) -> list[Line2D]:
    """Entries of the key, outside of the panels."""
    entries = [Line2D([], [], color=colour, label=name) for name, colour in colours.items()]
    marks = ", ".join(f"{count:g}" for count in _MARKED)
    return [
        *entries,
        Line2D([], [], color="0.3", ls="--", label="with control variates"),
        Line2D([], [], color="0.3", marker="o", ms=4, ls="", label=f"{marks} surfaces"),
        Line2D([], [], color="0.75", lw=6, alpha=0.7, label="best split of the budget"),
    ]

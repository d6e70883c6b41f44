"""Figures of the change of closure due to each effect, and its cost in time."""

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from jointclosure.parameters import AUTO_TOLERANCE
from jointclosure.plotting.style import decimal_ticks, panel_grid, styled
from studies.frame.panels import key, legend_below, point_key

_FLOOR = 0.1
_WIDE = 5.0
"""Ratio of times above which an axis has room for only few labels."""


@styled
def effect_figure(table: pd.DataFrame) -> Figure:
    """Draw the change of the maximum closure due to each effect over its time.

    There is a column for each effect and a row for each cycle. A mark for each roughness (size)
    and stress (colour) is the median over the rocks, with a line from the smallest to the largest
    change. Changes below a tenth of a percent are drawn there.
    """
    shown = _over_rocks(table)
    effects, cycles = table.effect.unique(), sorted(table.cycle.unique())
    figure, panels = panel_grid(len(cycles), len(effects), (2.7, 2.9), (1.6, 0.6), sharey=True)
    norm = LogNorm(table.stress_MPa.min(), table.stress_MPa.max())
    for row, cycle in zip(panels, cycles, strict=True):
        for axes, effect in zip(row, effects, strict=True):
            part = shown[(shown.cycle == cycle) & (shown.effect == effect)]
            axes.vlines(part.time_ratio, part.least, part.most, color="0.8", lw=0.8, zorder=1)
            marks = axes.scatter(
                part.time_ratio,
                part.change,
                s=_mark_size(part.jrc),
                c=part.stress_MPa,
                norm=norm,
                cmap="viridis",
                edgecolors="w",
                linewidths=0.5,
                zorder=2,
            )
            axes.axvline(1.0, color="0.8", lw=0.8, zorder=0)
            axes.axhline(100.0 * AUTO_TOLERANCE, color="0.5", lw=0.8, ls="--", zorder=0)
            axes.set(xscale="log", yscale="log")
            for axis in (axes.xaxis, axes.yaxis):
                decimal_ticks(axis, subs=(1.0,), numticks=5)
        row[0].set_ylabel(f"size of the change of\nmax. closure, cycle {cycle} (%)")
    for axes, effect in zip(panels[0], effects, strict=True):
        axes.set_title(effect.replace("_", " "))
    for axes in panels[-1]:
        axes.set_xlabel("time with / without")
    for axes in panels.ravel():
        low, high = axes.get_xlim()
        labelled = (1.0, 3.0) if high / low > _WIDE else (1.0, 1.5, 2.0, 3.0, 7.0)
        axes.xaxis.set_major_locator(LogLocator(subs=labelled))
    figure.colorbar(marks, ax=panels, label="maximum stress (MPa)", shrink=0.7)
    handles = [
        point_key(f"JRC {jrc:g}", color="0.4", ms=np.sqrt(_mark_size(jrc)))
        for jrc in sorted(table.jrc.unique())
    ]
    handles.append(key(color="0.8", lw=0.8, label="least to largest of the rocks"))
    tolerance = f"tolerance of effects: auto, {100.0 * AUTO_TOLERANCE:g} %"
    handles.append(key(color="0.5", lw=0.8, ls="--", label=tolerance))
    legend_below(figure, handles)
    sns.despine(figure)
    return figure


def _mark_size(jrc):
    """Return the area of a mark [points squared]."""
    return 8.0 + 4.0 * jrc


def _over_rocks(table: pd.DataFrame) -> pd.DataFrame:
    """Return median, smallest and largest time ratio and change [%] over the rocks."""
    size = table.max_closure_added_percent.abs().clip(lower=_FLOOR)
    about = ["effect", "cycle", "jrc", "stress_MPa"]
    grouped = table.assign(size=size).groupby(about, sort=False)
    return grouped.agg(
        time_ratio=("time_ratio", "median"),
        change=("size", "median"),
        least=("size", "min"),
        most=("size", "max"),
    ).reset_index()

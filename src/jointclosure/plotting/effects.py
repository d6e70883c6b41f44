"""What each effect adds to closure, against what it costs in time."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

_FLOOR = 0.1
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")


def effect_figure(table: pd.DataFrame) -> Figure:
    """Change of the maximum closure by each effect, against the time that it takes.

    Parameters
    ----------
    table : DataFrame
        As from `jointclosure.study.ablation.effect_table`.

    Notes
    -----
    A column for each effect, a row for each cycle, a mark for each condition:
    its colour is the stress, its size the roughness, its shape the rock. Changes
    below a tenth of a percent are drawn there.
    """
    effects, cycles = table.effect.unique(), sorted(table.cycle.unique())
    figure, panels = plt.subplots(
        len(cycles),
        len(effects),
        figsize=(2.7 * len(effects) + 1.6, 2.9 * len(cycles) + 0.6),
        layout="constrained",
        sharey=True,
        squeeze=False,
    )
    norm = LogNorm(table.stress_MPa.min(), table.stress_MPa.max())
    markers = dict(zip(table.rock.unique(), _MARKERS, strict=False))
    for row, cycle in zip(panels, cycles, strict=True):
        for axes, effect in zip(row, effects, strict=True):
            part = table[(table.cycle == cycle) & (table.effect == effect)]
            for rock, points in part.groupby("rock", sort=False):
                marks = axes.scatter(
                    points.time_ratio,
                    points.max_closure_added_percent.abs().clip(lower=_FLOOR),
                    s=8.0 + 3.0 * points.jrc,
                    c=points.stress_MPa,
                    norm=norm,
                    cmap="viridis",
                    marker=markers[rock],
                    alpha=0.8,
                    linewidths=0,
                )
            axes.axvline(1.0, color="0.8", lw=0.8, zorder=0)
            axes.axhline(1.0, color="0.8", lw=0.8, zorder=0)
            axes.set(xscale="log", yscale="log")
        row[0].set_ylabel(f"change of max. closure\nof cycle {cycle} (%)")
    for axes, effect in zip(panels[0], effects, strict=True):
        axes.set_title(effect.replace("_", " "))
    for axes in panels[-1]:
        axes.set_xlabel("time with / without")
    figure.colorbar(marks, ax=panels, label="maximum stress (MPa)", shrink=0.7)
    handles = [
        plt.Line2D([], [], ls="", marker=marker, color="0.4", label=rock.replace("_", " "))
        for rock, marker in markers.items()
    ]
    low, high = np.nanmin(table.jrc), np.nanmax(table.jrc)
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=len(handles),
        frameon=False,
        title=f"size: JRC {low:g} to {high:g}",
    )
    sns.despine(figure)
    return figure

"""What each effect adds to closure, against what it costs in time."""

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from jointclosure.parameters import Effects, scene_name
from jointclosure.plotting.style import styled, subplots

_FLOOR = 0.1
_LEAST_ERROR = 0.01
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")


@styled
def effect_figure(table: pd.DataFrame) -> Figure:
    """Change of the maximum closure by each effect, against the time that it takes.

    Parameters
    ----------
    table : DataFrame
        As from `jointclosure.studies.effects.ablation.effect_table`.

    Notes
    -----
    A column for each effect, a row for each cycle, a mark for each condition:
    its colour is the stress, its size the roughness, its shape the rock. Changes
    below a tenth of a percent are drawn there.
    """
    effects, cycles = table.effect.unique(), sorted(table.cycle.unique())
    figure, panels = subplots(
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
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_locator(LogLocator(numticks=5))
                axis.set_major_formatter(StrMethodFormatter("{x:g}"))
                axis.set_minor_formatter(NullFormatter())
        row[0].set_ylabel(f"change of max. closure\nof cycle {cycle} (%)")
    for axes, effect in zip(panels[0], effects, strict=True):
        axes.set_title(effect.replace("_", " "))
    for axes in panels[-1]:
        axes.set_xlabel("time with / without")
    figure.colorbar(marks, ax=panels, label="maximum stress (MPa)", shrink=0.7)
    handles = [
        Line2D([], [], ls="", marker=marker, color="0.4", label=rock.replace("_", " "))
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


@styled
def choice_figure(table: pd.DataFrame) -> Figure:
    """Error of the selected effects against stress, and the time that the selection saves.

    Parameters
    ----------
    table : DataFrame
        Rows as from `jointclosure.studies.effects.validation.validate`.

    Notes
    -----
    A column for each tolerance. Grey conditions run every effect, and lose the time of the
    pilot only; errors below a hundredth of a percent are drawn there.
    """
    tolerances = sorted(table.tolerance.unique())
    figure, panels = subplots(
        2,
        len(tolerances),
        figsize=(3.2 * len(tolerances) + 1.4, 5.6),
        layout="constrained",
        sharex=True,
        sharey="row",
        squeeze=False,
    )
    names = sorted(table.chosen.unique(), key=lambda name: -name.count("-"))
    everything = scene_name(Effects())
    colours = dict(zip(names, sns.color_palette("colorblind", len(names)), strict=True))
    colours[everything] = "0.7"
    for (upper, lower), tolerance in zip(panels.T, tolerances, strict=True):
        part = table[table.tolerance == tolerance]
        for name in names:
            points = part[part.chosen == name]
            stress = 1e-6 * points.max_normal_stress
            off = points.actual_percent.clip(lower=_LEAST_ERROR)
            upper.plot(stress, off, "o", color=colours[name], ms=4)
            lower.plot(stress, points.saved_percent, "o", color=colours[name], ms=4)
        upper.axhline(100.0 * tolerance, color="0.1", lw=0.8)
        upper.set(title=f"tolerance {100.0 * tolerance:g} %", xscale="log", yscale="log")
        lower.axhline(0.0, color="0.8", lw=0.8, zorder=0)
        lower.set(xscale="log", xlabel="maximum normal stress (MPa)")
        for axis in (upper.yaxis, lower.xaxis):
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        lower.set_ylim(bottom=max(-100.0, table.saved_percent.min() - 5.0), top=105.0)
    panels[0, 0].set_ylabel("change of mean\nmax. closure (%)")
    panels[1, 0].set_ylabel("time saved,\npilot counted (%)")
    handles = [
        Line2D([], [], ls="", marker="o", color=colours[name], label=_left_out(name))
        for name in names
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    sns.despine(figure)
    return figure


def _left_out(scene: str) -> str:
    """What a scene goes without, in words."""
    full, left = scene_name(Effects()).split("-"), scene.split("-")
    missing = [name for name in full if name not in left]
    words = " or ".join(name.replace("_", " ") for name in missing)
    return f"without {words}" if missing else "all effects"

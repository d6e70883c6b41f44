"""Figures of the change of closure due to each effect, and its cost in time."""

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, StrMethodFormatter

from jointclosure.parameters import AUTO_TOLERANCE, Effects, scene_name
from jointclosure.plotting.style import decimal_ticks, panel_grid, styled
from studies.frame.panels import key, legend_below, point_key, ticks_at

_FLOOR = 0.1
_WIDE = 5.0
"""Ratio of times above which an axis has room for only few labels."""
_LEAST_ERROR = 0.01
_JOINTS = 180
"""Number of joints of the selections that are drawn."""


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


@styled
def region_figure(table: pd.DataFrame) -> Figure:
    """Draw the error made without each effect over the stress, relative to the rock's strength.

    There is a panel for each effect, and a point for each random condition, with its roughness as
    colour and its ratio of modulus to strength as marker. Shaded bands, named in each panel, are
    the errors below the tolerances of the table. Errors below the axis are drawn at its lower end.
    Conditions at which simulations without the effect fail are marked at its upper end.
    """
    points = table.drop_duplicates("scene")
    tolerances = 100.0 * np.sort(table.tolerance.unique())
    figure, panels = panel_grid(2, 2, (3.3, 2.6), (1.1, 0.7), sharex=True, sharey=True)
    for axes, effect in zip(panels.ravel(), _REGIONS, strict=True):
        marks = _draw_region(axes, points, points[f"without_{effect}_percent"])
        _name_bands(axes, tolerances)
        axes.set_title(f"without {effect.replace('_', ' ')}")
    axes.set(xscale="log", yscale="log", ylim=(0.8 * _ERRORS[0], 1.5 * _ERRORS[1]))
    axes.set_xlim(right=10.0)  # room for the names of the bands, as no ratio exceeds 1
    ticks_at(axes.xaxis, [0.0001, 0.001, 0.01, 0.1, 1.0])
    decimal_ticks(axes.yaxis, subs=(1.0,))
    for lower, left in zip(panels[1], panels[:, 0], strict=True):
        lower.set_xlabel("max. stress / compressive strength")
        left.set_ylabel("change of mean\nmax. closure (%)")
    figure.colorbar(marks, ax=panels, label="JRC", shrink=0.8)
    handles = [point_key(label, marker=m, color="0.4") for m, label in _STIFFNESSES.items()]
    handles.append(point_key("simulations fail", marker="x", color="0.4"))
    legend_below(figure, handles)
    sns.despine(figure)
    return figure


def _draw_region(axes: Axes, points: pd.DataFrame, percent: pd.Series) -> PathCollection:
    """Draw the errors [%] without an effect over stress over strength, and return the marks."""
    ratio = points.max_normal_stress / points.compressive_strength
    stiff = points.youngs_modulus / points.compressive_strength >= _STIFF
    failed = ~np.isfinite(percent)
    for marker, group in zip(_STIFFNESSES, (~stiff, stiff), strict=True):
        shown = group & ~failed
        marks = axes.scatter(
            ratio[shown], percent[shown].clip(_ERRORS[0]), c=points.jrc[shown], cmap="viridis",
            vmin=0.0, vmax=20.0, s=28, marker=marker, edgecolors="0.3", linewidths=0.4, zorder=2,
        )  # fmt: skip
    axes.plot(ratio[failed], np.full(failed.sum(), _ERRORS[1]), "x", color="0.4", ms=4)
    return marks


def _name_bands(axes: Axes, tolerances: np.ndarray) -> None:
    """Shade the errors below each tolerance [%], and write it at the upper edge of its band."""
    for tolerance in tolerances:
        axes.axhspan(0.0, tolerance, color="0.5", alpha=0.15, lw=0, zorder=0)
        axes.annotate(
            f"< {tolerance:g} %", (1.0, tolerance), xycoords=("axes fraction", "data"),
            xytext=(-2, -1), textcoords="offset points", ha="right", va="top", fontsize="small",
        )  # fmt: skip


_REGIONS = ("interaction", "soft_peaks", "gouge", "breakage")
_ERRORS = (0.1, 2000.0)
"""Range of the axis of errors [%]."""
_STIFF = 300.0
"""Ratio of Young's modulus to strength that separates the two kinds of marks."""
_STIFFNESSES = {"o": f"E / strength below {_STIFF:g}", "s": f"{_STIFF:g} and above"}


@styled
def choice_figure(table: pd.DataFrame) -> Figure:
    """Draw the error of the selected effects over stress, and the time that the selection saves.

    There is a column for each tolerance. Grey conditions keep all effects: they have no error,
    are counted in the upper panels instead of drawn, and lose only the time of the pilot. Errors
    below a hundredth of a percent are drawn there. Selections for the paper's 180 joints of a rock
    are drawn, if the table has them.
    """
    joints = table.joints.unique()
    table = table[table.joints == (_JOINTS if _JOINTS in joints else joints.max())]
    tolerances = sorted(table.tolerance.unique())
    figure, panels = panel_grid(
        2, len(tolerances), (3.2, 2.8), (1.4, 0.0), sharex=True, sharey="row"
    )
    names = sorted(table.chosen.unique(), key=lambda name: -name.count("-"))
    everything = scene_name(Effects())
    colours = dict(zip(names, sns.color_palette("colorblind", len(names)), strict=True))
    colours[everything] = "0.7"
    top = max(100.0, 2.0 * table.actual_percent.max())
    for (upper, lower), tolerance in zip(panels.T, tolerances, strict=True):
        part = table[table.tolerance == tolerance]
        for name in names:
            points = part[part.chosen == name]
            stress = 1e-6 * points.max_normal_stress
            look = {"color": colours[name], "ms": 5, "mec": "w", "mew": 0.5}
            if name != everything:
                off = points.actual_percent.clip(lower=_LEAST_ERROR)
                upper.plot(stress, off, "o", **look)
            lower.plot(stress, points.saved_percent, "o", **look)
        kept = (part.chosen == everything).sum()
        upper.set_title(f"{kept} of {len(part)} run all effects", fontsize="small")
        limit = 100.0 * tolerance
        upper.axhline(limit, color="0.1", lw=0.8)
        upper.annotate(
            f"tolerance {limit:g} %", (0.98, limit), xycoords=("axes fraction", "data"),
            xytext=(0, 3), textcoords="offset points", ha="right", fontsize="small",
        )  # fmt: skip
        upper.set(xscale="log", yscale="log", ylim=(0.5 * _LEAST_ERROR, top))
        lower.axhline(0.0, color="0.8", lw=0.8, zorder=0)
        lower.set(xscale="log", xlabel="maximum normal stress (MPa)")
        for axis in (upper.yaxis, lower.xaxis):
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        lower.set_ylim(table.saved_percent.min() - 5.0, 105.0)
    panels[0, 0].set_ylabel("change of mean\nmax. closure (%)")
    panels[1, 0].set_ylabel("time saved,\nincluding pilot (%)")
    handles = [point_key(_left_out(name), color=colours[name]) for name in names]
    legend_below(figure, handles, 2)
    sns.despine(figure)
    return figure


def _left_out(scene: str) -> str:
    """Describe the effects that a scene leaves out."""
    full, left = scene_name(Effects()).split("-"), scene.split("-")
    missing = [name for name in full if name not in left]
    words = " or ".join(name.replace("_", " ") for name in missing)
    return f"without {words}" if missing else "all effects"

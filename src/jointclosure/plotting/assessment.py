"""Figures of an assessment: error of each setting over its time, and changes without effects."""

import itertools
from typing import Any

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.assessment.assessed_results import ASSESSED, JUDGED
from jointclosure.assessment.assessment import Assessment
from jointclosure.assessment.effect_names import lacks_effects
from jointclosure.plotting.style import decimal_ticks, percent_ticks, styled, subplots


@styled
def assessment_figure(assessment: Assessment, title: str) -> Figure:
    """Draw the errors of settings over their time, and below them the changes without effects.

    The title has the verdict on the hardness of the joint.
    """
    table = assessment.differences
    table = table[(table.reference != table.variant) & table.quantity.isin(JUDGED)]
    percent = 100.0 * table[["value", "low", "high"]].add_suffix("_percent")
    table = table.join(percent)
    within = 100.0 * assessment.within
    without = lacks_effects(table.variant)
    figure, (upper, lower) = subplots(2, 1, figsize=(6.2, 8.6), height_ratios=(1.0, 1.1))
    if len(assessment.limits):
        draw_price(upper, _largest_limits(assessment), within)
        upper.set(title="limit that the error keeps in nine of ten joints")
        upper.set_ylabel("limit of the error of closure (%)")
    else:
        draw_price(upper, _largest_ends(table[~without]), within)
        upper.set(title=f"error relative to {table.reference[~without].iloc[0]}")
        upper.set_ylabel("largest error of closure (%),\nend of its 95 % interval")
    upper.set(xlabel="processor time of a joint (s)")
    scale = draw_effects(lower, table[without], within)
    lower.set(title="change of closure without an effect", xlabel=f"change of closure (%){scale}")
    for axes in (upper, lower):
        axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.45, -0.17), ncols=2)
    words = f"{title}, hardness: {assessment.hardness.verdict[0]}"
    figure.suptitle(words, x=0.01, ha="left", parse_math=False)  # a file's name is not a formula
    sns.despine(figure)
    return figure


def _largest_limits(assessment: Assessment) -> pd.DataFrame:
    """Return the errors of a single joint, from the limits that its closures keep.

    There is a row for each setting (``variant``) and cycle: ``error_percent`` [%] is the larger
    limit of net and gross closure, ``seconds`` the processor time.
    """
    limits = assessment.limits
    limits = limits[limits.quantity.isin(JUDGED)]
    largest = limits.groupby(["variant", "cycle"], sort=False).limit.max().reset_index()
    seconds = assessment.differences.groupby("variant").seconds.first()
    return largest.assign(error_percent=100.0 * largest.limit, seconds=largest.variant.map(seconds))


def _largest_ends(settings: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of several joints, from the intervals of the mean changes of closures.

    There is a row for each setting (``variant``) and cycle: ``error_percent`` [%] is the end of an
    interval that is farthest from 0, of net or gross closure, ``seconds`` the processor time.
    """
    by_cycle = settings.groupby(["variant", "cycle"], sort=False)
    largest = by_cycle.agg(
        low=("low_percent", "min"), high=("high_percent", "max"), seconds=("seconds", "first")
    )
    error = np.maximum(-largest.low, largest.high)
    return largest.assign(error_percent=error).reset_index()


def draw_price(axes: Axes, settings: pd.DataFrame, within: float) -> None:
    """Draw the errors [%] of settings over their processor time [s], and the requested accuracy.

    ``settings`` has a row for each ``variant`` and ``cycle``, with ``error_percent`` and
    ``seconds``; ``within`` is the request [%]. A setting has a mark for each cycle, with the number
    of the cycle; they are joined by a line.
    """
    colours = {cycle: f"C{number}" for number, cycle in enumerate(settings.cycle.unique())}
    names = list(dict.fromkeys(settings.variant))
    for name, rows in settings.groupby("variant"):
        axes.plot(rows.seconds, rows.error_percent, color="0.7", lw=1.0, zorder=1)
        for row in rows.itertuples():
            place = row.seconds, row.error_percent
            axes.plot(*place, "osD^v"[names.index(name)], color=colours[row.cycle])
            side = 1 if row.cycle % 2 else -1  # marks of two cycles may coincide
            axes.annotate(
                f"{row.cycle}", place, (6.0 * side, 0.0), textcoords="offset points",
                color=colours[row.cycle], fontsize="small", va="center",
                ha="left" if side > 0 else "right",
            )  # fmt: skip
    for mark, name in zip("osD^v", names, strict=False):
        axes.plot([], [], mark, color="0.5", label=name)
    for cycle, colour in colours.items():
        axes.plot([], [], lw=4, color=colour, label=f"cycle {cycle}")
    axes.axhline(within, color="0.5", linestyle="--", label=f"request ({within:g} %)")
    ends = [0.6 * settings.seconds.min(), 1.8 * settings.seconds.max()]
    axes.plot(ends, [within, within], alpha=0.0)  # room for ticks
    axes.set(xscale="log", yscale="log")
    decimal_ticks(axes.xaxis, axes.yaxis)


def draw_effects(
    axes: Axes, without: pd.DataFrame, within: float, shown: pd.DataFrame | None = None
) -> str:
    """Draw the changes of closure [%] without effects, on a band of the requested accuracy [%].

    Return what the label of the axis adds about its scale (`percent_ticks`). ``without`` has the
    changes and their intervals. Marks of gross closure are hollow. The axis has the range of all
    rows ``shown`` in a figure, by default of ``without``.
    """
    names = list(dict.fromkeys(without.variant))
    axes.axvspan(-within, within, color="0.9", lw=0.0, zorder=0)
    for number, (name, cycle) in enumerate(itertools.product(JUDGED, without.cycle.unique())):
        rows = without[(without.quantity == name) & (without.cycle == cycle)]
        at = [names.index(variant) + 0.15 * (number - 1.5) for variant in rows.variant]
        bars = [rows.value_percent - rows.low_percent, rows.high_percent - rows.value_percent]
        style: dict[str, Any] = {"fmt": "os"[cycle % 2 - 1], "ms": 4.5}
        style["mfc"] = None if name == JUDGED[0] else "w"
        style |= {"color": f"C{cycle - 1}", "label": f"{ASSESSED[name]}, cycle {cycle}"}
        axes.errorbar(rows.value_percent, at, xerr=bars, **style)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    ends = (without if shown is None else shown)[["low_percent", "high_percent"]].to_numpy()
    ends = ends[np.isfinite(ends)]
    low = min(ends.min(initial=0.0), -within)
    high = max(ends.max(initial=0.0), within)
    for place, name in enumerate(names):
        if not without.value_percent[without.variant == name].notna().any():
            axes.text(
                0.0, place, "no result", color="0.3", ha="center", va="center", fontsize="small"
            )
    return percent_ticks(axes.xaxis, within, 1.4 * low, 1.4 * high)

"""Figure of simulated joints beside measured ones."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.plotting.style import (
    decimal_ticks,
    keys_of,
    legend_below,
    styled,
    subplots,
    ticks_at,
)
from studies.measured_joints.observables import HEADINGS

_LOGARITHMIC = ("first_closure", "first_stiffness", "later_closure", "later_stiffness")
_FREE = "0.55"
_OFFSETS = (-0.27, -0.09, 0.09, 0.27)
"""Places of independent walls and of the three fitted joints about that of their variant."""


@styled
def measured_joints_figure(table: pd.DataFrame) -> Figure:
    """Draw each observable of all variants beside the measured values.

    Parameters
    ----------
    table : DataFrame
        As from `studies.measured_joints.observables.judged_joints`.

    Notes
    -----
    Bars are 95 % intervals of a single simulated joint. Bands, and lines of the same colours, are
    the measured joints; a grey band is a range over them.
    """
    variants = list(dict.fromkeys(table.variant))
    height = 1.0 + 0.32 * len(variants)
    figure, panels = subplots(2, 4, figsize=(14.0, 2.0 * height), sharey=True)
    for axes, (name, title) in zip(panels.flat, HEADINGS.items(), strict=True):
        _panel(axes, table[table.observable == name], variants)
        axes.set_xlabel(title)
        if name in _LOGARITHMIC:
            axes.set_xscale("log")
            decimal_ticks(axes.xaxis)
        else:
            axes.set_xlim(left=0.0)
    for axes in panels[:, 0]:
        ticks_at(axes.yaxis, range(len(variants)), variants)
        axes.set_ylim(len(variants) - 0.5, -0.5)
    legend_below(figure, keys_of(panels.flat), columns=4)
    return figure


def _panel(axes: Axes, table: pd.DataFrame, variants: list[str]) -> None:
    """Draw one observable over the variants."""
    joints = list(dict.fromkeys(table.joint))
    ranges = table.groupby("joint", sort=False)[["measured_low", "measured_high"]].first()
    if ranges.drop_duplicates().shape[0] == 1:
        axes.axvspan(*ranges.iloc[0], color="0.88", lw=0.0, label="measured, range of the joints")
    else:
        for i, (low, high) in enumerate(ranges.to_numpy()):
            band = f"measured, joint {joints[i]}"
            axes.axvspan(low, high, color=f"C{i}", alpha=0.25, lw=0.8, label=band)
    for i, joint in enumerate(joints):
        mated = table[(table.walls == "mated") & (table.joint == joint)]
        _bars(axes, mated, variants, _OFFSETS[i + 1], f"C{i}", f"mated, fitted to joint {joint}")
    free = table[(table.walls == "independent") & (table.joint == joints[0])]
    _bars(axes, free, variants, _OFFSETS[0], _FREE, "independent walls")


def _bars(
    axes: Axes, table: pd.DataFrame, variants: list[str], offset: float, colour: str, label: str
) -> None:
    """Draw means with the intervals of a single joint."""
    places = [variants.index(name) + offset for name in table.variant]
    bars = np.maximum(0.0, [table.value - table.low, table.high - table.value])
    axes.errorbar(table.value, places, xerr=bars, fmt="o", ms=3, lw=1.0, color=colour, label=label)

"""Figures of a study of global sensitivity to properties and open choices."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from jointclosure.engine.quantities import titles_of_cycles
from jointclosure.plotting.style import keys_of, legend_below, point_key, styled, subplots

SURFACES = "surfaces"
"""Row of a table of indices that is no input."""
SHOWN = titles_of_cycles(
    ("max_closure", 1),
    ("max_closure", 2),
    ("max_closure_net", 2),
    ("residual_closure_seated_net", 1),
    ("compliance_net", 1),
    ("compliance_net", 2),
)
"""Title of each panel, by response and cycle."""
_WIDTH = 1.96
_COLOURS = 10
"""Number of colours of lines, which repeat after it (`jointclosure.plotting.style`)."""


@styled
def indices(table: pd.DataFrame, titles: dict[str, str]) -> Figure:
    """Draw first and total indices of every input, with a panel for each response.

    Parameters
    ----------
    table : DataFrame
        From `jointclosure.experiments.global_sensitivity.table.index_table`.
    titles : dict
        Titles of the rocks.

    Notes
    -----
    Filled: total; hollow: first. Bars: 95 % intervals.
    """
    most = table.groupby(["rock", "response", "cycle"]).rows.transform("max")
    whole = table[table.rows == most]
    names = [name for name in dict.fromkeys(whole.input) if name != SURFACES]
    labels = [whole.title[whole.input == name].iloc[0] for name in names]
    rocks = list(dict.fromkeys(whole.rock))
    figure, panels = subplots(
        2, 3, figsize=(11.0, 2.2 + 0.5 * len(names)), sharex=True, sharey=True
    )
    places = np.arange(len(names))[::-1]
    for axes, ((response, cycle), title) in zip(panels.flat, SHOWN.items(), strict=True):
        for number, rock in enumerate(rocks):
            part = whole[(whole.rock == rock) & (whole.response == response)]
            part = part[part.cycle == cycle].set_index("input").reindex(names)
            at = places + 0.16 * ((len(rocks) - 1) / 2.0 - number)
            for kind, face in (("total", f"C{number}"), ("first", "white")):
                axes.errorbar(
                    part[kind], at, xerr=_WIDTH * part[f"{kind}_error"], fmt="o", ms=4.0,
                    color=f"C{number}", markerfacecolor=face, lw=0.8,
                    zorder=3 if kind == "first" else 2,
                )  # fmt: skip
        axes.axvline(0.0, color="0.6", lw=0.8, zorder=0)
        axes.set_title(title, fontsize=10)
        axes.set_yticks(places, labels, fontsize=8)
        axes.grid(axis="y", lw=0.3)
    for axes in panels[-1]:
        axes.set_xlabel("share of the variance of the mean")
    keys = [point_key(titles[rock], color=f"C{number}") for number, rock in enumerate(rocks)]
    keys.append(point_key("total index", color="0.3"))
    keys.append(point_key("first index", color="0.3", markerfacecolor="white"))
    legend_below(figure, keys)
    return figure


@styled
def convergence(table: pd.DataFrame, titles: dict[str, str]) -> Figure:
    """Draw total indices of the closures of both cycles over the number of rows.

    Parameters as of `indices`. Bars are 95 % intervals. Inputs beyond the number of colours have
    hollow markers and dashed lines.
    """
    table = table[table.response == "max_closure"]
    rocks = list(dict.fromkeys(table.rock))
    names = [name for name in dict.fromkeys(table.input) if name != SURFACES]
    figure, panels = subplots(
        2, max(1, len(rocks)), figsize=(2.7 * len(rocks) + 2.4, 5.6),
        sharex=True, sharey=True, squeeze=False,
    )  # fmt: skip
    markers = "osD^v<>PX*hd"
    for column, rock in zip(panels.T, rocks, strict=False):  # axes alone without any rock
        for axes, cycle in zip(column, (1, 2), strict=True):
            here = table[(table.rock == rock) & (table.cycle == cycle)]
            for number, name in enumerate(names):
                part = here[here.input == name].sort_values("rows")
                again = number >= _COLOURS
                axes.errorbar(
                    (part.rows + part.left_out) * 1.03 ** (number - len(names) / 2.0), part.total,
                    yerr=_WIDTH * part.total_error, marker=markers[number % len(markers)],
                    color=f"C{number}", markerfacecolor="white" if again else None,
                    linestyle="--" if again else "-", ms=4.0, lw=0.8, label=part.title.iloc[0],
                )  # fmt: skip
            axes.set_title(f"{titles[rock]}, cycle {cycle}", fontsize=10)
            axes.axhline(0.0, color="0.6", lw=0.8, zorder=0)
    ticks = sorted(set(table.rows + table.left_out))
    for axes in panels[-1]:
        axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{tick:.0f}" for tick in ticks])
        axes.minorticks_off()
        axes.set_xlabel("rows of the design")
    for axes in panels[:, 0]:
        axes.set_ylabel("total index")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, fontsize=8)
    return figure


@styled
def conclusions(table: pd.DataFrame, titles: dict[str, str]) -> Figure:
    """Draw the share of the open choices for which each conclusion holds, with 95 % intervals.

    Parameters
    ----------
    table : DataFrame
        From `jointclosure.experiments.global_sensitivity.conclusions.conclusion_tables`; if it is
        empty the figure is a text.
    titles : dict
        Titles of the rocks.
    """
    if table.empty:
        figure, axes = subplots(figsize=(6.0, 2.0), layout=None)
        axes.set_axis_off()
        axes.text(0.5, 0.5, "not all four properties vary", ha="center")
        return figure
    rocks = [*(rock for rock in dict.fromkeys(table.rock) if rock != "all"), "all"]
    colours = {rock: f"C{number}" for number, rock in enumerate(rocks)} | {"all": "0.15"}
    unique = table[["number", "conclusion"]].drop_duplicates().sort_values("number")
    rows = list(unique.itertuples(index=False))
    figure, panels = subplots(
        1, 4, figsize=(12.0, 1.6 + 0.55 * len(rows)), sharex=True, sharey=True
    )
    places = np.arange(len(rows))[::-1]
    cases = [
        (response, cycle) for cycle in (1, 2) for response in ("max_closure", "max_closure_net")
    ]
    for axes, (response, cycle) in zip(panels, cases, strict=True):
        here = table[(table.response == response) & (table.cycle == cycle)]
        for number, rock in enumerate(rocks):
            part = here[here.rock == rock].set_index("number").reindex([row[0] for row in rows])
            axes.errorbar(
                100.0 * part.share, places + 0.14 * ((len(rocks) - 1) / 2.0 - number),
                xerr=100.0 * np.array([part.share - part.share_low, part.share_high - part.share]),
                fmt="D" if rock == "all" else "o", ms=4.5, color=colours[rock], lw=0.8,
                label=titles.get(rock, "in all rocks at once"),
            )  # fmt: skip
        net = ", net of bulk\nindentation" if response == "max_closure_net" else ""
        axes.set_title(f"cycle {cycle}{net}", fontsize=10)
        axes.set_yticks(
            places,
            [f"{number}: {conclusion.replace('sigma_c', 'σc')}" for number, conclusion in rows],
            fontsize=8,
        )
        axes.set(xlim=(-4.0, 104.0), xlabel="share of open choices (%)")
        axes.grid(axis="y", lw=0.3)
    legend_below(figure, keys_of(panels[:1]), len(rocks))
    return figure

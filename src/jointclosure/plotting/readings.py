"""Figures of a study of readings: likelihood of Table 3, and sensitivities."""

import numpy as np
import pandas as pd
import scipy
import seaborn as sns
from matplotlib.figure import Figure

from jointclosure.config.properties import PARAMETER_TITLES
from jointclosure.plotting.style import keys_of, legend_below, styled, subplots

_CYCLES = (1, 2)
_SHOWN = 12
"""Number of readings in the figure of sensitivities, the best ones."""


@styled
def likelihoods(table: pd.DataFrame, implied: pd.DataFrame) -> Figure:
    """Draw the log-likelihood of Table 3 and S/mean of both cycles for all readings.

    Parameters
    ----------
    table, implied : DataFrame
        From `jointclosure.experiments.readings.table`.

    Notes
    -----
    Bars are standard errors. Hollow marks: only some rocks were closed, and the others are assumed
    to change alike. Bands: S/mean implied by Table 3, given the means of the best reading.
    """
    shown = table.sort_values("log_likelihood").reset_index(drop=True)
    figure, panels = subplots(
        1, 3, figsize=(11.0, 0.24 * len(shown) + 1.8), sharey=True, width_ratios=[2.0, 1.0, 1.0]
    )
    names = list(dict.fromkeys(shown["round"]))
    colours = dict(zip(names, sns.color_palette("colorblind", len(names)), strict=True))
    whole = shown.rocks == shown.rocks.loc[shown.rocks.str.len().idxmax()]
    columns = [("log_likelihood", "standard_error")]
    columns += [(f"scatter_{cycle}", f"scatter_{cycle}_error") for cycle in _CYCLES]
    for axes, (value, error) in zip(panels, columns, strict=True):
        for name, colour in colours.items():
            for all_rocks, face in ((True, colour), (False, "white")):
                part = shown[(shown["round"] == name) & (whole == all_rocks)]
                if part.empty:
                    continue
                axes.errorbar(
                    part[value],
                    part.index,
                    xerr=part[error],
                    fmt="o",
                    color=colour,
                    markerfacecolor=face,
                    markersize=4,
                    label=name.replace("_", " "),
                )
        axes.grid(axis="x", alpha=0.3)
    best = implied[implied.reading == implied.reading.iloc[0]]
    for axes, cycle in zip(panels[1:], _CYCLES, strict=True):
        band = best[best.cycle == cycle].iloc[0]
        axes.axvspan(band.low, band.high, color="0.85", zorder=0, label="implied by Table 3")
        axes.axvline(band.scatter, color="0.6", zorder=0)
        axes.set_xlabel(f"S/mean, cycle {cycle}")
        axes.set_xlim(left=0.0)
    panels[0].set_yticks(shown.index, shown.title)
    panels[0].set_xlabel("log-likelihood of the paper's Table 3")
    legend_below(figure, keys_of(panels), 6)
    return figure


@styled
def sensitivities(table: pd.DataFrame, paper: pd.DataFrame, draws: int) -> Figure:
    """Draw |elasticity| over S/mean by parameter and cycle, and the ratios implied by Table 3.

    Notes
    -----
    Where the response is near linear, the length of an interval in percent is
    100 t sqrt(2/n) S/mean over |elasticity|, so that every entry of Table 3 implies a ratio. Grey
    lines are the paper's rocks; a dash implies none.
    """
    shown = table.head(_SHOWN)[::-1].reset_index(drop=True)
    parameters = [name for name in PARAMETER_TITLES if f"{name}_1" in table]
    figure, panels = subplots(
        len(_CYCLES),
        len(parameters),
        figsize=(2.6 * len(parameters) + 1.6, 0.5 * len(shown) + 2.4),
        sharey=True,
        squeeze=False,
    )
    critical = float(scipy.stats.t.ppf(0.975, 2 * draws - 2))
    for row, cycle in zip(panels, _CYCLES, strict=True):
        for axes, name in zip(row, parameters, strict=True):
            percents = paper[(paper.parameter == name) & (paper.cycle == cycle)].paper_percent
            implied = 100.0 * critical * np.sqrt(2.0 / draws) / percents.dropna()
            for ratio in implied:
                axes.axvline(ratio, color="0.75", zorder=0)
            elasticity, scatter = shown[f"{name}_{cycle}"].abs(), shown[f"scatter_{cycle}"]
            relative = np.hypot(
                shown[f"{name}_{cycle}_error"] / elasticity,
                shown[f"scatter_{cycle}_error"] / scatter,
            )
            value = elasticity / scatter
            axes.errorbar(value, shown.index, xerr=value * relative, fmt="o", markersize=4)
            axes.set_title(f"{PARAMETER_TITLES[name]}, cycle {cycle}", fontsize="small")
            axes.set_xlim(0.0, 1.1 * max(*implied, *value))
        row[0].set_yticks(shown.index, shown.title)
    for axes in panels[-1]:
        axes.set_xlabel("|elasticity| / (S/mean)")
    figure.suptitle("Grey: ratios implied by the entries of Table 3", fontsize="medium")
    return figure

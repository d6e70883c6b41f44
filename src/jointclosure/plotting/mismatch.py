"""Figure of closure, stiffness, residual and hysteresis from mated to independent walls."""

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.quantities import HEADINGS
from jointclosure.plotting.style import styled, subplots, ticks_at

_PANELS = (
    "max_closure_seated_net_mm",
    "stiffness_net_MPa_per_mm",
    "residual_closure_seated_net_mm",
    "hysteresis",
)
_CYCLES = ("C0", "C1", "C2", "C4")


@styled
def mismatch_figure(table: pd.DataFrame) -> Figure:
    """Draw the effect of mismatch without a shift (left), and of a shift on cycle 1 (right).

    Parameters
    ----------
    table : DataFrame
        As from `jointclosure.experiments.mismatch.mismatch_table`; its first rock is drawn.

    Notes
    -----
    Bars and the grey band are standard errors over surfaces. Mated and independent walls are at
    the ends of the left axes; the grey line is that of independent walls.
    """
    table = table[table.rock == table.rock.iloc[0]]
    figure, panels = subplots(len(_PANELS), 2, figsize=(9.0, 11.0), sharey="row")
    for row, column in zip(panels, _PANELS, strict=True):
        _against_mismatch(row[0], table[table.shift_mm == 0.0], column)
        _against_shift(row[1], table[table.cycle == table.cycle.min()], column)
        row[0].set_ylabel(HEADINGS[column])
        if column == "stiffness_net_MPa_per_mm":
            row[0].set_yscale("log")
        elif column == "hysteresis":  # that of mated walls is unresolved, and may be far below
            row[0].set_ylim(-0.1, 1.05)
        else:
            row[0].set_ylim(bottom=min(0.0, 1.05 * table[column].min()))
    panels[0][0].set_title("without a shift")
    panels[0][1].set_title("shifted, first cycle")
    panels[-1][0].set_xlabel("mismatch wavelength (mm)")
    panels[-1][1].set_xlabel("shift (mm)")
    handles, names = panels[0][0].get_legend_handles_labels()
    panels[0][0].legend(handles, names, frameon=False, loc="upper left")
    handles, names = panels[0][1].get_legend_handles_labels()
    figure.legend(
        handles, names, loc="outside right upper", frameon=False, title="mismatch\nwavelength (mm)"
    )
    return figure


def _against_mismatch(axes: Axes, table: pd.DataFrame, column: str) -> None:
    """Draw a quantity of each cycle over the mismatch wavelength, mated walls first."""
    wavelengths = np.sort(table.wavelength_mm.unique())
    inner = wavelengths[(wavelengths > 0.0) & np.isfinite(wavelengths)]
    ends = (0.6 * inner[0], 1.7 * inner[-1]) if inner.size else (0.5, 2.0)
    places = {0.0: ends[0], np.inf: ends[1]} | {value: value for value in inner}
    for colour, (cycle, part) in zip(_CYCLES, table.groupby("cycle"), strict=False):
        part = part.sort_values("wavelength_mm")
        axes.errorbar(
            part.wavelength_mm.map(places), part[column], part[f"{column}_error"],
            fmt="o-", ms=4, lw=1.2, capsize=2, color=colour, label=f"cycle {cycle}",
        )  # fmt: skip
    axes.set_xscale("log")
    shown = [value for value in wavelengths if value in places]
    words = {0.0: "mates", np.inf: "indep."}
    labels = [words.get(value, f"{value:g}") for value in shown]
    ticks_at(axes.xaxis, [places[value] for value in shown], labels)
    axes.tick_params(axis="x", labelrotation=45)


def _against_shift(axes: Axes, table: pd.DataFrame, column: str) -> None:
    """Draw a quantity of one cycle over the shift, with a line for each mismatch wavelength."""
    free = table[np.isinf(table.wavelength_mm)]
    mean, error = free[column].iloc[0], free[f"{column}_error"].iloc[0]
    axes.axhspan(mean - error, mean + error, color="0.9", lw=0.0)
    axes.axhline(mean, color="0.6", lw=1.2, label="independent")
    shifted = table[np.isfinite(table.wavelength_mm)]
    colours = sns.color_palette("viridis", shifted.wavelength_mm.nunique())
    for colour, (wavelength, part) in zip(colours, shifted.groupby("wavelength_mm"), strict=True):
        part = part.sort_values("shift_mm")
        axes.errorbar(
            part.shift_mm, part[column], part[f"{column}_error"], fmt="o-", ms=3, lw=1.0,
            capsize=1.5, color=colour, label=f"{wavelength:g}" if wavelength else "0 (mates)",
        )  # fmt: skip
    smallest = shifted.shift_mm[shifted.shift_mm > 0.0].min()
    axes.set_xscale("symlog", linthresh=smallest if np.isfinite(smallest) else 1.0)
    axes.set_xlim(left=0.0)
    ticks_at(axes.xaxis, np.sort(shifted.shift_mm.unique())[::2])

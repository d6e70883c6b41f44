"""What a tilt and a rotation of the walls change."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from jointclosure.plotting.style import styled, subplots

_PANELS = (
    ("closure", 1, "maximum closure,\ncycle 1"),
    ("closure", 2, "maximum closure,\ncycle 2"),
    ("residual_seated_net", 1, "residual closure"),
    ("stiffness_net", 1, "net normal stiffness,\ncycle 1"),
    ("stiffness_net", 2, "net normal stiffness,\ncycle 2"),
)
"""Response, cycle and title of each row."""


@styled
def misalignment_figure(table: pd.DataFrame) -> Figure:
    """Changes from aligned walls against tilt (left) and rotation (right), by rock.

    Parameters
    ----------
    table : DataFrame
        As from `jointclosure.studies.misalignment.table.misalignment_table`.

    Notes
    -----
    Filled: independent walls; hollow and dashed: walls whose longer waves mate. Bars are 95 %
    intervals.
    """
    figure, panels = subplots(
        len(_PANELS), 2, figsize=(9.0, 11.0), layout="constrained", sharex="col"
    )
    rocks, wavelengths = list(dict.fromkeys(table.rock)), np.sort(table.wavelength_mm.unique())
    moved = {"tilt_degrees": "rotation_degrees", "rotation_degrees": "tilt_degrees"}
    for row, (response, cycle, title) in zip(panels, _PANELS, strict=True):
        shown = table[(table.response == response) & (table.cycle == cycle)]
        for axes, (along, other) in zip(row, moved.items(), strict=True):
            _changes(axes, shown[shown[other] == 0.0], along, rocks, wavelengths)
        row[0].set_ylabel(f"change of {title} (%)", fontsize=9)
    for axes, along in zip(panels[-1], moved, strict=True):
        axes.set_xlabel(along.replace("_degrees", " (degrees)"))
    _spread_rotations(panels[-1][1], table.rotation_degrees)
    marks = [
        Line2D([], [], color=f"C{place}", marker="o", ls="", label=rock.capitalize())
        for place, rock in enumerate(rocks)
    ]
    marks += [
        Line2D([], [], color="0.3", label=_named(wavelength), **_style(wavelength))
        for wavelength in wavelengths
    ]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), frameon=False)
    return figure


def _changes(axes: Axes, table: pd.DataFrame, along: str, rocks: list[str], wavelengths) -> None:
    for place, rock in enumerate(rocks):
        for wavelength in wavelengths:
            own = table[(table.rock == rock) & (table.wavelength_mm == wavelength)]
            own = own.sort_values(along)
            axes.errorbar(
                own[along], own.change_percent, yerr=1.96 * own.change_error, ms=3.5, lw=1.0,
                capsize=1.5, color=f"C{place}", **_style(wavelength),
            )  # fmt: skip
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=0)


def _style(wavelength: float) -> dict:
    if np.isinf(wavelength):
        return {"marker": "o", "ls": "-"}
    return {"marker": "o", "ls": "--", "markerfacecolor": "white"}


def _named(wavelength: float) -> str:
    return "independent" if np.isinf(wavelength) else f"waves beyond {wavelength:g} mm mate"


def _spread_rotations(axes: Axes, rotations: pd.Series) -> None:
    """Small rotations as far apart as large ones."""
    values = np.sort(rotations.unique())
    if values.size > 1:
        axes.set_xscale("symlog", linthresh=values[1], linscale=0.4)
        axes.set_xlim(-0.3 * values[1], 1.2 * values[-1])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks(values, [f"{value:g}" for value in values])

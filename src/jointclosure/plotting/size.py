"""Figure of closure, residual closure and stiffness over patch length and spacing."""

import re
from textwrap import fill

import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.quantities import COLUMNS, titles_of_cycles
from jointclosure.plotting.style import legend_below, styled, subplots, ticks_at

_ROWS = titles_of_cycles(
    ("max_closure_seated_net", 1),
    ("max_closure_net", 1),
    ("residual_closure_seated_net", 1),
    ("max_closure_seated_net", 2),
    ("stiffness_net", 2),
)
_MARKERS = "osD^vP*X"


@styled
def size_figure(table: pd.DataFrame) -> Figure:
    """Draw ratios to the joints of the base: over patch length (left) and spacing (right).

    Parameters
    ----------
    table : DataFrame
        As from `jointclosure.experiments.size.table.size_table`; its first rock is drawn.

    Notes
    -----
    Bars are standard errors over realisations, of ratios for the same walls. Both axes are
    logarithmic, so that a power law is a straight line.
    """
    table = table[table.rock == table.rock.iloc[0]]
    base = table[(table.max_closure_mm_ratio == 1.0) & (table.max_closure_mm_error == 0.0)].iloc[0]
    figure, panels = subplots(len(_ROWS), 2, figsize=(9.0, 11.0), sharey="row", sharex="col")
    for row, ((name, cycle), title) in zip(panels, _ROWS.items(), strict=True):
        rows = table[table.cycle == cycle]
        lines = (
            ("patch_mm", rows[rows.spacing_mm == base.spacing_mm]),
            ("spacing_mm", rows[rows.patch_mm == base.patch_mm]),
        )
        for axes, (along, part) in zip(row, lines, strict=True):
            _against(axes, part, along, COLUMNS[name][0])
        row[0].set_ylabel(fill(title, 18))
    figure.supylabel("ratio to the joints of the base")
    panels[-1][0].set_xlabel("patch length (mm)")
    panels[-1][1].set_xlabel("spacing (mm)")
    panels[0][0].set_title(f"spacing {base.spacing_mm:g} mm")
    panels[0][1].set_title(f"patch {base.patch_mm:g} mm")
    handles = panels[0][0].get_legend_handles_labels()[0]
    legend_below(figure, handles, 3, title="bars: standard errors of ratios of the same walls")
    return figure


def spectrum_title(name: str) -> str:
    """Return the words for the name of a spectrum, such as "H = 0.5, roll-off 3 mm"."""
    words = re.sub(r"\bhurst (\d)(\d+)", r"H = \1.\2,", name.replace("_", " "))
    words = re.sub(r"\bno roll off\b", "no roll-off", words)
    words = re.sub(r"\broll off (\d+)mm", r"roll-off \1 mm", words)
    return words.rstrip(",")


def _against(axes: Axes, table: pd.DataFrame, along: str, column: str) -> None:
    """Draw ratios of a reading over patch lengths or spacings, with a line for each spectrum."""
    spectra = list(dict.fromkeys(table.spectrum))
    colours = sns.color_palette("colorblind", len(spectra))
    axes.axhline(1.0, color="0.8", lw=0.8)
    for number, (spectrum, colour) in enumerate(zip(spectra, colours, strict=True)):
        part = table[table.spectrum == spectrum].sort_values(along)
        aside = 1.0 + 0.02 * (number - 0.5 * (len(spectra) - 1))
        axes.errorbar(
            part[along] * aside, part[f"{column}_ratio"], part[f"{column}_error"], color=colour,
            marker=_MARKERS[number % len(_MARKERS)], ms=4, lw=1.0, capsize=2,
            label=spectrum_title(spectrum),
        )  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    ticks_at(axes.xaxis, sorted(table[along].unique()))
    ticks_at(axes.yaxis, [0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 3.0])

"""Figures of an assessment: price of accuracy, changes by effects, and hardness."""

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.assess import HARD_CASES, JUDGED
from jointclosure.joint.protocol import LARGEST_UNBREAKABLE_SHARE
from jointclosure.plotting.assessment import draw_effects, draw_price
from jointclosure.plotting.style import decimal_ticks, panel_grid, styled, subplots
from jointclosure.storage.files import read_csv
from studies.frame.summary import grouped

_COLUMNS = 4
"""Largest number of panels in a row."""
_LEAST_SPREAD = 1e-5
"""Spread [1] at which smaller ones are drawn."""
_VERDICTS = {"easy": "o", "hard": "s", "not stable": "X"}


def _panels(table: pd.DataFrame, panel: tuple) -> Iterator[tuple[Axes, pd.DataFrame]]:
    """Generate a panel for the closures of each condition, in one figure."""
    shown = table[table.quantity.isin(JUDGED) & (table.variant != table.reference)]
    conditions = list(grouped(shown, "rock", "jrc", "stress_MPa"))
    columns = min(len(conditions), _COLUMNS)
    rows = -(-len(conditions) // columns)
    _, grid = panel_grid(rows, columns, panel, (1.2, 0.0), sharex=True, sharey=True)
    for axes in grid.flat[len(conditions) :]:
        axes.remove()
    for axes, (at, part) in zip(grid.flat, conditions, strict=False):
        axes.set_title(condition(**at))
        yield axes, part


def condition(rock: str, jrc: float, stress_MPa: float) -> str:
    """Describe a condition; scanned walls have no JRC."""
    walls = "scanned" if math.isnan(jrc) else f"JRC {jrc:g}"
    return f"{rock.capitalize()}, {walls}, {stress_MPa:g} MPa"


@styled
def price_panels(table: pd.DataFrame, within: float) -> Figure:
    """Draw the error of each setting of the numerics over its time, for each condition."""
    for axes, part in _panels(table[table.verdict.isna() | (table.verdict == "")], (3.0, 2.8)):
        draw_price(axes, part, 100.0 * within)
    return _finished(axes, "processor time of a joint (s)", "error of mean closure (%)")


@styled
def effect_panels(table: pd.DataFrame, within: float) -> Figure:
    """Draw the change of the mean closures without each group of effects."""
    without = table[table.variant.str.startswith("without ")]
    for axes, part in _panels(without, (3.0, 2.2)):
        draw_effects(axes, part, 100.0 * within)
    return _finished(axes, "change of mean closure (%)", "")


def _finished(axes: Axes, x: str, y: str) -> Figure:
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.supxlabel(x, fontsize="medium")
    figure.supylabel(y, fontsize="medium")
    handles, labels = axes.get_legend_handles_labels()
    columns = 2 if len(axes.figure.axes) == 1 else len(labels)
    figure.legend(handles, labels, loc="outside upper center", frameon=False, ncols=columns)
    sns.despine(figure)
    return figure


@styled
def hardness_panels(table: pd.DataFrame, within: float) -> Figure:
    """Draw features of joints in front of those of the hard cases, and the limits of easy ones."""
    figure, (left, right) = subplots(1, 2, figsize=(10.0, 3.8))
    shares = ["spread", "unbreakable_share", "largest_jump"]
    joints, cases = (
        part.assign(**100.0 * part[shares].clip(lower=_LEAST_SPREAD * np.array([1.0, 0.0, 0.0])))
        for part in (table.assign(rock=table.rock.str.capitalize()), read_csv(HARD_CASES))
    )
    for axes, x, y in ((left, *shares[:2]), (right, "contacts_at_max", shares[2])):
        marks = {"x": x, "y": y, "ax": axes}
        sns.scatterplot(cases, **marks, color="0.8", s=15, label="hard cases", legend=False)
        styles = {"hue": "rock", "style": "verdict", "markers": _VERDICTS, "s": 40}
        sns.scatterplot(joints, **marks, **styles, legend="full" if axes is right else False)
        axes.set_xscale("log")
    decimal_ticks(right.xaxis)  # the spreads of copies span too many decades
    left.axvline(50.0 * within, color="0.5", ls="--", zorder=0)
    left.axhline(100.0 * LARGEST_UNBREAKABLE_SHARE, color="0.5", ls="--", zorder=0)
    left.set(xlabel="spread of net closure over copies that must close alike (%)")
    left.set(ylabel="force on contacts that cannot break (%)")
    right.set(xlabel="cells in contact", ylabel="largest jump, of the closure (%)")
    right.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    sns.despine(figure)
    return figure

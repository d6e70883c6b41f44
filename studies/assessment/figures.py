"""Figures of an assessment: price of accuracy, changes by effects, and hardness."""

from collections.abc import Iterator

import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.engine.assessment import CLOSURE
from jointclosure.joint.protocol import LARGEST_UNBREAKABLE_SHARE
from jointclosure.plotting.assessment import draw_effects, draw_price
from jointclosure.plotting.style import decimal_ticks, panel_grid, styled, subplots

_COLUMNS = 4
"""Largest number of panels in a row."""
_VERDICTS = {"easy": "o", "hard": "s", "not stable": "X"}


def _panels(table: pd.DataFrame, panel: tuple) -> Iterator[tuple[Axes, pd.DataFrame]]:
    """Generate a panel for the closures of each condition, in one figure."""
    shown = table[(table.quantity == CLOSURE) & (table.variant != table.reference)]
    conditions = list(shown.groupby(["rock", "jrc", "stress_MPa"], sort=False))
    columns = min(len(conditions), _COLUMNS)
    rows = -(-len(conditions) // columns)
    _, grid = panel_grid(rows, columns, panel, (1.2, 0.0), sharex=True, sharey=True)
    for axes in grid.flat[len(conditions) :]:
        axes.remove()
    for axes, ((rock, jrc, stress), part) in zip(grid.flat, conditions, strict=False):
        axes.set_title(f"{str(rock).capitalize()}, JRC {jrc:g}, {stress:g} MPa")
        yield axes, part


@styled
def price_panels(table: pd.DataFrame, within: float) -> Figure:
    """Draw the error of each setting of the numerics over its time, for each condition."""
    for axes, part in _panels(table[table.verdict.isna() | (table.verdict == "")], (3.0, 2.8)):
        draw_price(axes, part, 100.0 * within)
    return _finished(axes, "processor time of a joint (s)", "error of mean net closure (%)")


@styled
def effect_panels(table: pd.DataFrame, within: float) -> Figure:
    """Draw the change of the mean net closure without each group of effects."""
    without = table[table.variant.str.startswith("without ")]
    for axes, part in _panels(without, (3.0, 2.2)):
        draw_effects(axes, part, 100.0 * within)
    return _finished(axes, "change of mean net closure (%)", "")


def _finished(axes: Axes, x: str, y: str) -> Figure:
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.supxlabel(x, fontsize="medium")
    figure.supylabel(y, fontsize="medium")
    handles, labels = axes.get_legend_handles_labels()
    columns = 3 if len(axes.figure.axes) == 1 else len(labels)
    figure.legend(handles, labels, loc="outside upper center", frameon=False, ncols=columns)
    sns.despine(figure)
    return figure


@styled
def hardness_figure(table: pd.DataFrame, within: float) -> Figure:
    """Draw unbreakable share over spread of copies of each joint, with the limits of easy ones."""
    figure, axes = subplots(figsize=(6.0, 3.8))
    shown = table.assign(percent=100.0 * table.unbreakable, rock=table.rock.str.capitalize())
    marks = {"data": shown, "x": "spread_percent", "y": "percent", "ax": axes}
    sns.scatterplot(**marks, hue="rock", style="verdict", markers=_VERDICTS, s=40)
    axes.axvline(50.0 * within, color="0.5", ls="--", zorder=0)
    axes.axhline(100.0 * LARGEST_UNBREAKABLE_SHARE, color="0.5", ls="--", zorder=0)
    axes.set(xlabel="spread of net closure over copies that must close alike (%)", xscale="log")
    axes.set(ylabel="force on contacts that cannot break (%)")
    decimal_ticks(axes.xaxis)
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    sns.despine(figure)
    return figure

"""Style of all figures, applied where a figure is made and where it is drawn.

It is never set for the whole process: a notebook that imports this package keeps its backend and
its style.
"""

import functools
from collections.abc import Callable, Iterable
from typing import TypeVar

import matplotlib
import numpy as np
import seaborn as sns
from cycler import cycler
from matplotlib.axis import Axis, XAxis
from matplotlib.figure import Figure
from matplotlib.ticker import (
    FixedLocator,
    LogLocator,
    NullFormatter,
    NullLocator,
    StrMethodFormatter,
)

from jointclosure.joint.status import LOADING, UNLOADING

BRANCH_LINES = {LOADING: "-", UNLOADING: "--"}
"""Line style of each branch in every figure."""

_STYLE = {  # settings of matplotlib
    **sns.plotting_context("paper", font_scale=1.1),
    **sns.axes_style("ticks"),
    "axes.prop_cycle": cycler("color", sns.color_palette("colorblind")),
    "patch.facecolor": sns.color_palette("colorblind")[0],
    "figure.dpi": 150,
    "savefig.dpi": 150,
    "axes.grid": False,
}


_Drawn = TypeVar("_Drawn")


def styled(draw: Callable[..., _Drawn]) -> Callable[..., _Drawn]:
    """Decorate a function that makes a figure, or draws on one, to apply the style."""

    @functools.wraps(draw)
    def drawn(*arguments, **settings) -> _Drawn:
        with matplotlib.rc_context(_STYLE):
            return draw(*arguments, **settings)

    return drawn


class StyledFigure(Figure):
    """Figure that also applies the style to parts that matplotlib makes while drawing (ticks)."""

    draw = styled(Figure.draw)
    savefig = styled(Figure.savefig)


def subplots(*shape, figsize, layout="constrained", title="", **settings) -> tuple:
    """Return a figure unknown to pyplot, and its axes: rows and columns, or those of a mosaic."""
    figure = StyledFigure(figsize=figsize, layout=layout)
    if title:
        figure.suptitle(title, parse_math=False)  # a file's name is not a formula
    make = figure.subplots if len(shape) != 1 else figure.subplot_mosaic
    return figure, make(*shape, **settings)


def panel_grid(rows: int, columns: int, panel: tuple, margin: tuple = (0.0, 0.0), **settings):
    """Return a figure and axes (rows, columns) of the size of a panel, and a margin [inches]."""
    figsize = (panel[0] * columns + margin[0], panel[1] * rows + margin[1])
    return subplots(rows, columns, figsize=figsize, squeeze=False, **settings)


def above(cycle: int, branch: str) -> float:
    """Return the drawing order: unloading above the next cycle's nearly equal loading."""
    return 2.0 if branch == LOADING else 3.0 - 0.01 * cycle


def decimal_ticks(*logarithmic: Axis, **locator) -> None:
    """Label logarithmic axes by decimal numbers, at 1, 2 and 5 of each decade.

    Longer axes have labels at 1 and 3, or at 1 alone.
    """
    for axis in logarithmic:
        low, high = axis.get_view_interval()
        places = {"subs": (1.0, 2.0, 5.0)} | locator
        if high > 50.0 * low:
            places["subs"] = (1.0,) if high > 3e3 * low else (1.0, 3.0)
        axis.set_major_locator(LogLocator(**places))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def ticks_at(axis: Axis, values: Iterable[float], labels: Iterable[str] | None = None) -> None:
    """Put ticks only at some values, without a change of the limits."""
    values = list(values)
    axis.set_major_locator(FixedLocator(values))
    axis.set_minor_locator(NullLocator())
    axis.set_ticklabels([f"{value:g}" for value in values] if labels is None else list(labels))


def percent_ticks(axis: Axis, linear: float, low: float, high: float, narrow: bool = False) -> str:
    """Scale an axis of signed percentages, and return words on the scale for its label.

    An axis that reaches no further than four times ``linear`` is linear. A longer one is linear up
    to there and logarithmic beyond, with fewer ticks where decades are many or the axis is
    ``narrow``.
    """
    set_scale, set_limits = (
        (axis.axes.set_xscale, axis.axes.set_xlim)
        if isinstance(axis, XAxis)
        else (axis.axes.set_yscale, axis.axes.set_ylim)
    )
    if max(-low, high) <= 4.0 * linear:
        set_limits(low, high)
        return ""
    set_scale("symlog", linthresh=linear, linscale=0.5 if narrow else 1.0)
    set_limits(low, high)
    decades = sum(max(0.0, np.log10(max(end, linear) / linear)) for end in (-low, high))
    steps = (1.0, 3.0) if decades <= 2.2 and not narrow else (1.0,)
    beyond = [step * 10.0**power for power in range(-3, 7) for step in steps]
    apart = 1.9 if decades <= 1.2 else 2.9  # ratio of a tick to the end of the linear part
    beyond = [value for value in beyond if value > apart * linear]
    beyond = sorted(value for end in beyond for value in (-end, end) if low <= value <= high)
    ends = [value for value in (-linear, linear) if low <= value <= high]
    ticks_at(axis, sorted([0.0, *beyond, *([] if narrow and beyond else ends)]))
    return f", logarithmic beyond ±{linear:g}"

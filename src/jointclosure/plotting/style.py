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

_LABEL_WIDTH, _LABEL_HEIGHT = 0.38, 0.25
"""Least distances [inches] of labels beside and above each other."""
_SMALL_CHARACTER = 0.068
"""Width [inches] of a character of small labels, with room for a narrower axis."""

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
    """Decorate a function that makes a figure, or draws on one: it runs with the common style."""

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
    """Make a figure that pyplot does not know, and return it with its axes.

    ``shape`` are the numbers of rows and columns, or one mosaic of names. ``figsize`` is in inches.
    """
    figure = StyledFigure(figsize=figsize, layout=layout)
    if title:
        figure.suptitle(title, parse_math=False)  # a file's name is not a formula
    make = figure.subplots if len(shape) != 1 else figure.subplot_mosaic
    return figure, make(*shape, **settings)


def panel_grid(rows: int, columns: int, panel: tuple, margin: tuple = (0.0, 0.0), **settings):
    """Make a figure of equal panels, and return it with its axes (rows, columns).

    ``panel`` is the width and height of one panel, ``margin`` what the figure has besides [inches].
    """
    figsize = (panel[0] * columns + margin[0], panel[1] * rows + margin[1])
    return subplots(rows, columns, figsize=figsize, squeeze=False, **settings)


def above(cycle: int, branch: str) -> float:
    """Return the drawing order of a branch of a curve: unloading above all loadings.

    An unloading is therefore seen on the loading of the next cycle, which is nearly equal.
    """
    return 2.0 if branch == LOADING else 3.0 - 0.01 * cycle


def decimal_ticks(*logarithmic: Axis, **locator) -> None:
    """Label logarithmic axes by decimal numbers, at 1, 2 and 5 of each decade.

    An axis over more than a factor of 50 has labels at 1 and 3, over more than 3,000 at 1 alone.
    ``locator`` are further arguments of matplotlib's `LogLocator`.
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
    """Put the ticks of an axis only at some values, with ``labels``, by default the values.

    The limits of the axis do not change.
    """
    values = list(values)
    axis.set_major_locator(FixedLocator(values))
    axis.set_minor_locator(NullLocator())
    axis.set_ticklabels([f"{value:g}" for value in values] if labels is None else list(labels))


def percent_ticks(axis: Axis, linear: float, low: float, high: float, narrow: bool = False) -> str:
    """Set limits and scale of an axis of signed percentages; return words for its label.

    The axis reaches from ``low`` to ``high``. If it reaches farther than four times ``linear``, it
    is logarithmic beyond ``linear`` on either side, with labels where there is room, 0 and powers
    of ten first, and short ticks between them. Otherwise it is linear, and the words are "". With
    ``narrow`` the linear part is half as long, and labels have the room of small letters, which the
    caller sets.
    """
    horizontal = isinstance(axis, XAxis)
    axes = axis.axes
    set_scale, set_limits = (
        (axes.set_xscale, axes.set_xlim) if horizontal else (axes.set_yscale, axes.set_ylim)
    )
    if max(-low, high) <= 4.0 * linear:
        set_limits(low, high)
        return ""
    set_scale("symlog", linthresh=linear, linscale=0.5 if narrow else 1.0)
    set_limits(low, high)
    steps = [step * 10.0**power for step in range(1, 10) for power in range(-3, 7)]
    beyond = sorted(step for step in steps if linear < step <= max(-low, high))
    by_lead = {lead: [value for value in beyond if f"{value:e}"[0] == lead] for lead in "1532"}
    tens = [value for value in reversed(by_lead["1"]) if value > 3.0 * linear]
    magnitudes = [0.0, *tens, linear, *(value for lead in "1532" for value in by_lead[lead])]
    length = (axes.bbox.width if horizontal else axes.bbox.height) / axes.figure.dpi
    places = axis.get_transform().transform
    start, end = places(np.array([low, high]))
    scale = (end - start) / length

    def room(value: float) -> float:
        width = _SMALL_CHARACTER * (len(f"{value:g}") + 1.0) if narrow else _LABEL_WIDTH
        return scale * (width if horizontal else _LABEL_HEIGHT)

    ticks: list[float] = []
    for value in (sign * magnitude for magnitude in magnitudes for sign in (1.0, -1.0)):
        free = all(
            abs(np.diff(places(np.array([tick, value])))[0]) >= 0.5 * (room(tick) + room(value))
            for tick in ticks
        )
        if low <= value <= high and free:
            ticks.append(value)
    ticks_at(axis, sorted(ticks))
    axis.set_minor_locator(FixedLocator([sign * value for value in beyond for sign in (-1, 1)]))
    return f", logarithmic beyond ±{linear:g}"

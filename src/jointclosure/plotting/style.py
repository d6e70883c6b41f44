"""Style of all figures, applied where a figure is made and where it is drawn.

It is never set for the whole process: a notebook that imports this package keeps its backend and
its style.
"""

import functools
from collections.abc import Callable
from typing import TypeVar

import matplotlib
import seaborn as sns
from cycler import cycler
from matplotlib.figure import Figure

from jointclosure.joint.protocol import LOADING, UNLOADING

BRANCH_LINES = {LOADING: "-", UNLOADING: "--"}
"""Line style of each branch in every figure."""

_STYLE = {
    **sns.plotting_context("paper", font_scale=1.1),
    **sns.axes_style("ticks"),
    "axes.prop_cycle": cycler("color", sns.color_palette("colorblind")),
    "patch.facecolor": sns.color_palette("colorblind")[0],
    "figure.dpi": 150,
    "savefig.dpi": 150,
    "axes.grid": False,
}


class StyledFigure(Figure):
    """Figure that also applies the style to parts that matplotlib makes while drawing (ticks)."""

    def draw(self, renderer):
        """As `Figure.draw`."""
        with matplotlib.rc_context(_STYLE):
            super().draw(renderer)

    def savefig(self, fname, **settings):
        """As `Figure.savefig`."""
        with matplotlib.rc_context(_STYLE):
            super().savefig(fname, **settings)


_Drawn = TypeVar("_Drawn")


def styled(draw: Callable[..., _Drawn]) -> Callable[..., _Drawn]:
    """Decorate a function that makes a figure, or draws on one, to apply the style."""

    @functools.wraps(draw)
    def drawn(*arguments, **settings) -> _Drawn:
        with matplotlib.rc_context(_STYLE):
            return draw(*arguments, **settings)

    return drawn


def subplots(rows: int = 1, columns: int = 1, *, figsize, layout=None, **settings) -> tuple:
    """Return a figure and its axes like ``pyplot.subplots``, but unknown to pyplot."""
    figure = StyledFigure(figsize=figsize, layout=layout)
    return figure, figure.subplots(rows, columns, **settings)


def above(cycle: int, branch: str) -> float:
    """Return the drawing order: unloading above the next cycle's nearly equal loading."""
    return 2.0 if branch == LOADING else 3.0 - 0.01 * cycle

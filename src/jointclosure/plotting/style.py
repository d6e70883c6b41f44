"""How all figures look. The style holds where a figure is made and where it is drawn.

Nothing of it is set for the whole process: a notebook that imports this package keeps its
backend and its own style.
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
"""Line style of a branch in every figure."""

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
    """A figure whose parts that matplotlib makes while drawing (ticks) have the style too."""

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
    """A function that makes a figure or draws on one, in the style."""

    @functools.wraps(draw)
    def drawn(*arguments, **settings) -> _Drawn:
        with matplotlib.rc_context(_STYLE):
            return draw(*arguments, **settings)

    return drawn


def subplots(rows: int = 1, columns: int = 1, *, figsize, layout=None, **settings) -> tuple:
    """A figure and its axes, as ``pyplot.subplots``, which pyplot does not keep."""
    figure = StyledFigure(figsize=figsize, layout=layout)
    return figure, figure.subplots(rows, columns, **settings)


def above(cycle: int, branch: str) -> float:
    """Order of drawing: unloading on the next cycle's loading, which nearly is the same curve."""
    return 2.0 if branch == LOADING else 3.0 - 0.01 * cycle

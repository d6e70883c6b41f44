"""Figures of tables: a row of panels for each quantity, a column for each coordinate; legends."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from jointclosure.ensembles.quantities import HEADINGS
from jointclosure.plotting.style import decimal_ticks, panel_grid, styled, ticks_at

_LOG_TICKS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
_KEY = 0.7
"""Width [inches] of an entry of a legend without its text."""
_LETTER = 0.07
"""Width [inches] of a letter of a legend."""
_INSIDE = 3
"""Largest number of entries of a legend that is drawn within a panel."""


def key(label: str, **style) -> Line2D:
    """Return an entry of a legend for which nothing is drawn in the axes."""
    return Line2D([], [], label=label, **style)


def point_key(label: str, marker: str = "o", **style) -> Line2D:
    """Return an entry of a legend with a marker and no line."""
    return key(label, marker=marker, ls="", **style)


def legend_below(
    figure: Figure, handles: Sequence[Artist], columns: int | None = None, **settings: Any
) -> None:
    """Draw a legend of ``handles`` below all axes of a figure.

    It has the given number of ``columns``. By default it has as many as fit into the width of the
    figure, which is widened if it is narrower than one column. ``settings`` are those of
    `Figure.legend`.
    """
    settings |= {"ncols": columns or _fitting(handles, figure.get_figwidth()), "frameon": False}
    if columns is None:
        figure.set_figwidth(max(figure.get_figwidth(), _width(handles)))
    figure.legend(handles=handles, loc="outside lower center", **settings)


def _width(handles: Sequence[Artist]) -> float:
    """Return the width [inches] of a column of a legend that has these entries."""
    return _KEY + _LETTER * max((len(str(handle.get_label())) for handle in handles), default=0)


def _fitting(handles: Sequence[Artist], width: float) -> int:
    """Return the largest number of columns, at least 1, of a legend that fits a width [inches]."""
    for count in range(len(handles), 1, -1):
        columns = np.array_split(np.arange(len(handles)), count)
        if sum(_width([handles[i] for i in column]) for column in columns) <= width:
            return count
    return 1


def legend_keys(panels: Iterable[Axes]) -> list[Artist]:
    """Return one legend entry for each different label in the panels."""
    entries: dict[str, Artist] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return list(entries.values())


class Row(NamedTuple):
    """Row of panels: its label, a table, and the names of two columns of the table.

    The columns have the values that are drawn, and their standard errors. ``axes`` are arguments of
    `Axes.set` for each panel.
    """

    label: str
    table: pd.DataFrame
    value: str
    error: str
    axes: Mapping[str, Any] = {}


class PanelColumn(NamedTuple):
    """Column of panels, in which tables are drawn over their column ``along``.

    There is a line for each value of the column ``lines``. Only rows of the table with the values
    ``where``, by column, are drawn. ``scale`` of the axis is linear, log or symlog; on a log scale
    0 and infinity are drawn at its ends. If ``level`` has values by column, the row with these
    values is no point of a line, but is drawn as a horizontal line across the panel.
    """

    along: str
    lines: str
    where: Mapping[str, Any] = {}
    scale: str = "linear"
    title: str = ""
    level: Mapping[str, Any] = {}

    def of(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the rows of a table that are drawn as lines."""
        table = _having(table, self.where)
        return table.drop(_having(table, self.level).index) if self.level else table


def _having(table: pd.DataFrame, values: Mapping[str, Any]) -> pd.DataFrame:
    """Return the rows of a table that have the given values, by column."""
    return table[(table[list(values)] == pd.Series(values, dtype=object)).all(axis=1)]


Names = Mapping[str, Mapping[Any, str]]
"""Names of values, such as infinity, at axes and in legends, by column and value."""


@styled
def panels(
    rows: Sequence[Row],
    columns: Sequence[PanelColumn],
    names: Names,
    *,
    styles: str = "",
    bars: float = 1.0,
    reference: float | None = None,
    sharey: str | bool = "row",
) -> Figure:
    """Draw the values of tables over coordinates, with error bars, in a grid of panels.

    Bars have ``bars`` standard errors to each side. If ``styles`` names a column of the tables,
    each of its values has a line style. ``reference`` is the height of a horizontal grey line in
    all panels, and ``sharey`` is as for `matplotlib.pyplot.subplots`.
    """
    shape = (len(rows), len(columns))
    panel = (max(3.3, 6.6 / len(columns)), 2.3)
    figure, grid = panel_grid(*shape, panel, (0.0, 0.8), sharex="col", sharey=sharey)
    whole = pd.concat([row.table for row in rows], ignore_index=True)
    dashes = _dashes(whole[styles], names) if styles else {}
    legends = {}
    for axes, column in zip(grid.T, columns, strict=True):
        known = column.of(whole)
        looks = _looks(known[column.lines], names)
        places = _places(known[column.along], column.scale)
        drawn = [
            ({column.lines: line} | ({styles: style} if dashes else {}), look | dash)
            for line, look in looks.items()
            for style, dash in (dashes or {"": {}}).items()
        ]
        for panel, row in zip(axes, rows, strict=True):
            _draw(panel, column, row, drawn, places, bars, 1.8 if styles else 0.0)
            if reference is not None:
                panel.axhline(reference, color="0.7", lw=0.8, zorder=0)
            panel.set(**row.axes)
            if "ylim" in row.axes:
                _mark_below(panel)
            if panel.get_yscale() == "log":
                decimal_ticks(panel.yaxis, subs=_LOG_TICKS)
        axes[0].set_title(column.title)
        positive = [value for value in places if value > 0.0]
        if column.scale == "log":
            axes[-1].set_xscale("log")
        elif column.scale == "symlog" and positive:  # small values are as far apart as large ones
            axes[-1].set_xscale("symlog", linthresh=positive[0], linscale=0.4)
            axes[-1].set_xlim(-0.4 * positive[0], 1.6 * positive[-1])
        elif styles:
            axes[-1].margins(x=0.08)  # for bars beside each other
        axes[-1].set_xlabel(HEADINGS.get(column.along, column.along) + _scale_words(column, places))
        words = [_name(column.along, value, names).replace(" ", "\n") for value in places]
        ticks_at(axes[-1].xaxis, places.values(), words)
        styled_keys = [key(color="0.3", marker="o", ms=3.5, **dash) for dash in dashes.values()]
        legends[column.lines] = [*(key(**look) for look in looks.values()), *styled_keys]
        for level in list(column.level.items())[:1]:
            legends[column.lines].append(key(_name(*level, names), color="0.6"))
    for panel, row in zip(grid[:, 0], rows, strict=True):
        panel.set_ylabel(fill(row.label, 28))
    if len(legends) > 1:
        for axes, lines in zip(grid[0], [column.lines for column in columns], strict=True):
            if lines in legends and len(legends[lines]) <= _INSIDE:
                title = HEADINGS.get(lines, lines)
                axes.legend(handles=legends.pop(lines), title=title, frameon=False)
    sides = ["center"] if len(legends) == 1 else ["left", "right"]
    for side, (lines, handles) in zip(sides, legends.items(), strict=False):
        fit = _fitting(handles, figure.get_figwidth() / len(legends))
        settings = {"ncols": fit, "frameon": False, "fontsize": "small"}
        title = "" if styles else HEADINGS.get(lines, lines)
        figure.legend(handles=handles, loc=f"outside lower {side}", title=title, **settings)
    return figure


def _scale_words(column: PanelColumn, places: Mapping[float, float]) -> str:
    """Return words on the scale of a column of panels for the label of its axis; "" if linear."""
    positive = [value for value in places if value > 0.0]
    if column.scale == "symlog" and positive:
        return f",\nlogarithmic beyond {positive[0]:g}"
    return ",\nlogarithmic" if column.scale == "log" else ""


def _mark_below(axes: Axes) -> None:
    """Mark values below the lower end of the y axis at this end, by an arrow and the value."""
    low = axes.get_ylim()[0]
    for line in [container[0] for container in axes.containers]:
        for x, y in zip(*line.get_data(), strict=True):
            if y < low:
                axes.plot([x], [low], marker="v", ms=7.0, color=line.get_color(), clip_on=False)
                axes.annotate(
                    f"{y:.2g}", (x, low), (16.0, 3.0), textcoords="offset points", color="0.3"
                )


def _name(column: Any, value: Any, names: Names) -> str:
    return names.get(column, {}).get(value) or (value if isinstance(value, str) else f"{value:g}")


def _looks(values: pd.Series, names: Names) -> dict[Any, dict[str, Any]]:
    """Return the label, colour and marker of the line of each value of a column.

    For real numbers colours follow their order. Otherwise colours may be repeated, and markers with
    a repeated colour are hollow.
    """
    real = pd.api.types.is_float_dtype(values)
    known = list(dict.fromkeys(values.sort_values() if real else values))
    palette = sns.color_palette("viridis" if real else "colorblind", len(known))
    looks = {}
    colours = len(known) if real else len(sns.color_palette("colorblind"))
    for i, (value, mark) in enumerate(zip(known, itertools.cycle("osD^vP*X"), strict=False)):
        label = _name(values.name, value, names)
        looks[value] = {"label": label, "color": palette[i], "marker": mark, "ms": 3.5}
        looks[value] |= {"mfc": "white"} if i >= colours else {}  # as its colour is repeated
    return looks


def _dashes(values: pd.Series, names: Names) -> dict[Any, dict[str, Any]]:
    """Return the label and line style of each value of a column, the largest value first.

    Markers of all but the largest value are hollow.
    """
    dashes: dict[Any, dict[str, Any]] = {}
    styles = itertools.cycle(("-", "--", ":"))
    for value, style in zip(sorted(values.unique(), reverse=True), styles, strict=False):
        hollow = {"mfc": "white"} if dashes else {}
        dashes[value] = {"label": _name(values.name, value, names), "ls": style} | hollow
    return dashes


def _places(values: pd.Series, scale: str) -> dict[float, float]:
    """Return where each value of a coordinate is drawn on its axis, by value, ascending.

    On a log scale 0 and infinity have places beyond the other values.
    """
    known = np.sort(values.unique().astype(float))
    inner = known[(known > 0.0) & np.isfinite(known)]
    least, most = (inner[0], inner[-1]) if inner.size else (1.0, 1.0)
    ends = {0.0: least / 3.0, np.inf: 3.0 * most} if scale == "log" else {}
    return {value: ends.get(value, value) for value in known}


def _draw(
    axes: Axes,
    column: PanelColumn,
    row: Row,
    lines: Sequence,
    places: Mapping,
    bars: float,
    apart: float,
) -> None:
    """Draw the lines of a panel with their error bars, and the level of its column, if any.

    ``lines`` has pairs: values by column that select a line's rows, and its style. ``places`` are
    those of `_places`. Lines are drawn ``apart`` [points] beside each other, so that their bars do
    not overlap. The error of the level is a band.
    """
    table = column.of(row.table)
    figure = axes.get_figure(root=True)
    assert figure is not None
    for number, (where, look) in enumerate(lines):
        line = _having(table, where).sort_values(column.along)
        at = line[column.along].map(places)
        error = bars * line[row.error]
        drawn = axes.errorbar(at, line[row.value], error, lw=1.0, capsize=1.5, **look)
        aside = apart * (number - 0.5 * (len(lines) - 1)) / 72.0
        moved = axes.transData + ScaledTranslation(aside, 0.0, figure.dpi_scale_trans)
        for artist in drawn.get_children() if apart else ():
            artist.set_transform(moved)
    if column.level:
        level = _having(row.table, {**column.where, **column.level}).iloc[0]
        value = level[row.value]
        error = bars * level[row.error]
        axes.axhspan(value - error, value + error, color="0.9", lw=0.0, zorder=0)
        axes.axhline(value, color="0.6", lw=1.2, zorder=0)

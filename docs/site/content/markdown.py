"""Tables as Markdown, declared by what stands in their rows and how their cells are written.

A form writes a cell of some rows of a stored table: a format string, or a function of the `Group`.
Fields of a string are columns of the first row, "{low:.1f} to {high:.1f}"; "{x min}" and "{x max}"
the least and largest of all rows; "{x±error}" a value with its standard error, rounded to it.
Conversion ``!k`` is to three figures with thousands set off, ``!p`` to a tenth and below that to
one digit. Where a field is absent (NaN) in the rows, the cell is empty.
"""

from collections.abc import Callable, Mapping
from string import Formatter
from typing import NamedTuple

import pandas as pd
from stored import stored

from jointclosure.statistics.standard_errors import rounded

MOST = "the most"
"""The largest value that a column has (`rows_of`)."""


class Group:
    """Rows of a table that a cell is made of; item "x" is column x of the first one."""

    def __init__(self, rows: pd.DataFrame, first: dict | None = None) -> None:
        self.rows = rows
        # as records, whose numbers are Python's: numpy's round otherwise
        self.first = first or rows.iloc[:1].to_dict("records")[0]

    def __getitem__(self, name: str) -> object:
        """Value of a field; a `KeyError` names a column that there is not."""
        if name in self.first:
            return self.first[name]
        column, _, which = name.rpartition(" ")
        if which in ("min", "max"):
            return getattr(self.rows[column], which)()
        value, _, error = name.partition("±")
        if error:
            return float("nan") if pd.isna(self[value]) else rounded(self[value], self[error])
        raise KeyError(name)


Form = str | Callable[[Group], object]


class _Forms(Formatter):
    def convert_field(self, value, conversion):
        """Know ``!k`` and ``!p`` besides the usual conversions."""
        if conversion == "k":
            return f"{float(f'{value:.3g}'):,.15g}"
        if conversion == "p":
            return f"{value:.1f}" if abs(value) >= 0.1 else f"{value:.1g}"
        return super().convert_field(value, conversion)


_FORMS = _Forms()


def written(form: Form, group: Group) -> str:
    """Write a cell."""
    if callable(form):
        return str(form(group))
    names = [name for _, name, _, _ in _FORMS.parse(form) if name]
    absent = any(pd.isna(group[name]) for name in names)
    return "" if absent else _FORMS.vformat(form, (), group)


class Table(NamedTuple):
    """A table of a page; called, it is its Markdown.

    Parameters
    ----------
    of : str
        The stored table, "run/table".
    columns : mapping
        Forms of cells, by their headings.
    rows : mapping
        Forms, by their headings, of the first columns: rows of the stored table for which they
        are alike make one row. Without them every stored row makes one.
    across, cell : form
        The heading that a stored row stands under, and the cells below such headings. These
        columns are before those of ``columns``.
    prepare : callable
        What is done to the stored table before.
    """

    of: str
    columns: Mapping[str, Form] = {}
    rows: Mapping[str, Form] = {}
    across: Form = ""
    cell: Form = ""
    prepare: Callable[[pd.DataFrame], pd.DataFrame] = lambda table: table

    def __call__(self) -> str:
        """Write the table."""
        table = self.prepare(stored(*self.of.split("/"))).reset_index(drop=True)
        records = table.to_dict("records")
        single = [Group(table[at : at + 1], records[at]) for at in range(len(table))]
        keys = [tuple(written(form, row) for form in self.rows.values()) for row in single]
        heads = pd.Series([written(self.across, row) for row in single])
        lines = []
        places = pd.Series(keys if self.rows else range(len(table)))
        for place in dict.fromkeys(places):
            here = places == place
            line = dict(zip(self.rows, place if self.rows else (), strict=True))
            for head in _ordered(table, heads) if self.across else ():
                part = table[here & (heads == head)]
                line[head] = written(self.cell, Group(part)) if len(part) else ""
            group = Group(table[here])
            lines.append(line | {name: written(form, group) for name, form in self.columns.items()})
        return markdown(pd.DataFrame(lines))


def _ordered(table: pd.DataFrame, heads: pd.Series) -> list[str]:
    """Headings in the order of `titled`, else as they come."""
    order = list(table.title.cat.categories) if hasattr(table.get("title"), "cat") else []
    return sorted(dict.fromkeys(heads), key=lambda head: order.index(head) if head in order else 0)


def markdown(table: pd.DataFrame) -> str:
    """Write a table whose columns are its headings; what is absent is empty."""
    cells = [["" if pd.isna(cell) else str(cell) for cell in row] for row in table.to_numpy()]
    rows = [[str(title) for title in table.columns], ["---"] * table.shape[1], *cells]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def chosen(**values: object) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """Return a function that selects rows by values of columns (`rows_of`)."""
    return lambda table: rows_of(table, **values)


def rows_of(table: pd.DataFrame, **values: object) -> pd.DataFrame:
    """Choose rows by values of columns; `MOST` is the largest there is. `ValueError` if none."""
    for name, value in values.items():
        table = table[table[name] == (table[name].max() if value == MOST else value)]
    if table.empty:
        raise ValueError(f"no row has {values}")
    return table


def titled(table: pd.DataFrame, titles: Mapping[tuple, str], *columns: str) -> pd.DataFrame:
    """Choose the rows whose columns have the keys of ``titles``, and add the titles.

    They are column ``title`` of what is returned, and sort as they stand in ``titles``.
    """
    keys = list(table[list(columns)].itertuples(index=False, name=None))
    names = pd.Categorical([titles.get(key) for key in keys], list(titles.values()), ordered=True)
    return table.assign(title=names).dropna(subset=["title"])


def value_of(table: str, form: Form, **values: object) -> str:
    """Write rows of a stored table, "run/table", that have some values."""
    return written(form, Group(rows_of(stored(*table.split("/")), **values)))

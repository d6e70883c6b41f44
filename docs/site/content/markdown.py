"""Tables as Markdown, from what their columns are called and how cells are written.

A cell is written by a format string over the columns of a row, "{low:.1f} to {high:.1f}", or by a
function of the row. Conversion ``!k`` writes a number to three figures, with thousands set off:
"{pairs!k}". Where a column of the string is absent (NaN) in a row, the cell is empty.
"""

from collections.abc import Callable, Mapping
from string import Formatter

import pandas as pd

from jointclosure.statistics.standard_errors import rounded

Form = str | Callable[[dict], object]
Cell = Callable[[pd.DataFrame], object]


class _Forms(Formatter):
    def convert_field(self, value: object, conversion: str | None) -> object:
        """Know ``!k`` besides the usual conversions."""
        if conversion == "k":
            return f"{float(f'{value:.3g}'):,.15g}"
        return super().convert_field(value, conversion)


_FORMS = _Forms()


def markdown(table: pd.DataFrame) -> str:
    """Write a table whose columns are its headings; what is absent is empty."""
    cells = [["" if pd.isna(cell) else str(cell) for cell in row] for row in table.to_numpy()]
    rows = [[str(title) for title in table.columns], ["---"] * table.shape[1], *cells]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def listed(table: pd.DataFrame, columns: Mapping[str, Form]) -> str:
    """Write a row for each row of a table."""
    rows = table.to_dict("records")
    return markdown(
        pd.DataFrame(
            [{title: written(form, row) for title, form in columns.items()} for row in rows]
        )
    )


def grouped(
    table: pd.DataFrame,
    rows: Mapping[str, str],
    columns: Mapping[str, Cell] | None = None,
    across: str | None = None,
    cell: Cell = len,
) -> str:
    """Write a row for each group of rows of a table, in their order.

    Parameters
    ----------
    table : DataFrame
    rows : mapping
        Columns that tell groups apart, by their headings.
    columns : mapping, optional
        Functions that make the rows of a group into a cell, by the headings of the cells. They
        stand behind those of ``across``.
    across : str, optional
        A column whose values are headings: in their order, where they have one (`titled`), else
        as they come.
    cell : callable
        What makes the rows of a group and such a heading into a cell.
    """
    titles = _headings(table[across]) if across else []
    lines = []
    for key, group in table.groupby(list(rows.values()), sort=False, dropna=False):
        parts = dict(list(group.groupby(across, sort=False))) if across else {}
        line = dict(zip(rows, key, strict=True))
        line |= {title: cell(parts[title]) if title in parts else "" for title in titles}
        lines.append(line | {title: form(group) for title, form in (columns or {}).items()})
    return markdown(pd.DataFrame(lines))


def _headings(column: pd.Series) -> list[str]:
    """Values of a column, without repetition."""
    names = list(dict.fromkeys(column))
    return (
        [name for name in column.cat.categories if name in names]
        if hasattr(column, "cat")
        else names
    )


def written(form: Form, row: dict) -> object:
    """Write a cell of a row; a `KeyError` names a column that there is not."""
    if callable(form):
        return form(row)
    names = [name for _, name, _, _ in _FORMS.parse(form) if name]
    return "" if any(pd.isna(row[name]) for name in names) else _FORMS.vformat(form, (), row)


def with_error(value: str, error: str, scale: float = 1.0) -> Form:
    """Write a column with its standard error; nothing where it is absent."""
    return lambda row: (
        "" if pd.isna(row[value]) else rounded(scale * row[value], scale * row[error])
    )


def rows_of(table: pd.DataFrame, **values: object) -> pd.DataFrame:
    """Choose rows by values of columns; `MOST` is the largest there is. `ValueError` if none."""
    for name, value in values.items():
        table = table[table[name] == (table[name].max() if value == MOST else value)]
    if table.empty:
        raise ValueError(f"no row has {values}")
    return table


MOST = "the most"


def first_row(table: pd.DataFrame) -> tuple:
    """Give the first row, its values as attributes: Python's numbers, which round as written."""
    return next(table.itertuples())


def titled(table: pd.DataFrame, titles: Mapping[tuple, str], *columns: str) -> pd.DataFrame:
    """Choose the rows whose columns have the keys of ``titles``, and add the titles.

    They are column ``title`` of what is returned, and sort as they stand in ``titles``.
    """
    keys = list(table[list(columns)].itertuples(index=False, name=None))
    names = pd.Categorical([titles.get(key) for key in keys], list(titles.values()), ordered=True)
    return table.assign(title=names).dropna(subset=["title"])


def span(values: pd.Series, errors: pd.Series, digits: int = 2) -> str:
    """Write the least and the largest value, and the largest standard error."""
    return f"{values.min():.{digits}f} to {values.max():.{digits}f} (± {errors.max():.{digits}f})"

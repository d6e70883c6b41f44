"""Tables and figures of the page: cells with their text and sort key, captions."""

from numbers import Integral, Real
from typing import NamedTuple

import pandas as pd

from jointclosure.cli.page import ABSENT, number_text, source
from jointclosure.engine.quantities import HEADINGS
from jointclosure.statistics.standard_errors import rounded


class Caption(NamedTuple):
    """Title and alternative text, as plain text, and the plain paragraphs of the caption."""

    title: str
    alternative: str
    paragraphs: list[str]


class Picture(NamedTuple):
    """Figure: its name, the bytes of its PNG, and its caption."""

    name: str
    png: bytes
    caption: Caption

    @property
    def source(self) -> str:
        """Figure as a data URL."""
        return source(self.png)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels, from the first chunk of the PNG."""
        return int.from_bytes(self.png[16:20]), int.from_bytes(self.png[20:24])


class Cell(NamedTuple):
    """Text of a cell, and its sort key: a number, a text, or "" for an empty cell."""

    text: str
    key: float | str


class Sheet(NamedTuple):
    """Table with its caption; ``name`` is its id, and the first cell of a row is its heading."""

    name: str
    caption: str
    titles: list[str]
    rows: list[list[Cell]]

    @property
    def kinds(self) -> list[str]:
        """Kind of each column: "number", "word" (kept on one line) or "text"."""
        return [_kind([row[i] for row in self.rows]) for i in range(len(self.titles))]


def sheet(name: str, caption: str, frame: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Make a table of the titled columns; numbers are rounded to columns with _standard_error."""
    shown = frame[list(titles)].astype(object)
    for column in titles:
        if (error := f"{column}_standard_error") in frame:
            shown[column] = [
                cell(value)._replace(text=rounded(value, spread))
                for value, spread in zip(frame[column], frame[error], strict=True)
            ]
    rows = [[cell(value) for value in row] for row in shown.itertuples(index=False)]
    return Sheet(name, caption, list(titles.values()), rows)


def headings(*columns: str) -> dict[str, str]:
    """Return headings of columns of quantities, or of their means ("max_closure_mean_mm")."""
    titles = {column: HEADINGS[column.replace("_mean_", "_")] for column in columns}
    return {column: title[0].upper() + title[1:] for column, title in titles.items()}


def cell(value: object) -> Cell:
    """Format a value for reading: numbers to four digits, missing values as a dash."""
    if isinstance(value, Cell):
        return value
    if isinstance(value, bool) or value is None or not isinstance(value, Real):
        words: dict[object, str] = {True: "yes", False: "no", None: ABSENT, "": ABSENT}
        text = words.get(value, str(value))
        return Cell(text, "" if text == ABSENT else text)
    if isinstance(value, Integral):
        return Cell(str(int(value)), int(value))
    text = number_text(float(value))
    return Cell(text, "" if text == ABSENT else float(value))


def given(value: float) -> Cell:
    """Format a configured number in its shortest form."""
    return Cell(f"{value:.6g}", float(value))


_LONGEST_WORD = 28
"""Number of characters up to which texts of a column are kept on one line."""


def _kind(cells: list[Cell]) -> str:
    if any(isinstance(cell.key, Real) for cell in cells) and all(
        isinstance(cell.key, Real) or cell.key == "" for cell in cells
    ):
        return "number"
    longest = max((len(line) for cell in cells for line in cell.text.split("\n")), default=0)
    return "word" if longest <= _LONGEST_WORD else "text"

"""Rendering of the page of a study: cells and tables, and figures."""

import hashlib
from collections.abc import Mapping
from importlib import resources
from numbers import Integral, Real
from typing import NamedTuple

import pandas as pd

from jointclosure.cli import report
from jointclosure.cli.report import source
from jointclosure.engine.quantities import HEADINGS
from jointclosure.statistics.standard_errors import ABSENT, number_text, rounded


class Picture(NamedTuple):
    """Figure: the bytes of its PNG."""

    png: bytes

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
    """Headings and rows of a table; the first cell of a row is its heading."""

    titles: list[str]
    rows: list[list[Cell]]

    @property
    def kinds(self) -> list[str]:
        """Kind of each column: "number", "word" (kept on one line) or "text"."""
        return [_kind([row[i] for row in self.rows]) for i in range(len(self.titles))]


def sheet(frame: pd.DataFrame, columns: str = "", heads: Mapping[str, str] = {}) -> Sheet:
    """Make a table of named columns, or of all, which then have the names of their headings.

    Numbers are rounded to columns with _standard_error.
    """
    names = columns.split() or list(frame.columns)
    shown = (frame[names] if columns else frame).astype(object)
    for column in names:
        if (error := f"{column}_standard_error") in frame:
            shown[column] = list(map(known_cell, frame[column], frame[error]))
    rows = [[cell(value) for value in row] for row in shown.itertuples(index=False)]
    return Sheet([heads.get(column) or heading_of(column) for column in names], rows)


def heading_of(column: str) -> str:
    """Return the heading of a quantity, of its mean ("max_closure_mean_mm"), or of the column."""
    title = HEADINGS.get(column.replace("_mean_", "_"), column.replace("_", " "))
    return title[0].upper() + title[1:]


def known_cell(value: float, error: float) -> Cell:
    """Format a number rounded to its error."""
    return cell(value)._replace(text=rounded(value, error))


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


_LONGEST_WORD = 28
"""Number of characters up to which texts of a column are kept on one line."""


def _kind(cells: list[Cell]) -> str:
    if any(isinstance(cell.key, Real) for cell in cells) and all(
        isinstance(cell.key, Real) or cell.key == "" for cell in cells
    ):
        return "number"
    longest = max((len(line) for cell in cells for line in cell.text.split("\n")), default=0)
    return "word" if longest <= _LONGEST_WORD else "text"


def render(content: dict) -> str:
    """Render the content of `studies.paper.report.content.content` as HTML."""
    return report.render(content | {"sheet": sheet}, "page.html.j2", "studies.paper.report")


def template_digest() -> str:
    """Return the digest of the templates, which a page depends on besides the package's Python."""
    digest = hashlib.sha256()
    for package in (report.LIBRARY, "studies.paper.report"):
        templates = resources.files(package).joinpath("templates")
        for file in sorted(templates.iterdir(), key=lambda file: file.name):
            digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]

"""Rendering of the page of a study: cells and tables, figures and their captions.

The caption of a figure is a page of reStructuredText that Snakemake's report reads too, with Jinja
expressions for values of the configuration; its title and alternative text are comments.
"""

import hashlib
from collections.abc import Mapping
from importlib import resources
from numbers import Integral, Real
from typing import NamedTuple

import jinja2
import pandas as pd

from jointclosure.cli import report
from jointclosure.cli.report import source
from jointclosure.engine.quantities import HEADINGS
from jointclosure.statistics.standard_errors import ABSENT, number_text, rounded


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


_SETTINGS = {
    "file_insertion_enabled": False,
    "raw_enabled": False,
    "strip_comments": False,
    "halt_level": 2,  # of docutils: a warning is an error
    "report_level": 5,
}


def read_caption(text: str, configuration: dict) -> Caption:
    """Return a caption for a study with this configuration."""
    import docutils.core
    import docutils.nodes

    environment = jinja2.Environment(undefined=jinja2.StrictUndefined)
    filled = environment.from_string(text).render(snakemake={"config": configuration})
    document = docutils.core.publish_doctree(filled, settings_overrides=_SETTINGS)
    comments = {}
    for comment in document.findall(docutils.nodes.comment):
        key, _, value = comment.astext().partition(":")
        comments[key.strip()] = " ".join(value.split())
    paragraphs = [
        " ".join(node.astext().split()) for node in document.findall(docutils.nodes.paragraph)
    ]
    missing = [key for key in ("title", "alt") if not comments.get(key)]
    if missing or not paragraphs:
        raise ValueError(f"a caption lacks {', '.join(missing) or 'its text'}: {text[:60]!r}")
    return Caption(comments["title"], comments["alt"], paragraphs)

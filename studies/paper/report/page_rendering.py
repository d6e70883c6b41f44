"""Rendering of the page of a study: cells and tables, and figures."""

import hashlib
import re
from collections.abc import Mapping
from importlib import resources
from numbers import Integral, Real
from typing import NamedTuple

import pandas as pd

from jointclosure.cli import report
from jointclosure.ensembles.quantities import HEADINGS
from jointclosure.statistics.number_texts import ABSENT, number_text, rounded


class Sheet(NamedTuple):
    """Headings, kinds and rows of a table; the first cell of a row is its heading.

    The kind of a column is "number", "word" (kept on one line) or "text".
    """

    titles: list[str]
    kinds: list[str]
    rows: list[tuple[str, ...]]


_ERRORS = ("_standard_error", "_half_width")
"""Suffixes of columns that have the error of a number."""


def sheet(frame: pd.DataFrame, columns: str = "", heads: Mapping[str, str] = {}) -> Sheet:
    """Make a table of the named ``columns`` of a frame, or of all columns if none is named.

    ``heads`` are headings by column; others are those of `column_heading`. Numbers are rounded by
    their columns of errors (``_standard_error`` or ``_half_width``), which follow them after "±".
    Columns of adjusted numbers are left out if all are missing.
    """
    named = [(name, frame[name]) for name in columns.split()]
    named = named or [one for one in frame.items() if not str(one[0]).endswith(_ERRORS)]
    titles = []
    texts = []
    for name, values in named:
        errors = [frame[f"{name}{suffix}"] for suffix in _ERRORS if f"{name}{suffix}" in frame]
        shown = list(
            map(rounded, values, errors[0]) if errors else map(text, values.astype(object))
        )
        if "adjusted" in str(name) and all(one == ABSENT for one in shown):
            continue
        texts.append(shown)
        titles.append(heads.get(name) or column_heading(name))
    return Sheet(titles, list(map(_kind, texts)), list(zip(*texts, strict=True)))


def column_heading(column: str) -> str:
    """Return the heading of a column: that of its quantity if it is one, or a mean of one."""
    title = HEADINGS.get(column.replace("_mean_", "_"), column.replace("_", " "))
    return title[0].upper() + title[1:]


def text(value: object) -> str:
    """Format a value for reading: numbers to four digits, missing values as a dash."""
    if isinstance(value, Real) and not isinstance(value, bool):
        return str(int(value)) if isinstance(value, Integral) else number_text(float(value))
    words: dict[object, str] = {True: "yes", False: "no", None: ABSENT, "": ABSENT}
    return words.get(value, str(value))


_LONGEST_WORD = 28
"""Number of characters up to which texts of a column are kept on one line."""


def _kind(texts: list[str]) -> str:
    if all(one == ABSENT or re.match(r"[-<]? ?\d", one) for one in texts):
        return "number"
    longest = max(len(line) for one in texts for line in one.split("\n"))
    return "word" if longest <= _LONGEST_WORD else "text"


def render(content: dict) -> str:
    """Render the content of `studies.paper.report.content.content` as HTML."""
    return report.render(content | {"sheet": sheet}, "page.html.j2", "studies.paper.report")


def template_digest() -> str:
    """Return a digest (16 hexadecimal digits) of all templates of the library and of this report.

    A page depends on them besides Python code.
    """
    digest = hashlib.sha256()
    for package in (report.LIBRARY, "studies.paper.report"):
        templates = resources.files(package).joinpath("templates")
        for file in sorted(templates.iterdir(), key=lambda file: file.name):
            digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]

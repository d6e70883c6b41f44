"""Text files of scanned walls as instruments and people write them: points, matrices of heights."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.walls.scans.contents import (
    VARIABLE,
    Contents,
    axis_name,
    reading_as,
    same_units,
    split_name,
    unit_in,
)
from jointclosure.walls.scans.headers import Header, placed, read_header
from jointclosure.walls.scans.points import LARGEST_OFFSET

COMMENTS = ("#", "%", "//", "!")
_MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--", "---", "***", "bad", "inf", "-inf"}
"""Words for a missing value."""
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x7f]")  # which no text has; \x1a ends old files
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # first bytes of a text in this encoding
_LEAST_PLACES = 5  # fewest evenly spaced numbers that are taken for places and not for heights
_DECIMAL_COMMA = re.compile(r"[-+]?\d+(,\d+)?([eE][-+]?\d+)?")
"""A number with a decimal comma."""
LEAST_COLUMNS = 12  # fewest columns of a matrix without names; points with colours have ten


class Table(NamedTuple):
    """Table of numbers in a text file, with the names and units of its columns."""

    values: np.ndarray  # (rows, columns), NaN where missing
    names: list[str]  # of the columns; empty if the file has none
    units: list[str | None]  # of the columns, as a line of units states them, else None
    remarks: tuple[str, ...]
    header: Header = Header()  # statements of the lines without numbers, names and units


class _Form(NamedTuple):
    """Form of a line of numbers: separator of words (None: blanks), and decimal sign."""

    separator: str | None
    decimal: str

    def words(self, line: str) -> list[str]:
        line = line.strip(" \r\n" if self.separator == "\t" else None)
        return [word.strip().strip('"') for word in line.split(self.separator)]

    def numbers(self, line: str) -> list[float]:
        """Return the numbers of a line, NaN for words of `_MISSING`; `ValueError` for others."""
        return [
            np.nan if word.lower() in _MISSING else float(word.replace(self.decimal, "."))
            for word in self.words(line)
        ]


def read_text_scan(path: Path, variable: str | None) -> Contents:
    """Read a text file of points, with x, y and z in each line, or of a matrix of heights.

    ``variable`` chooses the three columns of points among others, such as "x,y,height" or "1,2,4".
    Raise `InputError` if the file is no such table, or not a single wall.
    """
    table = read_table(path)
    if variable is None and (matrix := _matrix(table)) is not None:
        return matrix
    columns = _columns(table, variable)
    units = [unit_of_column(table, column) for column in columns]
    return placed(table.values[:, columns], units, table.header, table.remarks)


def _matrix(table: Table) -> Contents | None:
    """Return the contents of a table that is a matrix of heights; None if it is one of points.

    A matrix may have a frame: a first row of x and a first column of y, from which the heights are
    placed. Raise `InputError` if only the row or only the column is evenly spaced as places are.
    """
    values = table.values
    if table.names:  # x of a frame whose corner is a word
        try:
            x = [float(name.replace(",", ".")) for name in table.names[1:]]
        except ValueError:
            return None
        values = np.vstack([[np.nan, *x], values])
    elif values.shape[1] < LEAST_COLUMNS:
        return None
    places = (values[0, 1:], values[1:, 0])
    heights = values[1:, 1:]
    row, column = map(are_places, places)
    if table.names and not (row and column):
        return None
    plane = not heights.size or (are_places(heights[0]) and are_places(heights[:, 0]))
    if row and column and (table.names or not plane):
        read = "the first row and the first column, evenly spaced, were read as x and y"
        points = np.stack([part.ravel() for part in (*np.meshgrid(*places), heights)], axis=1)
        return placed(points, (None, None, None), table.header, (*table.remarks, read))
    for even, line, second in ((row, "row", heights[:1]), (column, "column", heights[:, :1])):
        if even and not plane and not are_places(second.ravel()):
            must = "must have x in its first row and y in its first column, or only heights"
            raise InputError(f"its first {line} is evenly spaced, as places are: a matrix {must}")
    spacing, units = table.header.spacing(values.shape)
    return Contents(
        values,
        spacing,
        height_units=table.header.height_units,
        length_units=units,
        remarks=table.remarks,
        unread=table.header.unread,
    )


def read_matrix(path: Path) -> Contents:
    """Read a text file as one matrix (y, x) of heights or of places; a spacing is not read."""
    with reading_as("a matrix"):
        table = read_table(path)
    height_units = table.header.height_units
    unread = table.header.unread
    return Contents(table.values, height_units=height_units, remarks=table.remarks, unread=unread)


def unit_of_column(table: Table, column: int) -> str | None:
    """Return the unit of a column from its name or from the line of units; None without.

    Raise `InputError` if both state different units.
    """
    name = table.names[column] if table.names else ""
    return same_units(f"the column {name!r}", split_name(name)[1], table.units[column])


def _columns(table: Table, variable: str | None) -> list[int]:
    """Return the numbers, from 0, of the columns of x, y and z in a table of points.

    ``variable`` states their names, or their numbers from 1. Raise `InputError` if they are not
    found.
    """
    names = table.names
    width = table.values.shape[1]
    must = f"or {VARIABLE} must state them, such as 1,2,3"
    if variable is None and not names and width != 3:
        raise InputError(
            f"{width} columns that are not named x, y and z: must be three in this order, {must}; "
            f"if it is a grid of heights, it must have at least {LEAST_COLUMNS} columns"
        )
    known = {axis_name(name): place for place, name in reversed([*enumerate(names)])}
    if variable is not None:
        known |= {name: place for place, name in reversed([*enumerate(names)])}
    if variable is not None or not names:
        known |= {str(place + 1): place for place in range(width)}
    words = "x,y,z" if names and variable is None else variable or "1,2,3"
    asked = [word.strip() for word in words.split(",")]
    places = [known.get(word, known.get(word.lower())) for word in asked]
    columns = [place for place in places if place is not None]
    if len(set(columns)) == len(asked) == 3:
        return columns
    listed = ", ".join(names) or f"numbers from 1 to {width}"
    if variable is None:
        missing = [word for word, place in zip(asked, places, strict=True) if place is None]
        lack = f"{' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing"
        raise InputError(f"columns {listed}: {lack}; must be named x, y and z, {must}")
    must = "must be three columns for x, y and z, as in 1,2,3"
    raise InputError(f"variable = {variable!r}: {must}; there are {listed}")


def read_table(path: Path, axes: Sequence[set[str]] = ({"x", "y", "z"},)) -> Table:
    """Read a table of numbers; separators, decimal commas, names and comments are detected.

    A line before the numbers is a line of names if it has all names of one of the sets of ``axes``,
    or more than two words, about as many as there are columns. Raise `InputError` if the file is
    not text or has no table.
    """
    content = path.read_bytes()
    if not is_text(content):
        raise InputError("is not text: it contains binary data")
    lines = _decode(content).splitlines()
    start = next((i for i, line in enumerate(lines) if _is_data(line)), None)
    head = lines[:start]
    kept = [line for line in lines[start:] if line.strip()]
    lines = [line for line in kept if not line.lstrip().startswith(COMMENTS)]
    head += [line for line in kept if line.lstrip().startswith(COMMENTS)]
    names, units, remarks, others = _find_names(
        head, len(_detect_form(lines[0]).words(lines[0])) if lines else 0, axes
    )
    if start is None:
        if not lines:
            raise InputError("has no points")
        where = " below the names" if names else ""
        last = lines[-1].strip()[:60]
        raise InputError(f"has no line of numbers{where}; there is {last!r}")
    form = _detect_form(lines[0])
    row = form.numbers(lines[0])
    following = form.words(lines[1]) if len(lines) > 1 else []
    if len(following) == len(row) + 1 and following[-1] and are_places(np.array(row)):
        lines[0] = f"nan{form.separator or ' '}{lines[0].strip()}"  # x of a frame without a corner
    values = _read_values(lines, form, names, remarks)
    width = values.shape[1]
    if names and len(names) != width:
        raise InputError(f"{len(names)} names ({', '.join(names)}) of {width} columns")
    if len(units) > width:
        raise InputError(f"has {len(units)} words in the line of units, must be {width}")
    units += [None] * (width - len(units))
    return Table(values, names, units, tuple(remarks), read_header(others))


def _read_values(lines: list[str], form: _Form, names: list[str], remarks: list[str]) -> np.ndarray:
    """Return the numbers (rows, columns) of lines in a form, NaN in lines with fewer numbers.

    Lines that repeat the ``names`` are skipped, and empty last columns are cut. Adds to the list of
    ``remarks`` what was left out. Raise `InputError` for other words, or lines with more numbers
    than most.
    """
    counts = np.array([len(form.words(line)) for line in lines])
    width = int(np.bincount(counts).argmax())
    if counts.max() > width:
        longest = lines[int(counts.argmax())].strip()[:60]
        raise InputError(f"{longest!r} has {counts.max()} numbers, other lines have {width}")
    values = np.full((len(lines), width), np.nan)
    repeated = []
    for row in np.flatnonzero(counts == width).tolist():
        try:
            values[row] = form.numbers(lines[row])
        except ValueError as error:
            if not names or form.words(lines[row])[: len(names)] != names:
                raise InputError(f"line {row + 1} of the numbers: {error}") from None
            repeated.append(row)
    if (short := counts < width).any():
        first = lines[int(short.argmax())].strip()[:60]
        few = f"{int(short.sum())} lines of fewer than {width} numbers were left out"
        remarks.append(caution(f"{few}, such as {first!r}"))
    if repeated:
        remarks.append(f"{len(repeated)} repeated lines of names were skipped")
    values = np.delete(values, repeated, axis=0)
    # a separator at the end of every line makes an empty column
    while width > len(names or "xyz") and np.isnan(values[:, width - 1]).all():
        width -= 1
    return values[:, :width]


def are_places(values: np.ndarray) -> bool:
    """Return whether numbers (n,) are evenly spaced, as places are, rising or falling.

    They may be off by `LARGEST_OFFSET` of a step. Fewer than `_LEAST_PLACES` numbers, or numbers
    with a NaN, are not.
    """
    if len(values) < _LEAST_PLACES or not np.isfinite(values).all():
        return False
    step = (values[-1] - values[0]) / (len(values) - 1)
    offsets = values - values[0] - step * np.arange(len(values))
    return bool(step != 0.0 and np.abs(offsets).max() <= LARGEST_OFFSET * abs(step))


def is_text(start: bytes) -> bool:
    """Return whether the first bytes of a file are text."""
    return start.startswith(_UTF_16) or not _BINARY.search(start)


def _decode(content: bytes) -> str:
    """Return the text of a file in UTF-8, UTF-16 or Latin-1."""
    if content.startswith(_UTF_16):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # for the micro sign of older instruments


def _detect_form(line: str) -> _Form:
    """Return the form of a line of numbers: its separator and its decimal sign."""
    for mark in (";", "\t"):
        if mark in line.strip():
            return _Form(mark, "," if "," in line and "." not in line else ".")
    words = line.split()
    if "," in line and len(words) > 1 and all(_DECIMAL_COMMA.fullmatch(word) for word in words):
        return _Form(None, ",")
    return _Form("," if "," in line else None, ".")


def _is_data(line: str) -> bool:
    """Return whether a line is of a table: at least two numbers, and else words of `_MISSING`."""
    try:
        return int(np.isfinite(_detect_form(line).numbers(line)).sum()) >= 2
    except ValueError:
        return False


def _find_names(
    head: list[str], width: int, axes: Sequence[set[str]]
) -> tuple[list[str], list[str | None], list[str], list[str]]:
    """Find names and units of columns in the lines without numbers, the ``head`` of a file.

    Return the names (empty without; comments may have them), the units, remarks on lines that were
    skipped or repeated, and the lines of neither names nor units. ``width`` is the number of
    columns, ``axes`` are those of `read_table`.
    """
    names: list[str] = []
    units: list[str | None] = []
    remarks = []
    fields = []
    others = []
    for number, line in enumerate(map(str.strip, head), start=1):
        comment = line.startswith(COMMENTS)
        words = _split_names(line.lstrip("#%/! ") if comment else line)
        bare = [word.strip("()[]").strip() for word in words]
        if any({axis_name(word) for word in words} >= each for each in axes):
            if names:
                remarks.append(f"line {number} repeats the names of the columns")
            names = words
        elif _is_units(line, bare):
            units = [unit_in(word) for word in bare]
        elif words:
            others.append(line)
            of_other_width = width >= LEAST_COLUMNS or re.search(r"[\d:=]", line)
            some = {axis_name(word) for word in words}
            if len(words) == len(some) == width and any(some < each for each in axes):
                fields = words  # names of axes, of which one is missing
            elif not comment and len(words) > 2 and (len(words) == width or not of_other_width):
                fields = words
            elif not comment and read_header([line]) == Header():
                remarks.append(f"line {number} was skipped: {line[:60]!r}")
    return names or fields, units, remarks, others


def _is_units(line: str, words: list[str]) -> bool:
    """Return whether a line states units of columns: two or more, at least half of its words."""
    count = sum(unit_in(word) is not None for word in words)
    return count > 1 and 2 * count >= len(words) and not re.search(r"[\d:=]", line)


def _split_names(line: str) -> list[str]:
    """Return the names in a line of names; a unit in brackets stays with its name."""
    mark = next((mark for mark in (";", "\t", ",") if mark in line), None)
    glued = line if mark else re.sub(r"\s+([(\[])", r"\1", line)
    words = [word.strip().strip('"') for word in glued.split(mark)]
    while words and not words[-1]:
        words.pop()
    return words

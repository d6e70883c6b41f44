"""Tables of numbers in text files, in the forms that instruments and people write."""

import io
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.inputs import SPELT, InputError
from jointclosure.inputs.remarks import caution
from jointclosure.walls.scans.contents import axis_name
from jointclosure.walls.scans.lattice import LARGEST_OFFSET

COMMENTS = ("#", "%", "//", "!")
_MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "---", "***", "bad", "inf", "-inf")
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x7f]")
"""Bytes that no text has; \\x1a ends old files."""
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_LEAST_PLACES = 5
"""Smallest number of evenly spaced numbers that are places and not heights."""
_DECIMAL_COMMA = re.compile(r"[-+]?\d+(,\d+)?([eE][-+]?\d+)?")


class Table(NamedTuple):
    """Numbers (rows, columns), NaN where missing; names and units of columns, empty without any."""

    values: np.ndarray
    names: list[str]
    units: list[str | None]
    remarks: tuple[str, ...]


class _Form(NamedTuple):
    """Rules for splitting a line into words."""

    separator: str | None
    decimal: str


def read_table(path: Path) -> Table:
    """Read a table of numbers; separators, decimal commas, names and comments are detected."""
    content = path.read_bytes()
    if is_binary(content):
        raise InputError("is not text: it contains binary data")
    lines = _decoded(content).splitlines()
    start = next((i for i, line in enumerate(lines) if _is_data(line)), None)
    head = lines[:start]
    names, units, remarks = _names(head)
    if start is None:
        raise _without_numbers(head, bool(names))
    form = _form_of(lines[start])
    lines = [line for line in lines[start:] if line.strip() and not _is_comment(line)]
    lines = _with_corner(lines, form)
    frame, width, short = _frame(lines, form, len(names or "xyz"))
    remarks += short
    frame, repeated = _numbers(frame, names, form.decimal)
    if repeated:
        remarks.append(f"{repeated} repeated lines of names were skipped")
    if names and len(names) != width:
        raise InputError(f"{len(names)} names ({', '.join(names)}) of {width} columns")
    if len(units) > width:
        raise InputError(
            f"has {len(units)} words in the line of units, must be {width}, one for each column"
        )
    if units:
        units += [None] * (width - len(units))
    values = frame.iloc[:, :width].to_numpy(dtype=float)
    return Table(values, names, units, tuple(remarks))


def _frame(lines: list[str], form: _Form, least: int) -> tuple[pd.DataFrame, int, list[str]]:
    """Return words of lines, their usual number, and a warning of shorter lines, left as NaN."""
    counts = np.array([len(line.strip(" ").split(form.separator)) for line in lines])
    width = int(np.bincount(counts).argmax())
    if counts.max() > width:
        longest = lines[int(counts.argmax())].strip()[:60]
        raise InputError(f"{longest!r} has {counts.max()} numbers, other lines have {width}")
    frame = pd.read_csv(
        io.StringIO("\n".join(lines)),
        sep=form.separator or r"\s+",
        decimal=form.decimal,
        header=None,
        names=range(width),
        index_col=False,
        skipinitialspace=True,
        na_values=[word for word in _MISSING if word],
    )
    # a separator at the end of every line makes an empty column
    while width > least and frame[width - 1].isna().all():
        width -= 1
    short = counts < width
    if not short.any():
        return frame, width, []
    frame[short] = np.nan
    first = lines[int(short.argmax())].strip()[:60]
    few = f"{int(short.sum())} lines of fewer than {width} numbers were left out"
    return frame, width, [caution(f"{few}, such as {first!r}")]


def are_places(values: np.ndarray) -> bool:
    """Return whether numbers (n,) are evenly spaced, rising or falling, within `LARGEST_OFFSET`."""
    if len(values) < _LEAST_PLACES or not np.isfinite(values).all():
        return False
    step = (values[-1] - values[0]) / (len(values) - 1)
    offsets = values - values[0] - step * np.arange(len(values))
    return bool(step != 0.0 and np.abs(offsets).max() <= LARGEST_OFFSET * abs(step))


def is_binary(content: bytes) -> bool:
    """Return whether a file's content, or the start of it, has bytes that no text has."""
    return not content.startswith(_UTF_16) and _BINARY.search(content) is not None


def _decoded(content: bytes) -> str:
    if content.startswith(_UTF_16):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")  # for the micro sign of older instruments


def _form_of(line: str) -> _Form:
    for mark in (";", "\t"):
        if mark in line.strip():
            return _Form(mark, "," if "," in line and "." not in line else ".")
    words = line.split()
    if "," in line and len(words) > 1 and all(_DECIMAL_COMMA.fullmatch(word) for word in words):
        return _Form(None, ",")
    return _Form("," if "," in line else None, ".")


def _words(line: str, form: _Form) -> list[str]:
    words = line.strip(" \r\n" if form.separator == "\t" else None).split(form.separator)
    return [word.strip().strip('"') for word in words]


def _with_corner(lines: list[str], form: _Form) -> list[str]:
    """Put a missing value before a first row of x: even, and one number shorter than the next."""
    if len(lines) < 2:
        return lines
    row, following = (_words(line, form) for line in lines[:2])
    if len(following) != len(row) + 1 or not following[-1]:
        return lines
    numbers = [word.replace(form.decimal, ".") for word in row]
    if not all(map(_is_number, numbers)) or "" in numbers:
        return lines
    if not are_places(pd.to_numeric(pd.Series(numbers), errors="coerce").to_numpy(dtype=float)):
        return lines
    return [f"nan{form.separator or ' '}{lines[0].strip()}", *lines[1:]]


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(COMMENTS)


def _is_data(line: str) -> bool:
    """Return whether a line has at least two numbers, and otherwise only missing values."""
    if not line.strip() or _is_comment(line):
        return False
    form = _form_of(line)
    words = _words(line, form)
    numbers = [_is_number(word.replace(form.decimal, ".")) for word in words]
    nothing = [word.lower() in _MISSING for word in words]
    return sum(numbers) - sum(nothing) >= 2 and all(map(any, zip(numbers, nothing, strict=True)))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return word.lower() in _MISSING
    return True


def _names(head: list[str]) -> tuple[list[str], list[str | None], list[str]]:
    """Return names of columns (also of a comment), their units, and remarks on other lines."""
    names: list[str] = []
    units: list[str | None] = []
    remarks, fields = [], []
    for number, line in enumerate(head, start=1):
        bare = line.strip()
        comment = bare.startswith(COMMENTS)
        words = _split_names(bare.lstrip("#%/! ") if comment else bare)
        if not words:
            continue
        if {axis_name(word) for word in words} >= {"x", "y", "z"}:
            if names:
                remarks.append(f"line {number} repeats the names of the columns")
            names = words
        elif sum(word.strip("()[]").strip() in SPELT for word in words) > 1:
            bare_words = [word.strip("()[]") for word in words]
            units = [word if word.strip() in SPELT else None for word in bare_words]
        elif not comment and len(words) > 2:
            fields = words
        elif not comment:
            remarks.append(f"line {number} was skipped: {bare[:60]!r}")
    return names or fields, units, remarks


def _split_names(line: str) -> list[str]:
    mark = next((mark for mark in (";", "\t", ",") if mark in line), None)
    glued = re.sub(r"\s+([(\[])", r"\1", line)
    words = [word.strip().strip('"') for word in (line if mark else glued).split(mark)]
    while words and not words[-1]:
        words.pop()
    return words


def _without_numbers(head: list[str], named: bool) -> InputError:
    written = [line.strip() for line in head if line.strip() and not _is_comment(line)]
    if not written:
        return InputError("has no points")
    if not named:
        return InputError(f"has no line of numbers; the first is {written[0][:60]!r}")
    return InputError(f"has no line of numbers below the names; there is {written[-1][:60]!r}")


def _numbers(frame: pd.DataFrame, names: list[str], decimal: str) -> tuple[pd.DataFrame, int]:
    """Return the numbers without repeated lines of names, and the number of these lines."""
    repeated = np.zeros(len(frame), bool)
    numbers = {}
    for column in frame.columns:
        if frame[column].dtype.kind in "fiu":
            numbers[column] = frame[column].astype(float)
            continue
        words = frame[column].astype(str).str.strip()
        values = pd.to_numeric(words.str.replace(decimal, ".", regex=False), errors="coerce")
        known = frame[column].notna() & ~words.str.lower().isin(_MISSING)
        name = words == names[column] if column < len(names) else known & False
        wrong = np.flatnonzero(values.isna() & known & ~name)
        if wrong.size:
            raise InputError(
                f"{words.iloc[wrong[0]]!r} in line {wrong[0] + 1} of the numbers is not a number"
            )
        repeated |= (values.isna() & name).to_numpy()
        numbers[column] = values.astype(float)
    return pd.DataFrame(numbers)[~repeated], int(repeated.sum())

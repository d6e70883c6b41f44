"""Headers of scan files (texts, meshes, pictures): units, spacing and size of the matrix."""

import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from jointclosure.inputs import SPELT, InputError
from jointclosure.walls.scans.contents import (
    Contents,
    Statement,
    agreed_spacing,
    same_units,
    split_name,
    unit_in,
)
from jointclosure.walls.scans.points import contents_of

_NUMBER = r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?"
"""A number, with a decimal point or comma."""
_MARKED = re.compile(r"(.+?)\s*[:=;,]+[\s:=;,]*(.*)")
"""Statement with a mark, as in "pixel size: 0.1 mm": its key and its value."""
_SPACED = re.compile(rf"(\D+?)\s+({_NUMBER}\b.*)|(.*\bunits?)\s+(\S+)", re.IGNORECASE)
"""Statement without a mark, as in "spacing 0.1 mm" or "units mm": its key and its value."""
_VALUE = re.compile(rf"({_NUMBER}(?!\w))?[\s,;(\[]*([^\s,;)\]]*)[\s,;)\].]*")
"""Value of a statement: a number, a unit, or both."""
_OF_HEIGHTS = ("value", "values", "z", "height", "heights", "data", "elevation", "zvalue")
"""Words for heights in a statement of units."""
_OF_PLACES = ("x", "y", "xy", "lateral", "horizontal", "coordinate", "plan", "axis")
"""Words for places in a statement of units."""
_STEPS = (
    "spacing", "step", "stepsize", "pixelsize", "pixelspacing", "pixelpitch", "pitch", "interval",
    "samplingstep", "samplinginterval", "samplingdistance", "sampling", "increment", "calibration",
    "cellsize", "scanspacing", "gridspacing", "gridstep", "pointspacing", "pointdistance",
)  # fmt: skip
"""Keys that state the spacing along both axes."""
_AXIS_STEPS = (*_STEPS, "inc", "pixel")
"""Keys that state the spacing along one axis if the name of the axis precedes or follows them."""
_SIZES = {"width": 1, "scanwidth": 1, "imagewidth": 1, "height": 0, "scanheight": 0}
"""Keys that state the length of the wall, and the axis, 0 for y and 1 for x."""
_COUNTS = {
    **dict.fromkeys(("columns", "ncols", "ncolumns", "nx", "xpixels", "xpoints", "horizontal"), 1),
    **dict.fromkeys(("numberofcolumns", "samplesperline", "pointsperline", "pixelsx"), 1),
    **dict.fromkeys(("rows", "nrows", "ny", "ypixels", "ypoints", "vertical", "lines"), 0),
    **dict.fromkeys(("numberofrows", "numberoflines", "pixelsy"), 0),
}
"""Keys that state the number of points along an axis, 0 for y and 1 for x."""
_FACTORS = re.compile(r"scalefactor|zscale|heightscale|conversionfactor|multiplier|bit2nm|^scale$")
"""Keys of a factor by which heights would have to be multiplied; only a factor of 1 is accepted."""
_MENTIONS = re.compile(r"units?|resolution|step|spacing|pixelsize|pitch|calibration|increment")
"""Words of a key that probably states a unit or the spacing."""
_LENGTH = re.compile(r"(?<![\w.])\d[\d.,]*\s*(?:mm|um|µm|μm|nm|cm|m|inch|microns?)(?!\w)")
"""A number with a unit of length."""


class Header(NamedTuple):
    """Statements of the header of a scan file; None where nothing is stated."""

    height_units: str | None = None
    length_units: str | None = None  # of x and y
    steps: tuple[Statement, ...] = ()  # of the spacing
    sizes: tuple[Statement, ...] = ()  # of the lengths of the wall (y, x), in place of a spacing
    counts: tuple[int | None, int | None] = (None, None)  # numbers of heights along y and x
    unread: tuple[str, ...] = ()  # lines that mention units or lengths and were not understood

    def statements(self, shape: tuple[int, ...]) -> list[Statement]:
        """Return the statements of the spacing of a matrix (y, x) of heights.

        A stated length of the wall gives a spacing too: the length over the number of cells. Raise
        `InputError` if the stated numbers of rows or columns are not those of the matrix.
        """
        for axis, stated, count in zip(("rows", "columns"), self.counts, shape, strict=True):
            if stated is not None and stated != count:
                raise InputError(f"the file states {stated} {axis}; there are {count}")
        cells = [size._replace(spacing=size.spacing / np.array(shape)) for size in self.sizes]
        return [*self.steps, *cells]

    def spacing(self, shape: tuple[int, ...]) -> tuple[tuple[float, float], str | None]:
        """Return the spacing (dy, dx) of a matrix (y, x) of heights, and its units or None.

        A spacing that is stated along one axis only holds along both; NaN if none is stated. Raise
        `InputError` as `statements`, or if statements differ.
        """
        (dy, dx), units = agreed_spacing(self.statements(shape))
        dy, dx = (other if np.isnan(step) else step for step, other in ((dy, dx), (dx, dy)))
        return (float(dy), float(dx)), units or self.length_units


def placed(
    points: np.ndarray,
    units: Sequence[str | None],
    header: Header,
    remarks: tuple[str, ...] = (),
) -> Contents:
    """Return the contents of points (n, 3), see `contents_of`, with the statements of a header.

    ``units`` are those that columns state for x, y and z. Raise `InputError` if the header states
    others. If the points lie on a grid, the header's spacing is kept to be compared with it.
    """
    along = (header.length_units, header.length_units, header.height_units)
    stated = [
        same_units(f"the column of {name}", *both)
        for name, *both in zip("xyz", units, along, strict=True)
    ]
    contents = contents_of(points, stated, remarks)
    unused = header.sizes
    if contents.points is not None:
        unused = (*header.steps, *header.sizes)
    else:
        contents = contents._replace(stated=header.steps)
    return contents._replace(unread=header.unread + tuple(part.names for part in unused))


def read_header(lines: Iterable[str]) -> Header:
    """Read the statements of header lines; `InputError` if units or counts contradict others."""
    header = Header()
    for line in lines:
        parts = re.split(r"[,;]\s+", line)
        several = len(parts) > 1 and all(re.search(r"[:=]", part) for part in parts)
        for part in parts if several else [line]:
            header = _add_statement(header, part)
    return header


def _add_statement(header: Header, line: str) -> Header:
    """Return the header with the statement of one more line.

    If the line is not understood, but mentions units or lengths, it is added to ``unread``. Raise
    `InputError` for a contradiction, a factor of heights, or a spacing that is not positive.
    """
    tidy = line.strip().lstrip("#%/!; ").replace('"', " ").replace("\t", " : ")
    bare = re.sub(r"\s+", " ", re.sub(r"[\s:]*:[\s:]*", ": ", tidy)).strip(" :;,")
    entry = _MARKED.fullmatch(bare) or _SPACED.fullmatch(bare)
    key_text, rest = [part for part in entry.groups() if part is not None] if entry else (bare, "")
    match = _VALUE.fullmatch(rest)
    if not entry or not match:
        return _add_unread(header, bare)
    name, of_name = split_name(key_text)
    key = re.sub(r"[\W_]", "", name).lower()
    value = float(match[1].replace(",", ".")) if match[1] else None
    unit = unit_in(match[2])
    if match[2] and unit is None:
        return _add_unread(header, bare)
    unit = same_units(bare, of_name, unit)
    if value is None:
        return _add_units(header, key, unit, bare)
    if key in _COUNTS and unit is None and value == int(value):
        counts = [*header.counts]
        if counts[_COUNTS[key]] not in (None, int(value)):
            raise InputError(f"the file states {counts[_COUNTS[key]]} and then {bare!r}")
        counts[_COUNTS[key]] = int(value)
        return header._replace(counts=(counts[0], counts[1]))
    if _FACTORS.search(key):
        if value == 1.0:
            return header
        raise InputError(f"the file states {bare!r}: heights must be stored without a factor")
    along = _kind_and_axes(key)
    if along is None:
        return _add_unread(header, bare)
    if not 0.0 < value < np.inf:
        raise InputError(f"the file states {bare!r}: must be positive and finite")
    kind, factors = along
    statement = Statement(bare, value * np.array(factors), unit)
    if kind == "sizes":
        return header._replace(sizes=(*header.sizes, statement))
    return header._replace(steps=(*header.steps, statement))


def _kind_and_axes(key: str) -> tuple[str, tuple[float, float]] | None:
    """Return whether a key states "steps" (spacing) or "sizes" (lengths of the wall), and of what.

    The second value has 1 for each axis (y, x) to which the key applies, else NaN. None for keys
    that state neither.
    """
    axes = {0: (1.0, np.nan), 1: (np.nan, 1.0)}
    if key in _SIZES:
        return "sizes", axes[_SIZES[key]]
    if key in (*_STEPS, "h", "dxy", "dxdy") or key.replace("xy", "", 1) in _STEPS:
        return "steps", (1.0, 1.0)
    for number, axis in enumerate("yx"):
        bare = key.removeprefix(axis) if key.startswith(axis) else key.removesuffix(axis)
        if bare != key and bare in ("length", "size"):
            return "sizes", axes[number]
        if key in (f"d{axis}", f"delta{axis}") or (bare != key and bare in _AXIS_STEPS):
            return "steps", axes[number]
    return {"pixelheight": ("steps", axes[0]), "pixelwidth": ("steps", axes[1])}.get(key)


def _add_units(header: Header, key: str, unit: str | None, line: str) -> Header:
    """Return the header with the ``unit`` that a line without a number states.

    ``key`` tells whether it is that of heights, of x and y, or of both. Lines of other keys are
    handled as not understood. Raise `InputError` if another line has stated another unit.
    """
    what = re.fullmatch(r"(\w*?)(?:axis)?units?(?:of)?(\w*)", key)
    if unit is None or what is None:
        return _add_unread(header, line)
    about = what[1] or what[2]
    if about in ("", "length", "lengths", "all", "measurement"):
        kinds: tuple[str, ...] = ("height_units", "length_units")
    elif about in _OF_HEIGHTS:
        kinds = ("height_units",)
    elif about in _OF_PLACES:
        kinds = ("length_units",)
    else:
        return _add_unread(header, line)
    stated: dict[str, Any] = {k: same_units(line, getattr(header, k), unit) for k in kinds}
    return header._replace(**stated)


def _add_unread(header: Header, line: str) -> Header:
    """Return the header with a line that was not understood, if it mentions units or lengths.

    Other lines are ignored: the header is returned as it is.
    """
    key = re.sub(r"[\W_]", "", re.split(r"[:=\t]", line)[0]).lower()
    words = re.split(r"[\s\[\](){}:=;,\"']+", line)
    valued = re.search(r"[:=]\s*\S", line) or _LENGTH.search(line)
    if (valued and (_MENTIONS.search(key) or _LENGTH.search(line))) or (
        len(words) <= 12 and any(word in SPELT and len(word) > 1 for word in words)
    ):
        return header._replace(unread=(*header.unread, line[:60]))
    return header

"""ESRI ASCII grids: a header of words and numbers, then rows from the largest y down."""

from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls.scans.contents import Contents, check_no_variable, check_size

_NEEDED = ("ncols", "nrows")
_KNOWN = (
    *_NEEDED,
    "cellsize",
    "dx",
    "dy",
    "xllcorner",
    "yllcorner",
    "xllcenter",
    "yllcenter",
    "nodata_value",
)


def read_asc(path: Path, variable: str | None) -> Contents:
    """Read an ESRI grid, without units.

    Raises
    ------
    InputError
        If a word is missing in the header or has no number, or the number of heights is not the
        declared one, altogether or in a row.
    """
    check_no_variable(variable)
    lines = [line.split() for line in path.read_text(encoding="latin-1").splitlines()]
    words = [word for line in lines for word in line]
    head: dict[str, float] = {}
    while 2 * len(head) + 1 < len(words) and words[2 * len(head)].lower() in _KNOWN:
        key, value = words[2 * len(head)].lower(), words[2 * len(head) + 1]
        if key in head:
            raise InputError(f"{key}: must be only once in the header")
        head[key] = _number(key, value)
    if missing := [key for key in _NEEDED if key not in head]:
        raise InputError(f"its header lacks {', '.join(missing)}")
    step = _cell_size(head)
    shape = _count("nrows", head), _count("ncols", head)
    check_size(shape)
    _check_rows([len(line) for line in lines if line and line[0].lower() not in _KNOWN], shape[1])
    values = words[2 * len(head) :]
    if len(values) != shape[0] * shape[1]:
        raise InputError(
            f"declares {shape[0]} rows of {shape[1]} heights, {shape[0] * shape[1]}, and contains "
            f"{len(values)}: is the file incomplete?"
        )
    try:
        heights = np.array(values, dtype=float).reshape(shape)[::-1].copy()
    except ValueError as error:
        raise InputError(f"has a height that is not a number ({error})") from None
    heights[heights == head.get("nodata_value", -9999.0)] = np.nan
    return Contents(heights, (step, step), origin=_origin(head, step))


def _check_rows(counts: list[int], columns: int) -> None:
    """Raise `InputError` if most lines are a row, and others have more or fewer heights.

    Files whose lines are no rows may be divided anywhere.
    """
    wrong = [row for row, count in enumerate(counts, start=1) if count != columns]
    if wrong and len(wrong) <= 0.5 * len(counts):
        raise InputError(
            f"row {wrong[0]} contains {counts[wrong[0] - 1]} heights, must be {columns} "
            f"({len(wrong)} such rows)"
        )


def _cell_size(head: dict[str, float]) -> float:
    """Return the cell size, or equal dx and dy in its place, as GDAL writes them.

    Raises
    ------
    InputError
        If there is none, or dx and dy differ.
    """
    sizes = {key: head[key] for key in ("dx", "dy", "cellsize") if key in head}
    if sizes.keys() in ({"dx"}, {"dy"}, set()):
        raise InputError("its header lacks cellsize")
    first = next(iter(sizes.values()))
    if any(abs(size - first) > 1e-6 * abs(first) for size in sizes.values()):
        listed = ", ".join(f"{key} = {size:g}" for key, size in sizes.items())
        raise InputError(f"{listed}: must be equal, because an ESRI grid has square cells")
    return first


def _number(key: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise InputError(f"{key} = {value!r}: must be a number") from None


def _count(key: str, head: dict[str, float]) -> int:
    if not (head[key] >= 1.0 and head[key].is_integer()):
        raise InputError(f"{key} = {head[key]:g}: must be a whole number of at least 1")
    return int(head[key])


def _origin(head: dict[str, float], step: float) -> tuple[float, float] | None:
    """Return (y, x) of the middle of the first cell, None if the file does not place it."""
    places = []
    for axis in "yx":
        if f"{axis}llcenter" in head:
            places.append(head[f"{axis}llcenter"])
        elif f"{axis}llcorner" in head:
            places.append(head[f"{axis}llcorner"] + 0.5 * step)
    return (places[0], places[1]) if len(places) == 2 else None

"""Surfer 6 grids (.grd), text (DSAA) and binary (DSBB): rows from the least y up."""

import struct
from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.scans.contents import Contents, check_no_variable, check_size, reading_as
from jointclosure.scans.instruments import read_any

_BLANK = 1.70141e38
"""Heights from this value on are missing."""


def read_grd(path: Path, variable: str | None) -> Contents:
    """Read a Surfer grid, without units; other files of this suffix as `instruments.read_any`.

    Raises
    ------
    InputError
        If the number of heights is not the declared one, or the file is of Surfer 7 or later.
    """
    with path.open("rb") as file:
        form = file.read(4)
    if form not in (b"DSAA", b"DSBB", b"DSRB"):
        return read_any(path, variable)
    check_no_variable(variable)
    if form == b"DSRB":
        raise InputError("is a grid of Surfer 7 or later: save it as a Surfer 6 grid")
    with reading_as("a Surfer grid"):
        head, heights = (_text if form == b"DSAA" else _binary)(path.read_bytes())
    nx, ny, (x, x_end), (y, y_end) = head
    if min(nx, ny) < 2:
        raise InputError(f"declares {ny} rows of {nx} heights: must be at least 2 of 2")
    if heights.size != nx * ny:
        raise InputError(
            f"declares {ny} rows of {nx} heights, {nx * ny}, and contains {heights.size}: "
            "is the file incomplete?"
        )
    heights = np.where(heights >= 0.999 * _BLANK, np.nan, heights).reshape(ny, nx)
    spacing = (y_end - y) / (ny - 1), (x_end - x) / (nx - 1)
    return Contents(heights, spacing, origin=(y, x))


def _text(content: bytes) -> tuple[tuple, np.ndarray]:
    """Return (nx, ny, x limits, y limits) and the heights in the order of the file."""
    words = content.split()
    nx, ny = int(words[1]), int(words[2])
    check_size((ny, nx))
    limits = [float(word) for word in words[3:7]]
    return (nx, ny, limits[:2], limits[2:]), np.array(words[9:], dtype=float)


def _binary(content: bytes) -> tuple[tuple, np.ndarray]:
    """Return the same of a binary grid."""
    nx, ny, *limits = struct.unpack_from("<2h4d", content, 4)
    check_size((ny, nx))
    start = 4 + struct.calcsize("<2h6d")
    heights = np.frombuffer(content[start : start + 4 * nx * ny], dtype="<f4").astype(float)
    return (nx, ny, limits[:2], limits[2:]), heights

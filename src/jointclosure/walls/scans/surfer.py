"""Surfer grids of version 6, text (DSAA) and binary (DSBB), and of version 7 (DSRB).

Rows are from the least y up.
"""

import struct
from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls.scans.contents import Contents, check_no_variable, check_size, reading_as

_BLANK = 1.70141e38
"""Heights from this value on are missing."""


def read_grd(path: Path, variable: str | None) -> Contents:
    """Read a Surfer grid, without units.

    Raises
    ------
    InputError
        If the number of heights is not the declared one.
    """
    check_no_variable(variable)
    content = path.read_bytes()
    with reading_as("a Surfer grid"):
        head, heights = FORMS[content[:4]](content)
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


def _sections(content: bytes) -> tuple[tuple, np.ndarray]:
    """Return the same of a grid of version 7, whose sections have names and sizes in bytes.

    Heights are missing from the file's blank value on, or only where equal to it (form 2).
    """
    sections, start = {}, 0
    while start + 8 <= len(content):
        name, size = struct.unpack_from("<4si", content, start)
        if size < 0:
            raise InputError(f"section {name!r}: must have a size of at least 0 bytes")
        sections[name] = content[start + 8 : start + 8 + size]
        start += 8 + size
    if missing := {b"GRID", b"DATA"} - sections.keys():
        raise InputError(f"lacks the section {', '.join(sorted(map(bytes.decode, missing)))}")
    ny, nx, x, y, dx, dy, *_, angle, blank = struct.unpack_from("<2i8d", sections[b"GRID"])
    if angle != 0.0:
        raise InputError(f"rotation = {angle:g} degrees: must be 0, a grid along x and y")
    check_size((ny, nx))
    heights = np.frombuffer(sections[b"DATA"][: 8 * nx * ny], dtype="<f8").copy()
    exact = struct.unpack_from("<i", sections[b"DSRB"]) == (2,)
    heights[heights == blank if exact else heights >= blank] = np.nan
    return (nx, ny, (x, x + (nx - 1) * dx), (y, y + (ny - 1) * dy)), heights


FORMS = {b"DSAA": _text, b"DSBB": _binary, b"DSRB": _sections}
"""Readers by the first bytes of a file."""

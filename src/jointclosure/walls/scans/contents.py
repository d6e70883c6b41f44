"""Content of the file of a scanned wall, and errors of its reading."""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError

LARGEST_ARRAY, LARGEST_FILE = 800_000_000, 2_000_000_000
"""Largest size [bytes] of an array, 10,000 x 10,000 heights in double precision, and of a file that
is read as a whole. A damaged or malicious file may declare more."""
SAME_SPACING = 1e-3
"""Largest difference of statements of one spacing, over the spacing: those of 1/3 mm may be
rounded."""

VARIABLE = "variable (--variable on the command line)"
"""Argument and option that choose an array, a channel or columns, for messages."""
_BYTES = re.compile(r"\\x[0-9a-f]{2}")
"""Byte of a file as libraries print it in their messages."""


class Contents(NamedTuple):
    """Heights (y, x) on a grid of a spacing (dy, dx), or points (n, 3), in the file's units.

    Rows are in order of increasing y. Units are as written in the file ("mm", "micrometre"), or
    None if it states none. ``origin`` is the (y, x) of the first cell, None if the file does not
    place its grid. ``remarks`` are sentences on what reading skipped. A step of NaN is not stated.
    """

    heights: np.ndarray | None = None
    spacing: tuple[float, float] | None = None
    points: np.ndarray | None = None
    height_units: str | None = None
    length_units: str | None = None
    origin: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()


def check_size(shape: tuple[int, ...], itemsize: int = 8, name: str = "") -> None:
    """Raise `InputError` if an array of a shape is larger than `LARGEST_ARRAY`.

    ``itemsize`` is that of its values [bytes], and ``name`` names it in the message.
    """
    if math.prod(shape) * itemsize > LARGEST_ARRAY:
        size = " x ".join(map(str, shape))
        raise InputError(
            f"{f'{name}: ' if name else ''}declares {size} values of {itemsize} bytes: must be at "
            f"most {LARGEST_ARRAY / 1e6:g} MB"
        )


def check_no_variable(variable: str | None) -> None:
    """Raise `InputError` if a variable is given for a format that has no names."""
    if variable is not None:
        raise InputError(
            f"variable = {variable!r}: must be left out; the format has one array without a name"
        )


@contextmanager
def reading_as(form: str, *errors: type[Exception]) -> Iterator[None]:
    """Raise one clear `InputError` if a file is damaged: for these errors, by default for any."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        if errors and not isinstance(error, errors):
            raise
        reason = " ".join(str(error).split()) or type(error).__name__
        if _BYTES.search(reason) or not reason.isprintable():
            raise InputError(f"cannot be read as {form}") from None
        raise InputError(f"cannot be read as {form} ({reason})") from None

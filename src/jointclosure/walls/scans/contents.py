"""Content of the file of a scanned wall: its units, missing values, limits of size and errors."""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import SPELT, UNITS, InputError, size_of
from jointclosure.inputs.remarks import caution
from jointclosure.parameters import USUAL

LARGEST_ARRAY, LARGEST_FILE = 800_000_000, 2_000_000_000
"""Largest size [bytes] of an array, and of a file that is read as a whole."""
SAME_SPACING = 1e-3
"""Largest relative difference of statements of one spacing, which may be rounded."""
VARIABLE = "variable (--variable on the command line)"
"""Argument and option that choose an array, a channel or columns, for messages."""
_BYTES = re.compile(r"\\x[0-9a-f]{2}")  # bytes of a file in messages of libraries
_NAME_AND_UNIT = r"\s*(.*?)(?:_|\s*/\s*|\s*,\s*|\s+in\s+|[_\s]*[(\[])\s*([A-Za-zµμ]+)\s*[)\]]?\s*"

SENTINELS = (-999.0, -9999.0, 9999.0, -99999.0, 99999.0, -999999.0, 999999.0, -32767.0, -32768.0)
"""Values that count as missing if they are beyond all other values."""
LARGEST = 1e20  # larger values are missing in any unit, such as 1e30 and 1.70141e38


class Contents(NamedTuple):
    """Heights (y, x) on a grid (dy, dx), or points (n, 3), in the file's units, where stated.

    Rows are in order of increasing y; ``origin`` (y, x) is the first cell, NaN if it has no place.
    """

    heights: np.ndarray | None = None
    spacing: tuple[float, float] = (math.nan, math.nan)
    points: np.ndarray | None = None
    height_units: str | None = None
    length_units: str | None = None
    origin: tuple[float, float] = (math.nan, math.nan)
    remarks: tuple[str, ...] = ()

    def sides(self) -> tuple[float, float] | None:
        """Return the lengths of the wall along x and y in the file's units; None if unknown."""
        if self.points is not None:
            x, y = np.ptp(self.points[:, :2], axis=0).tolist() if len(self.points) else (0.0, 0.0)
            return x, y
        dy, dx = self.spacing
        shape = np.shape(np.asarray(self.heights))
        if math.isnan(dy + dx) or len(shape) != 2:
            return None
        return dx * (shape[1] - 1), dy * (shape[0] - 1)


def check_size(shape: tuple[int, ...], itemsize: int = 8) -> None:
    """Raise `InputError` if an array of values of ``itemsize`` bytes is above `LARGEST_ARRAY`."""
    if math.prod(shape) * itemsize > LARGEST_ARRAY:
        size = f"declares {' x '.join(map(str, shape))} values of {itemsize} bytes"
        raise InputError(f"{size}: must be at most {LARGEST_ARRAY / 1e6:g} MB")


def incomplete(declared: str, number: int) -> InputError:
    """Return the error for a file with less than it declares."""
    return InputError(f"declares {declared}, and contains {number}: is the file incomplete?")


def check_real(kind: np.dtype) -> None:
    """Raise `InputError` unless values of a type are real numbers."""
    if kind.kind not in "fiu":
        raise InputError(f"values of type {kind}: must be real numbers")


def real(values) -> np.ndarray:
    """Convert values to double precision, NaN where masked or not finite."""
    check_real(np.asarray(values).dtype)
    numbers = np.array(np.ma.filled(np.ma.asarray(values).astype(float), np.nan))
    numbers[~np.isfinite(numbers)] = np.nan
    return numbers


@contextmanager
def reading_as(title: str) -> Iterator[None]:
    """Raise one clear `InputError` if a file of a format is damaged, whatever a library raises."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if _BYTES.search(reason) or not reason.isprintable():
            raise InputError(f"cannot be read as {title}") from None
        raise InputError(f"cannot be read as {title} ({reason})") from None


def plausible(sides: tuple[float, float] | None) -> str:
    """Describe which units give a wall with sides in the file's units a plausible size."""
    if sides is None:
        return ""
    x, y = sides
    fitting = [
        f"{name} ({1e3 * size * x:.4g} x {1e3 * size * y:.4g} mm)"
        for name, size in UNITS.items()
        if _is_plausible(size, sides)
    ]
    spans = f"; it spans {x:.4g} x {y:.4g}"
    return f"{spans}, plausible in {' or '.join(fitting)}" if fitting else spans


def doubted(units: str, sides: tuple[float, float] | None) -> tuple[str, ...]:
    """Return a warning if units of the sides give an implausible size of the wall."""
    if sides is None or _is_plausible(size_of(units), sides):
        return ()
    return (caution(f"unusual in {units}{plausible(sides)}"),)


def _is_plausible(size: float, sides: tuple[float, float]) -> bool:
    smallest, largest, _ = USUAL["side_of_scan"]
    return size * min(sides) >= smallest and size * max(sides) <= largest


def settled(
    what: str, of_file: str | None, stated: str | None, sides: tuple[float, float] | None = None
) -> str:
    """Return the units of the file or of the user; `InputError` for none, or for two different."""
    units = of_file or stated
    if units is None:
        must = f"give units (--units on the command line){plausible(sides)}"
        raise InputError(f"does not state the units of its {what}: {must}")
    if stated is not None and size_of(units) != size_of(stated):
        raise InputError(f"units = {stated!r}: the {what} of the file are in {of_file!r}")
    return units


def split_name(name: str) -> tuple[str, str | None]:
    """Return ("Z", "mm") for "Z_mm", "Z [mm]", "Z/mm", "Z, mm", "Z in mm"; ("Z", None) for "Z"."""
    match = re.fullmatch(_NAME_AND_UNIT, name)
    if match:
        unit = match[2] if match[2] in SPELT else match[2].lower()  # MM for mm
        if unit in SPELT:
            return match[1], unit
    return name.strip(), None


def axis_name(name: str) -> str:
    """Return "x", "y" or "z" for a column of points (height is z), else its name in lower case."""
    bare = split_name(name)[0].lower()
    if bare in ("height", "elevation"):
        return "z"
    match = re.fullmatch(r"([xyz])[ _-]?(?:pos(?:ition)?|coord(?:inate)?|axis|value)", bare)
    return match[1] if match else bare


def missing_values(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which values are missing, bool of their shape, and the sentinels that occur."""
    with np.errstate(invalid="ignore"):
        missing = np.abs(values) >= LARGEST
    sentinels = list(np.unique(values[missing]))
    others = values[np.isfinite(values) & ~missing & ~np.isin(values, SENTINELS)]
    for sentinel in SENTINELS if others.size else ():
        alike = values == sentinel
        if alike.any() and not others.min() <= sentinel <= others.max():
            missing |= alike
            sentinels.append(sentinel)
    return missing, np.array(sentinels)


def missing_sentence(count: int, sentinels: np.ndarray, what: str) -> str:
    """Return the sentence on values that were treated as missing."""
    words = ", ".join(f"{value:g}" for value in sentinels)
    return f"{count} {what} of {words} were treated as missing"


def missing_heights(heights: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return which heights are missing, also zeros that are too frequent, and remarks."""
    missing, sentinels = missing_values(heights)
    remarks = (missing_sentence(int(missing.sum()), sentinels, "heights"),) if missing.any() else ()
    known = heights[np.isfinite(heights) & ~missing]
    zeros = int((known == 0.0).sum())
    # an instrument that rounds gives neighbouring values about equally often
    if (
        not 10 <= zeros < known.size
        or zeros < 10 * np.unique(known[known != 0.0], return_counts=True)[1].max()
    ):
        return missing, remarks
    about = f"{zeros} of {known.size} heights are exactly 0, far more than of any other"
    if zeros > 0.5 * known.size:  # the wall may be flat
        return missing, (*remarks, caution(f"{about}; they were used as heights"))
    return missing | (heights == 0.0), (*remarks, caution(f"{about}; they were treated as missing"))

"""Contents of the file of a scanned wall, in its units, and their conversion to metres.

Also limits of the size of files and arrays, and words for units and axes.
"""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import SPELT, UNITS, InputError, size_of
from jointclosure.inputs.remarks import caution
from jointclosure.parameters import USUAL
from jointclosure.walls.gridding import Cloud, Scan, points_of
from jointclosure.walls.neighbours import neighbour_pairs
from jointclosure.walls.plateaus import zeros_are_contacts
from jointclosure.walls.scans.sheet import check_precision_of_heights

LARGEST_ARRAY = 800_000_000  # largest size [bytes] of an array in double precision; chosen
LARGEST_FILE = 2_000_000_000  # largest size [bytes] of a file that is read as a whole; chosen
SAME_SPACING = 1e-3  # largest relative difference of two statements of the same spacing
VARIABLE = "variable (--variable on the command line)"
"""Argument and option that choose an array, a channel or columns, for messages."""
_BYTES = re.compile(r"\\x[0-9a-f]{2}")  # bytes of a file in messages of libraries
_NAME_AND_UNIT = r"\s*(.*?)(?:_|\s*/\s*|\s*,\s*|\s+in\s+|[_\s]*[(\[])\s*([A-Za-zµμ]+)\s*[)\]]?\s*"
"""Name of a column with a unit: "Z_mm", "Z / mm", "Z, mm", "Z in mm", "Z [mm]" or "Z (mm)"."""
_FOREIGN = frozenset({
    "cm", "dm", "km", "pm", "ft", "feet", "foot", "mil", "mils", "thou", "px", "pixel", "pixels",
    "angstrom", "centimetre", "centimetres", "centimeter", "centimeters",
})  # fmt: skip
"""Units of length that are recognised in files and refused: users must convert the heights."""

SENTINELS = (-999.0, -9999.0, 9999.0, -99999.0, 99999.0, -999999.0, 999999.0, -32767.0, -32768.0)
"""Values that files contain in place of a missing one; they count as missing if they are larger or
smaller than all other values."""
_ROWS = 200  # largest number of rows of a grid whose precision is checked
_DOUBLE = np.dtype(float)  # type in which all heights are kept
USUAL_DISTANCES = 1e-6, 2e-3
"""Least and largest usual distance [m] of neighbouring heights in scans of rock joints, from
profilometers to laser scanners; chosen. Other distances are probably in a wrong unit, and give a
caution."""
LARGEST = 1e20  # values of at least this size, such as 1.70141e38, are missing in any unit


class Statement(NamedTuple):
    """Spacing of a grid as one line or array of a file states it."""

    names: str  # of the line or the arrays, for messages
    spacing: np.ndarray  # (dy, dx) in the units; NaN along an axis for which none is stated
    units: str | None = None  # None: not stated


class Contents(NamedTuple):
    """Contents of a scan file in its units: heights on a grid, or points, and what it states.

    Either ``heights`` or ``points`` is None. Other fields are None or NaN if the file states none.
    """

    heights: np.ndarray | None = None  # (y, x), rows in order of increasing y
    spacing: tuple[float, float] = (math.nan, math.nan)  # (dy, dx)
    points: np.ndarray | None = None  # (n, 3): x, y, z
    height_units: str | None = None
    length_units: str | None = None
    origin: tuple[float, float] = (math.nan, math.nan)  # (y, x) of the first cell
    remarks: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()  # lines that mention units or lengths and were not used
    stated: tuple[Statement, ...] = ()  # of the header, to be compared with the spacing

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


def check_array(shape: tuple[int, ...], kind: np.dtype = _DOUBLE) -> None:
    """Raise `InputError` unless an array has real numbers, and at most `LARGEST_ARRAY` bytes."""
    if kind.kind not in "fiu":
        raise InputError(f"values of type {kind}: must be real numbers")
    if math.prod(shape) * max(kind.itemsize, _DOUBLE.itemsize) > LARGEST_ARRAY:
        size = f"declares {' x '.join(map(str, shape))} values of {kind.itemsize} bytes"
        as_double = ", which are read in double precision" if kind.itemsize < 8 else ""
        raise InputError(f"{size}{as_double}: must be at most {LARGEST_ARRAY / 1e6:g} MB")


def real(values) -> np.ndarray:
    """Return numbers in double precision, with NaN where they are masked or not finite.

    An array of doubles is not copied: NaN are written into it, unless it is read-only.
    """
    if np.ma.isMaskedArray(values):
        numbers = np.ma.filled(values.astype(float), np.nan)
    else:
        numbers = np.asarray(values, dtype=float)
    finite = np.isfinite(numbers)
    if not finite.all():
        numbers = numbers if numbers.flags.writeable else numbers.copy()
        numbers[~finite] = np.nan
    return numbers


@contextmanager
def reading_as(title: str) -> Iterator[None]:
    """Turn errors that a library raises in this context into an `InputError`.

    It names the format by its ``title``. An `InputError` and a `MemoryError` are passed on.
    """
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if _BYTES.search(reason) or not reason.isprintable():
            raise InputError(f"cannot be read as {title}") from None
        raise InputError(f"cannot be read as {title} ({reason})") from None


def _usual_units(sides: tuple[float, float] | None) -> tuple[list[str], str]:
    """Return the units in which a wall of these sides has a usual size, and words for messages.

    ``sides`` (x, y) are in the unknown units of the file. If they are None, any unit is usual.
    """
    if sides is None:
        return [*UNITS], ""
    smallest, largest, _ = USUAL["side_of_scan"]
    x, y = sides
    usual = {}
    for name, size in UNITS.items():
        if size * min(sides) >= smallest and size * max(sides) <= largest:
            usual[name] = f"{name} ({1e3 * size * x:.4g} x {1e3 * size * y:.4g} mm)"
    spans = f"; it spans {x:.4g} x {y:.4g}"
    return [*usual], f"{spans}, plausible in {' or '.join(usual.values())}" if usual else spans


def _distance_doubt(contents: Contents, lengths: str) -> str:
    """Return words for a caution if heights are unusually near or far apart; "" if they are not.

    ``lengths`` are the units of x and y. Limits are `USUAL_DISTANCES`.
    """
    sides = contents.sides()
    if contents.points is not None and sides is not None:
        count = int(np.isfinite(contents.points).all(axis=1).sum())
        apart = math.sqrt(sides[0] * sides[1] / max(count, 1))
    else:
        apart = float(max(contents.spacing))
    low, high = USUAL_DISTANCES
    distance = size_of(lengths) * apart
    if not math.isfinite(distance) or low <= distance <= high:
        return ""
    others = [name for name, size in UNITS.items() if low <= size * apart <= high]
    return (
        f"heights are {1e3 * distance:.3g} mm apart in {lengths}, and in scans of rock joints "
        f"usually {1e3 * low:g} to {1e3 * high:g} mm, as they would be in "
        f"{' or '.join(others) or 'no known unit'}; check units"
    )


def settled(
    what: str,
    of_file: str | None,
    stated: str | None,
    sides: tuple[float, float] | None = None,
    unread: tuple[str, ...] = (),
) -> str:
    """Return the units of ``what`` (heights or distances) that a file or its user states.

    Raise `InputError` if neither the file (``of_file``) nor the user (``stated``) states units, or
    if both state different ones. The message contains the ``sides`` of the wall and ``unread``
    lines of the file, from which the user may recognise the units.
    """
    units = of_file or stated
    if units is None:
        must = f"give units (--units on the command line){_usual_units(sides)[1]}"
        problem = f"does not state the units of its {what}"
        if unread:
            problem += f" in words that are understood ({'; '.join(map(repr, unread))})"
        raise InputError(f"{problem}: {must}")
    if stated is not None and size_of(units) != size_of(stated):
        raise InputError(
            f"units = {stated!r}: the {what} of the file are in {of_file!r}; "
            f"leave the units out, or give {of_file}"
        )
    return units


def agreed_spacing(statements: list[Statement]) -> tuple[np.ndarray, str | None]:
    """Return the spacing (dy, dx) that statements of a file agree on, and its units.

    It is NaN along an axis without a statement; units are those of the first statement with units,
    or None. Raise `InputError` if statements differ by more than `SAME_SPACING`.
    """
    units = next((each.units for each in statements if each.units), None)
    stated = [each.spacing * unit_ratio(each.units, units) for each in statements]
    known = [column[np.isfinite(column)] for column in np.reshape(stated, (-1, 2)).T]
    if any(len(column) and np.ptp(column) > SAME_SPACING * column[0] for column in known):
        listed = [
            f"{each.names} {listing(each.spacing[np.isfinite(each.spacing)], each.units)}"
            for each in statements
        ]
        raise InputError(f"states different spacings (y, x): {'; '.join(listed)}; must be the same")
    return np.array([column[0] if len(column) else math.nan for column in known]), units


def unit_ratio(units: str | None, target: str | None) -> float:
    """Return the factor that converts numbers in ``units`` of length to the ``target`` units.

    It is 1 if either is not stated.
    """
    return size_of(units) / size_of(target) if units and target and units != target else 1.0


def listing(values, units: str | None = None) -> str:
    """Return numbers as "3 x 4 mm"."""
    return f"{' x '.join(f'{value:.6g}' for value in values)}{f' {units}' if units else ''}"


def unit_in(word: str) -> str | None:
    """Return the unit of length that a word spells, also if it is refused later; else None."""
    word = word.strip()
    return next((w for w in (word, word.lower()) if w in SPELT or w in _FOREIGN), None)


def same_units(where: str, *stated: str | None) -> str | None:
    """Return the unit of length that statements agree on; None if no unit is stated.

    Raise `InputError` that names the place ``where`` in the file if they differ.
    """
    units = [unit for unit in stated if unit]
    if len({size_of(unit) for unit in units}) > 1:
        listed = " and ".join(map(repr, dict.fromkeys(units)))
        raise InputError(f"{where}: states the units {listed}; must be the same")
    return units[0] if units else None


def split_name(name: str) -> tuple[str, str | None]:
    """Return a column's name without its unit, and the unit or None: ("Z", "mm") for "Z [mm]".

    Other spellings are "Z_mm", "Z/mm", "Z, mm" and "Z in mm".
    """
    match = re.fullmatch(_NAME_AND_UNIT, name)
    if match:
        unit = "in" if match[2].lower() == "in" else unit_in(match[2])
        if unit is not None:
            return match[1], unit
    return name.strip(), None


def axis_name(name: str) -> str:
    """Return the axis "x", "y" or "z" that the name of a column means; "height" is z.

    For other names it returns the name in lower case, without its unit.
    """
    bare = split_name(name)[0].lower()
    if bare in ("height", "elevation"):
        return "z"
    match = re.fullmatch(r"([xyz])[ _-]?(?:pos(?:ition)?|coord(?:inate)?|axis|value)", bare)
    return match[1] if match else bare


def missing_values(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which values stand for missing ones (bool, as ``values``), and these values (n,).

    They are values of at least `LARGEST` size, and `SENTINELS`. NaN are not among them.
    """
    missing = (values >= LARGEST) | (values <= -LARGEST)
    sentinels = list(np.unique(values[missing]))
    others = np.isfinite(values) & ~missing & ~np.isin(values, SENTINELS)
    low = np.min(values, where=others, initial=np.inf)
    high = np.max(values, where=others, initial=-np.inf)
    for sentinel in SENTINELS if others.any() else ():
        alike = values == sentinel
        if alike.any() and not low <= sentinel <= high:
            missing |= alike
            sentinels.append(sentinel)
    return missing, np.array(sentinels)


def missing_text(count: int, sentinels: np.ndarray, what: str) -> str:
    """Return the remark that ``count`` values (``what``) were treated as missing."""
    words = ", ".join(f"{value:g}" for value in sentinels)
    return f"{count} {what} of {words} were treated as missing"


def missing_heights(scan: Scan | Cloud) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return which heights of a scan stand for missing ones, and remarks on them.

    The answer is (y, x) for a grid and (n,) for points. Missing are `missing_values`, and heights
    of exactly 0 if they are ten times as frequent as any other height. Zeros are kept that may be
    heights: those of a wall that is mostly 0, and the contacts of an aperture map.
    """
    heights = scan.heights if isinstance(scan, Scan) else scan.points[:, 2]
    missing, sentinels = missing_values(heights)
    remarks = (missing_text(int(missing.sum()), sentinels, "heights"),) if missing.any() else ()
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
    used = np.where(missing, np.nan, heights)
    kept: Scan | Cloud
    if isinstance(scan, Scan):
        kept = scan._replace(heights=used)
    else:
        placed = np.isfinite(scan.points[:, :2]).all(axis=1) & np.isfinite(used)
        kept = Cloud(scan.points[placed])
    if zeros_are_contacts(points_of(kept)[:, 2], neighbour_pairs(kept)):
        contacts = "no height is negative, and heights rise from them without a step"
        done = f"{about}; {contacts}: they were used as contacts of an aperture map"
        return missing, (*remarks, done)
    return missing | (heights == 0.0), (*remarks, caution(f"{about}; they were treated as missing"))


def in_metres(contents: Contents, units: str | None, spacing: float | None) -> Scan | Cloud:
    """Return the scan that the contents of a file are, in metres.

    Missing heights of a grid are NaN; points without a height are left out. ``units`` and
    ``spacing`` [m] are those that the user states, None for those of the file. Raise `InputError`
    if they are stated neither by the file nor by the user, if both differ, or if a grid has fewer
    than 3 x 3 heights, none that is known, or heights that are stored too coarsely.
    """
    sides = contents.sides()
    hint = sides if contents.length_units is None else None
    height = size_of(settled("heights", contents.height_units, units, hint, contents.unread))
    lengths = "m"
    stated = np.array(contents.spacing)
    if contents.points is not None or not np.isnan(stated).all():
        lengths = settled("distances", contents.length_units, units, sides, contents.unread)
    elif spacing is not None:
        stated = np.full(2, spacing)
        contents = contents._replace(spacing=(spacing, spacing))
    across = size_of(lengths)
    usual, spans = _usual_units(contents.sides())
    remarks = contents.remarks
    if contents.unread:
        listed = "; ".join(map(repr, contents.unread))
        unused = f"the file states {listed}, which was not used"
        remarks = (*remarks, caution(f"{unused}; check units and spacing"))
    if SPELT[lengths.strip()] not in usual:
        remarks = (*remarks, caution(f"unusual in {lengths}{spans}"))
    elif spacing is None and (doubt := _distance_doubt(contents, lengths)):
        remarks = (*remarks, caution(doubt))
    if contents.points is not None:
        if spacing is not None:
            given = f"scan_spacing = {1e3 * spacing:g} mm"
            raise InputError(f"{given}: must be left out for points, which have no grid")
        known = contents.points[np.isfinite(contents.points[:, 2])]
        if empty := len(contents.points) - len(known):
            remarks = (*remarks, f"{empty} points without a height were left out")
        return Cloud(known * np.array([across, across, height]), remarks)
    steps = _spacing(stated * across, spacing)
    agreed_spacing([Statement("the grid", np.array(steps) / across, lengths), *contents.stated])
    y, x = contents.origin
    origin = None if np.isnan(y + x) else (y * across, x * across)
    heights = real(contents.heights)
    heights = heights if heights.flags.writeable else heights.copy()
    if heights.ndim != 2 or min(heights.shape) < 3:
        raise InputError(f"heights of shape {heights.shape}: must be (y, x), at least 3 x 3")
    missing, missing_remarks = missing_heights(Scan(heights, steps))
    heights[missing] = np.nan
    if not np.isfinite(heights).any():
        raise InputError(f"all of its {heights.size} heights are missing")
    rows = heights[:: -(-len(heights) // _ROWS)]
    check_precision_of_heights(np.diff(rows, axis=1), rows)
    heights *= height
    return Scan(heights, steps, origin, remarks + missing_remarks)


def _spacing(stated: np.ndarray, spacing: float | None) -> tuple[float, float]:
    """Return the spacing (dy, dx) [m] of a grid: that of the file, else that of the caller.

    ``stated`` (2,) [m] is that of the file, with NaN along an axis where it states none. Raise
    `InputError` if the spacing along an axis is not known, not positive, or differs between both.
    """
    unstated = np.isnan(stated)
    if spacing is None and unstated.any():
        axes = " and ".join(axis for axis, missing in zip("yx", unstated, strict=True) if missing)
        raise InputError(
            f"does not state the spacing of its grid along {axes}: scan_spacing must be given "
            "(--scan-spacing on the command line, spacing_mm in a configuration)"
        )
    if spacing is not None and (np.abs(stated - spacing) > SAME_SPACING * spacing).any():
        steps = " and ".join(f"{1e3 * step:g}" for step in dict.fromkeys(stated[~unstated]))
        given = f"scan_spacing = {1e3 * spacing:g} mm"
        raise InputError(f"{given}: the file states {steps} mm; must be left out")
    dy, dx = np.where(unstated, np.nan if spacing is None else spacing, stated).tolist()
    if not all(0.0 < step < np.inf for step in (dy, dx)):
        raise InputError(f"scan_spacing = {(dy, dx)}: must be positive")
    return dy, dx

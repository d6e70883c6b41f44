"""Measured closure curves, read from text.

A curve is a CSV of stress, closure and cycle, in the order in which it was measured;
docs/first_hour.md shows one. The closure of every cycle counts from the point where its loading
reaches the seating stress, for measured and simulated curves, so that the zero of the measured
closures does not matter.
"""

import csv
import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import SPELT, InputError
from jointclosure.joint.curves import crossing
from jointclosure.joint.protocol import LOADING, UNLOADING
from jointclosure.parameters.units import SI_FACTORS

STRESS_UNITS, CLOSURE_UNITS = ("Pa", "kPa", "MPa", "GPa"), ("m", "mm", "um")
_ALLOWED: dict[str, tuple[str, ...]] = {
    "stress": STRESS_UNITS,
    "closure": CLOSURE_UNITS,
    "cycle": ("",),
}
_FACTORS = SI_FACTORS | {"kPa": 1e3}
_ALIASES = {"normal_stress": "stress", "closure_net_since_seating": "closure"}
"""Names that curves.csv of `jointclosure close` has for the columns of a curve."""


class MeasuredCurve(NamedTuple):
    """Points (n,) of a measured curve: stress [Pa], closure [m], cycle, and line in the file."""

    stress: np.ndarray
    closure: np.ndarray
    cycle: np.ndarray
    line: np.ndarray

    @property
    def cycles(self) -> list[int]:
        """Return the measured cycles, ascending."""
        return np.unique(self.cycle).tolist()

    def branches(self, cycle: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return stress and closure of a cycle, up to its largest stress and beyond it."""
        here = self.cycle == cycle
        stress, closure = self.stress[here], self.closure[here]
        top = int(np.argmax(stress))
        return {
            LOADING: (stress[: top + 1], closure[: top + 1]),
            UNLOADING: (stress[top + 1 :], closure[top + 1 :]),
        }

    def first_loading(self) -> "MeasuredCurve":
        """Return the curve up to the largest stress of its first cycle."""
        here = np.flatnonzero(self.cycle == self.cycle.min())
        here = here[: int(np.argmax(self.stress[here])) + 1]
        return MeasuredCurve(*(column[here] for column in self))

    def since_seating(self, cycle: int, seating_stress: float):
        """Return (branch, stress [Pa], closure [m]) of a cycle, with closure since its seating."""
        branches = self.branches(cycle)
        zero = crossing(*branches[LOADING], seating_stress)
        for branch, (stress, closure) in branches.items():
            counts = stress > seating_stress if branch == LOADING else stress >= 0.0
            yield branch, stress[counts], closure[counts] - zero


def parsed_curve(
    text: str,
    name: str,
    stress_unit: str | None = None,
    closure_unit: str | None = None,
    *,
    cycle: int | None = None,
    names: Sequence[str] | None = None,
) -> MeasuredCurve:
    """Read a curve from the text of a CSV file."""
    numbered = enumerate(text.removeprefix("\ufeff").splitlines(), start=1)
    lines = [(n, line) for n, line in numbered if line.strip() and line.lstrip()[0] != "#"]
    if not lines:
        raise InputError(f"{name}: has no header and no rows")
    mark = next((mark for mark in ";\t," if mark in lines[0][1]), None)
    if mark is None and len(lines[0][1].split()) < 2:
        raise InputError(
            f"{name}, line {lines[0][0]}: {lines[0][1].strip()!r}: columns must be separated by "
            "commas, semicolons, tabs or blanks"
        )
    table = [(number, _cells(line, mark)) for number, line in lines]
    if names and all(map(str.isdecimal, names)) and all(map(_is_number, table[0][1])):
        table.insert(0, (table[0][0], [str(1 + i) for i in range(len(table[0][1]))]))
    (first, header), *body = table
    where = f"{name}, line {first}"
    below = [""] * len(header)
    if body and any(_unit(cell) in STRESS_UNITS for cell in body[0][1]):
        below = [_unit(cell) for cell in body.pop(0)[1]] + below
    units = {"stress": stress_unit, "closure": closure_unit, "cycle": None}
    found: dict[str, tuple[int, str]] = {}
    for position, quantity in enumerate(_named(header, where, names)):
        if quantity not in _ALLOWED:
            continue
        what, allowed = f"{where}: column {header[position]!r}", _ALLOWED[quantity]
        if quantity in found:
            raise InputError(f"{what}: must be the only one of {quantity}")
        stated = _heading(header[position])[1]
        if names is not None and stated not in allowed:
            stated = ""  # part of another heading, such as sigma_n
        unit = (stated or below[position] or units[quantity] or "") * (quantity != "cycle")
        if unit not in allowed:
            usual = {"stress": "MPa", "closure": "mm"}[quantity]
            key = f"--{quantity}-unit ({quantity}_unit= in Python)"
            key = f"the key {quantity}_unit" if cycle is None else key  # of a study
            lacks = f"has no unit; write it in the heading ({quantity}_{usual}), or state {key}:"
            wrong = f"unit {unit!r} must be" if unit else lacks
            raise InputError(f"{what}: {wrong} one of {', '.join(allowed)}")
        found[quantity] = position, unit
    missing = [n for n in _ALLOWED if n not in found and (n != "cycle" or cycle is None)]
    if missing:
        others = "; --columns, or columns= in Python, names or numbers others" if cycle else ""
        raise InputError(
            f"{where}: lacks {', '.join(missing)} (columns are stress_MPa,closure_mm,cycle"
            f"{others}); there are {', '.join(header)}"
        )
    columns = {quantity: found[quantity] for quantity in _ALLOWED if quantity in found}
    rows = []
    for number, cells in body:
        at = f"{name}, line {number}"
        if len(cells) != len(header):
            decimals = " (decimals are written with points)" if mark == "," else ""
            raise InputError(
                f"{at}: {(mark or ' ').join(cells)!r} has {len(cells)} values, the header has "
                f"{len(header)}{decimals}"
            )
        values = [_number(cells[i], at, quantity) for quantity, (i, _) in columns.items()]
        rows.append((*values, number))
    if not rows:
        raise InputError(f"{name}: has a header and no rows")
    stress, closure, *cycles, numbers = (np.array(column) for column in zip(*rows, strict=True))
    of_cycle = cycles[0].astype(int) if cycles else np.full(len(rows), cycle)
    factors = [_FACTORS.get(unit, 1.0) for _, unit in columns.values()]
    return MeasuredCurve(stress * factors[0], closure * factors[1], of_cycle, numbers)


def _named(header: list[str], where: str, names: Sequence[str] | None) -> list[str]:
    """Return the quantity of every column, by its heading or by names or numbers of columns."""
    if names is None:
        named = [_heading(cell)[0] for cell in header]
        return [_ALIASES.get(name, name) for name in named]
    numbers = [str(1 + position) for position in range(len(header))]
    places = [next((each.index(n) for each in (header, numbers) if n in each), -1) for n in names]
    if -1 in places or not 2 <= len(names) <= 3:
        raise InputError(
            f"{where}: columns {', '.join(names)}: must be two or three of "
            f"{', '.join(header)}, or their numbers from 1 to {len(header)}"
        )
    by_place = dict(zip(places, _ALLOWED, strict=False))
    return [by_place.get(position, "") for position in range(len(header))]


def _heading(cell: str) -> tuple[str, str]:
    """Return the name, and the unit at its end or in brackets, of a heading; or empty texts."""
    parts = re.fullmatch(r"(.*?)(?:_([A-Za-zµμ]+)|\s*[(\[]([^)\]]+)[)\]])?", cell)
    return (parts[1].lower(), _unit(parts[2] or parts[3] or "")) if parts else ("", "")


def _unit(cell: str) -> str:
    """Return a unit without brackets, and micrometres as um."""
    bare = cell.strip("()[]")
    return SPELT.get(bare, bare)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cells(line: str, mark: str | None) -> list[str]:
    """Return the cells of a line; decimal commas, which a mark other than "," allows, as points."""
    split = line.split() if mark is None else next(csv.reader([line], delimiter=mark))
    cells = [cell.strip() for cell in split]
    if mark == ",":
        return cells
    return [point if _is_number(point := cell.replace(",", ".")) else cell for cell in cells]


def _number(cell: str, where: str, quantity: str) -> float:
    value = float(cell) if _is_number(cell) else math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {quantity} = {cell.strip()!r}: must be a finite number")
    if quantity == "stress" and value < 0.0:
        raise InputError(f"{where}: stress = {cell.strip()}: must be 0 or above (compression)")
    if quantity == "cycle" and not (value >= 1.0 and value.is_integer()):
        raise InputError(f"{where}: cycle = {cell.strip()}: must be a whole number of at least 1")
    return value


LARGEST_CLOSURE = 20e-3
"""Largest range of measured closures [m]; more is mostly one in another unit."""


def check_loadings(curve: MeasuredCurve, name: str, seating: float) -> None:
    """Check order of cycles, loadings from at or below seating [Pa], and size of closures."""
    if (range_ := float(np.ptp(curve.closure))) > LARGEST_CLOSURE:
        raise InputError(
            f"{name}: closures range over {1e3 * range_:.3g} mm: must be at most "
            f"{1e3 * LARGEST_CLOSURE:g} mm; is their unit right?"
        )
    counts = f"seating_stress_MPa = {1e-6 * seating:g}, from which closures count"
    for i in np.flatnonzero(np.diff(curve.cycle) < 0) + 1:
        raise InputError(
            f"{name}, line {curve.line[i]}: cycle = {curve.cycle[i]} after cycle "
            f"{curve.cycle[i - 1]}: points must be in the order in which they were measured"
        )
    for cycle in curve.cycles:
        loading, _ = curve.branches(cycle)[LOADING]
        where = f"{name}, line {curve.line[curve.cycle == cycle][0]}"
        where += f": stress = {1e-6 * loading[0]:g} MPa"
        if loading[0] > seating:
            must = "must start at or below"
            raise InputError(f"{where}: the loading of cycle {cycle} {must} {counts}")
        if not (loading > seating).any():
            raise InputError(f"{where}: no stress of cycle {cycle} is above {counts}")

"""Measured closure curves, read from text.

A curve is a CSV of stress, closure and cycle, in the order in which it was measured;
docs/first_hour.md shows one. The closure of every cycle counts from the point where its loading
reaches the seating stress, for measured and simulated curves, so that the zero of the measured
closures does not matter.
"""

import csv
import itertools
import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.joint.interpolation import crossing
from jointclosure.joint.status import LOADING, UNLOADING
from jointclosure.measured import dense_logs
from jointclosure.measured.headings import (
    CLOSURE_UNITS,
    FORCE_UNITS,
    KNOWN,
    STRESS_UNITS,
    Heading,
    heading_of,
    unit_of,
)

_ALLOWED = {"stress": STRESS_UNITS, "closure": CLOSURE_UNITS, "cycle": {}}
"""Quantities of the columns of a curve, each with its allowed units in SI."""
_ALIASES = {"normal_stress": "stress", "closure_net_since_seating": "closure"}
"""Names that curves.csv of `jointclosure close` has for the columns of a curve."""
_FORCES = ("load", "force")
"""Last words of the headings of forces."""
_SPECIMENS = ("specimen", "specimen_id", "sample", "sample_id", "joint", "joint_id", "test_id")
"""Headings of columns whose values name the specimen of each row."""


_MOST_OF_FIRST = 1.1
"""Largest allowed ratio of the closure of a later loading to that of the first loading, where no
column numbers the cycles: with more, the later loading is taken for another specimen."""


class TableLine(NamedTuple):
    """Number of a line in its file, and its text."""

    number: int
    text: str


class CurveColumn(NamedTuple):
    """Position of a column in the rows, and the factor that converts its values to SI."""

    position: int
    factor: float


class MeasuredCurve(NamedTuple):
    """Points (n,) of a measured curve: stress [Pa], closure [m], cycle, and line in the file.

    They are in the order of measurement; cycles are numbered from 1.
    """

    stress: np.ndarray
    closure: np.ndarray
    cycle: np.ndarray
    line: np.ndarray

    @property
    def cycles(self) -> list[int]:
        """Numbers of the measured cycles, ascending."""
        return np.unique(self.cycle).tolist()

    def ascending(self, cycle: int) -> dict[str, dense_logs.MeasuredBranch]:
        """Return the loading and the unloading of a cycle, both in ascending order of stress.

        The loading ends with the point of the largest stress, and the unloading, which may have no
        points, is without it. Dense logs whose values scatter are averaged
        (`jointclosure.measured.dense_logs.averaged`).
        """
        here = self.cycle == cycle
        stress = self.stress[here]
        closure = self.closure[here]
        top = dense_logs.place_of_largest(stress) + 1
        back = slice(None, top - 1 if top else None, -1)
        return {
            LOADING: dense_logs.averaged(stress[:top], closure[:top]),
            UNLOADING: dense_logs.averaged(stress[back], closure[back]),
        }

    def branches(self, cycle: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return stresses [Pa] and closures [m] of the loading and of the unloading of a cycle.

        They are as in `ascending`, but the unloading descends, as it was measured.
        """
        up, down = self.ascending(cycle).values()
        return {LOADING: up[:2], UNLOADING: (down.stress[::-1], down.closure[::-1])}

    def first_loading(self) -> "MeasuredCurve":
        """Return the part of the curve up to the largest stress of its first cycle."""
        here = np.flatnonzero(self.cycle == self.cycle.min())
        here = here[: dense_logs.place_of_largest(self.stress[here]) + 1]
        return MeasuredCurve(*(column[here] for column in self))

    def since_seating(self, cycle: int, seating_stress: float):
        """Generate the branches of a cycle with their closures since seating.

        Each is the name of the branch, stresses (n,) [Pa] and closures (n,) [m], which count from
        where the loading reaches the ``seating_stress`` [Pa]. Points of the loading at or below
        this stress are left out, and points of the unloading below 0.
        """
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
    area: float | None = None,
) -> MeasuredCurve:
    """Read a curve from the text of a CSV file.

    Parameters
    ----------
    text, name : str
        Text of the file, and its name in messages.
    stress_unit, closure_unit : str, optional
        Units of columns whose headings state none.
    cycle : int, optional
        Number of the first loading, for a file without a column of cycles; later loadings are
        numbered on from it. If it is None, the file must have that column.
    names : sequence of str, optional
        Headings, or numbers from 1, of the columns of stress, closure and cycle.
    area : float, optional
        Loaded area [m2], by which a column of forces becomes one of stresses.

    Returns
    -------
    MeasuredCurve
        Points in SI units, in the order of the file. They are not checked yet (`check_curve`).

    Raises
    ------
    InputError
        If a column is missing, a line, a unit or a number cannot be read or may be read in two
        ways, the area is missing for forces or given for stresses, or there seem to be several
        specimens.
    """
    numbered = enumerate(text.removeprefix("\ufeff").splitlines(), start=1)
    every = [TableLine(number, line) for number, line in numbered if line.strip()]
    table = _split_table(every, name, names)
    stated = {"stress": stress_unit, "closure": closure_unit}
    found: dict[str, CurveColumn] = {}
    for position, quantity in enumerate(_quantities_of_columns(table.header, table.where, names)):
        if quantity not in _ALLOWED:
            continue
        what = f"{table.where}: column {table.header[position]!r}"
        if quantity in found:
            raise InputError(f"{what}: must be the only one of {quantity}")
        factor = 1.0
        if quantity != "cycle":
            heading = heading_of(table.header[position])
            heading = _add_unit_below(heading, table.units[position], what)
            by_columns = names is not None
            of_study = cycle is None
            unit = _unit_of_column(quantity, heading, stated[quantity], what, by_columns, of_study)
            factor = KNOWN[unit] / _area_of_unit(unit, area, what, of_study)
            _check_preamble(every, table.body, name, what, unit, bool(heading.unit))
        found[quantity] = CurveColumn(position, factor)
    missing = [n for n in _ALLOWED if n not in found and (n != "cycle" or cycle is None)]
    if missing:
        others = "; --columns, or columns= in Python, names or numbers others" if cycle else ""
        raise InputError(
            f"{table.where}: lacks {', '.join(missing)} (columns are stress_MPa,closure_mm,cycle"
            f"{others}); there are {', '.join(table.header)}"
        )
    _check_one_table(table.header, table.body, name, table.mark, "cycle" in found)
    columns = _parsed_columns(table.body, found, name)
    stress = columns["stress"] * found["stress"].factor
    closure = columns["closure"] * found["closure"].factor
    lines = np.array([number for number, _ in table.body])
    if "cycle" in found:
        return MeasuredCurve(stress, closure, columns["cycle"].astype(int), lines)
    curve = MeasuredCurve(stress, closure, np.full(lines.size, cycle), lines)
    return _number_loadings(curve, name)


class _Table(NamedTuple):
    """Table of a file, split into cells."""

    where: str  # file and line of the headings, for messages
    header: list[str]
    units: list[str]  # of the row below the headings; empty texts without one
    body: list[tuple[int, list[str]]]  # number of the line and cells of each row
    mark: str | None  # between the columns, None for blanks


def _split_table(every: Sequence[TableLine], name: str, names: Sequence[str] | None) -> _Table:
    """Find the line of headings in a file, and split it and the rows below it into cells.

    Lines that begin with # are left out. ``name`` is the file in messages, ``names`` are the
    columns that the user named. Raise `InputError` if nothing is left, or if there is one column.
    """
    lines = [line for line in every if line.text.lstrip()[0] != "#"]
    if not lines:
        raise InputError(f"{name}: has no header and no rows")
    place = _place_of_header(lines, names)
    mark = _separator(lines[place].text)
    if mark is None and len(lines[place].text.split()) < 2:
        raise InputError(
            f"{name}, line {lines[place].number}: {lines[place].text.strip()!r}: columns must be "
            "separated by commas, semicolons, tabs or blanks"
        )
    table = [(number, _cells(line, mark)) for number, line in lines[place:]]
    if names and all(map(str.isdecimal, names)) and all(map(_is_number, table[0][1])):
        # columns without headings are named by their numbers
        table.insert(0, (table[0][0], [str(1 + i) for i in range(len(table[0][1]))]))
    (first, header), *body = table
    units = [""] * len(header)
    if body and _is_row_of_units(body[0][1]):
        units = body.pop(0)[1] + units
    return _Table(f"{name}, line {first}", header, units, body, mark)


def _parsed_columns(
    body: Sequence[tuple[int, list[str]]], found: dict[str, CurveColumn], name: str
) -> dict[str, np.ndarray]:
    """Return the values (n,) of each column that was ``found``, in the units of the file.

    Raise `InputError` if there are no rows, or for a cell that is no number (`_parsed_number`).
    """
    if not body:
        raise InputError(f"{name}: has a header and no rows")
    columns = {quantity: found[quantity].position for quantity in _ALLOWED if quantity in found}
    rows = []
    for number, cells in body:
        at = f"{name}, line {number}"
        rows.append([_parsed_number(cells[i], at, quantity) for quantity, i in columns.items()])
    return dict(zip(columns, np.array(rows).T, strict=True))


def _number_loadings(curve: MeasuredCurve, name: str) -> MeasuredCurve:
    """Return a curve whose loadings are numbered as cycles, from the number that all points have.

    The point of smallest stress between two loadings ends one cycle and begins the next: it is
    there twice. Raise `InputError` for a later loading that closes the joint by more than
    `_MOST_OF_FIRST` times the closure of the first: it is probably of another specimen.
    """
    ends = [0, *dense_logs.troughs(curve.stress), curve.stress.size - 1]
    parts = [np.arange(start, end + 1) for start, end in itertools.pairwise(ends)]
    first, *others = (
        np.ptp(curve.closure[part[: 1 + dense_logs.place_of_largest(curve.stress[part])]])
        for part in parts
    )
    for part, later in zip(parts[1:], others, strict=True):
        if later > _MOST_OF_FIRST * first:
            raise InputError(
                f"{name}, line {curve.line[part[0]]}: the loading from here on closes by "
                f"{1e3 * later:.3g} mm and the first one by {1e3 * first:.3g} mm: curves of "
                "several specimens must be in files of their own; if it is a cycle of the same "
                "joint, add a column cycle"
            )
    number = np.repeat(np.arange(len(parts)), [part.size for part in parts])
    stress, closure, cycle, line = (column[np.concatenate(parts)] for column in curve)
    return MeasuredCurve(stress, closure, cycle + number, line)


def _place_of_header(lines: Sequence[TableLine], names: Sequence[str] | None) -> int:
    """Return the index of the line of headings among ``lines``, 0 if none is recognised.

    Other text may stand above the headings. ``names`` are the headings or the numbers of the
    columns that the user named. If no line has them, or the words stress and closure, the headings
    are those above the first line of numbers.
    """
    if names and all(map(str.isdecimal, names)):
        return _place_above_numbers(lines, [int(number) - 1 for number in names])
    for place, line in enumerate(lines):
        cells = _cells(line.text, _separator(line.text))
        known = set(_quantities_of_headings(cells))
        if (
            all(n in cells or n.isdecimal() for n in names)
            if names
            else {"stress", "closure"} <= known
        ):
            return place
    return _place_above_numbers(lines, range(2))


def _place_above_numbers(lines: Sequence[TableLine], positions: Sequence[int]) -> int:
    """Return the index of the line of headings above the first line of numbers.

    It is the first line with numbers in the columns at all ``positions``. A line of units may stand
    between. The index is that of the line of numbers if it has no headings, and 0 without one.
    """
    for place, line in enumerate(lines):
        cells = _cells(line.text, _separator(line.text))
        if max(positions) >= len(cells) or not all(_is_number(cells[i]) for i in positions):
            continue
        for above in (place - 1, place - 2):  # headings, or units below headings
            others = _cells(lines[above].text, _separator(lines[above].text)) if above >= 0 else []
            if len(others) != len(cells) or any(map(_is_number, others)):
                return above + 1
            if not _is_row_of_units(others):
                return above
        return place - 2
    return 0


def _separator(line: str) -> str | None:
    """Return the mark between the columns of a line: semicolon, tab, comma, or None for blanks."""
    return next((mark for mark in ";\t," if mark in line), None)


def _is_row_of_units(cells: Sequence[str]) -> bool:
    """Return whether the cells of a line are units: at least one is, and none is a number."""
    return any(map(unit_of, cells)) and not any(map(_is_number, cells))


def _add_unit_below(heading: Heading, below: str, what: str) -> Heading:
    """Return a heading with the unit of the cell ``below`` it; unchanged if that cell is empty.

    Raise `InputError` if both have units that differ. ``what`` names the column in messages.
    """
    if not below.strip("()[] -"):
        return heading
    unit = unit_of(below)
    if heading.unit and unit != heading.unit:
        raise InputError(f"{what}: its unit is {heading.unit} and in the line below it {below}")
    return heading._replace(unit=unit, unknown="" if unit else below)


def _unit_of_column(
    quantity: str, heading: Heading, stated: str | None, what: str, by_columns: bool, of_study: bool
) -> str:
    """Return the unit of a column: that of its ``heading``, or else the ``stated`` one.

    Raise `InputError` if there is none, or if it does not fit the ``quantity``. ``what`` names the
    column in messages. ``by_columns`` is whether the user named the columns, so that words in the
    heading are not taken for a unit; ``of_study`` whether messages advise a key of a study.
    """
    allowed = _ALLOWED[quantity]
    usual = {"stress": "MPa", "closure": "mm"}[quantity]
    fitting = allowed | (FORCE_UNITS if quantity == "stress" else {})
    key = f"--{quantity}-unit ({quantity}_unit= in Python)"
    key = f"the key {quantity}_unit" if of_study else key
    unknown = heading.unknown
    if not (
        by_columns or unknown or heading.unit or _quantity_of_heading(heading.name) == quantity
    ):
        unknown = heading.name.rpartition("_")[2]
    unit = unknown or heading.unit or stated or ""
    if unit in fitting and not unknown:
        return unit
    must = f"must be one of {', '.join(allowed)}"
    if quantity == "stress":
        must += f", or of a force {', '.join(FORCE_UNITS)}"
    if not unit:
        raise InputError(
            f"{what}: has no unit; write it in the heading ({quantity}_{usual}), or state {key}: "
            f"{must.removeprefix('must be ')}"
        )
    raise InputError(f"{what}: unit {unit!r} {must}")


def _area_of_unit(unit: str, area: float | None, what: str, of_study: bool) -> float:
    """Return the area [m2] by which values in a ``unit`` are divided: 1 unless they are forces.

    Raise `InputError` for forces without an area, and for stresses with one.
    """
    if unit in CLOSURE_UNITS:
        return 1.0
    key = "the key area_mm2" if of_study else "--area (area= in Python)"
    if unit in FORCE_UNITS and area is None:
        raise InputError(
            f"{what}: {unit} is a unit of force; state the loaded area, {key}, by which it "
            "becomes a stress"
        )
    if unit in STRESS_UNITS and area is not None:
        raise InputError(
            f"{what}: {unit} is a unit of stress; leave out the loaded area, {key}, which forces "
            "are divided by"
        )
    return 1.0 if area is None else area


def _check_preamble(
    every: Sequence[TableLine], body: Sequence, name: str, what: str, unit: str, in_heading: bool
) -> None:
    """Raise `InputError` for a line above the table that contradicts the ``unit`` of a column.

    Only lines count that speak of units or of the quantity of the column. Numbers with a unit, such
    as the capacity of a load cell, do not count. If a stress has its unit in the heading
    (``in_heading``), lines on loads and forces do not count either. ``what`` names the column in
    messages, ``name`` the file.
    """
    kind = CLOSURE_UNITS if unit in CLOSURE_UNITS else STRESS_UNITS | FORCE_UNITS
    about = "closure|displacement" if unit in CLOSURE_UNITS else "stress|load|force"
    about = "stress" if in_heading and unit in STRESS_UNITS else about
    first_row = body[0][0] if body else 0
    above = what.partition(": column")[0]
    for number, text in every:
        at = f"{name}, line {number}"
        if number < first_row and at != above and re.search(rf"(?i)\bunits?\b|{about}", text):
            plain = re.sub(r"\d\s*[A-Za-zµμ]+(?:/\w+)?", " ", text)
            units = {unit_of(word) for word in re.split(r"[\s,;:=()\[\]#_]+", plain)} & kind.keys()
            if units and unit not in units:
                raise InputError(
                    f"{at}: {text.strip()!r} states other units than {what}, which is read in "
                    f"{unit}: remove what is wrong"
                )


def _check_one_table(
    header: list[str], body: Sequence, name: str, mark: str | None, has_cycles: bool
) -> None:
    """Raise `InputError` for rows that do not fit the table, and for several specimens in a file.

    Several specimens are recognised by a column that names them, or, without a column of cycles
    (``has_cycles``), by lines that divide the rows. ``mark`` is what separates the columns.
    """
    apart = "curves of several specimens must be in files of their own"
    for number, cells in body:
        at = f"{name}, line {number}"
        if not any(map(_is_number, cells)) or cells == header:
            raise InputError(
                f"{at}: {(mark or ' ').join(cells)!r} stands among the rows of the table and has "
                f"no number; {apart}, and remove other text"
            )
        if len(cells) != len(header):
            decimals = " (decimals are written with points)" if mark == "," else ""
            raise InputError(
                f"{at}: {(mark or ' ').join(cells)!r} has {len(cells)} values, the header has "
                f"{len(header)}{decimals}"
            )
    for position, cell in enumerate(header):
        values = dict.fromkeys(cells[position] for _, cells in body)
        if heading_of(cell).name in _SPECIMENS and 1 < len(values) < len(body):
            raise InputError(
                f"{name}: column {cell!r} has {len(values)} values, {', '.join(list(values)[:3])}"
                f"{' and others' * (len(values) > 3)}; {apart}"
            )
    numbers = [number for number, _ in body]
    gaps = [later for earlier, later in itertools.pairwise(numbers) if later > earlier + 1]
    if not has_cycles and 0 < len(gaps) < len(numbers) - 1:
        raise InputError(
            f"{name}, line {gaps[0]}: rows are divided by a line that is no row. If these are "
            f"cycles of one joint, add a column cycle; {apart}"
        )


def _quantities_of_columns(header: list[str], where: str, names: Sequence[str] | None) -> list[str]:
    """Return the quantity of every column: "stress", "closure", "cycle" or any other word.

    It follows from the headings, or from ``names``, the headings or numbers of stress, closure and
    cycle that the user stated. Raise `InputError` for names that are missing or ambiguous.
    """
    if names is None:
        return _quantities_of_headings(header)
    numbers = [str(1 + position) for position in range(len(header))]
    if twice := [n for n in names if header.count(n) > 1]:
        raise InputError(
            f"{where}: column {twice[0]!r} stands there {header.count(twice[0])} times: give the "
            f"numbers of the columns, from 1 to {len(header)}; curves of several specimens must "
            "be in files of their own"
        )
    places = [next((each.index(n) for each in (header, numbers) if n in each), -1) for n in names]
    if -1 in places or not 2 <= len(names) <= 3:
        raise InputError(
            f"{where}: columns {', '.join(names)}: must be two or three of "
            f"{', '.join(header)}, or their numbers from 1 to {len(header)}"
        )
    cycles = [
        i
        for i, cell in enumerate(header)
        if _quantity_of_heading(cell) == "cycle" and i not in places
    ]
    by_place = dict(zip([*places, *cycles], _ALLOWED, strict=False))
    return [by_place.get(position, "") for position in range(len(header))]


def _quantities_of_headings(header: Sequence[str]) -> list[str]:
    """Return the quantity of every column by its heading.

    Without a column of stress, a column of forces counts as "stress": the caller divides it by the
    loaded area.
    """
    quantities = [_quantity_of_heading(cell) for cell in header]
    if "stress" in quantities:
        return quantities
    force = [_is_force(heading_of(cell)) for cell in header]
    return ["stress" if f else q for f, q in zip(force, quantities, strict=True)]


def _is_force(heading: Heading) -> bool:
    """Return whether a heading names a load or a force, and has a unit of force."""
    return heading.unit in FORCE_UNITS and heading.name.rpartition("_")[2] in _FORCES


def _quantity_of_heading(cell: str) -> str:
    """Return the quantity that the heading of a column names, such as "stress".

    The last word of the heading may be a unit, known or not.
    """
    name = heading_of(cell).name
    before = name.rpartition("_")[0]
    name = before if name not in _ALIASES and before in (*_ALLOWED, *_ALIASES) else name
    return _ALIASES.get(name, name)


def _is_number(cell: str) -> bool:
    """Return whether a cell of the file is a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cells(line: str, mark: str | None) -> list[str]:
    """Split a line into its cells at a ``mark``, or at blanks if it is None.

    Unless the mark is a comma, a cell that is a number with a decimal comma gets a point.
    """
    split = line.split() if mark is None else next(csv.reader([line], delimiter=mark))
    cells = [cell.strip() for cell in split]
    if mark == ",":
        return cells
    return [point if _is_number(point := cell.replace(",", ".")) else cell for cell in cells]


def _parsed_number(cell: str, where: str, quantity: str) -> float:
    """Return the number in a cell of a measured curve.

    Raise `InputError`, which names the line ``where``, unless it is a finite number, and for a
    cycle a whole number of at least 1.
    """
    value = float(cell) if _is_number(cell) else math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {quantity} = {cell.strip()!r}: must be a finite number")
    if quantity == "cycle" and not (value >= 1.0 and value.is_integer()):
        raise InputError(f"{where}: cycle = {cell.strip()}: must be a whole number of at least 1")
    return value


CLOSURES = 0.2e-6, 20e-3
"""Least and largest allowed range of the closures of a curve [m]: beyond, the unit is wrong."""
STRESSES = 1e3, 1e9
"""Least and largest allowed maximum of the stresses of a curve [Pa]."""
_OF_SCATTER = 5.0
"""Negative stress that scatter explains, over the standard deviation of the scatter."""


def check_curve(curve: MeasuredCurve, name: str, seating: float) -> None:
    """Raise `InputError` if a curve cannot be compared with simulated joints.

    Its points must be in the order of the cycles, without spikes, and of usual signs and sizes
    (`_check_sizes`). Each cycle must have one loading, which starts at or below ``seating`` [Pa]
    and ends above it, with a larger closure at the end than at seating. An unloading down to
    seating must end with less closure than the loading. ``name`` is the curve in messages.
    """
    counts = f"seating_stress_MPa = {1e-6 * seating:g}, from which closures count"
    for i in np.flatnonzero(np.diff(curve.cycle) < 0) + 1:
        raise InputError(
            f"{name}, line {curve.line[i]}: cycle = {curve.cycle[i]} after cycle "
            f"{curve.cycle[i - 1]}: points must be in the order in which they were measured"
        )
    _check_sizes(curve, name)
    for cycle in curve.cycles:
        here = curve.cycle == cycle
        if again := dense_logs.troughs(curve.stress[here]):
            raise InputError(
                f"{name}, line {curve.line[here][again[0]]}: cycle {cycle} is loaded again from "
                f"{1e-6 * curve.stress[here][again[0]]:.3g} MPa: every loading must have a cycle "
                "of its own, and curves of several specimens files of their own"
            )
        branches = curve.branches(cycle)
        stress, closure = branches[LOADING]
        where = f"{name}, line {curve.line[here][0]}: stress = {1e-6 * stress[0]:g} MPa"
        if stress[0] > seating:
            must = "must start at or below"
            raise InputError(f"{where}: the loading of cycle {cycle} {must} {counts}")
        if not (stress > seating).any():
            raise InputError(
                f"{where}: no stress of cycle {cycle} is above {counts}; the largest is "
                f"{1e-6 * stress.max():.3g} MPa: is the unit of the stress right?"
            )
        ends = crossing(stress, closure, seating), float(closure[-1])
        if not ends[1] > ends[0]:
            raise InputError(
                f"{name}: closure of cycle {cycle} must increase with stress on loading, but is "
                f"{1e3 * ends[0]:.4g} mm at {1e-6 * seating:g} MPa and {1e3 * ends[1]:.4g} mm at "
                f"{1e-6 * stress[-1]:g} MPa; change its sign if it is an opening"
            )
        stress, back = branches[UNLOADING]
        if stress.size and stress[-1] <= seating and not back[-1] < ends[1]:
            raise InputError(
                f"{name}: closure of cycle {cycle} must decrease on unloading, but is "
                f"{1e3 * ends[1]:.4g} mm at the largest stress and {1e3 * back[-1]:.4g} mm at "
                f"{1e-6 * stress[-1]:g} MPa"
            )


def _check_sizes(curve: MeasuredCurve, name: str) -> None:
    """Raise `InputError` unless the numbers of a curve are finite, without spikes, and usual.

    Columns must have one shape (n,). Stresses may be negative only within their scatter. The
    largest stress must be within `STRESSES`, the range of the closures within `CLOSURES`.
    """
    sizes = [np.shape(column) for column in curve]
    if len(set(sizes)) > 1 or len(sizes[0]) != 1 or sizes[0] == (0,):
        raise InputError(
            f"{name}: stress, closure, cycle and line have shapes {sizes}: must be (n,)"
        )
    for quantity, values in (("stress", curve.stress), ("closure", curve.closure)):
        if not np.isfinite(values).all():
            raise InputError(f"{name}: {quantity} has values that are not finite")
        if (numbers := dense_logs.spikes(values)).size:
            at = int(numbers[0])
            size, unit = {"stress": (1e-6, "MPa"), "closure": (1e3, "mm")}[quantity]
            raise InputError(
                f"{name}, line {curve.line[at]}: {quantity} = {size * values[at]:.4g} {unit} lies "
                f"far from the points before and after it, as do {numbers.size - 1} others: "
                "remove failed measurements"
            )
    largest = float(curve.stress.max())
    least = float(curve.stress.min())
    if least < -_OF_SCATTER * dense_logs.scatter_of(curve.stress):
        line = curve.line[int(np.argmin(curve.stress))]
        sign = "; compression is positive, change the sign" if -least > largest else ""
        raise InputError(
            f"{name}, line {line}: stress = {1e-6 * least:g} MPa: must be 0 or above "
            f"(compression), or differ from 0 by the scatter of the stresses alone{sign}"
        )
    for what, value, (low, high), unit, size in (
        ("closures range over", float(np.ptp(curve.closure)), CLOSURES, "mm", 1e3),
        ("the largest stress is", largest, STRESSES, "MPa", 1e-6),
    ):
        if not low <= value <= high:
            limit = f"at most {size * high:g}" if value > high else f"at least {size * low:g}"
            raise InputError(
                f"{name}: {what} {size * value:.3g} {unit}: must be {limit} {unit}; "
                "is their unit right?"
            )

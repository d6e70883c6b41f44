"""Points x, y, z in text: csv, xyz, txt."""

from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.scans.contents import Contents
from jointclosure.scans.lattice import lattice_of, merged_points
from jointclosure.scans.sentinels import missing_heights, missing_values, said
from jointclosure.scans.text import Table, read_table
from jointclosure.scans.units import size_of, split_name
from jointclosure.surface.outliers import strays

NAMED = 3
"""Stray points that are told by their places."""


def read_text(path: Path, variable: str | None) -> Contents:
    """Points from lines of x, y and z, separated by commas, semicolons, tabs or blanks.

    Lines of names may say the columns' units ("x_mm", "z (um)"); ``variable`` names three
    columns, or counts them from 1 ("x,y,height", "1,2,4"), where they are not named x, y and z.
    What is missing, stray or passed over is told in the remarks. Points that are all cells of a
    regular grid are returned as that grid.
    """
    try:
        table = read_table(path)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot be read as points ({str(error).strip()})") from None
    columns = _columns(table, variable)
    values = table.values[:, columns]
    x, y, z = (_unit_of(table, column) for column in columns)
    if x != y:
        raise InputError(f"x is in {x} and y in {y}: must be in the same units")
    found = contents_of(values)
    return found._replace(height_units=z, length_units=x, remarks=table.remarks + found.remarks)


def contents_of(points: np.ndarray) -> Contents:
    """Points (n, 3) as the regular grid on which they lie, else as points; without units.

    Raises
    ------
    InputError
        A point has a height and lacks its place, or places have several heights.
    """
    points, remarks = cleaned(points)
    lattice = lattice_of(points)
    if lattice is None:
        points, repeats = merged_points(points)
        return Contents(points=points, remarks=remarks + repeats)
    return Contents(
        lattice.heights, lattice.spacing, None, None, None, lattice.origin,
        remarks + lattice.remarks,
    )  # fmt: skip


def _unit_of(table: Table, column: int) -> str | None:
    """The unit of a column by its name or by the line of units below the names."""
    name = table.names[column] if table.names else ""
    by_name, by_line = split_name(name)[1], table.units[column] if table.units else None
    if by_name and by_line and size_of(by_name) != size_of(by_line):
        raise InputError(f"the column {name!r} is in {by_line!r} by the line of units")
    return by_name or by_line


def cleaned(points: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Points (n, 3) of a wall, NaN where a height is missing, and what was left out of them.

    Raises
    ------
    InputError
        A point has a height and lacks its place.
    """
    points = points.astype(float)
    places, sentinels = zip(*(missing_values(column) for column in points[:, :2].T), strict=True)
    without_height, remarks = missing_heights(points[:, 2])
    missing = np.column_stack([*places, without_height])
    if missing[:, :2].any():
        count, values = int(missing[:, :2].any(axis=1).sum()), np.unique(np.concatenate(sentinels))
        remarks += (said(count, values, "places"),)
    points[missing] = np.nan
    points[~np.isfinite(points)] = np.nan
    placed = np.isfinite(points[:, :2]).all(axis=1)
    nowhere = np.flatnonzero(~placed & np.isfinite(points[:, 2]) & ~missing.any(axis=1))
    if nowhere.size:
        raise InputError(f"{nowhere.size} points lack x or y, the first is number {nowhere[0] + 1}")
    if not placed.all():
        remarks += (f"{int((~placed).sum())} lines without a place were passed over",)
        points = points[placed]
    stray = strays(points)
    if stray.any():
        named = [f"({x:g}, {y:g}, {z:g})" for x, y, z in points[stray][:NAMED]]
        more = ", ..." if stray.sum() > NAMED else ""
        verb = "points were" if stray.sum() > 1 else "point was"
        remarks += (
            f"{int(stray.sum())} stray {verb} cut, far from all others: {', '.join(named)}{more} "
            "(x, y, z in the file's units)",
        )
        points = points[~stray]
    return points, remarks


def _columns(table: Table, variable: str | None) -> list[int]:
    """Numbers of the columns of x, y and z."""
    width = table.values.shape[1]
    bare = [split_name(name)[0].lower() for name in table.names]
    if variable is not None:
        return _stated_columns(table.names, bare, width, variable)
    if table.names:
        if not {"x", "y", "z"} <= set(bare):
            raise InputError(
                f"columns {', '.join(table.names)}: must name x, y and z, or say which they are "
                "(variable: 1,2,3)"
            )
        return [bare.index(axis) for axis in "xyz"]
    if width != 3:
        raise InputError(
            f"{width} columns without names: must be three, x, y and z, or say which they are "
            "(variable: 1,2,3)"
        )
    return [0, 1, 2]


def _stated_columns(names: list[str], bare: list[str], width: int, variable: str) -> list[int]:
    found = []
    for word in (word.strip() for word in variable.split(",")):
        if word.isdecimal() and 1 <= int(word) <= width:
            found.append(int(word) - 1)
        elif word in names:
            found.append(names.index(word))
        elif word.lower() in bare:
            found.append(bare.index(word.lower()))
    if len(found) != 3 or len(set(found)) != 3 or len(variable.split(",")) != 3:
        allowed = ", ".join(names) if names else f"numbers from 1 to {width}"
        raise InputError(
            f"variable = {variable!r}: must be three columns for x, y and z, as in 1,2,3; "
            f"there are {allowed}"
        )
    return found

"""Points x, y, z in text: csv, xyz, txt."""

from pathlib import Path

import numpy as np
import pandas as pd

from jointclosure.inputs import InputError
from jointclosure.scans.contents import Contents
from jointclosure.scans.units import split_name

_SEPARATORS = {",": ",", ";": ";", "\t": "\t"}


def read_text(path: Path, variable: str | None) -> Contents:
    """Points from lines of x, y and z, separated by commas, semicolons or blanks.

    A first line of names may say the columns' units ("x_mm", "z (um)"); further columns are left
    out where it names x, y and z. Lines that start with # are comments. Points that are all
    cells of a regular grid are returned as that grid.
    """
    if variable is not None:
        raise InputError(f"variable = {variable!r}: of text the columns x, y and z are read")
    try:
        table = _table(path)
        names = _columns(table)
        points = table[[names[axis] for axis in "xyz"]].to_numpy(dtype=float)
    except (ValueError, UnicodeDecodeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot be read as points ({str(error).strip()})") from None
    units = {axis: split_name(names[axis])[1] for axis in "xyz"}
    nowhere = np.flatnonzero(~np.isfinite(points[:, :2]).all(axis=1))
    if nowhere.size:
        raise InputError(f"{nowhere.size} points lack x or y, the first is number {nowhere[0] + 1}")
    if units["x"] != units["y"]:
        raise InputError(f"x is in {units['x']} and y in {units['y']}: must be in the same units")
    grid = _as_grid(points)
    if grid is not None:
        heights, spacing = grid
        return Contents(heights, spacing, None, units["z"], units["x"])
    return Contents(points=points, height_units=units["z"], length_units=units["x"])


def _columns(table: pd.DataFrame) -> dict[str, str]:
    """Columns by their names without units."""
    names = {split_name(str(column))[0].lower(): str(column) for column in table.columns}
    if not {"x", "y", "z"} <= set(names):
        raise InputError(f"columns {', '.join(names)}: must name x, y and z")
    return names


def _table(path: Path) -> pd.DataFrame:
    with path.open(encoding="utf-8") as file:
        lines = (line.strip() for line in file)
        first = next((line for line in lines if line and not line.startswith("#")), None)
    if first is None:
        raise InputError("has no points")
    separator = next((mark for mark in _SEPARATORS if mark in first), r"\s+")
    words = first.split(separator) if separator in _SEPARATORS else first.split()
    names = None
    if all(_is_number(word) for word in words):
        if len(words) != 3:
            raise InputError(f"{len(words)} columns without names: must be three, x, y and z")
        names = ["x", "y", "z"]
    return pd.read_csv(
        path, sep=separator, comment="#", names=names, skipinitialspace=True, encoding="utf-8"
    )


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _as_grid(points: np.ndarray) -> tuple[np.ndarray, tuple[float, float]] | None:
    """Heights (y, x) and spacing (dy, dx) of points that are all cells of a grid, else None."""
    axes = []
    for values in points[:, :2].T:
        levels, index = np.unique(values, return_inverse=True)
        steps = np.diff(levels)
        if len(levels) < 3 or np.ptp(steps) > 1e-3 * steps.mean():
            return None
        axes.append((index, len(levels), float(steps.mean())))
    (x, nx, dx), (y, ny, dy) = axes
    if nx * ny != len(points) or len(np.unique(y * nx + x)) != len(points):
        return None
    heights = np.empty((ny, nx))
    heights[y, x] = points[:, 2]
    return heights, (dy, dx)

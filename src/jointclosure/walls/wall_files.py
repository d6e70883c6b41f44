"""Two walls from their files: reading, and registration with errors that name the files."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from jointclosure.inputs import InputError, naming
from jointclosure.inputs.length_units import size_of
from jointclosure.inputs.remarks import caution
from jointclosure.walls.flat_walls import walls_not_flat
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.joint_grid import LARGEST
from jointclosure.walls.prepared_scans import SIDES
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.registration import registered_by
from jointclosure.walls.registration_options import RegistrationOptions
from jointclosure.walls.scans import read_scan

Wall = str | Path | Sequence[str | Path] | Scan | Cloud
"""A wall: file or three files of x, y and heights, scan, or "flat"."""


def registered_walls(
    upper: Wall,
    lower: Wall,
    scans: Mapping[str, Any],
    spacing: float | None = None,
    **options: Any,
) -> RegisteredPair:
    """Read and register two walls; the message of an error names their files.

    Options, the types of the walls, and flat walls are checked before a file is read. Walls whose
    files have names in the other order receive a warning.

    Parameters
    ----------
    upper, lower : Wall
        A file, three files of x, y and heights, a `Scan` or `Cloud`, or "flat".
    scans : mapping
        Keywords of `jointclosure.read_scan`, each one value or a pair (upper, lower); ignored for a
        wall that is no file.
    spacing : float, optional
        Stated grid spacing [m], checked before. Without it the joint may have `LARGEST` cells.
    **options
        Fields of `RegistrationOptions`.

    Raises
    ------
    InputError
        If a file cannot be read, or as `jointclosure.walls.registration.registered`.
    """
    for name, value in scans.items():
        if isinstance(value, tuple | list) and len(value) != 2:
            raise InputError(f"{name} = {value!r}: must be one value, or one for each wall")
    checked = RegistrationOptions(**options)
    walls = walls_not_flat(upper, lower, checked.orientation)
    for wall in walls.values():
        _check_type(wall)
    read = {side: _read_wall(wall, side, scans) for side, wall in walls.items()}
    most_cells = LARGEST if spacing is None else None
    if isinstance(upper, Scan | Cloud) or isinstance(lower, Scan | Cloud):
        return registered_by(checked, read, spacing, most_cells)
    names = (
        ", ".join(map(str, wall)) if isinstance(wall, tuple | list) else str(wall)
        for wall in (upper, lower)
    )
    with naming(" and ".join(names)), _naming_units(scans.get("units")):
        pair = registered_by(checked, read, spacing, most_cells)
    pair.remarks.extend(order_cautions(upper, lower))
    return pair


def _read_wall(wall: Wall, side: str, scans: Mapping[str, Any]) -> Scan | Cloud:
    """Return the scan of a side from its file, or the given scan.

    ``scans`` are as for `registered_walls`. Raise `InputError` if the file cannot be read.
    """
    if isinstance(wall, Scan | Cloud):
        return wall
    number = SIDES.index(side)
    return read_scan(
        wall, **{k: v[number] if isinstance(v, tuple | list) else v for k, v in scans.items()}
    )


@contextmanager
def _naming_units(units: Any) -> Iterator[None]:
    """Add to an `InputError` that the units stated for both walls differ, if they do.

    ``units`` are one unit or a pair (upper, lower).
    """
    try:
        yield
    except InputError as error:
        if isinstance(units, tuple | list) and size_of(units[0]) != size_of(units[1]):
            raise InputError(
                f"{error}; units are stated as {units[0]} for the upper wall and {units[1]} for "
                "the lower one (--units): are both right?"
            ) from None
        raise


def order_cautions(upper: Wall, lower: Wall) -> list[str]:
    """Return a warning if the names of two files say that the walls are in the wrong order.

    The upper wall's file is named "lower" and the lower wall's "upper"; other names are ignored.
    """
    names = [
        Path(wall).stem.lower() if isinstance(wall, str | Path) else "" for wall in (upper, lower)
    ]
    said = [{word for word in ("upper", "lower") if word in name} for name in names]
    if said != [{"lower"}, {"upper"}]:
        return []
    return [
        caution(
            f"{upper} is taken as the upper wall and {lower} as the lower one, as they are given "
            "in this order; exchange them if their names are right"
        )
    ]


def _check_type(wall: Wall) -> None:
    """Raise `InputError` if a wall is neither a scan, nor a file, nor several files."""
    if not isinstance(wall, Scan | Cloud | str | Path | tuple | list):
        raise InputError(
            f"a wall of type {type(wall).__name__}: must be a file, or a Scan or Cloud of it; "
            "walls that are arrays, with heights towards each other, are closed by simulate"
        )

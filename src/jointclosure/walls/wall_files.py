"""Two walls from their files: reading, and registration with errors that name the files."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from jointclosure.inputs import InputError, naming
from jointclosure.inputs.length_units import size_of
from jointclosure.inputs.remarks import caution
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.gridding import FLAT, Cloud, Scan
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.registration import registered_by
from jointclosure.walls.registration_options import RegistrationOptions
from jointclosure.walls.scans import read_scan

LARGEST = 1000 * 1000  # most cells of a joint without a stated grid spacing
SUGGESTED = 200  # cells along the longer side for which a coarser spacing is suggested
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

    ``scans`` are keywords of `jointclosure.read_scan`, each one value or a pair (upper, lower);
    ``options`` are those of `RegistrationOptions`. A stated ``spacing`` [m] was checked before;
    without one the joint may have `LARGEST` cells.
    """
    for name, value in scans.items():
        if isinstance(value, tuple | list) and len(value) != 2:
            raise InputError(f"{name} = {value!r}: must be one value, or one for each wall")
    checked = RegistrationOptions(**options)  # before files are read
    above, below = (
        read_wall(wall, **{k: v[n] if isinstance(v, tuple | list) else v for k, v in scans.items()})
        for n, wall in enumerate((upper, lower))
    )
    if isinstance(upper, Scan | Cloud) or isinstance(lower, Scan | Cloud):
        pair = registered_by(checked, above, below, spacing)
    else:
        names = (
            ", ".join(map(str, wall)) if isinstance(wall, tuple | list) else str(wall)
            for wall in (upper, lower)
        )
        with naming(" and ".join(names)), _naming_units(scans.get("units")):
            pair = registered_by(checked, above, below, spacing)
        pair.remarks.extend(order_cautions(upper, lower))
    check_cells(pair.upper.shape, pair.spacing, spacing is not None)
    return pair


@contextmanager
def _naming_units(units: Any) -> Iterator[None]:
    """Add to an `InputError` that both walls have other units, if they do."""
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
    """Return a warning if the names of two files say that the walls are in the wrong order."""
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


def check_cells(shape: tuple[int, int], spacing: float, stated: bool) -> None:
    """Raise `InputError` for more than `LARGEST` cells, unless the grid spacing [m] was stated."""
    cells = shape[0] * shape[1]
    if cells > LARGEST and not stated:
        raise InputError(
            f"{grid_text(shape, spacing)}: must be at most {LARGEST:,} cells unless the grid "
            f"spacing is stated; {coarser_grid(shape, spacing)}"
        )


def coarser_grid(shape: tuple[int, int], spacing: float) -> str:
    """Suggest a multiple of the spacing [m] at which a joint has about `SUGGESTED` cells a side."""
    step = max(int(np.ceil(max(shape) / SUGGESTED)), 2)
    return (
        f"a grid spacing of {1e3 * step * spacing:.4g} mm (--spacing, or spacing= in m) takes "
        "less, but a cell is an asperity: its effect is in the range with other choices"
    )


def read_wall(wall: Wall, **stated: Any) -> Scan | Cloud | str:
    """Return a scan or "flat", read from its file; keywords as for `jointclosure.read_scan`."""
    if isinstance(wall, Scan | Cloud):
        return wall
    if isinstance(wall, str | Path) and str(wall) == FLAT:
        return FLAT
    if not isinstance(wall, str | Path | tuple | list):
        raise InputError(
            f"a wall of type {type(wall).__name__}: must be a file, or a Scan or Cloud of it; "
            "walls that are arrays, with heights towards each other, are closed by simulate"
        )
    return read_scan(wall, **stated)

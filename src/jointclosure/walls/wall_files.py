"""Two walls from their files: reading, and registration with errors that name the files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jointclosure.inputs import InputError, naming
from jointclosure.walls.gridding import FLAT, Cloud, Scan
from jointclosure.walls.registration import RegisteredPair, registered
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

    ``scans`` are keywords of `jointclosure.read_scan`, each one value or a pair (upper, lower);
    ``options`` are those of `registered`.
    """
    for name, value in scans.items():
        if isinstance(value, tuple | list) and len(value) != 2:
            raise InputError(f"{name} = {value!r}: must be one value, or one for each wall")
    above, below = (
        read_wall(wall, **{k: v[n] if isinstance(v, tuple | list) else v for k, v in scans.items()})
        for n, wall in enumerate((upper, lower))
    )
    if isinstance(upper, Scan | Cloud) or isinstance(lower, Scan | Cloud):
        return registered(above, below, spacing, **options)
    names = (
        ", ".join(map(str, wall)) if isinstance(wall, tuple | list) else str(wall)
        for wall in (upper, lower)
    )
    with naming(" and ".join(names)):
        return registered(above, below, spacing, **options)


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

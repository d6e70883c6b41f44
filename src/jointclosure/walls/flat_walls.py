"""Joints of which one wall is flat: which walls were scanned, and what they must be stated with."""

from pathlib import Path
from typing import TypeVar

from jointclosure.inputs import InputError
from jointclosure.walls.gridding import FLAT

_Wall = TypeVar("_Wall")


def walls_not_flat(upper: _Wall, lower: _Wall, orientation: str | None) -> dict[str, _Wall]:
    """Return the walls that are not flat by their sides, "upper" before "lower".

    A flat wall is stated by the word "flat" in place of a scan or a file. The other walls are not
    looked at, so that flat walls are refused before files are read. Raise `InputError` if both
    walls are flat, or if the ``orientation`` does not suit the flat one: it must be left out under
    a flat upper wall, and be "common_frame" or "towards" over a flat lower one.
    """
    walls = {side: wall for side, wall in (("upper", upper), ("lower", lower)) if not _flat(wall)}
    if not walls:
        raise InputError("upper and lower: both walls are flat; one must be a scan")
    if "upper" not in walls and orientation is not None:
        raise InputError(f"orientation = {orientation!r}: must be left out for a flat wall")
    if "lower" not in walls and orientation not in ("common_frame", "towards"):
        stated = "" if orientation is None else f" = {orientation!r}"
        raise InputError(
            f"orientation{stated}: must be stated where the lower wall is flat: common_frame "
            "(the heights are an aperture map) or towards (they count towards the other wall)"
        )
    return walls


def _flat(wall: object) -> bool:
    return isinstance(wall, str | Path) and str(wall) == FLAT

"""What the file of a scanned wall says."""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError

LARGEST_SCAN = 100_000_000
"""Heights of a file: 10,000 x 10,000 take 0.8 GB. A damaged or hostile file may declare more."""


class Contents(NamedTuple):
    """Heights (y, x) on a grid of a spacing (dy, dx), or points (n, 3); each in its own units.

    Rows are those of growing y. Units are as the file writes them ("mm", "micrometre"), None where
    it does not. ``origin`` is (y, x) of the first cell, None where the file does not place its
    grid; ``remarks`` are sentences on what was passed over in reading.
    """

    heights: np.ndarray | None = None
    spacing: tuple[float, float] | None = None
    points: np.ndarray | None = None
    height_units: str | None = None
    length_units: str | None = None
    origin: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()


def check_size(shape: tuple[int, ...]) -> None:
    """Raise `InputError` where an array of a shape is larger than `LARGEST_SCAN`."""
    if math.prod(shape) > LARGEST_SCAN:
        size = " x ".join(map(str, shape))
        raise InputError(f"declares {size} values: at most {LARGEST_SCAN:,} are read")

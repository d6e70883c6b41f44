"""What the file of a scanned wall says."""

from typing import NamedTuple

import numpy as np


class Contents(NamedTuple):
    """Heights (y, x) on a grid of a spacing (dy, dx), or points (n, 3); each in its own units.

    Units are as the file writes them ("mm", "micrometre"), None where it does not. ``origin`` is
    (y, x) of the first cell, None where the file does not place its grid; ``remarks`` are
    sentences on what was passed over in reading.
    """

    heights: np.ndarray | None = None
    spacing: tuple[float, float] | None = None
    points: np.ndarray | None = None
    height_units: str | None = None
    length_units: str | None = None
    origin: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()

"""Time and memory that a joint of scanned walls will take, before it is closed."""

import time
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.uncertainty import sources_of, variants_of
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions

WINDOW = 64
"""Cells a side of the window of the walls that is closed to estimate the time."""
EXPONENT = 1.5
"""Power of the number of cells with which the time of a closure grows. From 64 x 64 to 200 x 200
cells (granite, JRC 8, 10 MPa, resolved breakage) it was 1.1 for walls that mate beyond 3 mm and 2.2
for independent walls with waves of all lengths; to 400 x 400 cells 1.3 for the former."""
UNKNOWN = 4.0
"""Factor by which the true time may be shorter or longer than the estimate."""
BYTES = 1000
"""Memory for each cell; 1.0 kB was measured between 100 x 100 and 400 x 400 cells."""
BASE_BYTES = 300e6
"""Memory of the program with a small joint."""
SMALL = 150 * 150
"""Number of cells up to which a joint with its range takes about 20 s or less."""
LARGEST = 1000 * 1000
"""Largest number of cells that is closed without a stated grid spacing."""
SUGGESTED = 200
"""Cells along the longer side for which a coarser spacing is suggested."""


class Cost(NamedTuple):
    """Estimated processor time [s], within a factor of `UNKNOWN`, and memory [bytes]."""

    seconds: float
    memory: float

    def sentence(self, shape: tuple[int, int], spacing: float) -> str:
        """Describe the cost, and a coarser spacing that takes less."""
        ny, nx = shape
        low, high = (_rounded(self.seconds * part) for part in (1.0 / UNKNOWN, UNKNOWN))
        return (
            f"{nx} x {ny} cells will take about {low} to {high} of processor time and "
            f"{1e-9 * self.memory:.1f} GB; {coarser(shape, spacing)}"
        )


def coarser(shape: tuple[int, int], spacing: float) -> str:
    """Suggest a multiple of the spacing [m] at which a joint has about `SUGGESTED` cells a side."""
    step = max(int(np.ceil(max(shape) / SUGGESTED)), 2)
    return (
        f"a grid spacing of {1e3 * step * spacing:.4g} mm (--grid-spacing, or spacing= in m) takes "
        "less, but a cell is an asperity: its effect is in the range as grid spacing"
    )


def check_cells(shape: tuple[int, int], spacing: float, stated: bool) -> None:
    """Raise `InputError` for more than `LARGEST` cells, unless the grid spacing was stated."""
    cells = shape[0] * shape[1]
    if cells > LARGEST and not stated:
        raise InputError(
            f"{shape[1]} x {shape[0]} cells of {1e3 * spacing:.4g} mm: must be at most {LARGEST:,} "
            f"cells unless the grid spacing is stated; {coarser(shape, spacing)}"
        )


def expected_cost(
    upper: np.ndarray,
    lower: np.ndarray,
    conditions: Conditions,
    single: bool,
    ranges: Mapping[str, tuple[float, float]] = {},
) -> Cost | None:
    """Estimate the cost of closing two walls (y, x) [m]; None for a joint of up to `SMALL` cells.

    A window of the walls is closed twice, the second time compiled, and its time is multiplied by
    the power `EXPONENT` of the cells, and by the closures of a range unless ``single``.

    Raises
    ------
    InputError
        If ``ranges``, as for `sources_of`, are not allowed.
    """
    sources = {} if single else sources_of(conditions, (upper.shape[0], upper.shape[1]), ranges)
    if upper.size <= SMALL:
        return None
    corners = [(size - min(size, WINDOW)) // 2 for size in upper.shape]
    window = tuple(slice(corner, corner + WINDOW) for corner in corners)
    for _ in range(2):
        start = time.process_time()
        close_walls(upper[window], lower[window], conditions)
        seconds = time.process_time() - start
    closures = 1.0
    if not single:
        closures += sum(v.step ** (-2.0 * EXPONENT) for v in variants_of(conditions, sources))
    share = upper.size / upper[window].size
    return Cost(seconds * share**EXPONENT * closures, BASE_BYTES + BYTES * upper.size)


def _rounded(seconds: float) -> str:
    """Format a rough time in one unit."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= size:
            return (
                f"{seconds / size:.2g} {unit}"
                if seconds < 10 * size
                else f"{seconds / size:.0f} {unit}"
            )
    return f"{seconds:.0f} s"

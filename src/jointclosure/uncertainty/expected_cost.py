"""Estimates of the time and memory that simulations will take."""

import time
from typing import NamedTuple

import numpy as np

from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.simulation import simulate_walls
from jointclosure.parameters import Effects, Numerics
from jointclosure.uncertainty.sources import OTHER_RULE
from jointclosure.uncertainty.uncertain_joint import UncertainJoint, threads_for
from jointclosure.walls import Walls
from jointclosure.walls.joint_grid import coarser_grid

WINDOW = 128  # cells along a side of the window of the walls that is simulated to estimate the time
EXPONENTS = (1.15, 1.75)
"""Smallest and largest power of the number of cells with which the time of a joint grows. From
128 x 128 to 300 x 300 cells of eight pairs of walls (granite, JRC 8, 10 MPa, resolved breakage) it
was 1.7 and 1.8 for independent walls with waves of all lengths, and 1.2 to 1.5 for walls that mate
beyond 3 or 10 mm or have a roll-off of 3 mm."""
SCATTER = 1.4
"""Factor by which a single time is shorter or longer than by these powers: with it, all times of
these walls with 200 x 200 and 300 x 300 cells were within the forecast."""
BYTES = 1000  # memory for each cell, as measured between 100 x 100 and 400 x 400 cells
BASE_BYTES = 300e6  # memory of the program with a small joint
SMALL = 150 * 150  # cells up to which a joint itself shows soon how long its range takes
# Time of a joint over that by the paper's steps with all effects, measured on the last two of three
# joints (100 x 100 cells). Tolerances of 0.1, 0.02 and 0.004 took 4.9, 5.2 and 13 times as long in
# dolerite (30 MPa), 5.0, 4.0 and 12 times in siltstone (15 MPa). The factors were 3.6 and 6.1
# without gouge, 0.05 and 0.07 without breakage, 0.6 and 0.75 without interaction, and 1.0 without
# soft peaks.
RESOLVED_COST = 5.0
"""Least relative time with resolved breakage."""
TOLERANCE_COST = 0.053
"""Relative time with resolved breakage, times the tolerance, if that is more."""
NO_GOUGE_COST = 5.0
"""Least relative time without gouge."""
NO_BREAKAGE_COST = 0.06
"""Relative time without breakage, by any steps."""
NO_INTERACTION_COST = 0.7
"""Factor of the relative time without interaction."""


class Cost(NamedTuple):
    """Estimated cost of simulations: least and largest processor time [s], and memory [bytes]."""

    seconds: tuple[float, float]
    memory: float

    def sentence(self, shape: tuple[int, int], spacing: float) -> str:
        """Return a sentence on the cost of a joint, which advises a coarser spacing.

        The joint has (ny, nx) cells with a ``spacing`` [m].
        """
        ny, nx = shape
        low, high = (rough_time(seconds) for seconds in self.seconds)
        return (
            f"{nx} x {ny} cells will take about {low} to {high} of processor time and "
            f"{1e-9 * self.memory:.1f} GB; {coarser_grid(shape, spacing)}"
        )


def expected_cost(joint: UncertainJoint, workers: int | None = None) -> Cost | None:
    """Estimate the processor time and memory to simulate a joint and all its variants.

    None for a joint of up to `SMALL` cells, whose own simulation soon shows the time. Otherwise two
    windows in the middle of its walls are simulated here, which takes seconds or longer: one of 16
    cells a side, which compiles, and one of `WINDOW` cells, whose time is scaled to the joint by
    the powers `EXPONENTS` of the number of cells. Variants are estimated from the joint by their
    numbers of cells.

    ``workers`` is the number of variants that are simulated at the same time, by default as many as
    there are processors. It affects the memory only, because the time is that of all processors
    together.
    """
    if joint.upper.size <= SMALL:
        return None
    least, most = (
        seconds * (1.0 + _variants_over_joint(joint, power))
        for seconds, power in zip(
            seconds_of_joint(joint.upper, joint.lower, joint.conditions), EXPONENTS, strict=True
        )
    )
    joints = threads_for(joint.cells, workers) if joint.variants else 1
    return Cost((least, most), BASE_BYTES + BYTES * joint.cells * joints)


def seconds_of_range(joint: UncertainJoint, seconds: float) -> float:
    """Estimate the processor time [s] of all variants of a joint that itself took ``seconds``.

    Nothing is simulated. The smaller one of `EXPONENTS` is used.
    """
    return seconds * _variants_over_joint(joint, min(EXPONENTS))


def _variants_over_joint(joint: UncertainJoint, power: float) -> float:
    """Return the time of all variants of a joint over the time of the joint itself [1].

    Times are taken to grow with the ``power`` of the number of cells. The variant by the paper's
    steps (`OTHER_RULE`) is left out, because it takes a small share of the time of a variant with
    resolved breakage.
    """
    return sum(v.step ** (-2.0 * power) for v in joint.variants if v.source != OTHER_RULE)


def seconds_of_joint(
    upper: np.ndarray, lower: np.ndarray, conditions: CheckedConditions
) -> tuple[float, float]:
    """Estimate the least and the largest processor time [s] of a joint of two walls (y, x) [m].

    Two windows in the middle of the walls are simulated for it: one of 16 cells a side, which
    compiles, and one of `WINDOW` cells a side, or the whole of a smaller joint. The time of the
    second is scaled by powers of the number of cells (`EXPONENTS`), and by `SCATTER`.
    """
    time_of_window(upper, lower, WINDOW // 8, conditions)  # compiles
    seconds, cells = time_of_window(upper, lower, WINDOW, conditions)
    share = upper.size / cells
    least, most = (
        factor * seconds * share**power
        for factor, power in zip((1.0 / SCATTER, SCATTER), EXPONENTS, strict=True)
    )
    return least, most


def relative_cost(effects: Effects, numerics: Numerics) -> float:
    """Estimate the time of a joint with some effects and numerics, relative to the paper's [1].

    The paper's are fixed steps and all effects. Nothing is simulated: the factors were measured.
    """
    if not effects.breakage:
        return NO_BREAKAGE_COST
    cost = 1.0
    if numerics.breakage == "resolved":
        cost = max(RESOLVED_COST, TOLERANCE_COST / numerics.tolerance)
    if not effects.gouge:
        cost = max(cost, NO_GOUGE_COST)
    return cost if effects.interaction else NO_INTERACTION_COST * cost


def time_of_window(
    upper: np.ndarray, lower: np.ndarray, size: int, conditions: CheckedConditions
) -> tuple[float, int]:
    """Simulate a window in the middle of two walls (y, x) [m].

    Return the processor time [s] and the number of cells of the window, which has up to ``size``
    cells a side.
    """
    window = window_of((upper, lower), size)
    start = time.process_time()
    simulate_walls(*window, conditions)
    return time.process_time() - start, window[0].size


def window_of(pair: Walls, size: int) -> Walls:
    """Return the middle of two walls (y, x), with up to ``size`` cells along a side."""
    upper, lower = pair
    corners = [(cells - min(cells, size)) // 2 for cells in upper.shape]
    window = tuple(slice(corner, corner + size) for corner in corners)
    return upper[window], lower[window]


def rough_time(seconds: float) -> str:
    """Format a rough time [s] with one significant digit, in h, min or s, such as "3 min"."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= size:
            return f"{float(f'{seconds / size:.1g}'):g} {unit}"
    return f"{float(f'{seconds:.1g}'):g} s"

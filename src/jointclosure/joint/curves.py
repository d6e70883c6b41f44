"""Curves of a simulated joint over stress: closures, and values of steps, at given stresses."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from jointclosure.joint.history import NET, History, history_of
from jointclosure.joint.interpolation import cubic_over, rising_slopes
from jointclosure.joint.status import LOADING

LEVELS = 20
"""Largest number of stress intervals in a table, from seating to the maximum."""
_ROUND_DIGITS = 1.0, 2.0, 2.5, 5.0, 10.0  # first digits of a round interval of stress
_APART = 0.25  # least distance of a round stress from the ends of a table, over the interval
POINTS = 60
"""Intervals of stress by which the slope of a curve is computed."""
_NEARLY = 1.01
"""A stress counts as reached by a branch up to this times the branch's largest stress, which is
within the tolerance of a stated maximum."""


def stress_levels(joint: xr.Dataset, count: int = LEVELS, cycle: int | None = None) -> np.ndarray:
    """Return ``count`` evenly spaced stresses [Pa] from the seating stress to the largest stress.

    The largest stress is that of the joint, or that of a ``cycle`` if this is clearly smaller. A
    seating stress of 0 is left out.
    """
    history = history_of(joint)
    seating = history.seating_stress
    largest = float(history.stress.max())
    if cycle is not None:
        reached = float(history.stress[history.load_cycle == cycle].max())
        largest = largest if largest <= _NEARLY * reached else reached
    if seating == 0.0:  # no result is read at zero stress
        return np.linspace(seating, largest, count + 1)[1:]
    return np.linspace(seating, largest, count)


def round_levels(low: float, high: float) -> np.ndarray:
    """Return two stresses [Pa] and the multiples of a round interval between them.

    A low stress of 0 is left out. There are at most `LEVELS` intervals.
    """
    least = (high - low) / LEVELS
    power = 10.0 ** np.floor(np.log10(least))
    sizes = (digits * power for digits in _ROUND_DIGITS)
    interval = next(size for size in sizes if size >= (1.0 - 1e-9) * least)
    inner = interval * np.arange(np.floor(low / interval) + 1.0, np.ceil(high / interval))
    inner = inner[np.minimum(inner - low, high - inner) > _APART * interval]
    return np.array([low, *inner, high] if low > 0.0 else [*inner, high])


def table_levels(joint: xr.Dataset, at: Sequence[float] = ()) -> np.ndarray:
    """Return the stresses (levels,) [Pa] of `stress_table`.

    They are round stresses from the seating stress to the stated maximum, the maximum of every
    cycle, and the stresses ``at``. If the joint did not reach the stated maximum, its largest
    stress stands in place of it.
    """
    history = history_of(joint)
    reached = float(history.stress.max())
    stated = float(history.maxima.max())
    largest = stated if stated <= _NEARLY * reached else reached
    if not largest > history.seating_stress:
        return np.union1d([largest], at)
    maxima = history.maxima[history.maxima <= largest]
    levels = np.union1d(round_levels(history.seating_stress, largest), maxima)
    return np.union1d(levels, at)


def values_at_stresses(
    joint: xr.Dataset, values: np.ndarray, cycles: int, levels: np.ndarray, tolerance: float = 0.0
) -> np.ndarray:
    """Read values of steps (steps,), such as closures, at stresses (levels,) [Pa] of both branches.

    The result (cycles, 2, levels) is NaN at stresses that a branch does not have. A stress beyond
    the end of a branch by at most the relative ``tolerance`` is read at that end.
    """
    history = history_of(joint)
    answer = np.full((cycles, 2, levels.size), np.nan)
    near = 1.0 + 1.01 * tolerance
    for place, branch in history.existing_branches():
        stress = history.stress[branch.steps]
        maximum = stress.max()
        minimum = stress.min()
        read = np.where((levels < minimum) & (minimum <= levels * near), minimum, levels)
        read = np.where((maximum < read) & (read <= maximum * near), maximum, read)
        asked = read >= minimum
        answer[(*place, asked)] = history.read(branch, values, read[asked])
    return answer


def closures_at(joint: xr.Dataset, levels: np.ndarray, of: str | np.ndarray = NET) -> np.ndarray:
    """Read the net closure (cycles, 2, levels) [m] on loading and unloading at stresses [Pa].

    ``of`` is another variable of the steps, or their values (steps,). Stresses that a branch does
    not reach are NaN.
    """
    history = history_of(joint)
    values = history.along(of)
    closures = np.full((history.begun, 2, levels.size), np.nan)
    for (index, side), branch in history.existing_branches():
        loads = branch.name == LOADING
        steps = branch.steps if loads else branch.steps[::-1]
        stress = history.stress[steps]
        closure = values[steps]
        largest = float(stress.max())
        reached = np.where((levels > largest) & (levels <= _NEARLY * largest), largest, levels)
        end = history.landing_stresses[index] if loads else np.inf
        # one cubic up to the landing, and one beyond
        for known, asked in ((stress <= end, reached <= end), (stress >= end, reached > end)):
            if known.any():
                read = cubic_over(stress[known], closure[known])(reached[asked])
                closures[index, side, asked] = read
    return closures


def secant_stiffness(
    joint: xr.Dataset, cycle: int, low: float, high: float, of: str = NET
) -> float:
    """Compute the normal stiffness [Pa/m] of a loading by the chord between two stresses [Pa].

    The chord ends at most at the largest stress of the loading and at its landing stress. NaN if
    nothing is left of it, or if the closure ``of`` does not rise.
    """
    history = history_of(joint)
    loading = history.branch(cycle, LOADING)
    if not loading.exists:
        return np.nan
    reached = float(history.stress[loading.steps].max())
    levels = np.array([low, min(high, reached, history.landing_stresses[cycle - 1])])
    rise = float(np.diff(closures_at(joint, levels, of)[cycle - 1, 0])[0])
    return float(np.diff(levels)[0]) / rise if levels[1] > low and rise > 0.0 else np.nan


def normal_stiffness(joint: xr.Dataset, levels: np.ndarray, of: str = NET) -> np.ndarray:
    """Compute the normal stiffness (cycles, 2, levels) [Pa/m] at stresses (levels,) [Pa].

    The slope of the closure itself goes up and down where contacts break. The stiffness is
    therefore that of the concave curve nearest to the closure ``of`` over stress, and rises with
    stress. There is one such curve below the former maximum of a cycle, and another above it.
    """
    history = history_of(joint)
    fine = _fine_levels(joint, history, levels)
    closures = closures_at(joint, fine, of)
    stiffness = np.full((*closures.shape[:2], levels.size), np.nan)
    for (index, side), branch in history.existing_branches():
        closure = closures[index, side]
        loads = branch.name == LOADING
        end = history.landing_stresses[index] if loads else np.inf
        former = history.former_maxima[index] if loads else 0.0
        for part in (fine <= former, fine >= former):
            known = part & np.isfinite(closure) & (fine <= end)
            if known.sum() > 2:
                inside = (levels >= fine[known][0]) & (levels <= fine[known][-1])
                slopes = rising_slopes(fine[known], closure[known], levels[inside])
                stiffness[index, side, inside] = slopes
    return stiffness


def _fine_levels(joint: xr.Dataset, history: History, levels: np.ndarray) -> np.ndarray:
    """Return the stresses [Pa] between which slopes are computed.

    They are evenly spaced over the range of the table, with the former maxima, where the slope
    changes, and those of the given levels that lie beyond that range.
    """
    first, last = table_levels(joint)[[0, -1]]
    formers = history.former_maxima
    turns = formers[(formers > first) & (formers < last)]
    fine = np.union1d(np.linspace(first, last, POINTS + 1), turns)
    return np.union1d(fine, levels[(levels < first) | (levels > last)])

"""Closures of a history: per cycle, and at given stresses.

The seating stress never changes the history, only how it is read.
"""

from typing import Any

import numpy as np
import scipy
import xarray as xr

from jointclosure.joint.protocol import LOADING, UNLOADING

NET, GROSS = "closure_net", "closure"
"""Names of the two closures of a history. The net closure, without the elastic indentation of the
half-spaces, is that of the joint (`read_along`); the gross closure contains the indentation."""


def read_along(history: xr.Dataset, of: str = NET) -> np.ndarray:
    """Read a variable at each step of a history (steps,), by default the net closure.

    Net closure is the gross closure less ``bulk_indentation``, the displacement of the half-spaces
    of intact rock under the loaded patch as a whole (docs/model.md, "Interaction"). Laboratories
    report net closure, because they subtract the deformation of the intact rock. A program that
    computes the deformation of the rock itself also needs net closure.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`, with ``closure`` and ``bulk_indentation`` [m].
    of : str
        `NET`, or any variable over the steps, such as `GROSS`.

    Returns
    -------
    array (steps,)
        Closure from first touch [m]; other variables in the unit of the history.
    """
    if of == NET:
        return history.closure.values - history.bulk_indentation.values
    return history[of].values


def branch_of(cycle: np.ndarray, branch: np.ndarray, number: int, name: str) -> np.ndarray:
    """Return indices of the steps (n,) on one branch of one cycle, including its start.

    The start is the last step before the branch, if there is one.
    """
    here = np.flatnonzero((cycle == number) & (branch == name))
    if here.size and here[0] > 0:
        here = np.concatenate([[here[0] - 1], here])
    return here


def _is_complete(
    loading: np.ndarray, unloading: np.ndarray, stress: np.ndarray, minimum: float
) -> bool:
    """Return whether a cycle was loaded, and then unloaded to its minimum [Pa]."""
    return loading.size > 1 and unloading.size > 1 and float(stress[unloading[-1]]) <= minimum


def first_crossing(stress: np.ndarray, closure: np.ndarray, level: float) -> float:
    """Return the closure [m] where the stress (n,) [Pa] first reaches a level; NaN if never."""
    reached = np.flatnonzero(stress >= level)
    if reached.size == 0:
        return float("nan")
    after = int(reached[0])
    if after == 0:
        return float(closure[0])
    return _between(stress, closure, after - 1, after, level)


def last_crossing(stress: np.ndarray, closure: np.ndarray, level: float) -> float:
    """Return the closure [m] where the stress (n,) [Pa] was last at a level; NaN if never."""
    reached = np.flatnonzero(stress >= level)
    if reached.size == 0:
        return float("nan")
    before = int(reached[-1])
    if before == stress.size - 1:
        return float(closure[-1])
    return _between(stress, closure, before, before + 1, level)


def _between(
    stress: np.ndarray, closure: np.ndarray, before: int, after: int, level: float
) -> float:
    rise = stress[after] - stress[before]
    part = (level - stress[before]) / rise
    return float(closure[before] + part * (closure[after] - closure[before]))


def at_seating(values: np.ndarray, stress: np.ndarray, branch: str, seating: float) -> float:
    """Read values of a branch (n,) at the seating stress [Pa], in their unit.

    They are read where loading first reaches the stress, and where unloading last has it. NaN if
    the branch does not pass it.
    """
    if stress.size and stress.min() > seating:
        return float("nan")
    return (first_crossing if branch == LOADING else last_crossing)(stress, values, seating)


def cycle_closures(
    closure: np.ndarray,
    stress: np.ndarray,
    cycle: np.ndarray,
    branch: np.ndarray,
    minima: np.ndarray,
    seating_stress: float,
) -> dict[str, np.ndarray]:
    """Compute the closures of each cycle (cycles,) [m]; NaN for incomplete cycles.

    Parameters
    ----------
    closure, stress, cycle, branch : array (steps,)
        History: closure [m] from first touch, stress [Pa], cycle and branch.
    minima : array (cycles,)
        Stress [Pa] down to which each requested cycle is unloaded; 0 is last contact.
    seating_stress : float
        [Pa]. The ``_seated`` closures count from the first point of the cycle's loading that
        reaches it. They are NaN if loading starts, or unloading ends, above it.

    Returns
    -------
    dict
        ``max_closure`` from the start of the cycle (Bandis) and ``max_closure_seated``;
        ``residual_closure``, at the end of the cycle from first touch; and
        ``residual_closure_seated``, the residual closure of laboratories: closure at the
        seating stress on unloading less that on the loading of the same cycle.
    """
    names = ("max_closure", "residual_closure", "max_closure_seated", "residual_closure_seated")
    closures = {name: np.full(len(minima), np.nan) for name in names}
    for index, minimum in enumerate(minima):
        loading = branch_of(cycle, branch, index + 1, LOADING)
        unloading = branch_of(cycle, branch, index + 1, UNLOADING)
        if not _is_complete(loading, unloading, stress, minimum):
            continue
        seat, back = (
            at_seating(closure[here], stress[here], name, seating_stress)
            for here, name in ((loading, LOADING), (unloading, UNLOADING))
        )
        maximum, end = closure[loading[-1]], closure[unloading[-1]]
        closures["max_closure"][index] = maximum - closure[loading[0]]
        closures["residual_closure"][index] = end
        closures["max_closure_seated"][index] = maximum - seat
        closures["residual_closure_seated"][index] = back - seat
    return closures


def unloading_excess(
    closure: np.ndarray,
    stress: np.ndarray,
    cycle: np.ndarray,
    branch: np.ndarray,
    minima: np.ndarray,
) -> np.ndarray:
    """Return the largest excess of unloading over loading stress at equal closure (cycles,) [Pa].

    It is evaluated at the steps of unloading. The loading curve is interpolated between its steps
    by a monotone cubic, because the error of chords of these convex curves would be larger than the
    excess. Loading that starts without stress counts as 0 below its start; below a start at a
    stress nothing is compared. The excess is 0 if unloading nowhere exceeds loading, and NaN for
    incomplete cycles. ``minima`` is as for `cycle_closures`.
    """
    excess = np.full(len(minima), np.nan)
    for index, minimum in enumerate(minima):
        loading = branch_of(cycle, branch, index + 1, LOADING)
        unloading = branch_of(cycle, branch, index + 1, UNLOADING)
        if not _is_complete(loading, unloading, stress, minimum):
            continue
        # keep the last of several steps at one closure
        at, last = np.unique(closure[loading][::-1], return_index=True)
        loaded = stress[loading][::-1][last]
        after = closure[unloading[1:]]
        common = np.searchsorted(at, after)
        if np.array_equal(at[np.minimum(common, at.size - 1)], after):
            below = loaded[common]  # both branches have the same steps: no interpolation
        elif at.size > 1:
            below = scipy.interpolate.PchipInterpolator(at, loaded)(np.clip(after, at[0], at[-1]))
        else:
            below = np.full(after.shape, loaded[0])
        below[after < at[0]] = 0.0 if stress[loading[0]] == 0.0 else np.inf
        excess[index] = max(0.0, float(np.max(stress[unloading[1:]] - below)))
    return excess


def closure_at_stresses(
    closure: np.ndarray,
    stress: np.ndarray,
    cycle: np.ndarray,
    branch: np.ndarray,
    cycles: int,
    levels: np.ndarray,
    tolerance: float = 0.0,
) -> np.ndarray:
    """Return closures (cycles, 2, levels) [m] on loading and unloading at given stresses.

    It is read at the first crossing on loading and at the last on unloading, interpolated between
    steps; NaN if a level was not reached. A maximum within a relative ``tolerance`` below a level
    counts as reaching it, and so does a minimum within this tolerance above it.
    """
    answer = np.full((cycles, 2, levels.size), np.nan)
    for index in range(cycles):
        for side, (name, crossing) in enumerate(
            ((LOADING, first_crossing), (UNLOADING, last_crossing))
        ):
            here = branch_of(cycle, branch, index + 1, name)
            if here.size < 2:
                continue
            maximum, minimum = stress[here].max(), stress[here].min()
            for k, level in enumerate(levels):
                if level < minimum <= level * (1.0 + 1.01 * tolerance):
                    level = minimum
                if level < minimum:
                    continue
                if maximum < level <= maximum * (1.0 + 1.01 * tolerance):
                    level = maximum
                answer[index, side, k] = crossing(stress[here], closure[here], level)
    return answer


_ROUNDING = 1e-12


def loop_between(loading: Any, unloading: Any) -> Any:
    """Return closures of unloading less those of loading, both at the same stress.

    Branches of one curve that are read in both directions differ by rounding, which counts as 0.
    """
    loop = unloading - loading
    return loop * (abs(loop) > _ROUNDING * abs(loading))

"""Closures of a history, per cycle and at given stresses; titles and units of its variables.

The seating stress never changes the history, only how it is read.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import scipy
import xarray as xr

from jointclosure.joint.protocol import FLAGS, LOADING, UNLOADING

NET, GROSS = "closure_net", "closure"
"""Names of the two closures of a history. The net closure, without the elastic indentation of the
half-spaces, is that of the joint (`read_along`); the gross closure contains the indentation."""


def read_along(history: xr.Dataset, of: str = NET) -> np.ndarray:
    """Read a variable at each step of a history (steps,), by default the net closure.

    It is the gross closure less ``bulk_indentation``, the displacement of the half-spaces of intact
    rock under the loaded patch as a whole (docs/model.md, "Interaction"), as laboratories report it
    and programs that compute the deformation of the rock themselves need it.
    """
    if of == NET:
        return history.closure.values - history.bulk_indentation.values
    return history[of].values


def branch_of(history: xr.Dataset, cycle: int, branch: str) -> np.ndarray:
    """Return indices of the steps (n,) on one branch of one cycle, including its start."""
    here = np.flatnonzero((history.load_cycle.values == cycle) & (history.branch.values == branch))
    if here.size and here[0] > 0:
        here = np.concatenate([[here[0] - 1], here])
    return here


def maxima_of(history: xr.Dataset) -> np.ndarray:
    """Return the stated maximum stress (cycles,) [Pa] of each cycle that was begun."""
    stated = np.atleast_1d(history.attrs["max_normal_stress_Pa"])[::2]  # turning points, or one
    begun = int(history.load_cycle.max())
    return stated[:begun] if stated.size > 1 else np.broadcast_to(stated, begun)


def former_maximum(history: xr.Dataset, cycle: int) -> float:
    """Return the largest stated maximum [Pa] before a cycle that exceeds it; 0 if it does not."""
    stated = maxima_of(history)
    former = float(stated[: cycle - 1].max(initial=0.0))
    return former if stated[cycle - 1] > former else 0.0


def with_snapshots(history: xr.Dataset, stresses: Sequence[float]) -> xr.Dataset:
    """Return a history with the snapshots at some stresses [Pa] only; as if closed with these."""
    if len(stresses):
        return history.isel(snapshot=history.snapshot_stress.isin(stresses))
    states = [name for name in history.variables if str(name).startswith("snapshot_")]
    return history.drop_vars([*states, "upper_first", "lower_first"], errors="ignore")


def _whole_cycles(
    history: xr.Dataset, minima: np.ndarray
) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Generate index, loading and unloading of the cycles that were unloaded to a minimum [Pa]."""
    stress = history.normal_stress.values
    for index, minimum in enumerate(minima):
        loading, unloading = (branch_of(history, index + 1, name) for name in (LOADING, UNLOADING))
        if min(loading.size, unloading.size) > 1 and stress[unloading[-1]] <= minimum:
            yield index, loading, unloading


def crossing(stress: np.ndarray, values: np.ndarray, level: float, branch: str = LOADING) -> float:
    """Return the value where the stress (n,) [Pa] first reaches a level; NaN if never.

    On unloading it is where the stress was last at the level.
    """
    reached = np.flatnonzero(stress >= level)
    if reached.size == 0:
        return float("nan")
    at = int(reached[0 if branch == LOADING else -1])
    before = at - 1 if branch == LOADING else at
    if not 0 <= before < stress.size - 1:
        return float(values[at])
    rise = stress[before + 1] - stress[before]
    part = (level - stress[before]) / rise
    return float(values[before] + part * (values[before + 1] - values[before]))


def by_fixed_steps(history: xr.Dataset) -> bool:
    """Return whether the history has the paper's fixed steps."""
    return json.loads(history.attrs.get("numerics", "{}")).get("breakage") == "fixed_step"


def cubic_over(stress: np.ndarray, values: np.ndarray) -> Callable[[Any], Any]:
    """Return values (n,) as a monotone cubic of a stress (n,) [Pa] where that exceeds all before.

    NaN beyond its ends.
    """
    rises = np.concatenate([[True], stress[1:] > np.maximum.accumulate(stress)[:-1]])
    stress, values = stress[rises], values[rises]
    if stress.size > 1:
        return scipy.interpolate.PchipInterpolator(stress, values, extrapolate=False)
    return lambda level: np.where(level == stress[0], values[0], np.nan)


def values_where(
    history: xr.Dataset, here: np.ndarray, values: np.ndarray, levels: np.ndarray, branch: str
) -> np.ndarray:
    """Read values where the stress first reaches levels (n,) [Pa]; NaN if never.

    ``here`` are the steps of the branch. Fixed steps are read linearly, as in the paper.
    """
    stress, known = history.normal_stress.values[here], values[here]
    if by_fixed_steps(history):
        return np.array([crossing(stress, known, level, branch) for level in levels])
    order = slice(None, None, 1 if branch == LOADING else -1)
    return cubic_over(stress[order], known[order])(levels)


def seat_of(history: xr.Dataset, cycle: int, branch: str, of: str = NET) -> float:
    """Read the net closure [m], or the variable ``of``, at the seating stress of a branch."""
    here = branch_of(history, cycle, branch)
    seating = float(history.attrs["seating_stress_Pa"])
    if not here.size or history.normal_stress.values[here].min() > seating:
        return float("nan")
    along = read_along(history, of)
    return float(values_where(history, here, along, np.array([seating]), branch)[0])


def cycle_closures(
    history: xr.Dataset, of: str = NET, minima: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Compute the closures of each cycle (cycles,) [m]; NaN for incomplete cycles.

    ``minima`` (cycles,) [Pa] are the stresses that a whole cycle was unloaded to, by default any.
    """
    closure = read_along(history, of)
    minima = np.full(int(history.load_cycle.max()), np.inf) if minima is None else minima
    names = ("max_closure", "residual_closure", "max_closure_seated", "residual_closure_seated")
    closures = {name: np.full(len(minima), np.nan) for name in names}
    for index, loading, unloading in _whole_cycles(history, minima):
        seat, back = (seat_of(history, index + 1, name, of) for name in (LOADING, UNLOADING))
        maximum, end = closure[loading[-1]], closure[unloading[-1]]
        values = maximum - closure[loading[0]], end, maximum - seat, back - seat
        for name, value in zip(names, values, strict=True):
            closures[name][index] = value
    return closures


def unloading_excess(history: xr.Dataset, minima: np.ndarray) -> np.ndarray:
    """Return the largest excess of unloading over loading at equal closure (cycles,) [Pa]."""
    closure, stress = history.closure.values, history.normal_stress.values
    excess = np.full(len(minima), np.nan)
    for index, loading, unloading in _whole_cycles(history, minima):
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


def values_at_stresses(
    history: xr.Dataset, values: np.ndarray, cycles: int, levels: np.ndarray, tolerance: float = 0.0
) -> np.ndarray:
    """Read values of steps, such as closures, at stresses of both branches (cycles, 2, levels)."""
    answer = np.full((cycles, 2, levels.size), np.nan)
    for index, side in np.ndindex(cycles, 2):
        branch = (LOADING, UNLOADING)[side]
        here = branch_of(history, index + 1, branch)
        if here.size < 2:
            continue
        stress = history.normal_stress.values[here]
        maximum, minimum = stress.max(), stress.min()
        near = 1.0 + 1.01 * tolerance
        read = np.where((levels < minimum) & (minimum <= levels * near), minimum, levels)
        read = np.where((maximum < read) & (read <= maximum * near), maximum, read)
        asked = read >= minimum
        answer[index, side, asked] = values_where(history, here, values, read[asked], branch)
    return answer


def loop_between(loading: Any, unloading: Any) -> Any:
    """Return closures of unloading less those of loading, both at the same stress."""
    loop = unloading - loading
    return loop * (abs(loop) > 1e-12 * abs(loading))  # less is rounding


_VARIABLES = (
    ("closure", "m", "closure from first touch"),
    ("normal_stress", "Pa", "nominal normal stress"),
    ("contact_fraction", "1", "fraction of the cells in contact"),
    ("bulk_indentation", "m", "mean displacement by the interaction"),
    ("mean_aperture", "m", "mean distance of the deformed walls"),
    ("equilibrium_residual", "1", "recomputed residual of the forces over their sum"),
    ("max_closure", "m", "maximum closure", "from the start of the cycle"),
    ("residual_closure", "m", "residual closure", "from first touch"),
    ("max_closure_seated", "m", "maximum closure since seating"),
    ("residual_closure_seated", "m", "residual closure at seating"),
    ("max_bulk_indentation", "m", "bulk indentation at the maximum stress"),
    (
        "unloading_excess",
        "Pa",
        "largest stress by which unloading exceeds loading at equal closure",
    ),
    ("least_force", "N", "least force on any cell at any step"),
    ("locked_share", "1", "share of the force on locked contacts at the maximum stress"),
    ("flat_share", "1", "share of the force on other flat contacts at the maximum stress"),
    ("upper_final", "m", "upper wall at the end, towards the lower"),
    ("lower_final", "m", "lower wall at the end, towards the upper"),
    ("settled_states", "1", "states brought to rest, those thrown away included"),
    ("equilibria", "1", "equilibria solved on the way (reference: sweeps)"),
    ("newton_steps", "1", "steps of Newton's method"),
    ("breakage_steps", "1", "breakage steps taken"),
    ("replayed_cycles", "1", "cycles that are the unloading curve of the one before"),
    ("idle_steps", "1", "steps of the first loading without interaction, as it was idle"),
    (
        "idle_displacement",
        "1",
        "largest displacement of a contact that was left out so, over the closure",
    ),
    ("locked_contacts", "1", "largest number of locked contacts at a step"),
    ("solver_iterations", "1", "products with the interaction, or sweeps (reference)"),
    ("force", "N", "normal force of each contact"),
    ("overlap", "m", "overlap delta_S, negative where the walls are apart"),
    ("interaction_displacement", "m", "displacement by all other contacts"),
    (
        "hydraulic_aperture",
        "m",
        "aperture of parallel plates that pass as much, 0 where flow is blocked",
    ),
    (
        "largest_hydraulic",
        "m",
        "upper bound of the hydraulic aperture",
        "as if the open cells of every line across the flow were connected",
    ),
    ("flow_imbalance", "1", "sum of the cells' mass balances over the inflow"),
)
ATTRIBUTES: dict[str, dict[str, Any]] = {
    name: {"long_name": text, "units": unit} | ({"comment": comment[0]} if comment else {})
    for name, unit, text, *comment in _VARIABLES
}
ATTRIBUTES["status"] = {
    "long_name": "status of the simulation: 0 success, below 16 success with a remark",
    "flag_masks": np.array(list(FLAGS), dtype=np.int16),
    "flag_meanings": " ".join(FLAGS.values()),
}

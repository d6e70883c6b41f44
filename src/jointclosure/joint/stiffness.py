"""Normal stiffness over stress, for programs of blocks and joints."""

import json

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.joint.history import GROSS, NET, branch_of, read_along
from jointclosure.joint.protocol import LOADING, UNLOADING

LEVELS = 20
"""Number of stresses of a table, evenly spaced from seating to the maximum."""


def stress_levels(history: xr.Dataset, count: int = LEVELS, cycle: int | None = None) -> np.ndarray:
    """Return evenly spaced stresses [Pa] from the seating stress to the largest reached stress."""
    seating = float(history.attrs["seating_stress_Pa"])
    largest = float(history.normal_stress.max())
    if cycle is not None:
        reached = float(history.normal_stress.values[history.cycle.values == cycle].max())
        largest = largest if largest <= 1.01 * reached else reached
    return np.linspace(seating, largest, count + (seating == 0.0))[(seating == 0.0) :]


def closures_at(history: xr.Dataset, levels: np.ndarray, of: str = NET) -> np.ndarray:
    """Read the closure (cycles, 2, levels) [m] on loading and unloading at stresses [Pa]."""
    closures = np.full((int(history.cycle.max()), 2, levels.size), np.nan)
    for index, side in np.ndindex(closures.shape[:2]):
        here = branch_of(history, index + 1, (LOADING, UNLOADING)[side])
        if here.size < 2:
            continue
        here = here[::-1] if side else here
        stress, closure = history.normal_stress.values[here], read_along(history, of)[here]
        rises = np.concatenate([[True], stress[1:] > np.maximum.accumulate(stress)[:-1]])
        # a maximum within a percent below a level counts as reaching it
        largest = float(stress.max())
        reached = np.where((levels > largest) & (levels <= 1.01 * largest), largest, levels)
        end = np.inf if side else landing_stress(history, index + 1)
        closures[index, side] = _between(stress[rises], closure[rises], reached, end)
    return closures


def _between(
    stress: np.ndarray, closure: np.ndarray, levels: np.ndarray, landing: float
) -> np.ndarray:
    """Return the closure at levels by monotone cubics, one up to the landing and one beyond."""
    result = np.full(levels.size, np.nan)
    below = stress <= landing, levels <= landing
    for part, asked in (below, (stress >= landing, levels > landing)):
        known, values, at = stress[part], closure[part], levels[asked]
        if known.size > 1 and at.size:
            curve = scipy.interpolate.PchipInterpolator(known, values, extrapolate=False)
            result[asked] = curve(at)
        elif known.size and at.size:  # a single step
            result[asked] = np.where(at == known[0], values[0], np.nan)
    return result


def landing_stress(history: xr.Dataset, cycle: int) -> float:
    """Return the stress [Pa] from which a loading lands on its maximum; infinite if none."""
    effects, numerics = (
        json.loads(history.attrs.get(name, "{}")) for name in ("effects", "numerics")
    )
    by_fixed_steps = numerics.get("breakage") == "fixed_step" and effects["breakage"]
    if not by_fixed_steps or numerics["target"] == "interpolate":
        return np.inf
    here = branch_of(history, cycle, LOADING)
    stress = history.normal_stress.values
    former = stress[history.cycle.values < cycle].max(initial=0.0)
    within = 1.0 + 3.0 * numerics["stress_tolerance"]  # both within the tolerance
    if here.size < 2 or stress[here].max() <= former * within:
        return np.inf
    step = numerics["displacement_step" if cycle == 1 else "later_displacement_step"]
    whole = np.flatnonzero(np.diff(history.closure.values[here]) >= 0.999 * step)
    return float(stress[here][whole[-1] + 1 if whole.size else 0])


def secant_stiffness(
    history: xr.Dataset, cycle: int, low: float, high: float, of: str = NET
) -> float:
    """Compute the normal stiffness [Pa/m] of a loading by the chord between two stresses."""
    here = branch_of(history, cycle, LOADING)
    if here.size < 2:
        return np.nan
    reached = float(history.normal_stress.values[here].max())
    levels = np.array([low, min(high, reached, landing_stress(history, cycle))])
    rise = float(np.diff(closures_at(history, levels, of)[cycle - 1, 0])[0])
    return float(np.diff(levels)[0]) / rise if levels[1] > low and rise > 0.0 else np.nan


def stiffness_table(history: xr.Dataset, count: int = LEVELS) -> pd.DataFrame:
    """Compute normal stiffness by chords between evenly spaced stresses, by cycle and branch."""
    levels = stress_levels(history, count)
    net, gross = (_chords(levels, closures_at(history, levels, of)) for of in (NET, GROSS))
    rows = []
    for index, side in np.ndindex(net.shape[:2]):
        columns = {
            "cycle": index + 1,
            "branch": (LOADING, UNLOADING)[side],
            "from_MPa": 1e-6 * levels[:-1],
            "to_MPa": 1e-6 * levels[1:],
            "normal_stress_MPa": 0.5e-6 * (levels[:-1] + levels[1:]),
            "normal_stiffness_net_MPa_per_mm": 1e-9 * net[index, side],
            "normal_stiffness_gross_MPa_per_mm": 1e-9 * gross[index, side],
            "landing": (side == 0) & (levels[1:] > landing_stress(history, index + 1)),
        }
        rows.append(pd.DataFrame(columns))
    return pd.concat(rows, ignore_index=True)


def _chords(levels: np.ndarray, closures: np.ndarray) -> np.ndarray:
    """Return stiffness (..., levels - 1) [Pa/m] from closures (..., levels) [m] at stresses."""
    run = np.diff(closures)
    rise = np.broadcast_to(np.diff(levels), run.shape)
    return np.divide(rise, run, out=np.full(run.shape, np.nan), where=run > 0.0)

"""Curves of a closed joint as tables: rows by step, cycle, or interval of stress (stiffness)."""

import json

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.joint.history import GROSS, NET, branch_of, cycle_closures, read_along, seat_of
from jointclosure.joint.protocol import LOADING, UNLOADING


def spacing_of(history: xr.Dataset) -> float:
    """Return the spacing of a joint's cells [m], from their coordinates."""
    axes = (history[name].values for name in ("y", "x"))
    return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)


def area_of(history: xr.Dataset) -> float:
    """Return the nominal area of a joint [m2], from the coordinates of its cells."""
    return spacing_of(history) ** 2 * history.sizes["y"] * history.sizes["x"]


LEVELS = 20
"""Number of stresses of a table of stiffness, evenly spaced from seating to the maximum."""
KINDS = {"net": NET, "gross": GROSS}
"""Kinds of closure in names of columns, and their names for `read_along`."""


def curve_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure over stress by cycle and branch, one row per step."""
    rows = []
    for number in np.unique(history.cycle.values):
        for name in (LOADING, UNLOADING):
            here = branch_of(history, number, name)
            if here.size > 1:
                rows.append(_branch_table(history, int(number), name, here))
    return pd.concat(rows, ignore_index=True)


def _branch_table(history: xr.Dataset, cycle: int, branch: str, here: np.ndarray) -> pd.DataFrame:
    """Return the rows of `curve_table` for one branch, whose steps are given."""
    area, stress = area_of(history), history.normal_stress.values[here]
    aperture, contact = history.mean_aperture.values[here], history.contact_fraction.values[here]
    closures = {kind: read_along(history, of)[here] for kind, of in KINDS.items()}
    columns = {"cycle": cycle, "branch": branch, "normal_stress_MPa": 1e-6 * stress}
    for kind, of in KINDS.items():
        since = closures[kind] - seat_of(history, cycle, LOADING, of)
        columns[f"closure_{kind}_since_seating_mm"] = 1e3 * since
    columns |= {f"closure_{kind}_mm": 1e3 * closure for kind, closure in closures.items()}
    for kind, closure in closures.items():
        columns[f"normal_stiffness_{kind}_MPa_per_mm"] = 1e-9 * _chords(closure, stress)
    beyond = np.append(stress[1:], stress[-1]) > landing_stress(history, cycle)
    columns |= {
        "landing": (branch == LOADING) & beyond,
        "mean_aperture_mm": 1e3 * aperture,
        "void_volume_mm3": 1e9 * area * aperture,
        "contact_area_mm2": 1e6 * area * contact,
        "contact_fraction": contact,
    }
    return pd.DataFrame(columns | _flow_columns(history, here))


def has_flow(history: xr.Dataset) -> bool:
    """Return whether a history has hydraulic apertures."""
    return "hydraulic_aperture" in history


def mean_hydraulic(history: xr.Dataset) -> np.ndarray:
    """Return the geometric mean (n,) of the hydraulic apertures along x and y [m]."""
    return np.sqrt(history.hydraulic_aperture.prod("direction", skipna=False).values)


def _flow_columns(history: xr.Dataset, here: np.ndarray) -> dict[str, np.ndarray]:
    """Return hydraulic apertures at steps and ratios to the mean aperture; {} without flow."""
    columns: dict[str, np.ndarray] = {}
    mean = history.mean_aperture.values[here]
    for name in history.direction.values if has_flow(history) else ():
        hydraulic = history.hydraulic_aperture.sel(direction=name).values[here]
        columns[f"hydraulic_aperture_{name}_mm"] = 1e3 * hydraulic
        columns[f"hydraulic_ratio_{name}"] = hydraulic / mean
    return columns


def net_responses(history: xr.Dataset, largest: float) -> dict[str, np.ndarray]:
    """Return the net closures and stiffness of each cycle, as a laboratory reports them."""
    completed = np.isfinite(history.max_closure.values)
    begun = int(history.cycle.max())
    cycles, net = range(1, begun + 1), cycle_closures(history)
    seated = "max_closure_seated", "residual_closure_seated"
    responses = {f"{name}_net": net[name] for name in ("max_closure", *seated)}
    stiffness = [secant_stiffness(history, cycle, 0.5 * largest, largest) for cycle in cycles]
    responses["stiffness_net"] = np.array(stiffness)
    responses["landing_stress"] = np.array([landing_stress(history, cycle) for cycle in cycles])
    missing = (0, completed.size - begun)
    return {
        name: np.where(completed, np.pad(values, missing, constant_values=np.nan), np.nan)
        for name, values in responses.items()
    }


def cycle_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate the closures of each cycle, since seating as in laboratory reports."""
    numbers = np.unique(history.cycle.values)
    columns = {"cycle": numbers}
    for net, of in (("_net", NET), ("", GROSS)):
        read = cycle_closures(history, of)
        closures = {name: 1e3 * values[numbers - 1] for name, values in read.items()}
        since, residual = closures["max_closure_seated"], closures["residual_closure_seated"]
        columns[f"max_closure_seated{net}_mm"] = since
        columns[f"residual_closure_seated{net}_mm"] = residual
        columns[f"residual_share{net}"] = residual / since
        columns[f"max_closure{net}_mm"] = closures["max_closure"]
    states = [_state_of(history, number) for number in numbers]
    return pd.DataFrame(columns).join(pd.DataFrame(states))


def _state_of(history: xr.Dataset, cycle: int) -> dict[str, float]:
    """Return apertures and contact of a row of `cycle_table`, by names of columns."""
    at_max = branch_of(history, cycle, UNLOADING)[:1]

    def read(values: np.ndarray) -> float:
        return float(values[0]) if at_max.size else float("nan")

    state = {"mean_aperture_at_seating_mm": 1e3 * seat_of(history, cycle, LOADING, "mean_aperture")}
    state["mean_aperture_at_max_mm"] = 1e3 * read(history.mean_aperture.values[at_max])
    for name, values in _flow_columns(history, at_max).items():
        if name.endswith("_mm"):
            state[f"{name.removesuffix('_mm')}_at_max_mm"] = read(values)
    return state | {"contact_at_max": read(history.contact_fraction.values[at_max])}


def hysteresis(closed: xr.Dataset) -> np.ndarray:
    """Compute the share (cycles,) of each cycle's work of loading lost on unloading."""
    closure, stress = closed.closure.values, closed.normal_stress.values
    shares = np.full(closed.max_closure.size, np.nan)
    for index in range(shares.size):
        loading, unloading = (branch_of(closed, index + 1, name) for name in (LOADING, UNLOADING))
        if loading.size > 1 and unloading.size > 1:
            given = np.trapezoid(stress[loading], closure[loading])
            back = -np.trapezoid(stress[unloading], closure[unloading])
            shares[index] = 1.0 - back / given
    return shares


def _chords(closure: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Return the slope [Pa/m] at each step (n,) by the chord of its neighbours, or NaN."""
    steps = np.arange(closure.size)
    before, after = np.maximum(steps - 1, 0), np.minimum(steps + 1, closure.size - 1)
    run, rise = closure[after] - closure[before], stress[after] - stress[before]
    return np.divide(rise, run, out=np.full(run.shape, np.nan), where=run != 0.0)


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
    given = (json.loads(history.attrs.get(name, "{}")) for name in ("effects", "numerics"))
    effects, numerics = given
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
    net, gross = (_between_levels(levels, closures_at(history, levels, of)) for of in (NET, GROSS))
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


def _between_levels(levels: np.ndarray, closures: np.ndarray) -> np.ndarray:
    """Return stiffness (..., levels - 1) [Pa/m] from closures (..., levels) [m] at stresses."""
    run = np.diff(closures)
    rise = np.broadcast_to(np.diff(levels), run.shape)
    return np.divide(rise, run, out=np.full(run.shape, np.nan), where=run > 0.0)

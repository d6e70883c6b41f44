"""Curves of a closed joint as tables: rows by step, cycle, or interval of stress (stiffness)."""

import json

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.joint.history import (
    GROSS,
    NET,
    branch_of,
    by_fixed_steps,
    cubic_over,
    cycle_closures,
    former_maximum,
    maxima_of,
    read_along,
    seat_of,
)
from jointclosure.joint.protocol import LOADING, UNLOADING


def spacing_of(history: xr.Dataset) -> float:
    """Return the spacing of a joint's cells [m], from their coordinates."""
    axes = (history[name].values for name in ("y", "x"))
    return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)


def area_of(history: xr.Dataset) -> float:
    """Return the nominal area of a joint [m2], from the coordinates of its cells."""
    return spacing_of(history) ** 2 * history.sizes["y"] * history.sizes["x"]


LEVELS = 20
"""Number of stresses of a table, evenly spaced from seating to the maximum."""
POINTS = 60
"""Number of intervals of stress by which the slope of a curve is computed."""
LAST_CHORD = 0.15
"""Part of the range of stress over which its last stiffness is read at least."""
WATER = 9.81 * 998.2 / (12.0 * 1.002e-3)
"""Transmissivity of water at 20 degrees [m2/s] over the cube of the hydraulic aperture [m]."""
KINDS = {"net": NET, "gross": GROSS}
"""Kinds of closure in names of columns, and their names for `read_along`."""


def curve_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure over stress by cycle and branch, one row per step."""
    rows = []
    for number in np.unique(history.load_cycle.values):
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
    columns |= {
        "mean_aperture_mm": 1e3 * aperture,
        "void_volume_mm3": 1e9 * area * aperture,
        "contact_area_mm2": 1e6 * area * contact,
        "contact_fraction": contact,
    }
    return pd.DataFrame(columns | _flow_columns(history, here))


def has_flow(history: xr.Dataset) -> bool:
    """Return whether a history has hydraulic apertures."""
    return "hydraulic_aperture" in history


def mean_hydraulic(history: xr.Dataset, of: str = "hydraulic_aperture") -> np.ndarray:
    """Return the geometric mean (n,) of the hydraulic apertures along x and y [m]."""
    return np.sqrt(history[of].prod("direction", skipna=False).values)


def _flow_columns(history: xr.Dataset, here: np.ndarray) -> dict[str, np.ndarray]:
    """Return hydraulic apertures at steps and ratios to the mean aperture; {} without flow."""
    columns: dict[str, np.ndarray] = {}
    mean = history.mean_aperture.values[here]
    for name in history.direction.values if has_flow(history) else ():
        hydraulic = history.hydraulic_aperture.sel(direction=name).values[here]
        columns[f"hydraulic_aperture_{name}_mm"] = 1e3 * hydraulic
        columns[f"hydraulic_ratio_{name}"] = hydraulic / mean
    return columns


def net_responses(history: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the net closures and stiffness of each cycle, as a laboratory reports them.

    The stiffness is the chord of a loading from half of its maximum stress, or from the former
    maximum if that is higher.
    """
    completed = np.isfinite(history.max_closure.values)
    begun = int(history.load_cycle.max())
    cycles, net = range(1, begun + 1), cycle_closures(history)
    seated = "max_closure_seated", "residual_closure_seated"
    responses = {f"{name}_net": net[name] for name in ("max_closure", *seated)}
    ends = [
        (max(0.5 * end, former_maximum(history, cycle)), end)
        for cycle, end in zip(cycles, maxima_of(history), strict=False)
    ]
    stiffness = [
        secant_stiffness(history, cycle, *of) for cycle, of in zip(cycles, ends, strict=True)
    ]
    responses["stiffness_net"] = np.array(stiffness)
    responses["landing_stress"] = np.array([landing_stress(history, cycle) for cycle in cycles])
    missing = (0, completed.size - begun)
    return {
        name: np.where(completed, np.pad(values, missing, constant_values=np.nan), np.nan)
        for name, values in responses.items()
    }


def cycle_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate the closures of each cycle, since seating as in laboratory reports."""
    numbers = np.unique(history.load_cycle.values)
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


def stress_levels(history: xr.Dataset, count: int = LEVELS, cycle: int | None = None) -> np.ndarray:
    """Return evenly spaced stresses [Pa] from the seating stress to the largest reached stress."""
    seating = float(history.attrs["seating_stress_Pa"])
    largest = float(history.normal_stress.max())
    if cycle is not None:
        reached = float(history.normal_stress.values[history.load_cycle.values == cycle].max())
        largest = largest if largest <= 1.01 * reached else reached
    return np.linspace(seating, largest, count + (seating == 0.0))[(seating == 0.0) :]


def closures_at(history: xr.Dataset, levels: np.ndarray, of: str = NET) -> np.ndarray:
    """Read the closure (cycles, 2, levels) [m] on loading and unloading at stresses [Pa]."""
    closures = np.full((int(history.load_cycle.max()), 2, levels.size), np.nan)
    for index, side in np.ndindex(closures.shape[:2]):
        here = branch_of(history, index + 1, (LOADING, UNLOADING)[side])
        if here.size < 2:
            continue
        here = here[::-1] if side else here
        stress, closure = history.normal_stress.values[here], read_along(history, of)[here]
        # a maximum within a percent below a level counts as reaching it
        largest = float(stress.max())
        reached = np.where((levels > largest) & (levels <= 1.01 * largest), largest, levels)
        end = np.inf if side else landing_stress(history, index + 1)
        for known, asked in ((stress <= end, reached <= end), (stress >= end, reached > end)):
            if known.any():  # one cubic up to the landing, and one beyond
                read = cubic_over(stress[known], closure[known])(reached[asked])
                closures[index, side, asked] = read
    return closures


def landing_stress(history: xr.Dataset, cycle: int) -> float:
    """Return the stress [Pa] from which a loading lands on its maximum; infinite if none."""
    if not by_fixed_steps(history) or not json.loads(history.attrs["effects"])["breakage"]:
        return np.inf
    numerics = json.loads(history.attrs["numerics"])
    if numerics["target"] == "interpolate":
        return np.inf
    here = branch_of(history, cycle, LOADING)
    stress = history.normal_stress.values
    former = stress[history.load_cycle.values < cycle].max(initial=0.0)
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


def normal_stiffness(history: xr.Dataset, levels: np.ndarray, of: str = NET) -> np.ndarray:
    """Compute the stiffness (cycles, 2, levels) [Pa/m] at stresses [Pa], which rises with them.

    It is the slope of the concave curve nearest to the closure over stress: where contacts break,
    the slope of the closure itself goes up and down with every step. A loading beyond the former
    maximum has two such curves, up to it and beyond it. Landings are left out.
    """
    fine = np.linspace(levels[0], levels[-1], POINTS + 1)
    closures = closures_at(history, fine, of)
    stiffness = np.full((*closures.shape[:2], levels.size), np.nan)
    for index, side in np.ndindex(closures.shape[:2]):
        closure = closures[index, side]
        end = np.inf if side else landing_stress(history, index + 1)
        former = 0.0 if side else former_maximum(history, index + 1)
        for part in (fine < former, fine >= former):
            known = part & np.isfinite(closure) & (fine <= end)
            if known.sum() > 2:
                inside = (levels >= fine[known][0]) & (levels <= fine[known][-1])
                slopes = _rising_slopes(fine[known], closure[known], levels[inside])
                stiffness[index, side, inside] = slopes
    return stiffness


def _rising_slopes(stress: np.ndarray, closure: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return the slopes of stress over the concave curve nearest to closures, at levels."""
    run = np.diff(stress)
    fit = scipy.optimize.isotonic_regression(np.diff(closure) / run, weights=run, increasing=False)
    # no later slope corrects the last ones, which are one chord therefore
    blocks = fit.blocks[stress[fit.blocks] <= stress[-1] - LAST_CHORD * np.ptp(stress)]
    blocks = np.append(blocks, stress.size - 1)
    middle = 0.5 * (stress[blocks[:-1]] + stress[blocks[1:]])
    compliance = np.diff(closure[blocks]) / np.diff(stress[blocks])
    middle, slopes = middle[compliance > 0.0], 1.0 / compliance[compliance > 0.0]
    if slopes.size < 2:
        return np.full(levels.size, slopes[0] if slopes.size else np.nan)
    rise = np.diff(slopes)[[0, -1]] / np.diff(middle)[[0, -1]]
    ends = slopes[[0, -1]] + rise * (stress[[0, -1]] - middle[[0, -1]])
    ends = np.clip(ends, slopes[[0, -1]] * [0.5, 1.0], slopes[[0, -1]] * [1.0, 2.0])
    at, values = np.r_[stress[0], middle, stress[-1]], np.r_[ends[0], slopes, ends[1]]
    return np.interp(levels, at, values)


def stress_table(history: xr.Dataset, levels: np.ndarray | None = None) -> pd.DataFrame:
    """Tabulate closure, stiffness and aperture at stresses [Pa], by cycle and branch."""
    levels = stress_levels(history) if levels is None else levels
    columns: dict[str, np.ndarray] = {}
    begun = int(history.load_cycle.max())
    for kind, of in KINDS.items():
        seats = np.array([seat_of(history, cycle + 1, LOADING, of) for cycle in range(begun)])
        since = closures_at(history, levels, of) - seats[:, None, None]
        columns[f"closure_{kind}_since_seating_mm"] = 1e3 * since
    for kind, of in KINDS.items():
        stiffness = 1e-9 * normal_stiffness(history, levels, of)
        columns[f"normal_stiffness_{kind}_MPa_per_mm"] = stiffness
    columns["mean_aperture_mm"] = 1e3 * closures_at(history, levels, "mean_aperture")
    if has_flow(history):
        means = {"largest_hydraulic": mean_hydraulic(history, "largest_hydraulic")}
        known = mean_hydraulic(history)
        means["hydraulic_aperture"] = np.where(
            np.isfinite(known), known, means["largest_hydraulic"]
        )
        flows = history.assign({f"{name}_mean": ("step", mean) for name, mean in means.items()})
        read = {n: np.maximum(closures_at(flows, levels, f"{n}_mean"), 0.0) for n in means}
        columns |= {f"{name}_mm": 1e3 * values for name, values in read.items()}
    index = pd.MultiIndex.from_product(
        [range(1, begun + 1), (LOADING, UNLOADING), 1e-6 * levels],
        names=["cycle", "branch", "normal_stress_MPa"],
    )
    flat = {name: values.ravel() for name, values in columns.items()}
    return with_transmissivity(pd.DataFrame(flat, index).reset_index())


def with_transmissivity(curves: pd.DataFrame) -> pd.DataFrame:
    """Add the transmissivity of every hydraulic aperture in `stress_table`, or in its bands."""
    name, words = "hydraulic_aperture_mm", "transmissivity_m2_per_s"
    known = [*members(curves, name), name] if name in curves else []
    return curves.assign(**{c.replace(name, words): WATER * (1e-3 * curves[c]) ** 3 for c in known})


def members(curves: pd.DataFrame, name: str) -> list[str]:
    """Return the columns of a quantity's median, low and high curve, or of its only curve.

    Without a name these are the endings of columns.
    """
    if f"{name or 'closure_net_since_seating_mm'}_median" in curves:
        return [f"{name}_{member}" for member in ("median", "low", "high")]
    return [name]

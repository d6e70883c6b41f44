"""Curves of a closed joint as tables, with one row per step or one row per cycle."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.history import GROSS, NET, branch_of, cycle_closures, read_along, seat_of
from jointclosure.joint.protocol import LOADING, UNLOADING
from jointclosure.joint.stiffness import landing_stress, secant_stiffness


def spacing_of(history: xr.Dataset) -> float:
    """Return the spacing of a joint's cells [m], from their coordinates."""
    axes = (history[name].values for name in ("y", "x"))
    return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)


def area_of(history: xr.Dataset) -> float:
    """Return the nominal area of a joint [m2], from the coordinates of its cells."""
    return spacing_of(history) ** 2 * history.sizes["y"] * history.sizes["x"]


KINDS = {"net": NET, "gross": GROSS}
"""Kinds of closure in names of columns, and their names for
`jointclosure.joint.history.read_along`."""


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
    area = area_of(history)
    stress, aperture, contact = (
        history[name].values[here]
        for name in ("normal_stress", "mean_aperture", "contact_fraction")
    )
    closures = {kind: read_along(history, of)[here] for kind, of in KINDS.items()}
    seats = {kind: seat_of(history, cycle, LOADING, of) for kind, of in KINDS.items()}
    columns = {"cycle": cycle, "branch": branch, "normal_stress_MPa": 1e-6 * stress}
    columns |= {
        f"closure_{kind}_since_seating_mm": 1e3 * (closure - seats[kind])
        for kind, closure in closures.items()
    }
    columns |= {f"closure_{kind}_mm": 1e3 * closure for kind, closure in closures.items()}
    columns |= {
        f"normal_stiffness_{kind}_MPa_per_mm": 1e-9 * _chords(closure, stress)
        for kind, closure in closures.items()
    }
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
    net = cycle_closures(history)
    responses = {
        f"{name}_net": net[name]
        for name in ("max_closure", "max_closure_seated", "residual_closure_seated")
    }
    cycles = range(1, begun + 1)
    responses |= {
        "stiffness_net": np.array(
            [secant_stiffness(history, cycle, 0.5 * largest, largest) for cycle in cycles]
        ),
        "landing_stress": np.array([landing_stress(history, cycle) for cycle in cycles]),
    }
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
        closures = {
            name: 1e3 * values[numbers - 1] for name, values in cycle_closures(history, of).items()
        }
        since, residual = closures["max_closure_seated"], closures["residual_closure_seated"]
        columns[f"max_closure_seated{net}_mm"] = since
        columns[f"residual_closure_seated{net}_mm"] = residual
        columns[f"residual_share{net}"] = residual / since
        columns[f"max_closure{net}_mm"] = closures["max_closure"]
    return pd.DataFrame(columns).join(
        pd.DataFrame([_state_of(history, number) for number in numbers])
    )


def _state_of(history: xr.Dataset, cycle: int) -> dict[str, float]:
    """Return apertures and contact of a row of `cycle_table`, by names of columns."""
    at_max = branch_of(history, cycle, UNLOADING)[:1]

    def read(values: np.ndarray) -> float:
        return float(values[0]) if at_max.size else float("nan")

    return {
        "mean_aperture_at_seating_mm": 1e3 * seat_of(history, cycle, LOADING, "mean_aperture"),
        "mean_aperture_at_max_mm": 1e3 * read(history.mean_aperture.values[at_max]),
        **{
            f"{name.removesuffix('_mm')}_at_max_mm": read(values)
            for name, values in _flow_columns(history, at_max).items()
            if name.endswith("_mm")
        },
        "contact_at_max": read(history.contact_fraction.values[at_max]),
    }


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

"""The curves of a closed joint as tables: a row a step, and a row a cycle."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.history import (
    GROSS,
    NET,
    branch_of,
    first_crossing,
    last_crossing,
    read_along,
)
from jointclosure.protocol import LOADING, UNLOADING


def spacing_of(history: xr.Dataset) -> float:
    """Spacing of a joint's cells [m], from their coordinates."""
    axes = (history[name].values for name in ("y", "x"))
    return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)


def area_of(history: xr.Dataset) -> float:
    """Nominal area of a joint [m2], from the coordinates of its cells."""
    return spacing_of(history) ** 2 * history.sizes["y"] * history.sizes["x"]


KINDS = {"net": NET, "gross": GROSS}
"""Part of a column's name, and the closure that it is of (`jointclosure.history.read_along`)."""


def curve_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure against stress by cycle and branch, a row a step.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.

    Returns
    -------
    DataFrame
        ``cycle``, ``branch``, ``normal_stress_MPa``; of the net and the gross closure (`KINDS`)
        ``closure_<kind>_since_seating_mm`` from the point of the cycle's loading at the seating
        stress (negative before it, NaN where it was not reached), ``closure_<kind>_mm`` from first
        touch and ``normal_stiffness_<kind>_MPa_per_mm`` (kn = d sigma/d closure, by the chord of
        a step's neighbours, NaN where closure does not change); ``mean_aperture_mm``,
        ``void_volume_mm3`` (mean aperture times nominal area), ``contact_area_mm2`` (of the cells
        that carry force: an upper bound) and ``contact_fraction``; of a history with flow also
        ``hydraulic_aperture_x_mm``, ``hydraulic_aperture_y_mm`` and their ratios to the mean
        aperture. A branch begins with the last step of the one before.
    """
    rows = []
    for number in np.unique(history.cycle.values):
        for name in (LOADING, UNLOADING):
            here = branch_of(history.cycle.values, history.branch.values, number, name)
            if here.size > 1:
                rows.append(_branch_table(history, int(number), name, here))
    return pd.concat(rows, ignore_index=True)


def _branch_table(history: xr.Dataset, cycle: int, branch: str, here: np.ndarray) -> pd.DataFrame:
    """Rows of `curve_table` of one branch, whose steps are given."""
    area = area_of(history)
    stress, aperture, contact = (
        history[each].values[here]
        for each in ("normal_stress", "mean_aperture", "contact_fraction")
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
    columns |= {
        "mean_aperture_mm": 1e3 * aperture,
        "void_volume_mm3": 1e9 * area * aperture,
        "contact_area_mm2": 1e6 * area * contact,
        "contact_fraction": contact,
    }
    return pd.DataFrame(columns | _flow_columns(history, here))


def has_flow(history: xr.Dataset) -> bool:
    """Whether hydraulic apertures were asked for."""
    return "hydraulic_aperture" in history


def mean_hydraulic(history: xr.Dataset) -> np.ndarray:
    """Geometric mean (n,) of the hydraulic apertures along x and y [m]: for what takes but one."""
    return np.sqrt(history.hydraulic_aperture.prod("direction", skipna=False).values)


def _flow_columns(history: xr.Dataset, here: np.ndarray) -> dict[str, np.ndarray]:
    """Hydraulic apertures at steps, and their ratios to the mean aperture; none without flow."""
    columns: dict[str, np.ndarray] = {}
    mean = history.mean_aperture.values[here]
    for name in history.direction.values if has_flow(history) else ():
        hydraulic = history.hydraulic_aperture.sel(direction=name).values[here]
        columns[f"hydraulic_aperture_{name}_mm"] = 1e3 * hydraulic
        columns[f"hydraulic_ratio_{name}"] = hydraulic / mean
    return columns


def _flow_at_max(history: xr.Dataset, cycle: int) -> dict[str, float]:
    """Hydraulic apertures at a cycle's maximum, by their columns; none without flow."""
    here = branch_of(history.cycle.values, history.branch.values, cycle, UNLOADING)
    return {
        f"{name.removesuffix('_mm')}_at_max_mm": values[0] if here.size else float("nan")
        for name, values in _flow_columns(history, here[:1]).items()
        if name.endswith("_mm")
    }


def seat_of(history: xr.Dataset, cycle: int, branch: str, of: str = NET) -> float:
    """Read the closure at the seating stress: first reached on loading, last had on unloading.

    ``of`` names what is read (`jointclosure.history.read_along`), by default the net closure [m].
    NaN where the branch starts or ends above the seating stress.
    """
    here = branch_of(history.cycle.values, history.branch.values, cycle, branch)
    crossing = first_crossing if branch == LOADING else last_crossing
    level = float(history.attrs["seating_stress_Pa"])
    stress = history.normal_stress.values[here]
    if here.size and stress.min() > level:
        return float("nan")
    return crossing(stress, read_along(history, of)[here], level)


def cycle_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate the closures of each cycle, since seating as laboratories report them.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.

    Returns
    -------
    DataFrame
        One row a cycle; of the net and the gross closure (`KINDS`)
        ``closure_<kind>_since_seating_mm`` at its maximum, ``residual_<kind>_at_seating_mm``:
        closure at the seating stress on unloading less that on loading,
        ``residual_share_<kind>`` of the closure since seating, and ``max_closure_<kind>_mm`` from
        the cycle's start; ``mean_aperture_at_seating_mm``, ``mean_aperture_at_max_mm`` and
        ``contact_at_max``; of a history with flow also ``hydraulic_aperture_x_at_max_mm`` and the
        same along y. What counts at the maximum is NaN in a cycle whose loading failed.
    """
    rows = []
    for number in np.unique(history.cycle.values):
        row = {"cycle": number}
        for kind, of in KINDS.items():
            row |= _closures_of(history, number, kind, of)
        at_seating = seat_of(history, number, LOADING, "mean_aperture")
        row |= {
            "mean_aperture_at_seating_mm": 1e3 * at_seating,
            "mean_aperture_at_max_mm": 1e3 * _at_maximum(history, number, "mean_aperture"),
            **_flow_at_max(history, number),
            "contact_at_max": _at_maximum(history, number, "contact_fraction"),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def _closures_of(history: xr.Dataset, cycle: int, kind: str, of: str) -> dict[str, float]:
    """Closures of a row of `cycle_table`, by the names of their columns."""
    start = branch_of(history.cycle.values, history.branch.values, cycle, LOADING)[0]
    largest = _at_maximum(history, cycle, of)
    seat, back = (seat_of(history, cycle, name, of) for name in (LOADING, UNLOADING))
    return {
        f"closure_{kind}_since_seating_mm": 1e3 * (largest - seat),
        f"residual_{kind}_at_seating_mm": 1e3 * (back - seat),
        f"residual_share_{kind}": (back - seat) / (largest - seat),
        f"max_closure_{kind}_mm": 1e3 * (largest - read_along(history, of)[start]),
    }


def _at_maximum(history: xr.Dataset, cycle: int, of: str) -> float:
    """Read a variable where a cycle's unloading begins; NaN where its loading failed."""
    here = branch_of(history.cycle.values, history.branch.values, cycle, UNLOADING)
    return read_along(history, of)[here[0]] if here.size else float("nan")


def hysteresis(closed: xr.Dataset) -> np.ndarray:
    """Share of each cycle's work of loading that unloading does not give back (cycles,)."""
    closure, stress = closed.closure.values, closed.normal_stress.values
    cycle, branch = closed.cycle.values, closed.branch.values
    shares = np.full(closed.max_closure.size, np.nan)
    for index in range(shares.size):
        loading = branch_of(cycle, branch, index + 1, LOADING)
        unloading = branch_of(cycle, branch, index + 1, UNLOADING)
        if loading.size > 1 and unloading.size > 1:
            given = np.trapezoid(stress[loading], closure[loading])
            back = -np.trapezoid(stress[unloading], closure[unloading])
            shares[index] = 1.0 - back / given
    return shares


def _chords(closure: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Slope [Pa/m] at each step (n,) by the chord from its neighbours; NaN where there is none."""
    before = np.concatenate([[0], np.arange(closure.size - 1)])
    after = np.concatenate([np.arange(1, closure.size), [closure.size - 1]])
    run = closure[after] - closure[before]
    rise = stress[after] - stress[before]
    return np.divide(rise, run, out=np.full(run.shape, np.nan), where=run != 0.0)

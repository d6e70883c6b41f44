"""The curves of a closed joint as tables: a row a step, and a row a cycle."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.history import branch_of, first_crossing, last_crossing
from jointclosure.protocol import LOADING, UNLOADING


def spacing_of(history: xr.Dataset) -> float:
    """Spacing of a joint's cells [m], from their coordinates."""
    axes = (history[name].values for name in ("y", "x"))
    return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)


def area_of(history: xr.Dataset) -> float:
    """Nominal area of a joint [m2], from the coordinates of its cells."""
    return spacing_of(history) ** 2 * history.sizes["y"] * history.sizes["x"]


def curve_table(history: xr.Dataset) -> pd.DataFrame:
    """Closure against stress by cycle and branch, as laboratories tell it.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.

    Returns
    -------
    DataFrame
        ``cycle``, ``branch``, ``normal_stress_MPa``, ``closure_mm`` from first touch,
        ``closure_since_seating_mm`` from the point of the cycle's loading at the seating stress
        (negative before it, NaN where it was not reached), ``normal_stiffness_MPa_per_mm``
        (kn = d sigma/d closure, by the chord of a step's neighbours, NaN where closure does not
        change), ``mean_aperture_mm``, ``void_volume_mm3`` (mean aperture times nominal area),
        ``contact_area_mm2`` (of the cells that carry force: an upper bound) and
        ``contact_fraction``; of a history with flow also ``hydraulic_aperture_x_mm``,
        ``hydraulic_aperture_y_mm`` and their ratios to the mean aperture. A branch begins with the
        last step of the one before.
    """
    rows = []
    area = area_of(history)
    for number in np.unique(history.cycle.values):
        seat = seat_of(history, number, LOADING)
        for name in (LOADING, UNLOADING):
            here = branch_of(history.cycle.values, history.branch.values, number, name)
            if here.size < 2:
                continue
            stress, closure, aperture, contact = (
                history[each].values[here]
                for each in ("normal_stress", "closure", "mean_aperture", "contact_fraction")
            )
            columns = {
                "cycle": number,
                "branch": name,
                "normal_stress_MPa": 1e-6 * stress,
                "closure_mm": 1e3 * closure,
                "closure_since_seating_mm": 1e3 * (closure - seat),
                "normal_stiffness_MPa_per_mm": 1e-9 * _chords(closure, stress),
                "mean_aperture_mm": 1e3 * aperture,
                "void_volume_mm3": 1e9 * area * aperture,
                "contact_area_mm2": 1e6 * area * contact,
                "contact_fraction": contact,
            }
            rows.append(pd.DataFrame(columns | _flow_columns(history, here)))
    return pd.concat(rows, ignore_index=True)


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


def _flow_at_max(history: xr.Dataset, step: int) -> dict[str, float]:
    """Hydraulic apertures at a step, by the names of their columns; none without flow."""
    at = _flow_columns(history, np.array([step]))
    return {
        f"{name.removesuffix('_mm')}_at_max_mm": float(values[0])
        for name, values in at.items()
        if name.endswith("_mm")
    }


def seat_of(history: xr.Dataset, cycle: int, branch: str) -> float:
    """Closure [m] at the seating stress: first reached on loading, last had on unloading.

    NaN where the branch starts or ends above it.
    """
    here = branch_of(history.cycle.values, history.branch.values, cycle, branch)
    crossing = first_crossing if branch == LOADING else last_crossing
    level = float(history.attrs["seating_stress_Pa"])
    stress = history.normal_stress.values[here]
    if here.size and stress.min() > level:
        return float("nan")
    return crossing(stress, history.closure.values[here], level)


def cycle_table(history: xr.Dataset) -> pd.DataFrame:
    """Closures of each cycle as laboratories tell them: since seating, and what stays.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.

    Returns
    -------
    DataFrame
        One row a cycle: ``max_closure_mm`` from the cycle's start, ``closure_since_seating_mm`` at
        its maximum, ``residual_at_seating_mm``: closure at the seating stress on unloading less
        that on loading, ``residual_share`` of the closure since seating,
        ``mean_aperture_at_seating_mm``, ``mean_aperture_at_max_mm`` and ``contact_at_max``; of a
        history with flow also ``hydraulic_aperture_x_at_max_mm`` and the same along y.
    """
    rows = []
    cycle, branch = history.cycle.values, history.branch.values
    for number in np.unique(cycle):
        here = branch_of(cycle, branch, number, LOADING)
        seat, back = (seat_of(history, number, name) for name in (LOADING, UNLOADING))
        closure, aperture = history.closure.values[here], history.mean_aperture.values[here]
        order = np.argsort(closure)
        rows.append(
            {
                "cycle": number,
                "max_closure_mm": 1e3 * (closure[-1] - closure[0]),
                "closure_since_seating_mm": 1e3 * (closure[-1] - seat),
                "residual_at_seating_mm": 1e3 * (back - seat),
                "residual_share": (back - seat) / (closure[-1] - seat),
                "mean_aperture_at_seating_mm": 1e3
                * np.interp(seat, closure[order], aperture[order]),
                "mean_aperture_at_max_mm": 1e3 * aperture[-1],
                **_flow_at_max(history, here[-1]),
                "contact_at_max": history.contact_fraction.values[here[-1]],
            }
        )
    return pd.DataFrame(rows)


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

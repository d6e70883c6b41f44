"""Tables of a simulated joint: by step, by load cycle, and at given stresses."""

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.history import Branch, History, history_of
from jointclosure.joint.status import BRANCHES, LOADING

WATER = 9.81 * 998.2 / (12.0 * 1.002e-3)
"""Transmissivity for water at 20 degrees Celsius [m2/s] over the cube of the hydraulic aperture
[m]."""
HYDRAULIC = "hydraulic_aperture", "smallest_hydraulic", "largest_hydraulic"
"""Variables of flow: the hydraulic aperture where it is known, and its bounds."""
TRANSMISSIVITIES = {
    "hydraulic_aperture_mm": "transmissivity_m2_per_s",
    "smallest_hydraulic_mm": "smallest_transmissivity_m2_per_s",
    "largest_hydraulic_mm": "largest_transmissivity_m2_per_s",
}
"""Columns of the transmissivity and its bounds, by the columns of the hydraulic apertures."""
ENDS = ["low", "high"]
"""Endings of the names of the columns with the lower and the upper limit of a range or band."""
WIDER = ["low_with_choices", "high_with_choices"]
"""Endings for the limits of the range or band that includes other choices of the model."""


def curve_table(joint: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure, aperture and contact of each step of a joint, by cycle and branch.

    The first step of a branch is the last one of the branch before it, which is repeated. Columns
    have their units in their names.
    """
    history = history_of(joint)
    flow = _flow_columns(history)
    rows = []
    for _, branch in history.existing_branches():
        columns = _columns_of_branch(history, branch)
        columns |= {name: values[branch.steps] for name, values in flow.items()}
        rows.append(pd.DataFrame(columns))
    return pd.concat(rows, ignore_index=True)


def _columns_of_branch(history: History, branch: Branch) -> dict[str, Any]:
    """Return the columns of `curve_table` for the steps (n,) of one branch."""
    steps = branch.steps
    columns: dict[str, Any] = {
        "cycle": branch.cycle,
        "branch": branch.name,
        "normal_stress_MPa": 1e-6 * history.stress[steps],
    }
    for kind, closure in history.closures.items():
        since = closure.values[steps] - closure.seat(branch.cycle, LOADING)
        columns[f"closure_{kind}_since_seating_mm"] = 1e3 * since
    for kind, closure in history.closures.items():
        columns[f"closure_{kind}_mm"] = 1e3 * closure.values[steps]
    aperture = history.joint.mean_aperture.values[steps]
    contact = history.joint.contact_fraction.values[steps]
    columns["mean_aperture_mm"] = 1e3 * aperture
    columns["void_volume_mm3"] = 1e9 * history.area * aperture
    columns["contact_area_mm2"] = 1e6 * history.area * contact
    columns["contact_fraction"] = contact
    return columns


def _flow_columns(history: History) -> dict[str, np.ndarray]:
    """Return the columns of flow (steps,): hydraulic apertures, their bounds, status and ratio.

    The ratio is that of the hydraulic to the mean aperture, NaN if the latter is 0. There are no
    columns for a joint without flow.
    """
    columns: dict[str, np.ndarray] = {}
    if not history.has_flow:
        return columns
    joint = history.joint
    mean = joint.mean_aperture.values
    statuses = history.flow_statuses
    for place, direction in enumerate(joint.direction.values):
        for name in HYDRAULIC:
            columns[f"{name}_{direction}_mm"] = 1e3 * joint[name].sel(direction=direction).values
        aperture = joint.hydraulic_aperture.sel(direction=direction).values
        ratio = np.divide(aperture, mean, out=np.full(mean.shape, np.nan), where=mean > 0.0)
        columns[f"hydraulic_ratio_{direction}"] = ratio
        columns[f"flow_status_{direction}"] = statuses[:, place]
    return columns


def cycle_table(joint: xr.Dataset) -> pd.DataFrame:
    """Tabulate the closures of each cycle of a joint, and its apertures at the maximum.

    Closures count since seating as in laboratory reports, and also from first touch.
    """
    history = history_of(joint)
    columns: dict[str, Any] = {"cycle": np.array([cycle.number for cycle in history.cycles])}
    for kind, closure in history.closures.items():
        suffix = "_net" if kind == "net" else ""
        closures = closure.cycle_closures()
        since = 1e3 * closures["max_closure_seated"]
        residual = 1e3 * closures["residual_closure_seated"]
        columns[f"max_closure_seated{suffix}_mm"] = since
        columns[f"residual_closure_seated{suffix}_mm"] = residual
        columns[f"residual_share{suffix}"] = residual / since
        columns[f"max_closure{suffix}_mm"] = 1e3 * closures["max_closure"]
    columns["mean_aperture_at_seating_mm"] = 1e3 * history.curve("mean_aperture").seats
    states = {"mean_aperture_mm": 1e3 * joint.mean_aperture.values}
    states |= _flow_columns(history)
    states["contact"] = joint.contact_fraction.values
    for name, values in states.items():
        if "ratio" not in name:
            column = f"{name.removesuffix('_mm')}_at_max{'_mm' if name.endswith('_mm') else ''}"
            columns[column] = history.curve(values).at_maxima
    return pd.DataFrame(columns)


def stress_table(joint: xr.Dataset, levels: np.ndarray | None = None) -> pd.DataFrame:
    """Tabulate closure, stiffness, aperture and flow at stresses [Pa], by cycle and branch.

    By default the stresses are those of `History.table_levels`. Closures since seating and
    apertures are in mm, stiffnesses in MPa/mm and transmissivities in m2/s; they are NaN where the
    branch does not reach the stress. Hydraulic apertures are geometric means of both directions.
    Where the ``flow_status`` is blocked (`History.flow_status_at`) they are 0, except the upper
    bound.
    """
    history = history_of(joint)
    if levels is None:
        levels = history.table_levels()
    columns: dict[str, np.ndarray] = {}
    for kind, closure in history.closures.items():
        since = closure.at(levels) - closure.seats[:, None, None]
        columns[f"closure_{kind}_since_seating_mm"] = 1e3 * since
    for kind, closure in history.closures.items():
        stiffness = 1e-9 * closure.normal_stiffness(levels)
        columns[f"normal_stiffness_{kind}_MPa_per_mm"] = stiffness
    columns["mean_aperture_mm"] = 1e3 * history.curve("mean_aperture").at(levels)
    if history.has_flow:
        statuses = history.flow_status_at(levels)
        for name in HYDRAULIC:  # geometric means along x and y
            mean = np.sqrt(joint[name].prod("direction", skipna=False).values)
            aperture = 1e3 * np.maximum(history.curve(mean).at(levels), 0.0)
            if name != "largest_hydraulic":  # also between a step with flow and a step without
                aperture[statuses == "blocked"] = 0.0
            columns[f"{name}_mm"] = aperture
        columns["flow_status"] = statuses
    index = pd.MultiIndex.from_product(
        [range(1, history.begun + 1), BRANCHES, levels / 1e6],
        names=["cycle", "branch", "normal_stress_MPa"],
    )
    flat = {name: values.ravel() for name, values in columns.items()}
    return with_transmissivity(pd.DataFrame(flat, index).reset_index())


def with_transmissivity(curves: pd.DataFrame) -> pd.DataFrame:
    """Return a `stress_table` with the transmissivity for every hydraulic aperture in it.

    Bounds and bands of the apertures have their transmissivities too (`TRANSMISSIVITIES`).
    """
    added = {}
    for name, transmissivity in TRANSMISSIVITIES.items():
        if name in curves:
            for column in [*columns_of(curves, name), *wider_columns_of(curves, name)]:
                added[column.replace(name, transmissivity)] = WATER * (1e-3 * curves[column]) ** 3
    return curves.assign(**added)


def has_bands(curves: pd.DataFrame) -> bool:
    """Return whether a `stress_table` has columns with the limits of bands."""
    return "closure_net_since_seating_mm_low" in curves


def columns_of(curves: pd.DataFrame, name: str) -> list[str]:
    """Return the names of the columns of a quantity in a `stress_table`.

    They are its own name, and those with ``_low`` and ``_high`` if it has a band.
    """
    if f"{name}_low" in curves:
        return [name, *(f"{name}_{end}" for end in ENDS)]
    return [name]


def wider_columns_of(curves: pd.DataFrame, name: str) -> list[str]:
    """Return the names of the columns of a quantity's band with other choices of the model.

    There are none if the `stress_table` has no such band.
    """
    return [f"{name}_{end}" for end in WIDER if f"{name}_{end}" in curves]

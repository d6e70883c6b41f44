"""A closed joint as other programs take it: parameters, tables and meshes; no files here."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engineering.curves import (
    curve_table,
    cycle_table,
    has_flow,
    mean_hydraulic,
)
from jointclosure.engineering.laws import fitted_laws, parameter
from jointclosure.engineering.stiffness import closures_at, stiffness_table, stress_levels
from jointclosure.inputs import InputError
from jointclosure.joint.history import branch_of, read_along
from jointclosure.joint.protocol import LOADING


def _last_from_seating(history: xr.Dataset, program: str) -> int:
    """The last cycle whose loading begins below the seating stress, from which closures count.

    Raises
    ------
    InputError
        None does.
    """
    seating = float(history.attrs["seating_stress_Pa"])
    for cycle in np.unique(history.cycle.values)[::-1]:
        here = branch_of(history.cycle.values, history.branch.values, cycle, LOADING)
        if here.size > 1 and history.normal_stress.values[here].min() <= seating:
            return int(cycle)
    raise InputError(f"{program}: no loading begins at or below the seating stress, {seating:g} Pa")


def porepy_parameters(history: xr.Dataset) -> dict[str, float]:
    """Find the solid constants of PorePy's Barton-Bandis fracture for the last loading.

    All are of the net closure, as PorePy deforms the rock itself, and so is the mean aperture.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.

    Returns
    -------
    dict
        ``fracture_normal_stiffness`` [Pa/m], which is kni, ``maximum_elastic_fracture_opening``
        [m], which is Vm, and ``residual_aperture`` [m]: the mean aperture at seating less Vm.

    Raises
    ------
    InputError
        No loading begins at seating, the hyperbola could not be fitted, or closes more than there
        is aperture.
    """
    cycle = _last_from_seating(history, "PorePy")
    fits, cycles = fitted_laws(history), cycle_table(history).set_index("cycle")
    stiffness, largest = (
        parameter(fits, cycle, LOADING, name) for name in ("kni_MPa_per_mm", "vm_mm")
    )
    aperture = float(cycles.mean_aperture_at_seating_mm[cycle])
    if not (stiffness > 0.0 and 0.0 < largest < aperture):
        raise InputError(
            f"PorePy: the hyperbola of cycle {cycle} has kni = {stiffness:g} MPa/mm and Vm = "
            f"{largest:g} mm at a mean aperture of {aperture:g} mm: kni must be positive, and Vm "
            "positive and below the aperture"
        )
    return {
        "fracture_normal_stiffness": 1e9 * stiffness,
        "maximum_elastic_fracture_opening": 1e-3 * largest,
        "residual_aperture": 1e-3 * (aperture - largest),
    }


OPENING_SLOPE = 0.95
"""Largest slope of a GEOS table at its end: GEOS takes it on to open walls, up to where the
aperture is the gap, and so needs it below 1. The mean aperture of a joint has slope 1, as each
wall keeps its volume."""
_END = 0.01
"""Share of the last interval in which that slope stands."""


def geos_aperture_table(history: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Find coordinates and values [m] of the aperture table of GEOS' contact models.

    Of the last loading from seating on: the normal gap, which is less than 0 by the net closure
    since seating, ascending to 0, and there the hydraulic aperture (the geometric mean of both
    directions), which is what its flow takes; the mean aperture of a history without flow.
    Where the last slope is larger, a point just before the end makes it `OPENING_SLOPE`.

    Raises
    ------
    InputError
        No seating stress, a loading that does not reach from it to the cycle's maximum, or an
        aperture that is not positive: walls that let nothing pass.
    """
    if float(history.attrs["seating_stress_Pa"]) == 0.0:
        raise InputError("GEOS: its table begins at seating; give a seating_stress above 0")
    cycle = _last_from_seating(history, "GEOS")
    closure = closures_at(history, stress_levels(history, cycle=cycle))[cycle - 1, 0]
    if not (np.isfinite(closure).all() and (np.diff(closure) > 0.0).all()):
        raise InputError(
            f"GEOS: the loading of cycle {cycle} must close steadily from seating to its maximum"
        )
    of_cycle = (history.cycle.values == cycle) & (history.branch.values == LOADING)
    net = read_along(history)[of_cycle]
    order = np.argsort(net)
    known = mean_hydraulic(history) if has_flow(history) else history.mean_aperture.values
    aperture = np.interp(closure, net[order], known[of_cycle][order])
    if not (aperture > 0.0).all():
        kind = "hydraulic" if has_flow(history) else "mean"
        raise InputError(f"GEOS: the {kind} aperture must be positive, and is 0 at some stresses")
    gap = -(closure - closure[0])[::-1]
    gap[-1] = 0.0  # and not -0
    values = aperture[::-1]
    if (values[-1] - values[-2]) / (gap[-1] - gap[-2]) > OPENING_SLOPE:
        before = _END * gap[-2]
        gap = np.insert(gap, -1, before)
        values = np.insert(values, -1, values[-1] + OPENING_SLOPE * before)
    return gap, values


def itasca_tables(history: xr.Dataset) -> str:
    """Write commands that define tables of net normal stiffness [Pa/m] against normal stress [Pa].

    One table for each cycle's loading and unloading, in the form of 3DEC 7 and later,
    ``table 'name' add (x,y) ...``, without the chords of landings (`stiffness_table`).
    Of a history with flow also tables of the hydraulic aperture [m], the geometric mean of both
    directions, at its steps.
    """
    lines = ["; normal stiffness (Pa/m) against normal stress (Pa) by cycle and branch"]
    table = stiffness_table(history)
    for (cycle, branch), own in table[~table.landing].groupby(["cycle", "branch"], sort=False):
        stress, stiffness = own.normal_stress_MPa, 1e9 * own.normal_stiffness_net_MPa_per_mm
        lines.append(_itasca_table(f"kn-cycle-{cycle}-{branch}", stress, stiffness))
    if has_flow(history):
        lines.append("; hydraulic aperture (m) against normal stress (Pa) by cycle and branch")
        for (cycle, branch), own in curve_table(history).groupby(["cycle", "branch"], sort=False):
            aperture = 1e-3 * np.sqrt(own.hydraulic_aperture_x_mm * own.hydraulic_aperture_y_mm)
            order = np.argsort(own.normal_stress_MPa.to_numpy(), kind="stable")
            stress = own.normal_stress_MPa.iloc[order]
            name = f"aperture-cycle-{cycle}-{branch}"
            lines.append(_itasca_table(name, stress, aperture.iloc[order]))
    return "\n".join(lines) + "\n"


def _itasca_table(name: str, stress: pd.Series, values: pd.Series) -> str:
    """A command that defines values over stresses [MPa], without those that are not known."""
    pairs = " ".join(
        f"({1e6 * at:.6e},{value:.6e})"
        for at, value in zip(stress, values, strict=True)
        if np.isfinite(value)
    )
    return f"table '{name}' add {pairs}"


class FractureMesh(NamedTuple):
    """A triangulated midplane: points (n, 3) [m], triangles (m, 3), and fields of each triangle."""

    points: np.ndarray
    triangles: np.ndarray
    cell_fields: dict[str, np.ndarray]


def fracture_mesh(
    upper: np.ndarray, lower: np.ndarray, opening: float, spacing: float
) -> FractureMesh:
    """The midplane of a joint, with its aperture and where walls touch.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights [m] towards the other wall.
    opening : float
        Distance of the planes that heights are counted from [m]: the sum of the heights where the
        walls only just touch.
    spacing : float
        Of the cells [m].

    Returns
    -------
    FractureMesh
        Two triangles between four neighbouring cells; ``aperture`` [m] is the mean of a
        triangle's corners, ``contact`` 1 where one of them touches, else 0, and ``MaterialIDs`` 0.
    """
    aperture = np.maximum(opening - upper - lower, 0.0)
    midplane = lower + 0.5 * (opening - upper - lower)
    ny, nx = upper.shape
    y, x = np.indices(upper.shape) * spacing
    points = np.column_stack([x.ravel(), y.ravel(), midplane.ravel()])
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + nx], axis=1),
            np.stack([corner + 1, corner + nx + 1, corner + nx], axis=1),
        ]
    )
    of_corners = aperture.ravel()[triangles]
    return FractureMesh(
        points,
        triangles,
        {
            "aperture": of_corners.mean(axis=1),
            "contact": (of_corners <= 0.0).any(axis=1).astype(np.int32),
            "MaterialIDs": np.zeros(len(triangles), np.int32),
        },
    )

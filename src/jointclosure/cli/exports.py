"""Files of a closed joint: tables, figures, and inputs of other programs (docs/export.md)."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.joint.curves import (
    curve_table,
    cycle_table,
    has_flow,
    mean_hydraulic,
    spacing_of,
)
from jointclosure.joint.history import branch_of, read_along
from jointclosure.joint.laws import describe_law, fitted_laws, parameter
from jointclosure.joint.protocol import FAILURE, LOADING
from jointclosure.joint.stiffness import closures_at, stiffness_table, stress_levels
from jointclosure.storage.figures import save_figure, write_vtu
from jointclosure.storage.text import write_csv, write_text

FIGURES = 7
"""Significant digits of numbers in tables: more than their accuracy, but enough to distinguish
neighbouring steps."""
OPENING_SLOPE = 0.95
"""Largest slope at the end of a GEOS table. GEOS extrapolates the table to open walls, up to where
the aperture equals the gap, and therefore needs a slope below 1. The mean aperture of a joint has
slope 1, because each wall keeps its volume."""
_END = 0.01
"""Share of the last interval that has this slope."""
_GEOS = """<!-- for <Functions>; its contact model has apertureTableName="joint_aperture".
     Gap and aperture in m, from joint.nc beside this file. -->
<TableFunction
  name="joint_aperture"
  coordinateFiles="{ geos_gap.csv }"
  voxelFile="geos_aperture.csv"
  interpolation="linear"/>
"""
_NET = (
    "stiffness, laws and inputs of other programs are net, without the elastic indentation of "
    "the half-spaces; curves.csv, cycles.csv and stiffness.csv have gross values too"
)


def write_exports(history: xr.Dataset, folder: Path, title: str) -> None:
    """Write tables, figure and inputs of other programs of a joint that did not fail; print notes.

    The notes are the kind of closure, the best law of each cycle's loading, and the reasons of
    inputs that could not be written.
    """
    if int(history.status) >= FAILURE:
        return
    from jointclosure.plotting.joint import engineering_figure

    notes, fits = [_NET], fitted_laws(history)
    notes += [describe_law(fits, cycle, LOADING) for cycle in cycle_table(history).cycle]
    for names, export in EXPORTS.items():
        files = [folder / name for name in names.split()]
        try:
            contents = export(history)
            for file, content in zip(files, contents if files[1:] else [contents], strict=True):
                _write(content, file)
        except InputError as error:  # the files of other programs are still written
            notes.append(f"not written: {error}")
    save_figure(engineering_figure(history, title), folder / "engineering.png")
    print("\n".join(f"- {note}" for note in notes))


def _write(content: Any, path: Path) -> None:
    """Write an export in the form of its type."""
    if isinstance(content, pd.DataFrame):
        write_csv(content, path, FIGURES)
    elif isinstance(content, FractureMesh):
        write_vtu(*content, path)
    else:
        text = content if isinstance(content, str) else json.dumps(content, indent=1) + "\n"
        write_text(text, path)


def _last_from_seating(history: xr.Dataset, program: str) -> int:
    """Return the last cycle whose loading begins below the seating stress."""
    seating = float(history.attrs["seating_stress_Pa"])
    for cycle in np.unique(history.cycle.values)[::-1]:
        here = branch_of(history, cycle, LOADING)
        if here.size > 1 and history.normal_stress.values[here].min() <= seating:
            return int(cycle)
    raise InputError(f"{program}: no loading begins at or below the seating stress, {seating:g} Pa")


def porepy_parameters(history: xr.Dataset) -> dict[str, float]:
    """Compute the solid constants of PorePy's Barton-Bandis fracture for the last loading.

    All constants, including the mean aperture, refer to the net closure, because PorePy computes
    the deformation of the rock itself.

    They are ``fracture_normal_stiffness`` [Pa/m], kni; ``maximum_elastic_fracture_opening`` [m],
    Vm; and ``residual_aperture`` [m], the mean aperture at seating less Vm. Refused if no loading
    begins at seating, or if the hyperbola could not be fitted or closes beyond the aperture.
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


def geos_aperture_table(history: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return coordinates and values [m] of the aperture table of GEOS' contact models.

    The table is for the last loading from seating on. Coordinates are the normal gap, the negative
    net closure since seating, ascending to 0. The value at 0 is the aperture at seating. Values are
    hydraulic apertures (the geometric mean of both directions), which the flow of GEOS uses, or
    mean apertures for a history without flow. If the last slope is larger than `OPENING_SLOPE`, a
    point just before the end reduces it to this value. Refused without a seating stress, if the
    loading does not extend from it to the maximum, or if an aperture is not positive.
    """
    if float(history.attrs["seating_stress_Pa"]) == 0.0:
        raise InputError("GEOS: the table begins at seating; seating_stress must be above 0")
    cycle = _last_from_seating(history, "GEOS")
    closure = closures_at(history, stress_levels(history, cycle=cycle))[cycle - 1, 0]
    if not (np.isfinite(closure).all() and (np.diff(closure) > 0.0).all()):
        must = "must close monotonically from seating to its maximum"
        raise InputError(f"GEOS: the loading of cycle {cycle} {must}")
    of_cycle = (history.cycle.values == cycle) & (history.branch.values == LOADING)
    net = read_along(history)[of_cycle]
    order = np.argsort(net)
    known = mean_hydraulic(history) if has_flow(history) else history.mean_aperture.values
    aperture = np.interp(closure, net[order], known[of_cycle][order])
    if not (aperture > 0.0).all():
        kind = "hydraulic" if has_flow(history) else "mean"
        raise InputError(
            f"GEOS: the {kind} aperture must be positive, its least value is "
            f"{1e3 * aperture.min():.2g} mm"
        )
    gap = -(closure - closure[0])[::-1]
    gap[-1] = 0.0  # not -0.0
    values = aperture[::-1]
    if (values[-1] - values[-2]) / (gap[-1] - gap[-2]) > OPENING_SLOPE:
        before = _END * gap[-2]
        gap = np.insert(gap, -1, before)
        values = np.insert(values, -1, values[-1] + OPENING_SLOPE * before)
    return gap, values


def geos_files(history: xr.Dataset) -> tuple[str, str, str]:
    """Return gaps and apertures of `geos_aperture_table` as GEOS reads them, and their element."""
    gap, aperture = (
        "\n".join(f"{value:.9e}" for value in values) + "\n"
        for values in geos_aperture_table(history)
    )
    return gap, aperture, _GEOS


def itasca_tables(history: xr.Dataset) -> str:
    """Write commands that define tables of net normal stiffness [Pa/m] over normal stress [Pa].

    There is one table for each cycle's loading and unloading, in the form of 3DEC 7 and later,
    ``table 'name' add (x,y) ...``, without the chords of landings (`stiffness_table`). For a
    history with flow there are also tables of the hydraulic aperture [m] at its steps, the
    geometric mean of both directions.
    """
    lines = ["; normal stiffness (Pa/m) against normal stress (Pa) by cycle and branch"]
    table = stiffness_table(history)
    for (cycle, branch), rows in table[~table.landing].groupby(["cycle", "branch"], sort=False):
        stress, stiffness = rows.normal_stress_MPa, 1e9 * rows.normal_stiffness_net_MPa_per_mm
        lines.append(_itasca_table(f"kn-cycle-{cycle}-{branch}", stress, stiffness))
    if has_flow(history):
        lines.append("; hydraulic aperture (m) against normal stress (Pa) by cycle and branch")
        for (cycle, branch), rows in curve_table(history).groupby(["cycle", "branch"], sort=False):
            aperture = 1e-3 * np.sqrt(rows.hydraulic_aperture_x_mm * rows.hydraulic_aperture_y_mm)
            order = np.argsort(rows.normal_stress_MPa.to_numpy(), kind="stable")
            stress = rows.normal_stress_MPa.iloc[order]
            name = f"aperture-cycle-{cycle}-{branch}"
            lines.append(_itasca_table(name, stress, aperture.iloc[order]))
    return "\n".join(lines) + "\n"


def _itasca_table(name: str, stress: pd.Series, values: pd.Series) -> str:
    """Return a command that defines known values over stresses [MPa]."""
    pairs = " ".join(
        f"({1e6 * at:.6e},{value:.6e})"
        for at, value in zip(stress, values, strict=True)
        if np.isfinite(value)
    )
    return f"table '{name}' add {pairs}"


class FractureMesh(NamedTuple):
    """Triangulated midplane: points (n, 3) [m], triangles (m, 3), and fields of triangles."""

    points: np.ndarray
    triangles: np.ndarray
    cell_fields: dict[str, np.ndarray]


def fracture_mesh(history: xr.Dataset) -> FractureMesh:
    """Triangulate the midplane of the joint at its end, where the walls just touch.

    There are two triangles between four neighbouring cells. ``aperture`` [m] is the mean of a
    triangle's corners, ``contact`` is 1 if one of them is in contact, otherwise 0, and
    ``MaterialIDs`` is 0.
    """
    upper, lower = history.upper_final.values, history.lower_final.values
    opening, spacing = float((upper + lower).max()), spacing_of(history)
    aperture = np.maximum(opening - upper - lower, 0.0)
    midplane = lower + 0.5 * (opening - upper - lower)
    ny, nx = upper.shape
    y, x = np.indices(upper.shape) * spacing
    points = np.column_stack([x.ravel(), y.ravel(), midplane.ravel()])
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    halves = (corner, corner + 1, corner + nx), (corner + 1, corner + nx + 1, corner + nx)
    triangles = np.concatenate([np.stack(corners, axis=1) for corners in halves])
    of_corners = aperture.ravel()[triangles]
    fields = {
        "aperture": of_corners.mean(axis=1),
        "contact": (of_corners <= 0.0).any(axis=1).astype(np.int32),
        "MaterialIDs": np.zeros(len(triangles), np.int32),
    }
    return FractureMesh(points, triangles, fields)


EXPORTS: dict[str, Callable[[xr.Dataset], Any]] = {
    "curves.csv": curve_table,
    "cycles.csv": cycle_table,
    "stiffness.csv": stiffness_table,
    "laws.csv": fitted_laws,
    "joint_stiffness.dat": itasca_tables,
    "porepy.json": porepy_parameters,
    "geos_gap.csv geos_aperture.csv geos.xml": geos_files,
    "fracture.vtu": fracture_mesh,
}
"""Functions of a history by the files that their results are written to."""

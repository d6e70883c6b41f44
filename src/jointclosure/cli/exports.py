"""Files of a closed joint: tables, figures, and inputs of other programs (docs/export.md)."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.results import FIGURES, failed, write
from jointclosure.inputs import InputError
from jointclosure.joint.curves import (
    closures_at,
    curve_table,
    cycle_table,
    has_flow,
    mean_hydraulic,
    spacing_of,
    stiffness_table,
    stress_levels,
)
from jointclosure.joint.history import branch_of, read_along
from jointclosure.joint.laws import describe_law, fitted_laws, parameter
from jointclosure.joint.protocol import LOADING

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


def write_exports(history: xr.Dataset, title: str, folder: Path) -> None:
    """Write `EXPORTS` and their figure of a joint that did not fail; print laws and refusals."""
    if failed(history):
        return
    from jointclosure.plotting.joint import engineering_figure

    notes, fits = [_NET], fitted_laws(history)
    notes += [describe_law(fits, cycle, LOADING) for cycle in cycle_table(history).cycle]
    for names, export in EXPORTS.items():
        files = [folder / name for name in names.split()]
        try:
            contents = export(history)
            for file, content in zip(files, contents if files[1:] else [contents], strict=True):
                write(content, file, FIGURES)
        except InputError as error:  # the files of other programs are still written
            notes.append(f"not written: {error}")
    write(engineering_figure(history, title), folder / "engineering.png")
    print("\n".join(f"- {note}" for note in notes))


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

    ``fracture_normal_stiffness`` [Pa/m], kni; ``maximum_elastic_fracture_opening`` [m], Vm; and
    ``residual_aperture`` [m], the mean aperture at seating less Vm. They refer to the net closure,
    because PorePy computes the deformation of the rock itself.
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
    """Return normal gaps and apertures [m] of the last loading from seating on, as GEOS takes them.

    Gaps are the negative net closure since seating, ascending to 0. Apertures are hydraulic (the
    geometric mean of both directions), or mean ones of a history without flow. If the last slope is
    larger than `OPENING_SLOPE`, a point just before the end reduces it to this value.
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
        kind, least = "hydraulic" if has_flow(history) else "mean", 1e3 * aperture.min()
        must = f"must be positive, its least value is {least:.2g} mm"
        raise InputError(f"GEOS: the {kind} aperture {must}")
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
        "".join(f"{value:.9e}\n" for value in values) for values in geos_aperture_table(history)
    )
    return gap, aperture, _GEOS


def itasca_tables(history: xr.Dataset) -> str:
    """Write commands of 3DEC 7 that define tables over normal stress [Pa], by cycle and branch.

    They are of net normal stiffness [Pa/m], without the chords of landings (`stiffness_table`), and
    with flow of the geometric mean of the hydraulic apertures [m].
    """
    chords = stiffness_table(history)
    chords = chords[~chords.landing]
    values = 1e9 * chords.normal_stiffness_net_MPa_per_mm
    lines = ["; normal stiffness (Pa/m) against normal stress (Pa) by cycle and branch"]
    lines += _tables("kn", chords.assign(value=values))
    if has_flow(history):
        rows = curve_table(history)
        values = 1e-3 * np.sqrt(rows.hydraulic_aperture_x_mm * rows.hydraulic_aperture_y_mm)
        rows = rows.assign(value=values).sort_values("normal_stress_MPa", kind="stable")
        lines.append("; hydraulic aperture (m) against normal stress (Pa) by cycle and branch")
        lines += _tables("aperture", rows)
    return "\n".join(lines) + "\n"


def _tables(name: str, rows: pd.DataFrame) -> list[str]:
    """Return a command for each cycle and branch that defines known values over stresses."""
    lines = []
    for (cycle, branch), part in rows.groupby(["cycle", "branch"]):
        known = part[np.isfinite(part.value)]
        pairs = zip(1e6 * known.normal_stress_MPa, known.value, strict=True)
        text = " ".join(f"({stress:.6e},{value:.6e})" for stress, value in pairs)
        lines.append(f"table '{name}-cycle-{cycle}-{branch}' add {text}")
    return lines


def fracture_mesh(
    history: xr.Dataset,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Triangulate the midplane of the joint at its end, where the walls just touch.

    Returns points (n, 3) [m], triangles (m, 3), two between four neighbouring cells, and fields of
    triangles: ``aperture`` [m], the mean of the corners, ``contact``, 1 if one of them is in
    contact, otherwise 0, and ``MaterialIDs``, 0.
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
    return points, triangles, fields


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

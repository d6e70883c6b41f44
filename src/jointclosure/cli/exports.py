"""Files of a closed joint: tables, figures, and inputs of other programs (docs/export.md)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.results import FIGURES, failed
from jointclosure.inputs import InputError
from jointclosure.joint.barton_bandis import BartonBandis
from jointclosure.joint.curves import (
    curve_table,
    cycle_table,
    has_flow,
    members,
    spacing_of,
    stress_table,
)
from jointclosure.joint.history import branch_of
from jointclosure.joint.laws import LAWS, fit_law, fitted_laws
from jointclosure.joint.protocol import LOADING
from jointclosure.storage.files import csv_text

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
    "the half-spaces; answer.csv, curves.csv and cycles.csv have gross values too"
)


def export_files(
    history: xr.Dataset,
    title: str,
    curves: pd.DataFrame | None = None,
    laws: Mapping[int, BartonBandis] = {},
) -> dict[str, Any]:
    """Return the files of a joint that did not fail by name; print what is not written.

    ``curves`` are bands of `stress_table`, and ``laws`` those of Barton and Bandis since seating.
    """
    if failed(history):
        return {}
    from jointclosure.plotting.joint import engineering_figure

    curves = stress_table(history) if curves is None else curves
    tables = {
        "curves": curve_table(history),
        "cycles": cycle_table(history),
        "answer": curves,
        "laws": fitted_laws(history),
    }
    notes = [_NET]
    files: dict[str, Any] = {
        f"{name}.csv": csv_text(table, FIGURES) for name, table in tables.items()
    }
    for export in (itasca_tables, porepy_files, geos_files, fracture_mesh):
        try:
            files |= export(history, curves)
        except InputError as error:  # the files of other programs are still written
            notes.append(f"not written: {error}")
    files["engineering.png"] = engineering_figure(history, title, curves, laws)
    print("\n".join(f"- {note}" for note in notes))
    return files


def _loading(
    history: xr.Dataset, curves: pd.DataFrame, program: str
) -> tuple[int, pd.DataFrame, dict[str, str]]:
    """Return the last loading from seating: cycle, rows that are known, and endings of columns.

    Endings are by those of files: the median, and the low and the high end of a band.
    """
    known = curves.dropna(subset=members(curves, "closure_net_since_seating_mm"))
    seating = float(history.attrs["seating_stress_Pa"])
    begins = {c: branch_of(history, c, LOADING) for c in np.unique(known.cycle)}
    stress = history.normal_stress.values
    cycles = [c for c, here in begins.items() if here.size > 1 and stress[here].min() <= seating]
    if not cycles:
        must = f"no loading begins at or below the seating stress, {seating:g} Pa"
        raise InputError(f"{program}: {must}")
    cycle, names = int(cycles[-1]), members(curves, "")
    rows = known[(known.cycle == cycle) & (known.branch == LOADING)]
    return cycle, rows, dict(zip(("", "_low", "_high")[: len(names)], names, strict=True))


def porepy_files(history: xr.Dataset, curves: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Return the solid constants of PorePy's Barton-Bandis fracture for the last loading.

    ``fracture_normal_stiffness`` [Pa/m], kni; ``maximum_elastic_fracture_opening`` [m], Vm; and
    ``residual_aperture`` [m], the mean aperture at seating less Vm, at least 0. They refer to the
    net closure, because PorePy computes the deformation of the rock itself.
    """
    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    cycle, rows, endings = _loading(history, curves, "PorePy")
    files = {}
    for ending, member in endings.items():
        closure = rows[f"closure_net_since_seating_mm{member}"].to_numpy()
        law, stress = LAWS["hyperbolic"], rows.normal_stress_MPa.to_numpy()
        stiffness, largest = fit_law(law, stress, closure - closure[0], seating)[0]
        aperture = float(rows[f"mean_aperture_mm{member}"].iloc[0])
        if not (stiffness > 0.0 and largest > 0.0 and aperture > 0.0):
            raise InputError(
                f"PorePy: the hyperbola of cycle {cycle} has kni = {stiffness:g} MPa/mm and Vm = "
                f"{largest:g} mm at a mean aperture of {aperture:g} mm: all must be positive"
            )
        files[f"porepy{ending}.json"] = {
            "fracture_normal_stiffness": 1e9 * stiffness,
            "maximum_elastic_fracture_opening": 1e-3 * largest,
            "residual_aperture": 1e-3 * max(aperture - largest, 0.0),
        }
    return files


def geos_files(history: xr.Dataset, curves: pd.DataFrame) -> dict[str, str]:
    """Return gaps and apertures of the last loading from seating on as GEOS reads them.

    Gaps [m] are the negative net closure since seating, ascending to 0. Apertures [m] are hydraulic
    (the geometric mean of both directions; where flow is blocked, its upper bound), or mean ones of
    a history without flow.
    """
    if float(history.attrs["seating_stress_Pa"]) == 0.0:
        raise InputError("GEOS: the table begins at seating; seating_stress must be above 0")
    cycle, rows, endings = _loading(history, curves, "GEOS")
    closure = 1e-3 * rows[members(curves, "closure_net_since_seating_mm")[0]].to_numpy()
    if not (closure.size > 1 and (np.diff(closure) > 0.0).all()):
        must = "must close monotonically from seating to its maximum"
        raise InputError(f"GEOS: the loading of cycle {cycle} {must}")
    kind = "hydraulic" if has_flow(history) else "mean"
    apertures: dict[str, np.ndarray] = {}
    for ending, member in endings.items():
        aperture = 1e-3 * rows[f"{kind}_aperture_mm{member}"].to_numpy()
        if has_flow(history):
            aperture = bounded(aperture, 1e-3 * rows[f"largest_hydraulic_mm{member}"].to_numpy())
        if ending and not (aperture > 0.0).all():
            continue  # the end of a band where no void is left
        if not (aperture > 0.0).all():
            first = rows.normal_stress_MPa.iloc[int(np.argmin(aperture > 0.0))]
            raise InputError(
                f"GEOS: the {kind} aperture must be positive, and is not from {first:.3g} MPa on, "
                "where no void is left that could flow"
            )
        apertures[f"geos_aperture{ending}.csv"] = aperture
    gap, tables = with_opening(closure, np.stack(list(apertures.values())))
    written = {"geos_gap.csv": gap} | dict(zip(apertures, tables, strict=True))
    texts = {
        name: "".join(f"{value:.9e}\n" for value in values) for name, values in written.items()
    }
    return texts | {"geos.xml": _GEOS}


def bounded(hydraulic: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Return hydraulic apertures (n,) at rising stresses, upper bounds where flow is blocked.

    It falls with stress, so that no aperture exceeds those before.
    """
    return np.minimum.accumulate(np.where(hydraulic > 0.0, hydraulic, largest))


def with_opening(closure: np.ndarray, apertures: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return gaps and apertures (tables, n) [m] as GEOS takes them, from closures since seating.

    If a last slope is larger than `OPENING_SLOPE`, points just before the end reduce it to this
    value.
    """
    gap = -(closure - closure[0])[::-1]
    gap[-1] = 0.0  # not -0.0
    values = apertures[:, ::-1]
    slopes = (values[:, -1] - values[:, -2]) / (gap[-1] - gap[-2])
    if slopes.max() > OPENING_SLOPE:
        before = _END * gap[-2]
        opened = values[:, -1] + np.minimum(slopes, OPENING_SLOPE) * before
        gap, values = np.insert(gap, -1, before), np.insert(values, -1, opened, axis=1)
    return gap, values


def itasca_tables(history: xr.Dataset, curves: pd.DataFrame) -> dict[str, str]:
    """Write commands of 3DEC 7 that define tables over normal stress [Pa], by cycle and branch.

    They are of net normal stiffness [Pa/m], and with flow of the geometric mean of the hydraulic
    apertures [m]; names of the low and the high end of a band end so.
    """
    lines = ["; normal stiffness (Pa/m) against normal stress (Pa) by cycle and branch"]
    lines += _tables("kn", curves, "normal_stiffness_net_MPa_per_mm", 1e9)
    if has_flow(history):
        lines.append("; hydraulic aperture (m) against normal stress (Pa) by cycle and branch")
        lines += _tables("aperture", curves, "hydraulic_aperture_mm", 1e-3)
        lines.append("; its upper bound (m), as a cell in contact is shut whole")
        lines += _tables("aperture-bound", curves, "largest_hydraulic_mm", 1e-3)
    return {"joint_stiffness.dat": "\n".join(lines) + "\n"}


def _tables(name: str, curves: pd.DataFrame, column: str, scale: float) -> list[str]:
    """Return a command for each cycle, branch and end of a band that defines known values."""
    lines = []
    for member, ending in zip(members(curves, column), ("", "-low", "-high"), strict=False):
        for (cycle, branch), part in curves.dropna(subset=member).groupby(["cycle", "branch"]):
            pairs = zip(1e6 * part.normal_stress_MPa, scale * part[member], strict=True)
            text = " ".join(f"({stress:.6e},{value:.6e})" for stress, value in pairs)
            lines.append(f"table '{name}-cycle-{cycle}-{branch}{ending}' add {text}")
    return lines


def fracture_mesh(history: xr.Dataset, curves: pd.DataFrame) -> dict[str, tuple]:
    """Triangulate the midplane of the joint at its end, where the walls just touch.

    The file has points (n, 3) [m], triangles (m, 3), two between four neighbouring cells, and
    fields of triangles: ``aperture`` [m], the mean of the corners, ``contact``, 1 if one of them is
    in contact, otherwise 0, and ``MaterialIDs``, 0.
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
    return {"fracture.vtu": (points, triangles, fields)}

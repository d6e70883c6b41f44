"""Files of a closed joint for engineering programs."""

import json
from pathlib import Path

import xarray as xr

from jointclosure.cli.exchange import (
    fracture_mesh,
    geos_aperture_table,
    itasca_tables,
    porepy_parameters,
)
from jointclosure.inputs import InputError
from jointclosure.joint.curves import curve_table, cycle_table, spacing_of
from jointclosure.joint.laws import describe_law, fitted_laws
from jointclosure.joint.protocol import FAILURE, LOADING
from jointclosure.joint.stiffness import stiffness_table
from jointclosure.storage.figures import save_figure
from jointclosure.storage.meshes import write_vtu
from jointclosure.storage.text import write_csv, write_text

FIGURES = 7
"""Significant digits of numbers in tables: more than their accuracy, but enough to distinguish
neighbouring steps."""

_GEOS = """<!-- for <Functions>; its contact model has apertureTableName="joint_aperture".
     Gap and aperture in m, from joint.nc beside this file. -->
<TableFunction
  name="joint_aperture"
  coordinateFiles="{ geos_gap.csv }"
  voxelFile="geos_aperture.csv"
  interpolation="linear"/>
"""


def write_exports(history: xr.Dataset, folder: Path, title: str) -> None:
    """Write and print as `write_engineering`, unless the simulation failed."""
    if int(history.status) < FAILURE:
        print("\n".join(f"- {line}" for line in write_engineering(history, folder, title)))


def write_engineering(history: xr.Dataset, folder: Path, title: str) -> list[str]:
    """Write curves, stiffness, laws and input of other programs.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.
    folder : path
        An existing folder.
    title : str
        Title of the figure.

    Returns
    -------
    list of str
        Sentences on the kind of closure in the files, the best law of each cycle's loading, and
        files that could not be written.
    """
    from jointclosure.plotting.engineering import engineering_figure

    write_csv(curve_table(history), folder / "curves.csv", FIGURES)
    cycles, fits = cycle_table(history), fitted_laws(history)
    write_csv(cycles, folder / "cycles.csv", FIGURES)
    write_csv(stiffness_table(history), folder / "stiffness.csv", FIGURES)
    write_csv(fits, folder / "laws.csv", FIGURES)
    write_text(itasca_tables(history), folder / "joint_stiffness.dat")
    messages = [
        "stiffness, laws and inputs of other programs are net, without the elastic indentation of "
        "the half-spaces; curves.csv, cycles.csv and stiffness.csv have gross values too"
    ]
    messages += [describe_law(fits, cycle, LOADING) for cycle in cycles.cycle]
    for write in (_write_porepy, _write_geos, _write_mesh):
        try:
            write(history, folder)
        except InputError as error:  # the files of other programs are still written
            messages.append(f"not written: {error}")
    save_figure(engineering_figure(history, title), folder / "engineering.png")
    return messages


def _write_porepy(history: xr.Dataset, folder: Path) -> None:
    text = json.dumps(porepy_parameters(history), indent=1)
    write_text(text + "\n", folder / "porepy.json")


def _write_geos(history: xr.Dataset, folder: Path) -> None:
    for name, values in zip(("gap", "aperture"), geos_aperture_table(history), strict=True):
        lines = [f"{value:.9e}" for value in values]
        write_text("\n".join(lines) + "\n", folder / f"geos_{name}.csv")
    write_text(_GEOS, folder / "geos.xml")


def _write_mesh(history: xr.Dataset, folder: Path) -> None:
    upper, lower = history.upper_final.values, history.lower_final.values
    mesh = fracture_mesh(upper, lower, float((upper + lower).max()), spacing_of(history))
    write_vtu(*mesh, folder / "fracture.vtu")

"""All files of a simulated joint: its tables, and the inputs of other programs."""

from collections.abc import Callable

import pandas as pd
import xarray as xr

from jointclosure.exports.csv_tables import csv_files, with_law
from jointclosure.exports.geos import geos_barton_bandis, geos_files
from jointclosure.exports.hyperbola import fitted_loading
from jointclosure.exports.loading import Exported, loading_remark
from jointclosure.exports.porepy import porepy_files
from jointclosure.exports.udec_3dec import barton_bandis_commands, itasca_tables
from jointclosure.exports.vtu import fracture_mesh
from jointclosure.inputs import InputError
from jointclosure.joint.laws import JointLaws
from jointclosure.joint.status import failed

NET = (
    "stiffness, laws and inputs of other programs are net; answer.csv, curves.csv and cycles.csv "
    "have gross values too"
)
"""Remark on the closures and stiffnesses of all files."""


def joint_files(
    joint: xr.Dataset, curves: pd.DataFrame, laws: JointLaws, cycle: int = 1
) -> Exported:
    """Return the tables of a joint and the inputs of other programs, by names of files.

    Parameters
    ----------
    joint
        History of the joint: what `simulate` returns, or the ``history`` of what `close` returns.
    curves
        `stress_table` of the joint, with bands if they are known: the ``curves`` of what `close`
        returns.
    laws
        Laws of Barton and Bandis of the joint: the ``laws`` of what `close` returns.
    cycle
        Number of the cycle whose loading the constants for other programs describe.

    Returns
    -------
    Exported
        Texts, constants [SI] and a mesh [m] by names of files, as `write` of
        `jointclosure.storage.folders` takes them. Remarks state what the files describe, and why
        the input of a program is left out. A joint that failed has no files and no remarks.
    """
    if failed(joint):
        return Exported({}, [])
    curves = with_law(joint, curves, laws)
    fitted = fitted_loading(joint, curves, cycle)
    files: dict[str, object] = dict(csv_files(joint, curves))
    remarks = [NET, loading_remark(joint, cycle)]
    inputs: list[Callable[[], Exported]] = [
        lambda: itasca_tables(joint, curves),
        lambda: barton_bandis_commands(joint, curves, laws, cycle, fitted),
        lambda: porepy_files(joint, curves, cycle, fitted),
        lambda: geos_files(joint, curves, cycle),
        lambda: geos_barton_bandis(joint, curves, cycle),
        lambda: fracture_mesh(joint),
    ]
    for of_program in inputs:
        try:
            exported = of_program()
        except InputError as error:  # the files of other programs are still written
            remarks.append(f"not written: {error}")
            continue
        files |= exported.files
        remarks += [line for line in exported.remarks if line not in remarks]
    return Exported(files, remarks)

"""Writes a table for each case: closure, tangent stiffness and, for a study with flow, apertures
over stress, with mean, median and a band of 90 % over its joints (docs/export.md). No joint is
closed again.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.options import add_file_option, writable
from jointclosure.exports.csv_tables import FIGURES
from jointclosure.inputs import InputError, did_you_mean
from jointclosure.joint.history import KINDS
from jointclosure.joint.interpolation import rising_slopes
from jointclosure.joint.status import LOADING
from jointclosure.storage.files import write_csv
from jointclosure.storage.netcdf import reading_netcdf
from studies.commands import study_of
from studies.frame.joint_tables import over_stress, since_seating, succeeded

QUANTILES = (0.05, 0.5, 0.95)


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    what = "name of a case, such as dolerite-base; by default the base case of each rock"
    command.add_argument("--case", nargs="+", action="extend", metavar="NAME", help=what)
    add_file_option(command, "--output", "default: engineering in the results folder")


def run(arguments: argparse.Namespace) -> int:
    """Write a CSV table for each named case (default: base cases).

    Columns are closure, tangent stiffness and apertures over stress (`curves_with_quantiles`).
    """
    folder = arguments.output or arguments.results / "engineering"
    with reading_netcdf(study_of(arguments.results)) as study:
        known = study.case.values.tolist()
        asked = arguments.case or study.case.values[study.parameter.values == "base"].tolist()
        for name in asked:
            if name not in known:
                meant = did_you_mean(name, known)
                raise InputError(f"--case {name}: must be one of {', '.join(known)}{meant}")
        writable((), folder).mkdir(exist_ok=True)
        for name in asked:
            table = curves_with_quantiles(study.sel(case=name).load())
            write_csv(table, folder / f"{name}.csv", FIGURES)
    low, _, high = QUANTILES
    print(f"wrote {folder}: {', '.join(f'{name}.csv' for name in asked)}")
    print(f"bands are the {100 * low:g} and {100 * high:g} % quantiles of the joints")
    return 0


def curves_with_quantiles(case: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure, stiffness and apertures of a case by cycle, branch and stress.

    Each quantity has a mean (``<name>_mean``) and quantiles (such as ``<name>_q05``) over the
    ``samples`` joints that succeeded. The mean of stiffnesses is harmonic. Stiffnesses are computed
    as those of `stress_table`; on loading they are NaN at stresses beyond ``landing_stress``.
    """
    good = case.where(succeeded(case))
    landing = good.landing_stress.where(good.branch == LOADING, np.inf)
    fields: dict[str, Any] = {}
    for kind in KINDS:
        net = kind == "net"
        closure = good.closure - good.bulk_indentation if net else good.closure
        fields[f"closure_{kind}_since_seating_mm"] = 1e3 * since_seating(good, net)
        fields[f"closure_{kind}_mm"] = 1e3 * closure
        fields[f"normal_stiffness_{kind}_MPa_per_mm"] = _stiffness(closure, landing)
    if "hydraulic_aperture" in good:
        fields["mean_aperture_mm"] = 1e3 * good.mean_aperture
        for direction in good.direction.values:
            along = 1e3 * good.hydraulic_aperture.sel(direction=direction, drop=True)
            fields[f"hydraulic_aperture_{direction}_mm"] = along
    columns = {"samples": np.isfinite(good.closure).sum("realization")}
    if (
        "hydraulic_aperture" in good
    ):  # joints for which only bounds of the flow are known are left out
        for direction in good.direction.values:
            known = np.isfinite(good.hydraulic_aperture.sel(direction=direction, drop=True))
            columns[f"samples_of_flow_{direction}"] = known.sum("realization")
    for name, values in fields.items():
        known = np.isfinite(values).any("realization")
        filled = values.where(known, 0.0)  # a quantile of no numbers would warn
        if name.startswith("normal_stiffness"):  # the stiffness of the mean curve
            mean = 1.0 / (1.0 / values).mean("realization")
        else:
            mean = filled.mean("realization")
        columns[f"{name}_mean"] = mean.where(known)
        bounds = np.nanquantile(filled.values, QUANTILES, axis=values.get_axis_num("realization"))
        for quantile, part in zip(QUANTILES, bounds, strict=True):
            label = f"{name}_q{round(100.0 * quantile):02d}"
            columns[label] = known.copy(data=part).where(known)
    return over_stress(columns, case.stress, ["cycle", "branch"])


def _stiffness(closure: xr.DataArray, end: xr.DataArray) -> xr.DataArray:
    """Return the stiffness [MPa/mm] of closure curves [m]; NaN at stresses beyond ``end`` [Pa]."""
    stress = closure.stress.values

    def slopes(curve: np.ndarray, end: float) -> np.ndarray:
        known = np.isfinite(curve) & (stress <= end)
        found = np.full(stress.size, np.nan)
        if known.sum() > 2:
            found[known] = 1e-9 * rising_slopes(stress[known], curve[known], stress[known])
        return found

    return xr.apply_ufunc(
        slopes, closure, end, input_core_dims=[["stress"], []], output_core_dims=[["stress"]],
        vectorize=True,
    ).transpose(*closure.dims)  # fmt: skip

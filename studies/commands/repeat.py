"""Closes one surface pair of a study again, with the settings of its files, and reports whether the
results are the stored ones.
"""

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from jointclosure.ensembles.quantities import names_of_case
from jointclosure.inputs import InputError
from jointclosure.storage.files import read_text
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls import Walls
from studies.commands import existing
from studies.commands.differences import differences
from studies.frame.cases import cases_of, ensembles_of
from studies.frame.configuration import Configuration, read_stored
from studies.frame.experiments import case_point
from studies.frame.scanned_walls import cut_walls
from studies.frame.settings import Point, walls_of
from studies.frame.simulation import close_joints, under_chosen


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    command.add_argument("case", help="name of the case, such as slate-jrc-low")
    command.add_argument("realization", type=int, help="number of the realisation, from 0")
    other = command.add_mutually_exclusive_group()
    for name, what in (("pool", "the pool of common surfaces"), ("finest", "the finest numerics")):
        action = other.add_argument(f"--{name}", action="store_const", const=name, default="cases")
        action.dest = "ensemble"
        action.help = f"a realisation of {what}"


def run(arguments: argparse.Namespace) -> int:
    """Repeat a realisation; return 1 if it differs from the stored one."""
    results = arguments.results
    label = arguments.case
    number = arguments.realization
    ensemble = arguments.ensemble
    stated = json.loads(read_text(existing(results / "tables/configuration.json")))
    configurations = ensembles_of(read_stored(stated))
    if ensemble not in configurations:
        raise InputError(f"--{ensemble}: {results} has none")
    study = configurations[ensemble]
    case = {case.label: case for case in cases_of(study)}.get(label)
    if case is None:
        raise InputError(f"{results}: has no case {label!r}")
    count = _realizations(results, configurations, ensemble)
    if not 0 <= number < count:
        raise InputError(
            f"{results}: has no realisation {number} of {label!r} in {ensemble}; it has {count} of "
            "each case, from 0"
        )
    point = case_point(study, case, range(number, number + 1))
    effects = results / f"effects/{case.rock}.nc"
    if study.effects.auto is not None:
        point, _ = under_chosen(point, read_netcdf(existing(effects)))
    print(f"realisation {number} of {label}", flush=True)
    names = names_of_case(study.flow)
    again = close_joints(point, _walls(results, study, point), names)
    for key, variable in again.data_vars.items():
        if variable.size <= max(8, again.sizes["cycle"]) and variable.dtype.kind in "iuf":
            values = ", ".join(f"{value:.8g}" for value in np.ravel(variable.values))
            print(f"  {key:24} {values} {variable.attrs.get('units', '')}".rstrip())
    stored = _stored(results / ensemble, label, number)
    if stored is None:
        print("no stored results to compare with")
        return 0
    messages = differences(stored.drop_attrs(deep=False), again.drop_attrs(deep=False))
    print("\n".join(messages) or "identical to the stored results")
    return 1 if messages else 0


def _realizations(results: Path, ensembles: Mapping[str, Configuration], ensemble: str) -> int:
    """Return the number of realisations of each case; with a requested accuracy, of its plans."""
    if ensemble == "pool" or ensembles["cases"].study.accuracy is None:
        return ensembles[ensemble].study.realizations
    plans = (json.loads(read_text(file)) for file in results.glob("accuracy/round_*.json"))
    return max((plan[ensemble] for plan in plans), default=0)


def _walls(results: Path, study: Configuration, point: Point) -> Iterator[Walls]:
    """Generate the walls of a point: made from seeds, or cut out of the rock's scanned walls."""
    rock = point.settings.case.rock
    if not study.rocks[rock].walls:
        return walls_of(point.settings)
    return cut_walls(read_netcdf(existing(results / f"walls/{rock}.nc")), point.settings)


def _stored(folder: Path, label: str, number: int) -> xr.Dataset | None:
    """Read a realisation of a case from the file that has it; None if no file has it."""
    for file in sorted(folder.glob(f"{label}.*.nc")):
        joints = read_netcdf(file)
        places = np.flatnonzero(joints.realization.values == number)
        if places.size:
            return joints.isel(joint=places)
    return None

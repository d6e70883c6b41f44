"""`python -m studies repeat`: repeat one realisation of a study, from its files or logs."""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from jointclosure.engine.settings import ClosureSettings
from jointclosure.inputs import InputError
from jointclosure.inputs.plain import from_plain
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_text
from studies.commands import COMMANDS
from studies.frame.ensemble.comparison import differences
from studies.frame.ensemble.repetition import repeated

_SETTINGS = "settings: "


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "repeat",
        help=COMMANDS["repeat"],
        description="Closes one surface pair of a study again, with the settings of its files "
        "or, if its job failed, of its logs, and reports whether the results are the stored ones.",
    )
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    command.add_argument("case", help="name of the case, such as slate-jrc-low")
    command.add_argument("realization", type=int, help="number of the realisation, from 0")
    command.add_argument(
        "--pool", action="store_true", help="a realisation of the pool of common surfaces"
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Repeat a realisation; return 1 if it differs from the stored one."""
    results, case, realization = arguments.results, arguments.case, arguments.realization
    ensemble = "pool" if arguments.pool else "cases"
    settings = _settings(results, ensemble, case, realization)
    first = settings.surfaces.first_realization
    surface = settings.case.surface
    walls = _stored(results / f"{ensemble}/{surface}.{first}.surfaces.nc", realization)
    print(f"realisation {realization} of {case}", flush=True)
    again = repeated(settings, realization, walls)
    for name, variable in again.data_vars.items():
        if variable.size <= max(8, again.sizes["cycle"]):
            values = ", ".join(f"{value:.8g}" for value in np.ravel(variable.values))
            print(f"  {name:24} {values} {variable.attrs.get('units', '')}".rstrip())
    stored = _stored(results / f"{ensemble}/{case}.{first}.nc", realization)
    if stored is None:
        print("no stored results to compare with")
        return 0
    messages = differences(stored.drop_attrs(deep=False), again.drop_attrs(deep=False))
    print("\n".join(messages) or "identical to the stored results")
    return 1 if messages else 0


def _stored(path: Path, realization: int) -> xr.Dataset | None:
    if not path.is_file():
        return None
    with reading_netcdf(path) as dataset:
        return dataset.sel(realization=[realization]).load()


def _settings(results: Path, ensemble: str, case: str, realization: int) -> ClosureSettings:
    """Return the settings of the block of a case that contains the realisation."""
    logs = sorted((results / "logs/close_surfaces" / ensemble).glob(f"{_plain(case)}.*.log"))
    for log in logs:
        lines = (line for line in read_text(log).splitlines() if _SETTINGS in line)
        for line in lines:
            settings = from_plain(ClosureSettings, json.loads(line.partition(_SETTINGS)[2]))
            first = settings.surfaces.first_realization
            if first <= realization < first + settings.surfaces.realizations:
                return settings
    raise InputError(
        f"{results}: no log in logs/close_surfaces/{ensemble} contains realisation "
        f"{realization} of {case!r}"
    )


def _plain(case: str) -> str:
    if not case.replace("-", "").replace("_", "").isalnum():
        raise InputError(f"case = {case!r}: must be letters, digits, '-' and '_'")
    return case

"""Closes one surface pair of a study again, with the settings of its files and logs, and reports
whether the results are the stored ones.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from jointclosure.engine.cache import is_kept
from jointclosure.inputs import InputError
from jointclosure.storage.files import read_text
from jointclosure.storage.netcdf import reading_netcdf
from studies.commands.compare import differences
from studies.frame.cases import dataset_of
from studies.frame.closing import Ensemble, close_block
from studies.frame.configuration import resolved

_CONFIGURATION = "configuration: "


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    command.add_argument("case", help="name of the case, such as slate-jrc-low")
    command.add_argument("realization", type=int, help="number of the realisation, from 0")
    other = command.add_mutually_exclusive_group()
    for name, what in (("pool", "the pool of common surfaces"), ("finest", "the finest numerics")):
        action = other.add_argument(f"--{name}", action="store_const", const=name, default="cases")
        action.dest, action.help = "ensemble", f"a realisation of {what}"


def run(arguments: argparse.Namespace) -> int:
    """Repeat a realisation; return 1 if it differs from the stored one."""
    results, label, realization = arguments.results, arguments.case, arguments.realization
    name = arguments.ensemble
    log = results / f"logs/close_{Path(dataset_of(name)).stem}.log"
    lines = read_text(log).splitlines() if log.is_file() else []
    keys = [line.partition(_CONFIGURATION)[2] for line in lines if _CONFIGURATION in line]
    if not keys:
        raise InputError(f"{log}: has no configuration; was the study run here?")
    ensemble = Ensemble(resolved(json.loads(keys[0])), name, results)
    block = next((block for block in ensemble.blocks if realization in block), None)
    if label not in ensemble.cases or block is None:
        raise InputError(f"{results}: has no realisation {realization} of {label!r} in {name}")
    entries = {entry.name: entry for entry in ensemble.entries()}
    entry = entries[f"{name}/{label}.{block.start}"]
    (settings,) = entry.settings
    print(f"realisation {realization} of {label}", flush=True)
    alone = settings._replace(first_realization=realization, realizations=1)
    again = close_block(alone, entry.options.get("walls"))
    for key, variable in again.data_vars.items():
        if variable.size <= max(8, again.sizes["cycle"]):
            values = ", ".join(f"{value:.8g}" for value in np.ravel(variable.values))
            print(f"  {key:24} {values} {variable.attrs.get('units', '')}".rstrip())
    if not is_kept(entry, results):
        print("no stored results to compare with")
        return 0
    with reading_netcdf(entry.file(results)) as dataset:
        stored = dataset.sel(realization=[realization]).load()
    messages = differences(stored.drop_attrs(deep=False), again.drop_attrs(deep=False))
    print("\n".join(messages) or "identical to the stored results")
    return 1 if messages else 0

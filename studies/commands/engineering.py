"""Writes a table for each case: closure, normal stiffness and, for a study with flow, apertures
over stress, with mean, median and a band of 90 % over its joints (docs/export.md). No joint is
closed again.
"""

import argparse
from pathlib import Path

from jointclosure.cli.options import add_file, writable
from jointclosure.cli.results import FIGURES
from jointclosure.inputs import InputError
from jointclosure.storage.files import write_csv
from jointclosure.storage.netcdf import reading_netcdf
from studies.commands import study_of
from studies.frame.tables import QUANTILES, band_table


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    what = "name of a case, such as dolerite-base; by default the base case of each rock"
    command.add_argument("--case", nargs="+", action="extend", metavar="NAME", help=what)
    add_file(command, "--output", "default: engineering in the results folder")


def run(arguments: argparse.Namespace) -> int:
    """Write the tables."""
    folder = arguments.output or arguments.results / "engineering"
    with reading_netcdf(study_of(arguments.results)) as study:
        known = study.case.values.tolist()
        asked = arguments.case or study.case.values[study.parameter.values == "base"].tolist()
        for name in asked:
            if name not in known:
                raise InputError(f"--case {name}: must be one of {', '.join(known)}")
        writable((), folder).mkdir(exist_ok=True)
        for name in asked:
            table = band_table(study.sel(case=name).load())
            write_csv(table, folder / f"{name}.csv", FIGURES)
    low, _, high = QUANTILES
    print(f"wrote {folder}: {', '.join(f'{name}.csv' for name in asked)}")
    print(f"bands are the {100 * low:g} and {100 * high:g} % quantiles of the joints")
    return 0

"""`python -m studies engineering`: curves and stiffness of a study, with bands over its joints."""

from pathlib import Path

from jointclosure.cli.exports import FIGURES
from jointclosure.cli.options import check_folder
from jointclosure.inputs import InputError
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import write_csv
from studies.commands import COMMANDS
from studies.commands.finished import study_of
from studies.frame.ensemble.tables import QUANTILES, band_table


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "engineering",
        help=COMMANDS["engineering"],
        description="Writes a table for each case: closure, normal stiffness and, for a study with "
        "flow, apertures over stress, with mean, median and a band of 90 % over its joints "
        "(docs/export.md). No joint is closed again.",
    )
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    command.add_argument(
        "--case",
        nargs="+",
        action="extend",
        metavar="NAME",
        help="name of a case, such as dolerite-base; by default the base case of each rock",
    )
    command.add_argument(
        "--output", type=Path, metavar="FOLDER", help="default: engineering in the results folder"
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Write the tables."""
    folder = arguments.output or arguments.results / "engineering"
    with reading_netcdf(study_of(arguments.results)) as study:
        known = study.case.values.tolist()
        asked = arguments.case or study.case.values[study.parameter.values == "base"].tolist()
        for name in asked:
            if name not in known:
                raise InputError(f"--case {name}: must be one of {', '.join(known)}")
        check_folder(folder)
        folder.mkdir(exist_ok=True)
        for name in asked:
            table = band_table(study.sel(case=name).load())
            write_csv(table, folder / f"{name}.csv", FIGURES)
    low, _, high = QUANTILES
    print(f"wrote {folder}: {', '.join(f'{name}.csv' for name in asked)}")
    print(f"bands are the {100 * low:g} and {100 * high:g} % quantiles of the joints")
    return 0

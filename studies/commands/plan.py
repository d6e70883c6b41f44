"""From a finished study: number of surfaces per case that a precision or a power needs, for each
rock, parameter and cycle, and their time on this machine. Give one goal.
"""

import argparse
import json
from pathlib import Path

from jointclosure.storage.netcdf import read_netcdf, reading_netcdf
from studies.commands import study_of
from studies.frame.tables import CURVES
from studies.paper.planning import GOALS, Goal, plan


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    goals = command.add_mutually_exclusive_group(required=True)
    for kind, text in GOALS.items():
        goals.add_argument(f"--{kind}", type=float, help=text.replace("%", "%%"))
    what = "significance level of the t test (0.05)"
    command.add_argument("--significance", type=float, default=0.05, help=what)
    what = "for a study that closes the same surfaces in all cases (draws: common)"
    command.add_argument("--paired", action="store_true", help=what)


def run(arguments: argparse.Namespace) -> int:
    """Print the plan."""
    amounts = {kind: getattr(arguments, kind.replace("-", "_")) for kind in GOALS}
    (goal,) = (Goal(kind, amount) for kind, amount in amounts.items() if amount is not None)
    source = study_of(arguments.results)
    with reading_netcdf(source) as study:  # pool.nc may be from an earlier configuration
        if json.loads(study.attrs["configuration"])["study"].get("pool") is not None:
            source = arguments.results / "pool.nc"
    dataset = read_netcdf(source, without=CURVES)
    table = plan(dataset, goal, arguments.significance, arguments.paired)
    test = "paired t test, common draws" if arguments.paired else "unpaired t test"
    print(f"{GOALS[goal.kind]}: {goal.amount:g} ({test}); from {source}")
    if table.empty:
        print("no parameter is varied in this study")
        return 0
    shown = dict.fromkeys(("surfaces", "low_68", "high_68", "simulations"), "{:.0f}".format)
    print(table.to_string(index=False, formatters=shown | {"core_minutes": "{:.3g}".format}))
    most = table.loc[table.surfaces.idxmax()]
    print(f"most: {most.surfaces:.0f} surfaces ({most.rock}, {most.parameter}, cycle {most.cycle})")
    return 0

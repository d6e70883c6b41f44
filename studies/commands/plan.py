"""`python -m studies plan`: surfaces that a precision or a power needs, and their cost."""

import json
from pathlib import Path

from jointclosure.engine.aggregation import CURVES
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf
from studies.commands import COMMANDS
from studies.commands.finished import study_of
from studies.paper.planning import GOALS, Goal, plan


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "plan",
        help=COMMANDS["plan"],
        description="From a finished study: number of surfaces per case that a precision or a "
        "power needs, for each rock, parameter and cycle, and their time on this machine. Give "
        "one goal.",
    )
    command.add_argument("results", type=Path, help="results folder, such as results/paper")
    goals = command.add_mutually_exclusive_group(required=True)
    for kind, text in GOALS.items():
        goals.add_argument(f"--{kind}", type=float, help=text.replace("%", "%%"))
    command.add_argument(
        "--significance", type=float, default=0.05, help="significance level of the t test (0.05)"
    )
    command.add_argument(
        "--paired",
        action="store_true",
        help="for a study that closes the same surfaces in all cases (draws: common)",
    )
    command.set_defaults(run=run)


def _has_a_pool(study: Path) -> bool:
    """Return whether a study has a pool; pool.nc may be from an earlier configuration."""
    with reading_netcdf(study) as dataset:
        return json.loads(dataset.attrs["configuration"])["study"].get("pool") is not None


def run(arguments) -> int:
    """Print the plan."""
    (goal,) = [
        Goal(kind, amount)
        for kind in GOALS
        if (amount := getattr(arguments, kind.replace("-", "_"))) is not None
    ]
    study = study_of(arguments.results)
    source = arguments.results / "pool.nc" if _has_a_pool(study) else study
    table = plan(
        read_netcdf(source, without=CURVES), goal, arguments.significance, arguments.paired
    )
    test = "paired t test, common draws" if arguments.paired else "unpaired t test"
    print(f"{GOALS[goal.kind]}: {goal.amount:g} ({test}); from {source}")
    if table.empty:
        print("no parameter is varied in this study")
        return 0
    counts = ("surfaces", "low_68", "high_68", "simulations")
    shown = dict.fromkeys(counts, "{:.0f}".format)
    print(table.to_string(index=False, formatters=shown | {"core_minutes": "{:.3g}".format}))
    most = table.loc[table.surfaces.idxmax()]
    print(f"most: {most.surfaces:.0f} surfaces ({most.rock}, {most.parameter}, cycle {most.cycle})")
    return 0

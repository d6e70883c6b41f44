"""`jointclosure simulate`: close one joint of random walls."""

import argparse
import time
from pathlib import Path

from jointclosure.cli import COMMANDS
from jointclosure.cli.animations import kept_stresses, write_animation
from jointclosure.cli.engineering_files import write_exports
from jointclosure.cli.joint_keys import base_keys, joint_configuration
from jointclosure.cli.joint_options import (
    add_keywords,
    add_load_and_model,
    add_rock,
    check_can_be_made,
    check_destination,
    status_text,
    summary,
)
from jointclosure.engine.progress import closing_bar, duration
from jointclosure.inputs import InputError, check_seed
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.loading import describe_load
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.simulation import close_walls
from jointclosure.storage.figures import save_figure
from jointclosure.storage.folders import replace_files
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.walls.synthesis import wall_pair
from studies.frame.config.configuration import Configured

_PICTURES = (".png", ".pdf", ".svg")

_EXAMPLES = """examples:
  jointclosure simulate --rock dolerite --stress 10
  jointclosure simulate --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 10 --stress 15
  jointclosure simulate --config config/my_rock.yaml --rock granite --picture joint.png
  jointclosure simulate --rock dolerite --jrc 12 --cells 64 --seed 7 --output joint.nc
  jointclosure simulate --rock dolerite --stress 5,0,20,2,30 --animation crushed.gif
  jointclosure simulate --rock slate --without breakage gouge --cycles 1
  jointclosure simulate --rock dolerite --snapshots 1,5,30 --output joint.nc
  jointclosure simulate --rock slate --stress 10 --set numerics.breakage=resolved

Other values are those of the configuration, which explains every key (config/README.md).
"""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "simulate",
        help=COMMANDS["simulate"],
        description="Press two random walls together, release them, and print their closure.\n"
        "The rock is one of a configuration, by its name, or given by its properties.\n"
        "Walls are flat beyond 3 mm, as in the paper's study; those of natural rock have waves of\n"
        "all lengths: --set surface.roll_off_mm=null",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_rock(command)
    joint = command.add_argument_group("joint")
    joint.add_argument(
        "--cells", type=_cells, metavar="N", help="number of cells: 100, or 200x100 (x by y)"
    )
    add_keywords(
        joint,
        wall_pair,
        jrc={"type": float, "metavar": "JRC", "default": None},
        spacing={"type": float, "metavar": "mm", "default": None},
        seed={"type": int, "metavar": "N", "default": 1},
    )
    add_load_and_model(command)
    results = command.add_argument_group("results")
    results.add_argument("--output", type=Path, metavar="FILE.nc", help="netCDF of all steps")
    results.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="closure curve (png, pdf or svg)"
    )
    results.add_argument(
        "--tables",
        type=Path,
        metavar="FOLDER",
        help="curves, stiffness, fitted laws and input of other programs (docs/export.md)",
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Close the joint; return 1 if the simulation failed."""
    check_destination(arguments.output, (".nc",))
    check_destination(arguments.picture, _PICTURES)
    check_destination(arguments.animation, (".gif",))
    if arguments.tables:
        check_can_be_made(arguments.tables)
    if arguments.snapshots and not arguments.output:
        raise InputError("--snapshots: needs --output FILE.nc, which stores them")
    if arguments.picture:  # drawing takes a second to load, and needs an extra
        from jointclosure.plotting.joint import closure_curve
    if arguments.snapshots:
        from jointclosure.plotting.snapshots import snapshot_figure
    settings, conditions = _settings(arguments)
    grid, rock = settings.typed.grid, next(iter(settings.typed.rocks.values()))
    about = (
        f"{rock.title}, JRC {rock.jrc:g}, {grid.cells_x} x {grid.cells_y} cells of "
        f"{1e3 * grid.spacing:g} mm, seed {arguments.seed}"
    )
    print(f"{about}: {describe_load(conditions.max_normal_stress, conditions.cycle_count)}")
    start = time.perf_counter()
    surface = settings.typed.surface._asdict()
    walls = wall_pair(
        rock.jrc, grid.shape, grid.spacing, arguments.seed, **surface, unusual_values=True
    )
    with closing_bar(conditions.cycle_count) as report:
        closed = close_walls(*walls, conditions, report, kept_stresses(arguments, conditions))
    print(summary(closed))
    status = int(closed.status)
    print(f"{status_text(closed)}; {duration(time.perf_counter() - start)}")
    closed.attrs |= {"joint": about} | provenance(settings.keys)
    closed = write_animation(closed, arguments, about)
    if arguments.output:
        write_netcdf(closed, arguments.output)
        print(f"wrote {arguments.output}")
    if arguments.snapshots and closed.sizes["snapshot"]:
        maps = arguments.output.with_suffix(".png")
        save_figure(snapshot_figure(closed, about), maps)
        print(f"wrote {maps}")
    if arguments.picture:
        save_figure(closure_curve(closed, about), arguments.picture)
        print(f"wrote {arguments.picture}")
    if arguments.tables:
        names = replace_files(
            arguments.tables, "simulate", lambda folder: write_exports(closed, folder, about)
        )
        print(f"wrote {arguments.tables}: {', '.join(names) or 'no file'}")
    return 1 if status >= FAILURE else 0


def _settings(arguments) -> tuple[Configured, Conditions]:
    """Return the checked configuration of the arguments."""
    base = base_keys(arguments)
    check_seed("--seed", arguments.seed)
    if base["rocks"].get(arguments.rock, {}).get("walls"):
        raise InputError(f"--rock {arguments.rock}: has scanned walls, must have random ones")
    grid = dict(zip(("cells_x", "cells_y"), arguments.cells or (), strict=False))
    if arguments.spacing is not None:
        grid["spacing_mm"] = arguments.spacing
    return joint_configuration(base, arguments, {}, {"grid": grid})


def _cells(text: str) -> tuple[int, int]:
    numbers = text.lower().split("x")
    if len(numbers) > 2 or not all(number.isdigit() for number in numbers):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number, or two such as 200x100")
    return int(numbers[0]), int(numbers[-1])

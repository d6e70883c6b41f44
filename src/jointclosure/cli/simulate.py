"""`jointclosure simulate`: `jointclosure.simulate` with walls of `jointclosure.wall_pair`."""

import argparse
import time
from pathlib import Path

from jointclosure.cli import COMMANDS
from jointclosure.cli.exports import write_exports
from jointclosure.cli.options import (
    PICTURES,
    add_keywords,
    add_load,
    add_model,
    add_rock,
    check_file,
    check_folder,
    conditions_of,
    jrc_of,
    keywords,
    rock_of,
)
from jointclosure.cli.results import (
    attributes,
    kept_stresses,
    status_text,
    summary,
    write_animation,
)
from jointclosure.engine.progress import closing_bar, duration
from jointclosure.inputs import InputError, check_seed
from jointclosure.joint.conditions import Conditions, describe_load
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.simulation import simulate
from jointclosure.parameters import Numerics
from jointclosure.storage.figures import save_figure
from jointclosure.storage.folders import replace_files
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.walls.synthesis import wall_pair

_EXAMPLES = """examples:
  jointclosure simulate --rock dolerite --stress 10
  jointclosure simulate --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 10 --stress 15
  jointclosure simulate --rock dolerite --jrc 12 --cells 64 --seed 7 --output joint.nc
  jointclosure simulate --rock dolerite --stress 5,0,20,2,30 --animation crushed.gif
  jointclosure simulate --rock slate --without breakage gouge --cycles 1
  jointclosure simulate --rock dolerite --snapshots 1,5,30 --output joint.nc
  jointclosure simulate --rock slate --stress 10 --breakage resolved --picture joint.png
"""
_WALLS = ("hurst", "jrc_relation", "normalise", "correlation", "shift_in_cells",
          "mismatch_wavelength", "rule", "roll_off")  # fmt: skip
"""Keywords of `jointclosure.wall_pair` that have a default."""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "simulate",
        help=COMMANDS["simulate"],
        description="Press two random walls together, release them, and print their closure.\n"
        "The rock is one of the package, by its name, or given by its properties.\n"
        "Walls are flat beyond 3 mm, as in the paper's study; those of natural rock have waves of\n"
        "all lengths: --roll-off none",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_rock(command)
    joint = command.add_argument_group("joint")
    joint.add_argument(
        "--cells",
        type=_shape,
        default=(100, 100),
        metavar="N",
        help="number of cells: 100 (default), or 200x100 (x by y)",
    )
    add_keywords(
        joint, wall_pair, "jrc", *_WALLS, spacing={"default": 0.25e-3}, seed={"default": 1}
    )
    add_load(command, simulate)
    add_model(command, Numerics(), "flow", "unusual_values")
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


def run(arguments: argparse.Namespace) -> int:
    """Close the joint; return 1 if the simulation failed."""
    check_file(arguments.output, (".nc",))
    check_file(arguments.picture, PICTURES)
    check_file(arguments.animation, (".gif",))
    if arguments.tables:
        check_folder(arguments.tables)
    snapshots = getattr(arguments, "snapshots", ())
    if snapshots and not arguments.output:
        raise InputError("--snapshots: needs --output FILE.nc, which stores them")
    if arguments.picture:  # drawing takes a second to load, and needs an extra
        from jointclosure.plotting.joint import closure_curve
    if snapshots:
        from jointclosure.plotting.snapshots import snapshot_figure
    check_seed("--seed", arguments.seed)
    rock = rock_of(arguments, "jrc", "max_normal_stress")
    jrc = jrc_of(arguments, rock)
    stated = conditions_of(arguments, rock, Numerics())
    conditions = Conditions(**stated)
    kept = kept_stresses(arguments, conditions.max_normal_stress)
    conditions.checked(kept)
    about = {"jrc": jrc, "shape": arguments.cells, "seed": arguments.seed}
    about |= {"spacing": conditions.spacing, "unusual_values": conditions.unusual_values}
    about |= keywords(arguments, _WALLS)
    walls = wall_pair(**about)
    ny, nx = arguments.cells
    title = (
        f"{rock.title}, JRC {jrc:g}, {nx} x {ny} cells of {1e3 * conditions.grid_spacing:g} mm, "
        f"seed {arguments.seed}"
    )
    print(f"{title}: {describe_load(conditions.max_normal_stress, conditions.cycle_count)}")
    start = time.perf_counter()
    with closing_bar(conditions.cycle_count) as report:
        closed = simulate(*walls, conditions=conditions, report=report, snapshots=kept)
    print(summary(closed))
    print(f"{status_text(closed)}; {duration(time.perf_counter() - start)}")
    closed.attrs |= {"joint": title} | attributes(about | stated)
    closed = write_animation(closed, arguments, title)
    if arguments.output:
        write_netcdf(closed, arguments.output)
        print(f"wrote {arguments.output}")
    if snapshots and closed.sizes["snapshot"]:
        maps = arguments.output.with_suffix(".png")
        save_figure(snapshot_figure(closed, title), maps)
        print(f"wrote {maps}")
    if arguments.picture:
        save_figure(closure_curve(closed, title), arguments.picture)
        print(f"wrote {arguments.picture}")
    if arguments.tables:
        names = replace_files(
            arguments.tables, "simulate", lambda folder: write_exports(closed, folder, title)
        )
        print(f"wrote {arguments.tables}: {', '.join(names) or 'no file'}")
    return 1 if int(closed.status) >= FAILURE else 0


def _shape(text: str) -> tuple[int, int]:
    """Read the number of cells (y, x)."""
    parts = text.lower().split("x")
    if len(parts) > 2 or not all(part.isdigit() for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number, or two such as 200x100")
    return int(parts[-1]), int(parts[0])

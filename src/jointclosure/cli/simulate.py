"""Simulate a joint of two random walls under load cycles, and print its results.
The rock is given by the name of a rock of the package, or by its properties.
The walls have a roll-off of 3 mm, as in the paper's study. Walls of natural rock have waves of
all lengths: --roll-off none

examples:
  jointclosure simulate --rock dolerite --stress 10
  jointclosure simulate --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 10 --stress 15
  jointclosure simulate --rock dolerite --jrc 12 --cells 64 --seed 7 --output joint.nc
  jointclosure simulate --rock dolerite --stress 5,0,20,2,30 --animation crushed.gif
  jointclosure simulate --rock slate --without breakage gouge --cycles 1
  jointclosure simulate --rock dolerite --snapshots 1,5,30 --output joint.nc
  jointclosure simulate --rock slate --stress 10 --breakage resolved --picture joint.png
"""

import argparse
import inspect
from typing import Any

from jointclosure.cli import command_results, options
from jointclosure.execution.progress import duration, load_cycle_bar, seconds_of_process
from jointclosure.inputs import InputError
from jointclosure.joint.checked_conditions import check_named_stresses
from jointclosure.joint.conditions import (
    Conditions,
    conditions_from,
)
from jointclosure.joint.history import history_of
from jointclosure.joint.laws import check_joint_lengths, laws_of_joint
from jointclosure.joint.result_tables import stress_table
from jointclosure.joint.simulation import simulate_as_checked
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.parameters import Numerics
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.synthesis import wall_pair

_WALLS = ("jrc", "hurst", "jrc_relation", "normalise", "correlation", "shift_in_cells",
          "mismatch_wavelength", "rule", "roll_off")  # fmt: skip


def declare(command: argparse.ArgumentParser) -> None:
    joint = command.add_argument_group("joint")
    cells = {"default": (100, 100), "help": "number of cells: 100 (default), or 200x100 (x by y)"}
    usual: Any = {"shape": cells, "spacing": {"default": 0.25e-3}, "seed": {"default": 1}}
    options.add_keywords(joint, wall_pair, *_WALLS, **usual)
    options.add_conditions(command, Numerics())
    files = command.add_argument_group("results")
    options.add_file_option(files, "--output", "netCDF of all steps", ".nc")
    options.add_file_option(
        files, "--picture", "closure curve (png, pdf or svg)", *options.PICTURES
    )
    text = "curves, stiffness, fitted laws and input of other programs (docs/export.md)"
    options.add_file_option(files, "--tables", text)
    options.add_export_cycle(files)


def run(arguments: argparse.Namespace) -> int:
    """Simulate the joint, print its results, write requested files; return 1 if it failed."""
    snapshots = arguments.snapshots
    if snapshots and not arguments.output:
        raise InputError("--snapshots: needs --output FILE.nc, which stores them")
    if snapshots or arguments.picture:  # drawing takes a second to load, and needs an extra
        from jointclosure.plotting.joint import closure_curve
        from jointclosure.plotting.snapshots import snapshot_figure
    rock, stated = options.keywords(arguments, Conditions, Numerics(), "jrc", "max_normal_stress")
    about = options.given(arguments, inspect.signature(wall_pair).parameters)
    about["jrc"] = jrc = stated.pop("jrc")
    conditions = conditions_from(None, stated, "simulate", "spacing")
    kept = command_results.kept_stresses(
        snapshots, arguments.animation, conditions.max_normal_stress
    )
    checked = checked_as_stated(conditions, kept)
    options.check_export_cycle(arguments.export_cycle, checked.load)
    check_named_stresses(arguments.at, checked)
    lengths = options.given(arguments, ("joint_length", "lab_length"))
    check_joint_lengths(**lengths)
    walls = wall_pair(**about)
    grid = grid_text(arguments.shape, checked.grid_spacing)
    title = f"{rock.title}, JRC {jrc:g}, {grid}, seed {arguments.seed}"
    print(f"{title}: {checked.load.description()}")
    with load_cycle_bar(checked.cycle_count) as report:
        closed = simulate_as_checked(*walls, checked, report, kept)
    strength = rock.intact.compressive_strength
    cycles = checked.cycle_count
    seating = closed.attrs["seating_stress_Pa"]
    laws = laws_of_joint(jrc, strength, seating, cycles, **lengths)
    curves = stress_table(closed, history_of(closed).table_levels(arguments.at))
    print(command_results.summary(closed, laws, curves, at=arguments.at)[0])
    status, *remedies = command_results.status_lines(closed)
    spent = duration(seconds_of_process())
    print(f"{status}; {spent} since the program started", *remedies, sep="\n")
    closed.attrs |= {"joint": title} | command_results.attributes(about | stated)
    closed = command_results.write_animation(closed, arguments, title)
    files: dict[Any, Any] = {arguments.output: closed}
    if snapshots and closed.sizes["snapshot"]:
        files[arguments.output.with_suffix(".png")] = snapshot_figure(closed, title)
    if arguments.picture:
        files[arguments.picture] = closure_curve(closed, title)
    for path in filter(None, files):
        command_results.write(files[path], path)
        print(f"wrote {path}")
    if arguments.tables:
        exported = command_results.exported(closed, title, curves, laws, arguments.export_cycle)
        print(command_results.write_folder(arguments.tables, "simulate", exported.files))
    return int(command_results.failed(closed))

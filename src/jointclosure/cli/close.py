"""Register two scanned walls and simulate the joint under load cycles.
Prints a description of the scans, the registration of the walls, and the results with ranges.

examples:
  jointclosure close top.xyz bottom.xyz --units mm --rock granite
  jointclosure close top.stl bottom.stl --units mm --rock granite --stress 5 --cycles 3
  jointclosure close aperture.asc flat --orientation common_frame --units mm --rock granite
  jointclosure close top.csv bottom.csv --units mm --youngs-modulus 60 --poisson-ratio 0.22 \\
      --strength 180 --stress 15 --spacing 0.5 --output my_joint

docs/two_scans.md is a tutorial.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jointclosure.cli import command_results, options
from jointclosure.execution.progress import duration, seconds_of_process
from jointclosure.exports.loading import Exported, loading_text
from jointclosure.inputs import InputError, did_you_mean
from jointclosure.inputs.remarks import cautions
from jointclosure.joint.load import stated_load
from jointclosure.joint.result_tables import cycle_table
from jointclosure.joint.rocks import rock_record
from jointclosure.parameters import RESOLVED
from jointclosure.parameters.units import to_si
from jointclosure.uncertainty.scanned_joint import ClosedJoint, close
from jointclosure.uncertainty.sources import VARIED
from jointclosure.walls.gridding import FLAT
from jointclosure.walls.scans import file_digest


def declare(command: argparse.ArgumentParser) -> None:
    options.add_walls(command)
    options.add_conditions(command, RESOLVED)
    range_group = command.add_argument_group("range of the results")
    what = (
        "range in which a property of the rock lies, or peak_modulus_ratio, base_radius_in_cells "
        "or spacing_mm, such as: --range compressive_strength_MPa 140 200"
    )
    range_group.add_argument("--range", nargs=3, action="append", default=[], help=what,
                             metavar=("KEY", "LOW", "HIGH"))  # fmt: skip
    options.add_keywords(range_group, close, "single", "workers")
    text = "folder of the results (default closed_joint)"
    files = command.add_argument_group("results")
    options.add_file_option(files, "--output", text, default="closed_joint")
    options.add_export_cycle(files)


def run(arguments: argparse.Namespace) -> int:
    """Simulate the joint, print its results and write its folder; return 1 if it failed."""
    from jointclosure.plotting import walls  # noqa: F401  an extra that may be missing

    rock, stated = options.keywords(arguments, close, RESOLVED, "max_normal_stress")
    stated["ranges"] = _ranges(arguments.range)
    asked = stated.pop("snapshots")
    stress = stated["max_normal_stress"]
    load = stated_load(stress, stated.get("cycles"))
    options.check_export_cycle(arguments.export_cycle, load)
    kept = command_results.kept_stresses(asked, arguments.animation, stress)
    joint = close(**stated, snapshots=kept, rock_name=rock.title, progress=True)
    curves = joint.curves
    at = stated["at"]
    text, answer = command_results.summary(joint.history, joint.laws, curves, joint.budget, at)
    print(text)
    scans = {"upper": arguments.upper, "lower": arguments.lower}
    title = " on ".join(Path(scan).name for scan in scans.values())
    joint = joint._replace(history=command_results.write_animation(joint.history, arguments, title))
    about = command_results.attributes(stated)
    cycle = arguments.export_cycle
    without_heading = joint.budget is not None
    exported = command_results.exported(
        joint.history, title, curves, joint.laws, cycle, without_heading
    )
    files = _files(joint, scans, about, title, answer, exported, cycle)
    wrote = command_results.write_folder(arguments.output, "close", files)
    warned = len(files["joint.json"]["warnings"])
    above = f"; warnings above: {warned}" if warned else ""
    spent = duration(seconds_of_process())
    status, *remedies = command_results.status_lines(joint.history)
    print(f"{status}; {spent} since the program started{above}", *remedies, wrote, sep="\n")
    return int(command_results.failed(joint.history))


def _ranges(stated: list[list[str]]) -> dict[str, tuple[float, float]]:
    """Return the ranges (low, high) [SI] of the options --range, by the name of what varies.

    ``stated`` has key, low and high of each as texts. Raise one `InputError` that lists all wrong
    options.
    """
    ranges: dict[str, tuple[float, float]] = {}
    problems = []
    for key, *ends in stated:
        try:
            name, low, high = _range(key, ends)
        except InputError as error:
            problems.append(str(error))
            continue
        if name in ranges:
            problems.append(f"--range {key}: must be given once")
        ranges[name] = low, high
    options.refuse(problems)
    return ranges


def _range(key: str, ends: Sequence[str]) -> tuple[str, float, float]:
    """Return the name, lower and upper end [SI] of one range, from its key and ends as texts.

    Raise `InputError` if the ends are no numbers, or if the key cannot have a range.
    """
    try:
        values = [float(end) for end in ends]
    except ValueError:
        raise InputError(f"--range {key} {' '.join(ends)}: must end in two numbers") from None
    if key not in VARIED.values():
        known = ", ".join(VARIED.values())
        meant = did_you_mean(key, VARIED.values())
        raise InputError(f"--range {key}: must be one of {known}{meant}")
    ((name, (low, high)),) = to_si({key: values}).items()
    return name, low, high


def _files(
    joint: ClosedJoint,
    scans: dict[str, str],
    about: dict[str, str],
    title: str,
    answer: dict,
    exported: Exported,
    cycle: int,
) -> dict[str, Any]:
    """Return the contents of the files of a joint's folder, by the names of the files.

    They are the history, the record (joint.json), the figures, and the files for other programs,
    which are ``exported`` with the constants of a ``cycle``. ``scans`` are the paths of the scans
    by side, ``about`` is the provenance, and ``answer`` is that of `command_results.summary`.
    """
    from jointclosure.plotting.joint import closure_curve, range_figure
    from jointclosure.plotting.snapshots import snapshot_figure
    from jointclosure.plotting.walls import pair_figure

    history = joint.history
    budget = joint.budget
    digests = {side: file_digest(scan) for side, scan in scans.items() if scan != FLAT}
    files: dict[str, Any] = {
        "joint.nc": history.assign_attrs(about),
        "joint.json": _record(joint, title, answer, exported, cycle)
        | {"sha256": digests, "provenance": about},
        "walls.png": pair_figure(joint.pair, title),
        "closure.png": closure_curve(history, title, budget and budget.ranges),
    }
    if budget is not None:
        files |= {"range.csv": budget.results, "range.png": range_figure(budget, title)}
    if history.sizes.get("snapshot"):
        files["snapshots.png"] = snapshot_figure(history, title)
    return files | exported.files


def _record(
    joint: ClosedJoint, title: str, answer: dict[str, Any], exported: Exported, cycle: int
) -> dict[str, Any]:
    """Return the content of joint.json: results of a joint by names that end in their units.

    Arguments are as for `_files`.
    """
    pair = joint.pair
    history = joint.history
    budget = joint.budget
    laws = joint.laws
    values = command_results.law_values(history, laws)
    cycles = cycle_table(history).drop(columns="cycle")
    for name in ("residual_closure", "max_bulk_indentation"):
        cycles[f"{name}_mm"] = 1e3 * history[name].values[: len(cycles)]
    return {
        "title": title,
        "joint": repr(joint),
        "description": joint.description,
        "rock": rock_record(joint.conditions.rock, joint.rock_name),
        "status": command_results.status_text(history),
        "found": pair.remarks,
        "warnings": cautions([*pair.remarks, *answer["remarks"], *exported.remarks]),
        "cells_y_x": list(pair.upper.shape),
        "spacing_mm": 1e3 * pair.spacing,
        "orientation": pair.orientation,
        "slope_correlation": {fit.orientation: fit.correlation for fit in pair.fits},
        "motion": pair.motion.record(),
        "best_fit": pair.mated and pair.mated.record(),
        "correlation": pair.correlation,
        "mating": {
            "wavelength_mm": (1e3 * pair.mating.wavelengths).tolist(),
            "correlation": pair.mating.correlation.tolist(),
        },
        "mismatch_wavelength_mm": command_results.scaled(pair.mismatch, 1e3),
        "mean_aperture_at_first_touch_mm": 1e3 * float(pair.aperture.mean()),
        "first_touch_y_x": list(pair.first_touch_cell),
        "per_cycle": {name: command_results.plain(column) for name, column in cycles.items()},
        "barton_bandis": laws.record() | {"results": values},
        "range": budget.record() if budget else [],
        "exports": exported.remarks,
        "exports_of": "" if command_results.failed(history) else loading_text(history, cycle),
        **answer,
    }

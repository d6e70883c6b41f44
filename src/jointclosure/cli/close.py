"""`jointclosure close`: `jointclosure.close` with files, and a folder of results."""

import argparse
import json
import time
from pathlib import Path
from typing import Any

from jointclosure.cli import COMMANDS
from jointclosure.cli.exports import write_exports
from jointclosure.cli.options import (
    add_keywords,
    add_load,
    add_model,
    add_rock,
    check_file,
    check_folder,
    conditions_of,
    keywords,
    rock_of,
)
from jointclosure.cli.results import (
    attributes,
    finite,
    kept_stresses,
    status_text,
    summary,
    write_animation,
)
from jointclosure.engine.progress import duration
from jointclosure.engine.scanned_joint import RESOLVED, ClosedJoint, close
from jointclosure.engine.uncertainty import VARIED
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import cautions
from jointclosure.joint.curves import cycle_table
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.rocks import rock_record
from jointclosure.joint.simulation import simulate
from jointclosure.parameters.units import to_si
from jointclosure.storage.figures import save_figure
from jointclosure.storage.folders import replace_files
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.text import write_csv, write_text
from jointclosure.walls.measured import FLAT
from jointclosure.walls.registration import registered
from jointclosure.walls.scans import file_digest

_WALL = "scan of the {} wall; x.txt,y.txt,z.txt for matrices in three files; or flat"
_EXAMPLES = """examples:
  jointclosure close top.xyz bottom.xyz --units mm --rock granite
  jointclosure close top.stl bottom.stl --units mm --rock granite --stress 5 --cycles 3
  jointclosure close aperture.asc flat --orientation common_frame --units mm --rock granite
  jointclosure close top.csv bottom.csv --units mm --youngs-modulus 60 --poisson-ratio 0.22 \\
      --strength 180 --stress 15 --grid-spacing 0.5 --output my_joint

docs/two_scans.md is a tutorial.
"""
_SCANS = ("units", "scan_spacing", "variable", "orientation", "shift", "single")
"""Keywords of `jointclosure.close` that are no conditions."""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "close",
        help=COMMANDS["close"],
        description="Register two scanned walls, press them together and release them.\n"
        "Prints a description of the scans, the fit of the walls, and their closure.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for wall in ("upper", "lower"):
        command.add_argument(wall, help=_WALL.format(wall))
    scans = command.add_argument_group("scans")
    add_keywords(scans, close, "units", scan_spacing={"option": "--spacing"}, variable={})
    spikes = {"option": "--spikes", "choices": ("keep", "cut"), "default": "cut"}
    add_keywords(scans, registered, cut_spikes=spikes)
    joint = command.add_argument_group("joint")
    add_keywords(joint, registered, spacing={"option": "--grid-spacing"}, orientation={}, shift={})
    add_rock(command)
    add_load(command, simulate)
    add_model(command, RESOLVED, "flow", "unusual_values")
    known = command.add_argument_group("range of the results")
    known.add_argument(
        "--range",
        nargs=3,
        action="append",
        default=[],
        metavar=("KEY", "LOW", "HIGH"),
        help="what is known of a property of the rock, of peak_modulus_ratio, "
        "base_radius_in_cells or spacing_mm, such as: --range compressive_strength_MPa 140 200",
    )
    add_keywords(known, close, "single")
    command.add_argument(
        "--output",
        type=Path,
        default=Path("closed_joint"),
        metavar="FOLDER",
        help="folder of the results (default closed_joint)",
    )
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Close the joint and write its folder; return 1 if the simulation failed."""
    import jointclosure.plotting.walls  # noqa: F401  an extra that may be missing

    start = time.perf_counter()
    check_file(arguments.animation, (".gif",))
    check_folder(arguments.output)
    if arguments.single and arguments.range:
        raise InputError("--range: must be left out with --single")
    rock = rock_of(arguments, "max_normal_stress")
    stated = conditions_of(arguments, rock, RESOLVED) | keywords(arguments, _SCANS)
    stated |= {"cut_spikes": arguments.cut_spikes == "cut", "ranges": _ranges(arguments.range)}
    walls = arguments.upper, arguments.lower
    joint = close(
        *walls,
        **stated,
        snapshots=kept_stresses(arguments, stated["max_normal_stress"]),
        rock_name=rock.title,
        progress=True,
    )
    print(summary(joint.history, joint.budget))
    title = " on ".join(Path(wall).name for wall in walls)
    joint = joint._replace(history=write_animation(joint.history, arguments, title))
    settings = {"upper": walls[0], "lower": walls[1], **stated}
    names = replace_files(
        arguments.output, "close", lambda folder: _write(joint, settings, folder, title)
    )
    warned = len(cautions(joint.pair.report))
    above = f"; warnings above: {warned}" if warned else ""
    spent = duration(time.perf_counter() - start)
    print(f"{status_text(joint.history)}; {spent} in all{above}")
    print(f"wrote {arguments.output}: {', '.join(names)}")
    return 1 if int(joint.history.status) >= FAILURE else 0


def _ranges(stated: list[list[str]]) -> dict[str, tuple[float, float]]:
    """Return the stated ranges [SI] by name."""
    ranges: dict[str, tuple[float, float]] = {}
    for key, *ends in stated:
        try:
            values = [float(end) for end in ends]
        except ValueError:
            raise InputError(f"--range {key} {' '.join(ends)}: must end in two numbers") from None
        if key not in VARIED.values():
            raise InputError(f"--range {key}: must be one of {', '.join(VARIED.values())}")
        ((name, (low, high)),) = to_si({key: values}).items()
        if name in ranges:
            raise InputError(f"--range {key}: must be given once")
        ranges[name] = low, high
    return ranges


def _write(joint: ClosedJoint, settings: dict[str, Any], folder: Path, title: str) -> None:
    """Write all files of a joint: its history, registration, exports and figures."""
    from jointclosure.plotting.joint import closure_curve
    from jointclosure.plotting.snapshots import snapshot_figure
    from jointclosure.plotting.walls import pair_figure, range_figure

    about, history = attributes(settings), joint.history
    write_netcdf(history.assign_attrs(about), folder / "joint.nc")
    scans = {side: settings[side] for side in ("upper", "lower") if settings[side] != FLAT}
    record = _record(joint, title)
    record |= {"sha256": {side: file_digest(scan) for side, scan in scans.items()}}
    write_text(json.dumps(record | {"provenance": about}, indent=1) + "\n", folder / "joint.json")
    write_exports(history, folder, title)
    save_figure(pair_figure(joint.pair, title), folder / "walls.png")
    ranges = None if joint.budget is None else joint.budget.ranges
    save_figure(closure_curve(history, title, ranges), folder / "closure.png")
    if joint.budget is not None:
        write_csv(joint.budget.results, folder / "range.csv")
        save_figure(range_figure(joint.budget, title), folder / "range.png")
    if history.sizes.get("snapshot"):
        save_figure(snapshot_figure(history, title), folder / "snapshots.png")


def _record(joint: ClosedJoint, title: str) -> dict[str, Any]:
    """Return the results with units in their names."""
    pair, history = joint.pair, joint.history
    cycles = cycle_table(history).drop(columns="cycle")
    per_cycle = {name: finite(values) for name, values in cycles.items()}
    for name in ("residual_closure", "max_bulk_indentation"):
        per_cycle[f"{name}_mm"] = finite(history[name].values, 1e3)
    mismatch = zip(pair.mismatch._fields, finite(pair.mismatch, 1e3), strict=True)
    return {
        "title": title,
        "joint": repr(joint),
        "rock": rock_record(joint.conditions.rock, joint.rock_name),
        "status": status_text(history),
        "found": pair.report,
        "warnings": cautions(pair.report),
        "cells_y_x": list(pair.upper.shape),
        "spacing_mm": 1e3 * pair.spacing,
        "orientation": pair.orientation,
        "slope_correlation": {fit.orientation: fit.correlation for fit in pair.fits},
        "shift_mm_y_x": finite(pair.shift, 1e3),
        "mating_shift_mm_y_x": finite(pair.mating_shift, 1e3),
        "correlation": pair.correlation,
        "mating": {
            "wavelength_mm": (1e3 * pair.mating.wavelengths).tolist(),
            "correlation": pair.mating.correlation.tolist(),
        },
        "mismatch_wavelength_mm": dict(mismatch),
        "mean_aperture_at_first_touch_mm": 1e3 * float(pair.aperture.mean()),
        "first_touch_y_x": list(pair.first_touch),
        "per_cycle": per_cycle,
        "range": [] if joint.budget is None else joint.budget.record(),
        "about_range": [] if joint.budget is None else joint.budget.sentences(),
    }

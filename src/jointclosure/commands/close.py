"""`jointclosure close`: close the joint whose two walls were scanned."""

import argparse
import json
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from jointclosure.commands import COMMANDS
from jointclosure.commands.animations import kept_stresses, write_animation
from jointclosure.commands.engineering_files import write_exports
from jointclosure.commands.joint_options import (
    NEEDED,
    add_load_and_model,
    add_rock,
    base_keys,
    check_can_be_made,
    check_destination,
    joint_configuration,
    loaded,
    resolved_breakage,
    shown_progress,
    status_text,
    summary,
)
from jointclosure.config.configuration import Configured
from jointclosure.config.units import to_si
from jointclosure.engineering.curves import cycle_table
from jointclosure.ensemble.cases import cases_of
from jointclosure.ensemble.expected_cost import check_cells, expected_cost
from jointclosure.ensemble.measured_walls import brought_together
from jointclosure.ensemble.scanned_joint import (
    ClosedJoint,
    closed_pair,
    read_wall,
    with_range,
)
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.uncertainty import VARIED
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import cautions
from jointclosure.jobs.progress import bar, duration
from jointclosure.joint.loading import describe_load
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.rocks import rock_record, rock_text
from jointclosure.scans.units import UNITS
from jointclosure.storage.figures import save_figure
from jointclosure.storage.folders import replace_files
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_csv, write_text
from jointclosure.surface.measured import PAPER_SPACING
from jointclosure.surface.mismatch import Mismatch
from jointclosure.surface.registration import ORIENTATIONS, SHIFTS, RegisteredPair

_WALL = "scan of the {} wall; x.txt,y.txt,z.txt for matrices in three files; or flat"
_EXAMPLES = """examples:
  jointclosure close top.xyz bottom.xyz --units mm --rock granite
  jointclosure close top.stl bottom.stl --units mm --rock granite --stress 5 --cycles 3
  jointclosure close aperture.asc flat --orientation common_frame --units mm --rock granite
  jointclosure close top.csv bottom.csv --units mm --youngs-modulus 60 --poisson-ratio 0.22 \\
      --strength 180 --stress 15 --grid-spacing 0.5 --output my_joint

Other values are those of the configuration (config/README.md). docs/own_joint.md is a tutorial.
"""


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
    command.add_argument("upper", type=Path, help=_WALL.format("upper"))
    command.add_argument("lower", type=Path, help=_WALL.format("lower"))
    scans = command.add_argument_group("scans")
    scans.add_argument(
        "--units", choices=list(UNITS), help="units of the scans, if the files do not state them"
    )
    scans.add_argument(
        "--spacing",
        type=float,
        metavar="mm",
        help="spacing of the scans, if the files do not state it",
    )
    scans.add_argument(
        "--variable",
        help="name of the array or channel, if a file has several; columns of a text file",
    )
    scans.add_argument(
        "--spikes",
        choices=("keep", "cut"),
        default="cut",
        help="points that differ from all but one of their neighbours (default: cut)",
    )
    joint = command.add_argument_group("joint")
    joint.add_argument(
        "--grid-spacing",
        type=float,
        metavar="mm",
        help="grid spacing of the joint; by default the larger point distance of the scans, or the "
        f"multiple of it that is nearest to {1e3 * PAPER_SPACING:g} mm",
    )
    joint.add_argument(
        "--orientation",
        choices=list(ORIENTATIONS),
        help="orientation of the upper scan in the frame of the lower one; by default the one "
        "that fits best, if it is clear",
    )
    joint.add_argument(
        "--shift",
        choices=SHIFTS,
        help="leave the walls as scanned, or move the upper one to the position of best fit; by "
        "default scanned if both scans are in one frame, otherwise mated",
    )
    add_rock(command)
    add_load_and_model(command)
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
    known.add_argument(
        "--single", action="store_true", help="close the joint once, without a range"
    )
    results = command.add_argument_group("results")
    results.add_argument(
        "--output",
        type=Path,
        default=Path("closed_joint"),
        metavar="FOLDER",
        help="folder of the results (default closed_joint)",
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Close the joint and write its folder; return 1 if the simulation failed."""
    import jointclosure.plotting.scanned_joint  # noqa: F401  an extra that may be missing

    start = time.perf_counter()
    check_destination(arguments.animation, (".gif",))
    check_can_be_made(arguments.output)
    if arguments.single and arguments.range:
        raise InputError("--range: must be left out with --single")
    ranges = _ranges(arguments.range)
    settings = _settings(arguments)
    pair = _pair(arguments, settings)
    print("\n".join(f"- {line}" for line in pair.report))
    joint = _closed(settings, pair, arguments, ranges)
    if not arguments.single:
        with bar("range") as report:
            joint = with_range(joint, ranges, report)
    print(summary(joint.history, joint.budget))
    title = f"{arguments.upper.name} on {arguments.lower.name}"
    joint = joint._replace(history=write_animation(joint.history, arguments, title))
    names = replace_files(
        arguments.output, "close", lambda folder: _write(joint, settings, folder, title)
    )
    warned = len(cautions(pair.report))
    above = f"; warnings above: {warned}" if warned else ""
    spent = duration(time.perf_counter() - start)
    print(f"{status_text(joint.history)}; {spent} in all{above}")
    print(f"wrote {arguments.output}: {', '.join(names)}")
    return 1 if int(joint.history.status) >= FAILURE else 0


def _settings(arguments) -> Configured:
    """Return the checked configuration of the arguments, with a rock that has these walls."""
    walls = {
        "upper": str(arguments.upper),
        "lower": str(arguments.lower),
        "units": arguments.units,
        "spacing_mm": arguments.spacing,
        "variable": arguments.variable,
        "missing": "refuse",
        "inverted": [],
        "bring_together": True,
        "orientation": arguments.orientation,
        "shift": arguments.shift,
        "spikes": arguments.spikes,
    }
    grid = {} if arguments.grid_spacing is None else {"spacing_mm": arguments.grid_spacing}
    needed = tuple(option for option in NEEDED if option != "jrc")
    rock = {"jrc": None, "walls": walls}
    base = base_keys(arguments)
    changes = {"grid": grid, "surface": {"roll_off_mm": None}, **resolved_breakage(base, arguments)}
    return joint_configuration(base, arguments, rock, changes, needed)


def _ranges(stated: list[list[str]]) -> dict[str, tuple[float, float]]:
    """Return the stated ranges [SI] by name."""
    ranges = {}
    for key, *ends in stated:
        try:
            values = [float(end) for end in ends]
        except ValueError:
            raise InputError(f"--range {key} {' '.join(ends)}: must end in two numbers") from None
        if key not in VARIED.values():
            raise InputError(f"--range {key}: must be one of {', '.join(VARIED.values())}")
        ((name, values),) = to_si({key: values}).items()
        ranges[name] = tuple(values)
    return ranges


def _pair(arguments, settings: Configured) -> RegisteredPair:
    """Read the scans and register them as configured."""
    walls = next(iter(settings.typed.rocks.values())).walls
    assert walls is not None  # set from the arguments
    spacing = None if arguments.grid_spacing is None else 1e-3 * arguments.grid_spacing
    upper, lower = (
        read_wall(path, walls.units, walls.spacing, walls.variable)
        for path in (walls.upper, walls.lower)
    )
    allowed = settings.typed.study.unusual_values == "allow"
    return brought_together(upper, lower, walls, spacing, allowed)


def _closed(
    settings: Configured,
    pair: RegisteredPair,
    arguments,
    ranges: dict[str, tuple[float, float]],
) -> ClosedJoint:
    configuration = settings.typed
    case = cases_of(configuration)[0]
    surfaces = surface_settings(configuration, case, range(1))
    conditions = loaded(closure_settings(configuration, case, surfaces).conditions(), arguments)
    ny, nx = pair.upper.shape
    name = configuration.rocks[case.rock].title
    print(
        f"{rock_text(conditions.rock, name)}; {nx} x {ny} cells of {1e3 * pair.spacing:.4g} mm: "
        f"{describe_load(conditions.max_normal_stress, conditions.cycle_count)}"
    )
    check_cells(pair.upper.shape, pair.spacing, arguments.grid_spacing is not None)
    of_pair = conditions._replace(spacing=pair.spacing)
    cost = expected_cost(pair.upper, pair.lower, of_pair, arguments.single, ranges)
    if cost is not None:
        print(f"- {cost.sentence(pair.upper.shape, pair.spacing)}", flush=True)
    with shown_progress(conditions.cycle_count) as report:
        stresses = kept_stresses(arguments, conditions)
        return closed_pair(pair, conditions, report, stresses, rock_name=name)


def _write(joint: ClosedJoint, settings: Configured, folder: Path, title: str) -> None:
    """Write all files of a joint: its history, registration, exports and figures."""
    from jointclosure.plotting.joint import closure_curve
    from jointclosure.plotting.scanned_joint import pair_figure, range_figure
    from jointclosure.plotting.snapshots import snapshot_figure

    about, history = provenance(settings.keys), joint.history
    write_netcdf(history.assign_attrs(about), folder / "joint.nc")
    record = _record(joint, settings, about, title)
    write_text(json.dumps(record, indent=1) + "\n", folder / "joint.json")
    write_exports(history, folder, title)
    save_figure(pair_figure(joint.pair, title), folder / "walls.png")
    ranges = None if joint.budget is None else joint.budget.ranges
    save_figure(closure_curve(history, title, ranges), folder / "closure.png")
    if joint.budget is not None:
        write_csv(joint.budget.results, folder / "range.csv")
        save_figure(range_figure(joint.budget, title), folder / "range.png")
    if history.sizes.get("snapshot"):
        save_figure(snapshot_figure(history, title), folder / "snapshots.png")


def _record(joint: ClosedJoint, settings: Configured, about: dict[str, str], title: str) -> dict:
    """Return the results with units in their names, and their provenance."""
    pair, history = joint.pair, joint.history
    case = cases_of(settings.typed)[0]
    surfaces = surface_settings(settings.typed, case, range(1))
    per_cycle = {
        name: _finite(values) for name, values in cycle_table(history).items() if name != "cycle"
    } | {
        f"{name}_mm": _finite(1e3 * history[name].values)
        for name in ("residual_closure", "max_bulk_indentation")
    }
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
        "shift_mm_y_x": [1e3 * part for part in pair.shift],
        "mating_shift_mm_y_x": [1e3 * part for part in pair.mating_shift],
        "correlation": pair.correlation,
        "mating": {
            "wavelength_mm": (1e3 * pair.mating.wavelengths).tolist(),
            "correlation": pair.mating.correlation.tolist(),
        },
        "mismatch_wavelength_mm": _interval_mm(pair.mismatch),
        "mean_aperture_at_first_touch_mm": 1e3 * float(pair.aperture.mean()),
        "first_touch_y_x": list(pair.first_touch),
        "per_cycle": per_cycle,
        "range": [] if joint.budget is None else joint.budget.record(),
        "about_range": [] if joint.budget is None else joint.budget.sentences(),
        "sha256": surfaces.sha256,
        "provenance": about,
    }


def _finite(values: Iterable[float]) -> list[float | None]:
    """Return numbers for JSON, with null for numbers that are not finite."""
    return [float(value) if np.isfinite(value) else None for value in values]


def _interval_mm(mismatch: Mismatch) -> dict[str, float | None]:
    """Return a mismatch wavelength and its interval [mm]."""
    return dict(zip(mismatch._fields, _finite(1e3 * value for value in mismatch), strict=True))

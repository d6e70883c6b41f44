"""`jointclosure close`: `jointclosure.close` with files, and a folder of results."""

import argparse
import json
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from jointclosure.cli import COMMANDS
from jointclosure.cli.animations import kept_stresses, write_animation
from jointclosure.cli.engineering_files import write_exports
from jointclosure.cli.joint_keys import base_keys, joint_configuration, resolved_breakage
from jointclosure.cli.joint_options import (
    NEEDED,
    add_keywords,
    add_load_and_model,
    add_rock,
    add_scans,
    check_can_be_made,
    check_destination,
    status_text,
    summary,
)
from jointclosure.engine.progress import duration
from jointclosure.engine.scanned_joint import ClosedJoint, close
from jointclosure.engine.uncertainty import VARIED
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import cautions
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.curves import cycle_table
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.rocks import rock_record
from jointclosure.parameters.units import to_si
from jointclosure.storage.figures import save_figure
from jointclosure.storage.folders import replace_files
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_csv, write_text
from jointclosure.walls.registration import ORIENTATIONS, SHIFTS, registered
from studies.frame.config.configuration import Configured
from studies.frame.ensemble.slices import wall_digests

_WALL = "scan of the {} wall; x.txt,y.txt,z.txt for matrices in three files; or flat"
_EXAMPLES = """examples:
  jointclosure close top.xyz bottom.xyz --units mm --rock granite
  jointclosure close top.stl bottom.stl --units mm --rock granite --stress 5 --cycles 3
  jointclosure close aperture.asc flat --orientation common_frame --units mm --rock granite
  jointclosure close top.csv bottom.csv --units mm --youngs-modulus 60 --poisson-ratio 0.22 \\
      --strength 180 --stress 15 --grid-spacing 0.5 --output my_joint

Other values are those of the configuration (config/README.md). docs/two_scans.md is a tutorial.
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
    for wall in ("upper", "lower"):
        command.add_argument(wall, type=Path, help=_WALL.format(wall))
    scans = command.add_argument_group("scans")
    add_scans(scans, close, "scan_spacing")
    spikes = {"keyword": "cut_spikes", "choices": ("keep", "cut"), "default": "cut"}
    add_keywords(scans, registered, spikes=spikes)
    add_keywords(
        command.add_argument_group("joint"),
        registered,
        grid_spacing={"keyword": "spacing", "type": float, "metavar": "mm"},
        orientation={"choices": list(ORIENTATIONS)},
        shift={"choices": SHIFTS},
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
    add_keywords(known, close, single={"action": "store_true"})
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
    settings, conditions = _settings(arguments)
    rock = next(iter(settings.typed.rocks.values()))
    assert rock.walls is not None  # set from the arguments
    joint = close(
        rock.walls.upper,
        rock.walls.lower,
        conditions=conditions,
        units=rock.walls.units,
        scan_spacing=rock.walls.spacing,
        variable=rock.walls.variable,
        orientation=rock.walls.orientation,
        shift=rock.walls.shift,
        cut_spikes=rock.walls.spikes == "cut",
        single=arguments.single,
        ranges=ranges,
        snapshots=kept_stresses(arguments, conditions),
        rock_name=rock.title,
        progress=True,
    )
    print(summary(joint.history, joint.budget))
    title = f"{arguments.upper.name} on {arguments.lower.name}"
    joint = joint._replace(history=write_animation(joint.history, arguments, title))
    names = replace_files(
        arguments.output, "close", lambda folder: _write(joint, settings, folder, title)
    )
    warned = len(cautions(joint.pair.report))
    above = f"; warnings above: {warned}" if warned else ""
    spent = duration(time.perf_counter() - start)
    print(f"{status_text(joint.history)}; {spent} in all{above}")
    print(f"wrote {arguments.output}: {', '.join(names)}")
    return 1 if int(joint.history.status) >= FAILURE else 0


def _settings(arguments) -> tuple[Configured, Conditions]:
    """Return the checked configuration of the arguments, of a rock with these walls."""
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
    base = base_keys(arguments)
    changes = {"grid": grid, "surface": {"roll_off_mm": None}, **resolved_breakage(arguments)}
    settings, conditions = joint_configuration(
        base, arguments, {"jrc": None, "walls": walls}, changes, needed
    )
    if arguments.grid_spacing is None:  # the scans have one
        conditions = conditions._replace(spacing=None)
    return settings, conditions


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
        if name in ranges:
            raise InputError(f"--range {key}: must be given once")
        ranges[name] = tuple(values)
    return ranges


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
    walls = next(iter(settings.typed.rocks.values())).walls
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
        "mismatch_wavelength_mm": dict(
            zip(pair.mismatch._fields, _finite(1e3 * v for v in pair.mismatch), strict=True)
        ),
        "mean_aperture_at_first_touch_mm": 1e3 * float(pair.aperture.mean()),
        "first_touch_y_x": list(pair.first_touch),
        "per_cycle": per_cycle,
        "range": [] if joint.budget is None else joint.budget.record(),
        "about_range": [] if joint.budget is None else joint.budget.sentences(),
        "sha256": wall_digests(walls) if walls else {},
        "provenance": about,
    }


def _finite(values: Iterable[float]) -> list[float | None]:
    """Return numbers for JSON, with null for numbers that are not finite."""
    return [float(value) if np.isfinite(value) else None for value in values]

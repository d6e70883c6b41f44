"""`jointclosure fit`: mismatch wavelength of a joint from its measured closure."""

import argparse
import json
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from jointclosure.cli import COMMANDS
from jointclosure.cli.joint_keys import base_keys, joint_configuration, resolved_breakage
from jointclosure.cli.joint_options import (
    NEEDED,
    add_keywords,
    add_model,
    add_rock,
    add_seating,
    check_can_be_made,
)
from jointclosure.engine.progress import bar, duration
from jointclosure.engine.scanned_joint import registered_walls
from jointclosure.inputs import InputError, check_positive
from jointclosure.joint.conditions import Conditions
from jointclosure.measured.calibration import Interval
from jointclosure.measured.curves import CLOSURE_UNITS, STRESS_UNITS
from jointclosure.measured.fit import Fit, assumptions, fit, read_curve
from jointclosure.storage.figures import save_figure
from jointclosure.storage.folders import replace_files
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_text
from jointclosure.walls.registration import ORIENTATIONS, RegisteredPair, registered
from jointclosure.walls.scans import read_scan
from jointclosure.walls.scans.units import UNITS
from studies.frame.config.configuration import Configured, merged_study

_CONDITIONS = ("rock", "spacing", "seating_stress", "effects", "choices", "numerics")
"""Fields of `jointclosure.Conditions` that are keywords of `jointclosure.fit`."""
_EXAMPLES = """examples:
  jointclosure fit curve.csv --rock granite --jrc 10 --size 25
  jointclosure fit curve.csv --rock granite --jrc 6,10 --size 25 --fit-strength --output my_fit
  jointclosure fit curve.csv --rock granite --scans top.xyz bottom.xyz --units mm
  jointclosure fit curve.csv --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 8 \\
      --size 40 --stress-unit MPa --closure-unit mm --seating 0.25

The curve has columns stress_MPa, closure_mm and, for several cycles, cycle; others are not read
(docs/beyond.md).
"""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "fit",
        help=COMMANDS["fit"],
        description="Close joints from mated to independent walls, and find the mismatch\n"
        "wavelength of those whose closure is the measured one, with a 95 % interval.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("curve", type=Path, help="CSV of the measured closure curve")
    curve = command.add_argument_group("curve")
    add_keywords(
        curve,
        fit,
        stress_unit={"choices": STRESS_UNITS},
        closure_unit={"choices": CLOSURE_UNITS},
        columns={"type": lambda text: text.split(","), "metavar": "STRESS,CLOSURE[,CYCLE]"},
        closure_error={"type": float, "metavar": "%", "default": 2.0},
    )
    add_seating(curve)
    add_rock(command)
    joint = command.add_argument_group("joint")
    joint.add_argument(
        "--jrc", type=_jrc, metavar="JRC", help="joint roughness coefficient, or its range: 6,10"
    )
    joint.add_argument(
        "--scans", nargs=2, metavar=("UPPER", "LOWER"),
        help="scans of the walls, if there are any: the strength is then fitted",
    )  # fmt: skip
    add_keywords(joint, read_scan, units={"choices": list(UNITS)})
    add_keywords(joint, registered, orientation={"choices": list(ORIENTATIONS)})
    size = joint.add_mutually_exclusive_group()
    size.add_argument("--size", type=float, metavar="mm", help="side of the measured joint")
    size.add_argument(
        "--cells", type=int, metavar="N",
        help="cells along the sides of a smaller joint, which takes less time and closes less far",
    )  # fmt: skip
    add_keywords(
        joint,
        fit,
        spacing={"type": float, "metavar": "mm", "default": None},
        fit_strength={"action": "store_true"},
        surfaces={"type": int, "metavar": "N"},
        seed={"type": int, "metavar": "N"},
    )
    add_model(command)
    results = command.add_argument_group("results")
    results.add_argument(
        "--output", type=Path, metavar="FOLDER", help="folder of the results and a figure"
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Fit the joint, and print and write the result."""
    if arguments.output:
        from jointclosure.plotting.calibration import fit_figure

        check_can_be_made(arguments.output)
    form = {name: getattr(arguments, name) for name in ("stress_unit", "closure_unit", "columns")}
    curve = read_curve(arguments.curve, **form)
    pair = _pair(arguments)
    jrc = arguments.jrc
    if isinstance(jrc, tuple):  # the configuration has one value
        arguments.jrc = 0.5 * (jrc[0] + jrc[1])
    settings, conditions = _settings(arguments, float(curve.stress.max()))
    surface, grid = settings.typed.surface, settings.typed.grid
    middle = next(iter(settings.typed.rocks.values())).jrc
    jrcs = jrc if isinstance(jrc, tuple) else (middle, middle)
    if pair is None:
        assumed = assumptions(
            conditions.rock, jrcs, grid.shape, grid.spacing, surface.roll_off,
            arguments.fit_strength,
        )  # fmt: skip
        print(f"assumed (--jrc, --size or --cells, --spacing and --set change it): {assumed}")
    else:
        print("\n".join(f"- {line}" for line in pair.report))
    with _progress(arguments.surfaces) as report:
        result = fit(
            arguments.curve,
            jrc=jrcs,
            pair=pair,
            shape=grid.shape,
            fit_strength=arguments.fit_strength,
            surfaces=arguments.surfaces,
            closure_error=1e-2 * arguments.closure_error,
            seed=arguments.seed,
            hurst=surface.hurst,
            roll_off=surface.roll_off,
            report=report,
            **form,
            **{name: getattr(conditions, name) for name in _CONDITIONS},
        )
    print("\n".join(f"- {line}" for line in result.sentences()))
    if arguments.output:

        def write(folder: Path) -> None:
            record = _record(result, settings)
            write_text(json.dumps(record, indent=1) + "\n", folder / "fit.json")
            save_figure(fit_figure(result, arguments.curve.name), folder / "fit.png")

        names = replace_files(arguments.output, "fit", write)
        print(f"wrote {arguments.output}: {', '.join(names)}")
    return 0


@contextmanager
def _progress(surfaces: int) -> Iterator[Callable[[float], None]]:
    """Show a progress bar, and print the remaining time when each kind of joint was closed once.

    The first joint does not count, because it may have compiled the kernels.
    """
    with bar("closing") as show:
        first: list[float] = []

        def report(share: float) -> None:
            show(share, "")
            first.extend([share, time.perf_counter()] if not first else [])
            if math.isclose(share, 1.0 / surfaces):
                spent = time.perf_counter() - first[1]
                left = (1.0 - share) / (share - first[0]) * spent
                print(f"about {duration(left)} until the last joint is closed", flush=True)

        yield report


def _jrc(text: str) -> float | tuple[float, ...]:
    """Return a JRC or the ends of its range."""
    try:
        ends = tuple(float(word) for word in text.split(","))
    except ValueError:
        ends = ()
    if len(ends) not in (1, 2):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number, or a range such as 6,10")
    return ends if len(ends) == 2 else ends[0]


def _pair(arguments) -> RegisteredPair | None:
    """Read and register the scans of the walls, if there are any."""
    if arguments.scans is None:
        return None
    for option in ("jrc", "size"):
        if getattr(arguments, option) is not None:
            raise InputError(f"--{option}: must be left out with --scans")
    arguments.jrc = _UNUSED_JRC
    spacing = None if arguments.spacing is None else 1e-3 * arguments.spacing
    upper, lower = arguments.scans
    scans = {"units": arguments.units}
    return registered_walls(upper, lower, scans, spacing, orientation=arguments.orientation)


_UNUSED_JRC, _UNUSED_CELLS = 10.0, 64
"""JRC and cells of the configuration where walls are scanned, which are not used."""


def _settings(arguments, largest: float) -> tuple[Configured, Conditions]:
    """Return the checked configuration of the arguments."""
    base = base_keys(arguments)
    spacing = base["grid"]["spacing_mm"] if arguments.spacing is None else arguments.spacing
    if arguments.jrc is None and base["rocks"].get(arguments.rock, {}).get("jrc") is None:
        raise InputError("--jrc: must be given")
    cells = arguments.cells
    if arguments.size is not None:
        check_positive("--size", arguments.size, "mm")
        check_positive("--spacing", spacing, "mm")
        cells = round(arguments.size / spacing)
    if arguments.scans is not None:
        cells = _UNUSED_CELLS
    elif cells is None:
        raise InputError(
            "--size: must be given, the side of the measured joint in mm (or --cells of a smaller "
            "one), because closure depends on it"
        )
    grid: dict = {"cells_x": cells, "cells_y": cells, "spacing_mm": spacing}
    rock = {"max_normal_stress_MPa": 1e-6 * largest, "walls": None}
    needed = tuple(option for option in NEEDED if option != "stress")
    changes = {"grid": grid, **resolved_breakage(arguments)}
    if base["surface"] == merged_study()["surface"]:
        changes["surface"] = {"roll_off_mm": None}  # natural walls have waves of all lengths
    return joint_configuration(base, arguments, rock, changes, needed)


def _record(result: Fit, settings: Configured) -> dict:
    """Return the results with units in their names; null means infinity."""
    strength = result.compressive_strength
    return {
        "found": result.sentences(),
        "mismatch_wavelength_mm": _scaled(result.mismatch_wavelength, 1e3),
        "compressive_strength_MPa": None if strength is None else _scaled(strength, 1e-6),
        "p_value": result.p_value,
        "interval_holds": result.interval_holds,
        "assumed": result.assumed,
        "readings": [reading._asdict() for reading in result.agreements()],
        "scanned_walls": result.scanned,
        "measured_names": result.measured.names(),
        "measured_mm": (1e3 * result.measured.values).tolist(),
        "likelihood": {
            "wavelength_mm": (1e3 * result.likelihood.wavelengths).tolist(),
            "strength_MPa": (1e-6 * result.likelihood.strengths).tolist(),
            "log": result.likelihood.log.tolist(),
        },
        "provenance": provenance(settings.keys),
    }


def _scaled(interval: Interval, scale: float) -> dict[str, float | None]:
    return {
        name: scale * value if math.isfinite(value) else None
        for name, value in interval._asdict().items()
    }

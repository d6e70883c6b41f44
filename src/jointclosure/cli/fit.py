"""Close joints from mated to independent walls, and find the mismatch
wavelength of those whose closure is the measured one, with a 95 % interval.

examples:
  jointclosure fit curve.csv --rock granite --jrc 10 --size 25
  jointclosure fit curve.csv --rock granite --jrc 6,10 --size 25 --fit-strength --output my_fit
  jointclosure fit curve.csv --rock granite --scans top.xyz bottom.xyz --units mm
  jointclosure fit curve.csv --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 8 \\
      --size 40 --stress-unit MPa --closure-unit mm --seating 0.25

The curve has columns stress_MPa, closure_mm and, for several cycles, cycle; others are not read
(docs/beyond.md).
"""

import argparse
import inspect
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from jointclosure.cli import options, results
from jointclosure.engine.progress import bar, duration
from jointclosure.engine.scanned_joint import RESOLVED, registered_walls
from jointclosure.inputs import InputError, check_positive
from jointclosure.measured.curves import CLOSURE_UNITS, STRESS_UNITS
from jointclosure.measured.fit import Fit, assumptions, fit, read_curve
from jointclosure.storage.folders import replace_files
from jointclosure.walls.registration import RegisteredPair, registered
from jointclosure.walls.scans import read_scan

_USUAL = inspect.signature(fit).parameters
_CURVE = ("stress_unit", "closure_unit", "columns")
_JOINT = ("hurst", "roll_off", "fit_strength", "surfaces", "seed", "seating_stress")


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("curve", type=Path, help="CSV of the measured closure curve")
    curve = command.add_argument_group("curve")
    options.add_keywords(
        curve,
        fit,
        "seating_stress",
        stress_unit={"choices": STRESS_UNITS},
        closure_unit={"choices": CLOSURE_UNITS},
        columns={"type": lambda text: text.split(","), "metavar": "STRESS,CLOSURE[,CYCLE]"},
        closure_error={"metavar": "%", "default": 2.0},
    )
    joint = command.add_argument_group("joint")
    what = "scans of the walls, if there are any: the strength is then fitted"
    joint.add_argument("--scans", nargs=2, metavar=("UPPER", "LOWER"), help=what)
    options.add_keywords(joint, read_scan, "units")
    options.add_keywords(joint, registered, "orientation")
    size = joint.add_mutually_exclusive_group()
    size.add_argument("--size", type=float, metavar="mm", help="side of the measured joint")
    what = "cells along the sides of a smaller joint, which takes less time and closes less far"
    size.add_argument("--cells", type=int, metavar="N", help=what)
    options.add_keywords(joint, fit, "jrc", "spacing", "fit_strength", "surfaces", "seed")
    options.add_keywords(joint, fit, "hurst", "roll_off")
    options.add_conditions(command, RESOLVED, load=False)
    options.add_file(command, "--output", "folder of the results and a figure")


def run(arguments: argparse.Namespace) -> int:
    """Fit the joint, and print and write the result."""
    if arguments.output:
        from jointclosure.plotting.joint import fit_figure
    form = options.given(arguments, _CURVE)
    read_curve(arguments.curve, **form)
    pair = _pair(arguments)
    rock = options.rock_of(arguments, *() if pair else ("jrc",))
    stated = form | options.given(arguments, _JOINT) | options.model_of(arguments, RESOLVED)
    stated |= {"rock": rock.intact, "closure_error": 1e-2 * arguments.closure_error}
    if pair is None:
        stated |= {"jrc": options.jrc_of(arguments, rock)} | _random_walls(arguments)
        jrcs = stated["jrc"] if isinstance(stated["jrc"], tuple) else (stated["jrc"],) * 2
        walls = stated["shape"], stated["spacing"], stated.get("roll_off")
        assumed = assumptions(rock.intact, jrcs, *walls, arguments.fit_strength)
        print(f"assumed (--jrc, --size or --cells, --spacing and others change it): {assumed}")
    else:
        print("\n".join(f"- {line}" for line in pair.report))
    with _progress(stated.get("surfaces", _USUAL["surfaces"].default)) as report:
        result = fit(arguments.curve, pair=pair, report=report, **stated)
    print("\n".join(f"- {line}" for line in result.sentences()))
    if arguments.output:
        about = results.attributes({"curve": arguments.curve, "scans": arguments.scans, **stated})

        def fill(folder: Path) -> None:
            results.write(_record(result) | {"provenance": about}, folder / "fit.json")
            results.write(fit_figure(result, arguments.curve.name), folder / "fit.png")

        names = replace_files(arguments.output, "fit", fill)
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


def _pair(arguments: argparse.Namespace) -> RegisteredPair | None:
    """Read and register the scans of the walls, if there are any."""
    if arguments.scans is None:
        return None
    for option in ("jrc", "size"):
        if getattr(arguments, option, None) is not None:
            raise InputError(f"--{option}: must be left out with --scans")
    placed = options.given(arguments, ["spacing", "orientation"])
    upper, lower = arguments.scans
    return registered_walls(upper, lower, options.given(arguments, ["units"]), **placed)


def _random_walls(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return cells and spacing of the simulated joints."""
    spacing = getattr(arguments, "spacing", _USUAL["spacing"].default)
    check_positive("--spacing", spacing, "m")
    cells = arguments.cells
    if arguments.size is not None:
        check_positive("--size", arguments.size, "mm")
        cells = round(1e-3 * arguments.size / spacing)
    if cells is None:
        raise InputError(
            "--size: must be given, the side of the measured joint in mm (or --cells of a smaller "
            "one), because closure depends on it"
        )
    return {"shape": (cells, cells), "spacing": spacing}


def _record(result: Fit) -> dict[str, Any]:
    """Return the results with units in their names; null means infinity."""
    strength = result.compressive_strength
    return {
        "found": result.sentences(),
        "mismatch_wavelength_mm": results.scaled(result.mismatch_wavelength, 1e3),
        "compressive_strength_MPa": None if strength is None else results.scaled(strength, 1e-6),
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
    }

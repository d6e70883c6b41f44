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
from pathlib import Path
from typing import Any

from jointclosure.cli import options, results
from jointclosure.engine.scanned_joint import RESOLVED
from jointclosure.measured.curves import CLOSURE_UNITS, STRESS_UNITS
from jointclosure.measured.fit import Fit, fit


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("curve", type=Path, help="CSV of the measured closure curve")
    curve = command.add_argument_group("curve")
    options.add_keywords(
        curve,
        fit,
        "seating_stress",
        "first_loading",
        stress_unit={"choices": STRESS_UNITS},
        closure_unit={"choices": CLOSURE_UNITS},
        columns={"type": lambda text: text.split(","), "metavar": "STRESS,CLOSURE[,CYCLE]"},
        closure_error={"type": float, "metavar": "%", "default": 2.0},
    )
    joint = command.add_argument_group("joint")
    scans = {"nargs": 2, "metavar": ("UPPER", "LOWER")}
    options.add_keywords(joint, fit, "units", "orientation", scans=scans)
    sides = joint.add_mutually_exclusive_group()
    options.add_keywords(sides, fit, "size", shape=options.CELLS)
    options.add_keywords(joint, fit, "jrc", "spacing", "fit_strength", "surfaces", "seed")
    options.add_keywords(joint, fit, "hurst", "roll_off")
    options.add_conditions(command, RESOLVED, load=False)
    options.add_file(command, "--output", "folder of the results and a figure")


def run(arguments: argparse.Namespace) -> int:
    """Fit the joint, and print and write the result."""
    if arguments.output:
        from jointclosure.plotting.joint import fit_figure
    scanned = hasattr(arguments, "scans")
    rock = options.rock_of(arguments, *() if scanned else ("jrc",))
    stated = options.given(arguments, inspect.signature(fit).parameters)
    stated |= options.model_of(arguments, RESOLVED) | {"rock": rock.intact}
    stated["closure_error"] = 1e-2 * arguments.closure_error
    if not scanned:
        stated["jrc"] = rock.jrc
    result = fit(**stated, progress=True)
    print("\n".join(f"- {line}" for line in result.sentences()))
    if arguments.output:
        record = _record(result) | {"provenance": results.attributes(stated)}
        files = {"fit.json": record, "fit.png": fit_figure(result, arguments.curve.name)}
        print(results.write_folder(arguments.output, "fit", files))
    return 0


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

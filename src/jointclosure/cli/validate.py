"""Find which mechanisms and constants are compatible with all loadings of a measured curve: joints
of each strength, shift of walls seated anew, and strength of crushed rock are closed.

examples:
  jointclosure validate curve.csv --rock granite --scans top.xyz bottom.xyz --units mm
  jointclosure validate curve.csv --rock granite --jrc 6,10 --size 25 --output my_region
  jointclosure validate curve.csv --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 \\
      --strengths 60,200 --jrc 8 --size 40 --stress-unit MPa --closure-unit mm --seating 0.25

The curve has columns stress_MPa, closure_mm and, for several cycles, cycle; others are not read
(docs/two_scans.md). With --output, joints are kept in the folder, and a later run with the same
joints closes only what is missing.
"""

import argparse
import inspect
from pathlib import Path

from jointclosure.cli import options, results
from jointclosure.measured.curves import CLOSURE_UNITS, STRESS_UNITS
from jointclosure.measured.region import NUMERICS, validate


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("curve", type=Path, help="CSV of the measured closure curve")
    curve = command.add_argument_group("curve")
    options.add_keywords(
        curve,
        validate,
        "seating_stress",
        stress_unit={"choices": STRESS_UNITS},
        closure_unit={"choices": CLOSURE_UNITS},
        columns={"type": lambda text: text.split(","), "metavar": "STRESS,CLOSURE[,CYCLE]"},
        closure_error={"type": float, "metavar": "%", "default": 2.0},
    )
    tried = command.add_argument_group("constants that are tried")
    options.add_keywords(tried, validate, "strengths", "shifts", "crushed_strength_ratios")
    options.add_keywords(tried, validate, "surfaces", "seed")
    joint = command.add_argument_group("joint")
    scans = {"nargs": 2, "metavar": ("UPPER", "LOWER")}
    options.add_keywords(joint, validate, "units", "orientation", scans=scans)
    sides = joint.add_mutually_exclusive_group()
    options.add_keywords(sides, validate, "size", shape=options.CELLS)
    options.add_keywords(joint, validate, "jrc", "spacing", "hurst", "roll_off")
    options.add_conditions(command, NUMERICS, load=False)
    options.add_file(command, "--output", "folder of the tables, the figure, and closed joints")


def run(arguments: argparse.Namespace) -> int:
    """Print and write what is compatible with the curve."""
    if arguments.output:
        from jointclosure.plotting.region import region_figure
    scanned = hasattr(arguments, "scans")
    rock = options.rock_of(arguments, *() if scanned else ("jrc",))
    stated = options.given(arguments, inspect.signature(validate).parameters)
    stated |= options.model_of(arguments, NUMERICS) | {"rock": rock.intact}
    stated["closure_error"] = 1e-2 * arguments.closure_error
    if not scanned:
        stated["jrc"] = rock.jrc
    cache = arguments.output / "joints" if arguments.output else None
    region = validate(**stated, cache=cache, report=lambda line: print(f"- {line}", flush=True))
    ranges, quantities = region.table(), region.quantities()
    shown = {"index": False, "na_rep": "none", "float_format": "{:.3g}".format}
    print(f"\n{ranges.to_string(**shown)}\n\n{quantities.to_string(**shown)}\n")
    print("\n".join(f"- {line}" for line in region.sentences()))
    if arguments.output:
        record = {"found": region.sentences(), "measured_names": region.measured.names()}
        record["measured_mm"] = (1e3 * region.measured.values).tolist()
        files = {
            "region.csv": ranges,
            "quantities.csv": quantities,
            "region.json": record | {"provenance": results.attributes(stated)},
            "region.png": region_figure(region, arguments.curve.name),
        }
        print(results.write_folder(arguments.output, "validate", files))
    return 0

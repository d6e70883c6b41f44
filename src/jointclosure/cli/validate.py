"""Find which mechanisms and constants are compatible with all loadings of a measured curve.
Joints are simulated for several strengths, shifts of reseated walls, and strengths of crushed rock.

examples:
  jointclosure validate curve.csv --rock granite --scans top.xyz bottom.xyz --units mm
  jointclosure validate curve.csv --rock granite --jrc 6,10 --size 25 --output my_region
  jointclosure validate curve.csv --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 \\
      --strengths 60,200 --jrc 8 --size 40 --stress-unit MPa --closure-unit mm --seating 0.25

The curve has columns stress_MPa, closure_mm and, for several cycles, cycle; others are not read
(docs/two_scans.md). With --output, joints are kept in the folder, and a later run with the same
joints simulates only those that are missing.
"""

import argparse

from jointclosure.cli import command_results, options
from jointclosure.measured.validation import NUMERICS, validate


def declare(command: argparse.ArgumentParser) -> None:
    tried = "strengths", "shifts", "crushed_strength_ratios"
    options.add_measured(command, NUMERICS, "constants that are tried", validate, *tried)
    options.add_file_option(command, "--output", "folder of the tables, the figure, and the joints")


def run(arguments: argparse.Namespace) -> int:
    """Print the ranges of constants that are compatible with the curve, by mechanism.

    They are also written to a folder if requested.
    """
    if arguments.output:
        from jointclosure.plotting.measured import region_figure
    stated = options.measured_joint(arguments, validate, NUMERICS)
    cache = arguments.output / "joints" if arguments.output else None
    region = validate(**stated, cache=cache, report=lambda line: print(f"- {line}", flush=True))
    ranges = region.table()
    quantities = region.quantities()
    shown = {"index": False, "na_rep": "none", "float_format": "{:.3g}".format}
    print(f"\n{ranges.to_string(**shown)}\n\n{quantities.to_string(**shown)}\n")
    found = region.sentences()
    print("\n".join(f"- {line}" for line in found))
    if arguments.output:
        record = {"found": found, "measured_names": region.measured.names()}
        record["measured_mm"] = (1e3 * region.measured.values).tolist()
        files = {
            "region.csv": ranges,
            "quantities.csv": quantities,
            "region.json": record | {"provenance": command_results.attributes(stated)},
            "region.png": region_figure(region, arguments.curve.name),
        }
        print(command_results.write_folder(arguments.output, "validate", files))
    return 0

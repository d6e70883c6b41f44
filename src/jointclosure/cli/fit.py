"""Estimate the mismatch wavelength of a joint from its measured closure, with a 95 % interval.
Joints from mated to independent walls are simulated, and compared with the measured curve.

examples:
  jointclosure fit curve.csv --rock granite --jrc 10 --size 25
  jointclosure fit curve.csv --rock granite --jrc 6,10 --size 25 --fit-strength --output my_fit
  jointclosure fit curve.csv --rock granite --scans top.xyz bottom.xyz --units mm
  jointclosure fit curve.csv --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 8 \\
      --size 40 --stress-unit MPa --closure-unit mm --seating 0.25

The curve has columns stress_MPa, closure_mm and, for several cycles, cycle; others are not read
(docs/two_scans.md).
"""

import argparse

from jointclosure.cli import command_results, options
from jointclosure.measured.fit import fit
from jointclosure.parameters import RESOLVED


def declare(command: argparse.ArgumentParser) -> None:
    options.add_measured(command, RESOLVED, "fit", fit, "first_loading", "fit_strength")
    options.add_file_option(command, "--output", "folder of the results and a figure")


def run(arguments: argparse.Namespace) -> int:
    """Fit the joint to the curve; print the result, and write it if requested.

    In the file fit.json null is an infinite or unknown number, or a strength that was not fitted.
    """
    if arguments.output:
        from jointclosure.plotting.measured import fit_figure
    stated = options.measured_joint(arguments, fit, RESOLVED)
    cache = arguments.output / "joints" if arguments.output else None
    result = fit(**stated, cache=cache, progress=True)
    found = result.sentences()
    strength = result.compressive_strength
    print("\n".join(f"- {line}" for line in found))
    if not arguments.output:
        return 0
    record = {
        "found": found,
        "mismatch_wavelength_mm": command_results.scaled(result.mismatch_wavelength, 1e3),
        "compressive_strength_MPa": None
        if strength is None
        else command_results.scaled(strength, 1e-6),
        "p_value": result.p_value,
        "interval_holds": result.interval_holds,
        "assumed": result.assumed,
        "readings": [reading._asdict() for reading in result.agreements()],
        "numerical_changes": result.numerical,
        "scanned_walls": result.scanned,
        "measured_names": result.measured.names(),
        "measured_mm": (1e3 * result.measured.values).tolist(),
        "likelihood": {
            "wavelength_mm": (1e3 * result.likelihood.wavelengths).tolist(),
            "strength_MPa": (1e-6 * result.likelihood.strengths).tolist(),
            "log": result.likelihood.log.tolist(),
        },
        "provenance": command_results.attributes(stated),
    }
    files = {"fit.json": record, "fit.png": fit_figure(result, arguments.curve.name)}
    print(command_results.write_folder(arguments.output, "fit", files))
    return 0

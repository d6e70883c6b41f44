"""Fits of the three measured joints by `jointclosure.fit`, by size of the simulated joints.

The wavelength is fitted to the first loading (closure and recovery), by `fit` on the first cycle of
`digitised_curve`. The readings of both loadings are then compared with the joints of `fit` on both
cycles. Conditions are those of config/measured_joints.yaml. Run as
`python benchmarks/measured_fit.py`, about two minutes of processor time; `python
docs/site/publish.py build/benchmarks measured_fit` stores its tables for docs/mismatch.md.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))

import sys
from pathlib import Path

import pandas as pd

import jointclosure as jc
from jointclosure.config.measured_joints import JOINTS, measured
from jointclosure.config.rocks import named_rock
from jointclosure.ensemble.scanned_joint import RESOLVED
from jointclosure.measured.calibration import Simulated
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.joints import digitised_curve
from jointclosure.plotting.calibration import fit_figure
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import write_csv

OUTPUT = Path(__file__).parents[1] / "build/benchmarks"
SPACING, JRC, SURFACES, ERROR = 0.25e-3, 8.0, 12, 0.04
CELLS = (64, 128)
ROCK = named_rock("granite")._replace(youngs_modulus=1e9 * measured("youngs_modulus").value)


def first_cycle(curve: MeasuredCurve) -> MeasuredCurve:
    """Return the first cycle of a curve."""
    return MeasuredCurve(*(column[curve.cycle == 1] for column in curve))


def of_first_cycle(joints: Simulated) -> Simulated:
    """Return the readings of the first cycle: closure at the maximum, and recovery."""
    return Simulated(joints.logs[..., :2], joints.closures[..., :1, :, :], joints.stresses)


def main() -> None:
    """Fit the three joints, and write both tables and a figure of each fit."""
    fits, readings = [], []
    OUTPUT.mkdir(parents=True, exist_ok=True)
    for cells in CELLS:
        joints = None  # closed once for all curves, which differ in their readings only
        for joint in JOINTS:
            curve = digitised_curve(joint)
            options = {
                "rock": ROCK, "jrc": JRC, "shape": (cells, cells), "spacing": SPACING,
                "seating_stress": 1e6 * measured("seating_stress").value, "surfaces": SURFACES,
                "closure_error": ERROR, "roll_off": None, "numerics": RESOLVED,
            }  # fmt: skip
            both = jc.fit(curve, **options, simulated=joints)
            joints = both.simulated
            result = jc.fit(first_cycle(curve), **options, simulated=of_first_cycle(joints))
            about = {"joint": joint, "side_mm": 1e3 * SPACING * cells}
            low, high = result.mismatch_wavelength[1:]
            fits.append(
                about
                | {"wavelength_mm": 1e3 * result.mismatch_wavelength.value}
                | {"low_mm": 1e3 * low, "high_mm": 1e3 * high, "p_value": result.p_value}
            )
            readings += [about | reading._asdict() for reading in both.agreements()]
            save_figure(fit_figure(both, f"joint {joint}"), OUTPUT / f"fit_{joint}_{cells}.png")
            print(joint, cells, *result.sentences(), *both.sentences(), sep="\n- ", flush=True)
    write_csv(pd.DataFrame(fits), OUTPUT / "measured_fit.csv")
    write_csv(pd.DataFrame(readings), OUTPUT / "measured_fit_readings.csv")


if __name__ == "__main__":
    sys.exit(main())

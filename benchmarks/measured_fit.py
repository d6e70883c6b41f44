"""Fits of the three measured joints by `jointclosure.fit`, and of joints of known wavelength.

The wavelength is fitted to the first loading (closure and recovery), by `fit` on the first cycle of
`digitised_curve`; readings of both loadings are compared with the joints of `fit` on both cycles,
by the conditions of measured_joints.yaml. Simulated joints of granite of known wavelength are
fitted alike, to count how often the interval contains it. `python benchmarks/measured_fit.py` takes
five minutes; `python docs/site/publish.py build/benchmarks measured_fit` stores its tables.
"""

from pathlib import Path

from yardstick import options

# isort: split
import numpy as np
import pandas as pd
import xarray as xr

import jointclosure as jc
from jointclosure.engine.published_joints import JOINTS, measured
from jointclosure.engine.scanned_joint import RESOLVED
from jointclosure.joint.curves import closures_at
from jointclosure.joint.rocks import named_rock
from jointclosure.measured.calibration import Simulated
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.fit import DOUBTFUL, Fit
from jointclosure.plotting.measured import fit_figure
from jointclosure.storage.files import write, write_csv
from jointclosure.walls.synthesis import ROLL_OFF
from studies.measured_joints.observables import digitised_curve

OUTPUT = Path(__file__).parents[1] / "build/benchmarks"
WALLS = Path(__file__).parents[1] / "config/walls"
SPACING, JRC, SURFACES, ERROR = 0.25e-3, 8.0, 12, 0.04
CELLS = (64, 128)
KNOWN = (1e-3, 2e-3, 4e-3, np.inf)
FIRST_SEED, REPEATS = 1000, 10
ROCK = named_rock("granite")._replace(youngs_modulus=1e9 * measured("youngs_modulus").value)
PAPER = jc.Choices(strength_bound="none")  # by which the stored results were made
GRANITE = jc.Conditions(
    SPACING, named_rock("granite"), 10e6, choices=PAPER, numerics=RESOLVED
).checked()


def simulated_curve(wavelength: float, seed: int) -> MeasuredCurve:
    """Close a joint of the model, as a measured curve."""
    walls = {"mismatch_wavelength": None if np.isinf(wavelength) else wavelength, "roll_off": None}
    pair = jc.wall_pair(JRC, (CELLS[0], CELLS[0]), SPACING, seed, **walls)
    return curve_of(jc.simulate(*pair, conditions=GRANITE))


def curve_of(joint: xr.Dataset) -> MeasuredCurve:
    """Return the net closures of a joint since seating as a measured curve."""
    stresses = np.linspace(GRANITE.seating_stress, GRANITE.max_normal_stress, 21)
    closures = closures_at(joint, stresses)  # (cycles, loading and unloading, stresses)
    there_and_back = np.concatenate([closures[:, 0], closures[:, 1, ::-1]], axis=1)
    cycles = np.repeat(np.arange(len(closures)) + 1, 2 * stresses.size)
    stress = np.tile(np.concatenate([stresses, stresses[::-1]]), len(closures))
    since_seating = there_and_back - closures[0, 0, 0]
    return MeasuredCurve(stress, since_seating.ravel(), cycles, np.arange(stress.size) + 1)


def fitted(result: Fit) -> dict:
    """Return the wavelength of a fit in mm with its interval, and the p-value."""
    value, low, high = (1e3 * length for length in result.mismatch_wavelength)
    return {"wavelength_mm": value, "low_mm": low, "high_mm": high, "p_value": result.p_value}


def example_joint() -> pd.DataFrame:
    """Fit the joint of config/walls, made with 3 mm and waves of all lengths, by roll-off."""
    scans = (WALLS / "joint_upper.npz", WALLS / "joint_lower.npz")
    joint = jc.close(*scans, conditions=GRANITE, single=True)
    rows = []
    for roll_off in (None, ROLL_OFF):
        result = jc.fit(
            curve_of(joint.history), rock="granite", jrc=10.0, shape=joint.pair.upper.shape,
            seating_stress=GRANITE.seating_stress, roll_off=roll_off, choices=PAPER,
        )  # fmt: skip
        rows.append(
            {"roll_off_mm": np.inf if roll_off is None else 1e3 * roll_off} | fitted(result)
        )
    return pd.DataFrame(rows)


def known_wavelengths() -> pd.DataFrame:
    """Fit joints of known wavelength, all compared with the same simulated joints."""
    rows, joints = [], None
    for wavelength in KNOWN:
        for seed in range(FIRST_SEED, FIRST_SEED + REPEATS):
            result = jc.fit(
                simulated_curve(wavelength, seed), rock="granite", jrc=JRC, spacing=SPACING,
                shape=(CELLS[0], CELLS[0]), surfaces=SURFACES, closure_error=0.5e-2,
                seating_stress=GRANITE.seating_stress, simulated=joints, choices=PAPER,
            )  # fmt: skip
            joints = result.simulated
            low, high = result.mismatch_wavelength[1:]
            rows.append(
                {"known_mm": 1e3 * wavelength, "seed": seed}
                | fitted(result)
                | {"contains": low <= wavelength <= high}
            )
    return pd.DataFrame(rows)


def summary_of(known: pd.DataFrame) -> pd.DataFrame:
    """Count the intervals that contain the wavelength, and take the median estimate, by it."""
    groups = known.groupby("known_mm")
    return groups.agg(
        fits=("seed", "size"), contain=("contains", "sum"), median_mm=("wavelength_mm", "median"),
        unexplained=("p_value", lambda values: int((values < DOUBTFUL).sum())),
    ).rename_axis("wavelength_mm").reset_index()  # fmt: skip


def first_cycle(curve: MeasuredCurve) -> MeasuredCurve:
    """Return the first cycle of a curve."""
    return MeasuredCurve(*(column[curve.cycle == 1] for column in curve))


def of_first_cycle(joints: Simulated) -> Simulated:
    """Return the readings of the first cycle: closure at the maximum, and recovery."""
    return Simulated(joints.logs[..., :2], joints.closures[..., :1, :, :], joints.stresses)


def main() -> None:
    """Fit the joints, and write the tables and a figure of each fit of a measured joint."""
    fits, readings = [], []
    OUTPUT.mkdir(parents=True, exist_ok=True)
    for cells in CELLS:
        joints = None  # closed once for all curves, which differ in their readings only
        for joint in JOINTS:
            curve = digitised_curve(joint)
            stated = {
                "rock": ROCK, "jrc": JRC, "shape": (cells, cells), "spacing": SPACING,
                "seating_stress": 1e6 * measured("seating_stress").value, "surfaces": SURFACES,
                "closure_error": ERROR, "roll_off": None, "numerics": RESOLVED,
                "choices": PAPER,
            }  # fmt: skip
            both = jc.fit(curve, **stated, simulated=joints)
            joints = both.simulated
            result = jc.fit(first_cycle(curve), **stated, simulated=of_first_cycle(joints))
            about = {"joint": joint, "side_mm": 1e3 * SPACING * cells}
            fits.append(about | fitted(result))
            readings += [about | reading._asdict() for reading in both.agreements()]
            write(fit_figure(both, f"joint {joint}"), OUTPUT / f"fit_{joint}_{cells}.png")
            print(joint, cells, *result.sentences(), *both.sentences(), sep="\n- ", flush=True)
    write_csv(pd.DataFrame(fits), OUTPUT / "measured_fit.csv")
    write_csv(pd.DataFrame(readings), OUTPUT / "measured_fit_readings.csv")
    known = known_wavelengths()
    print(known.to_string(index=False), (table := summary_of(known)).to_string(), sep="\n")
    write_csv(table, OUTPUT / "measured_fit_known.csv")
    write_csv(example := example_joint(), OUTPUT / "measured_fit_example.csv")
    print(example.to_string())


if __name__ == "__main__":
    options(__doc__)
    main()

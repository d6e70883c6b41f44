"""Fits of joints of known wavelength by `jointclosure.fit`: does the interval contain it?

Simulated joints of granite take the place of measured ones. `python benchmarks/measured_fit.py`
takes some minutes; `python docs/site/publish.py build/benchmarks measured_fit` stores its table.
"""

from pathlib import Path

from yardstick import options

# isort: split
import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.history import history_of
from jointclosure.joint.rocks import named_rock
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.fit import DOUBTFUL
from jointclosure.storage.files import write_csv

OUTPUT = Path(__file__).parents[1] / "build/benchmarks"
SPACING, JRC, SURFACES, CELLS = 0.25e-3, 8.0, 12, 64
KNOWN = (1e-3, 2e-3, 4e-3, np.inf)
FIRST_SEED, REPEATS = 1000, 10
PAPER = jc.Choices(strength_bound="none")  # the choices of the stored results
GRANITE = jc.Conditions(
    SPACING, named_rock("granite"), 10e6, choices=PAPER, numerics=RESOLVED
).checked()


def simulated_curve(wavelength: float, seed: int) -> MeasuredCurve:
    """Simulate a joint; return its net closures since seating as a measured curve."""
    walls = {"mismatch_wavelength": None if np.isinf(wavelength) else wavelength, "roll_off": None}
    pair = jc.wall_pair(JRC, (CELLS, CELLS), SPACING, seed, **walls)
    joint = jc.simulate(*pair, conditions=GRANITE)
    stresses = np.linspace(GRANITE.seating_stress, GRANITE.largest_stress, 21)
    closures = history_of(joint).net.at(stresses)  # (cycles, loading and unloading, stresses)
    there_and_back = np.concatenate([closures[:, 0], closures[:, 1, ::-1]], axis=1)
    cycles = np.repeat(np.arange(len(closures)) + 1, 2 * stresses.size)
    stress = np.tile(np.concatenate([stresses, stresses[::-1]]), len(closures))
    since_seating = there_and_back - closures[0, 0, 0]
    return MeasuredCurve(stress, since_seating.ravel(), cycles, np.arange(stress.size) + 1)


def known_wavelengths() -> pd.DataFrame:
    """Fit joints of known wavelength, all by comparison with the same simulated joints."""
    rows = []
    joints = None
    for wavelength in KNOWN:
        for seed in range(FIRST_SEED, FIRST_SEED + REPEATS):
            result = jc.fit(
                simulated_curve(wavelength, seed), rock="granite", jrc=JRC, spacing=SPACING,
                shape=(CELLS, CELLS), surfaces=SURFACES, closure_error=0.5e-2,
                seating_stress=GRANITE.seating_stress, simulated=joints, choices=PAPER,
            )  # fmt: skip
            joints = result.simulated
            value, low, high = result.mismatch_wavelength
            row = {"known_mm": 1e3 * wavelength, "wavelength_mm": 1e3 * value}
            row |= {"low_mm": 1e3 * low, "high_mm": 1e3 * high, "p_value": result.p_value}
            rows.append(row | {"seed": seed, "contains": low <= wavelength <= high})
    return pd.DataFrame(rows)


def summary_of(known: pd.DataFrame) -> pd.DataFrame:
    """Tabulate by known wavelength the intervals that contain it, and the median estimate."""
    groups = known.groupby("known_mm")
    return groups.agg(
        fits=("seed", "size"), contain=("contains", "sum"), median_mm=("wavelength_mm", "median"),
        unexplained=("p_value", lambda values: int((values < DOUBTFUL).sum())),
    ).rename_axis("wavelength_mm").reset_index()  # fmt: skip


def main() -> None:
    """Fit the joints, and write the table."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    known = known_wavelengths()
    print(known.to_string(index=False), (table := summary_of(known)).to_string(), sep="\n")
    write_csv(table, OUTPUT / "measured_fit_known.csv")


if __name__ == "__main__":
    options(__doc__)
    main()

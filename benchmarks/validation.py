"""What the model gives beside three measured joints (docs/validation.md).

Run as `python benchmarks/validation.py`, a few minutes; it writes build/benchmarks/validation.csv,
which `python docs/site/publish.py build/benchmarks validation` stores for the page.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import pandas as pd

import jointclosure as jc
from jointclosure.engineering.curves import cycle_table
from jointclosure.engineering.laws import fitted_laws
from jointclosure.engineering.stiffness import secant_stiffness
from jointclosure.joint.history import GROSS, NET
from jointclosure.joint.rocks import named_rock
from jointclosure.storage.text import write_csv

OUTPUT = Path(__file__).parents[1] / "build/benchmarks/validation.csv"
SPACING, STRESS, JRC = 0.25e-3, 10e6, 8.0
ROCK = named_rock("granite")._replace(youngs_modulus=11e9)
"""Granite with the middle of the 10 to 12 GPa that were measured on the joints' granodiorite."""


class Joints(NamedTuple):
    """Joints that are closed: arguments of `jointclosure.wall_pair`, cells a side, how many."""

    walls: dict
    cells: int = 100
    number: int = 10


CASES: dict[str, Joints] = {
    "independent": Joints({"roll_off": None}),
    "independent, flat beyond 3 mm": Joints({}),
    "correlated by 0.9": Joints({"roll_off": None, "correlation": 0.9}),
    "mating beyond 6 mm": Joints({"roll_off": None, "mismatch_wavelength": 6e-3}),
    "mating beyond 3 mm": Joints({"roll_off": None, "mismatch_wavelength": 3e-3}),
    "mating beyond 1.5 mm": Joints({"roll_off": None, "mismatch_wavelength": 1.5e-3}),
    "mating beyond 3 mm, large": Joints({"roll_off": None, "mismatch_wavelength": 3e-3}, 488, 1),
}


def numbers_of(history) -> dict[str, float]:
    """What is compared, of one joint."""
    first = cycle_table(history).iloc[0]
    numbers = {}
    for kind, net, of in (("net", "_net", NET), ("gross", "", GROSS)):
        kn = [1e-9 * secant_stiffness(history, cycle, 0.5 * STRESS, STRESS, of) for cycle in (1, 2)]
        numbers[f"seated_{kind}"] = first[f"max_closure_seated{net}_mm"]
        numbers[f"stays_{kind}"] = 100.0 * first[f"residual_share{net}"]
        numbers[f"kn_{kind}"] = kn[0]
        numbers[f"stiffer_{kind}"] = kn[1] / kn[0]
    fits = fitted_laws(history)
    fits = fits[(fits.cycle == 1) & (fits.branch == "loading")].drop_duplicates("law")
    miss = 100.0 * fits.set_index("law").rms_mm / numbers["seated_net"]
    return numbers | {
        "semilog": float(miss["semi_logarithmic"]),
        "hyperbola": float(miss["hyperbolic"]),
        "loop": 1e-6 * float(history.unloading_excess[1]),
    }


def model_table(
    cases: Mapping[str, Joints], report: Callable[[str], None] = lambda line: None
) -> pd.DataFrame:
    """Means and standard deviations over the joints of each case, a row a case."""
    rows = []
    for name, joints in cases.items():
        shape = (joints.cells, joints.cells)
        numbers = pd.DataFrame(
            numbers_of(
                jc.simulate(
                    *jc.wall_pair(JRC, shape, SPACING, seed, **joints.walls),
                    spacing=SPACING,
                    rock=ROCK,
                    max_normal_stress=STRESS,
                )
            )
            for seed in range(joints.number)
        )
        row = {"walls": name, "side_mm": 1e3 * joints.cells * SPACING, "joints": joints.number}
        for key in numbers:
            row |= {f"{key}_mean": numbers[key].mean(), f"{key}_deviation": numbers[key].std()}
        rows.append(row)
        report(name)
    return pd.DataFrame(rows)


def main() -> None:
    """Close the joints and write the table."""
    table = model_table(CASES, lambda line: print(line, flush=True))
    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    write_csv(table, OUTPUT)


if __name__ == "__main__":
    main()

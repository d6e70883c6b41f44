"""Numerical errors that are stated of single joints, compared with true ones.

Conditions are those of `benchmarks/effects_auto.py`: E 5 to 80 GPa, strength 20 to 250 MPa, JRC 2
to 20, stress 0.001 to 0.5 of the strength, walls independent or mated beyond 1 to 10 mm, here with
32 to 64 cells along a side. A joint is closed by the tolerance of `jointclosure close`, and with
its copies by twice of it, of which the error is stated
(`jointclosure.uncertainty.numerical_error`). The true error is the difference from an eighth of
the tolerance.

`python benchmarks/numerical_error.py` writes joints.csv and coverage.csv, and goes on with the
joints that its folder has. ``--seed 7`` has the joints of which the constants were chosen.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from effects_auto import SPACING, scene

import jointclosure as jc
from jointclosure.ensembles.joints import Reading, simulate_row
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.status import FAILURE
from jointclosure.statistics.randomness import seed_of
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.numerical_error import NOT_STABLE, numerical_error, scatter_of
from jointclosure.uncertainty.variants import COPIES, coarser

TRUE = 0.125
"""Tolerance by which the true closure is simulated, over that of `close`."""
SETTINGS = [(1.0, "as it is"), *((2.0, name) for name in ("as it is", "last digits", "mirrored"))]
QUANTITIES = {"max_closure_seated_net": "net closure", "stiffness_net": "net stiffness"}
READ = (*QUANTITIES, "contacts_at_max", "status", "timing_simulation")


def closed(seed: int, number: int, cells: tuple[int, int]) -> list[dict]:
    """Simulate a joint by all settings; return rows by setting and cycle, none if one fails."""
    conditions, walls = scene(seed, number, cells)
    conditions = conditions._replace(choices=jc.Choices(strength_bound="base"))
    pair = jc.wall_pair(spacing=SPACING, seed=seed_of(seed, "numerical error", number), **walls)
    rows = []
    for tolerance, name in (*SETTINGS, (TRUE, "as it is")):
        numerics = coarser(RESOLVED, tolerance)
        try:
            here = conditions._replace(numerics=numerics).checked()
            joint = simulate_row(tuple(COPIES[name](wall) for wall in pair), Reading(here, READ))
        except jc.InputError as error:
            print(f"joint {number}: {error}")
            return []
        if joint["status"] >= FAILURE:
            print(f"joint {number}, {tolerance:g} x tolerance: status {int(joint['status'])}")
            return []
        for cycle in range(len(np.atleast_1d(joint["stiffness_net"]))):
            row = {"joint": number, "tolerance": tolerance, "copy": name, "cycle": cycle + 1}
            row |= {quantity: float(joint[quantity][cycle]) for quantity in QUANTITIES}
            row["contacts"] = float(np.ravel(joint["contacts_at_max"])[0])
            rows.append(row | {"seconds": float(joint["timing_simulation"])})
    return rows


def compared(joints: pd.DataFrame) -> pd.DataFrame:
    """Return the stated and the true relative error of each joint, cycle and quantity."""
    rows = []
    for (number, cycle), joint in joints.groupby(["joint", "cycle"]):
        by_setting = joint.set_index(["tolerance", "copy"])
        for quantity, title in QUANTITIES.items():
            values = by_setting[quantity]
            value = values[1.0].iloc[0]
            changed = values[2.0].to_numpy()
            contacts = float(by_setting.contacts[1.0].iloc[0])
            stated = numerical_error(value, changed, [value, *changed], contacts, int(cycle))
            seconds = by_setting.seconds
            rows.append({
                "joint": number, "quantity": title, "cycle": cycle, "stated": stated,
                "true": abs(value / values[TRUE].iloc[0] - 1.0), "contacts": contacts,
                "not_stable": scatter_of(changed) > NOT_STABLE,
                "cost": seconds[2.0].sum() / seconds[1.0].sum(),
            })  # fmt: skip
    return pd.DataFrame(rows)


def coverage_of(errors: pd.DataFrame) -> pd.DataFrame:
    """Count the true errors within the stated ones by quantity and cycle, with medians of both."""
    errors = errors.assign(inside=errors.true <= errors.stated, over=errors.stated / errors.true)
    by_result = errors.groupby(["quantity", "cycle"])
    table = by_result.agg(
        joints=("joint", "nunique"),
        inside=("inside", "sum"),
        stated_percent=("stated", lambda stated: 100.0 * stated.median()),
        true_percent=("true", lambda true: 100.0 * true.median()),
        stated_over_true=("over", "median"),
        not_stable=("not_stable", "sum"),
        cost=("cost", "median"),
    )
    return table.reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--joints", type=int, default=100)
    parser.add_argument("--first", type=int, default=80, help="number of the first joint")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--cells", type=int, nargs=2, default=(32, 64), metavar=("LEAST", "MOST"))
    parser.add_argument("--output", type=Path, default=Path("results/benchmarks/numerical_error"))
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    file = asked.output / "joints.csv"
    joints = read_csv(file) if file.exists() else pd.DataFrame(columns=["joint"])
    for number in range(asked.first, asked.first + asked.joints):
        if number in set(joints.joint):
            continue
        rows = pd.DataFrame(closed(asked.seed, number, tuple(asked.cells)))
        joints = pd.concat([joints, rows]) if len(joints) else rows
        write_csv(joints, file)
        print(f"joint {number}", flush=True)
    asked_for = joints.joint.between(asked.first, asked.first + asked.joints - 1)
    table = coverage_of(compared(joints[asked_for]))
    print(table.to_string(index=False))
    write_csv(table, asked.output / "coverage.csv")
    write_origin(asked.output, f"seed {asked.seed}, {joints.joint.nunique()} joints")


if __name__ == "__main__":
    main()

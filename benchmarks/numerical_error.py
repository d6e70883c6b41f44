"""Numerical errors that are stated of single joints, compared with true ones.

Conditions are those of `benchmarks/effects_auto.py`: E 5 to 80 GPa, strength 20 to 250 MPa, JRC 2
to 20, stress 0.001 to 0.5 of the strength, walls independent or mated beyond 1 to 10 mm, here with
32 to 64 cells along a side. A joint is simulated by the tolerance of `jointclosure close`, and with
its copies by twice of it, from which the error is stated
(`jointclosure.uncertainty.numerical_error`). The true error is the factor to the result by
an eighth of the tolerance, or its inverse, less 1. A joint that takes more than `LONGEST` seconds
by the tolerance of `close` is left out, because it takes up to twenty times as long by an eighth of
it.

`python benchmarks/numerical_error.py` writes joints.csv and coverage.csv, and goes on with the
joints that its folder has. ``--compare FOLDER ...`` compares constants of the limit by the joints
of these folders, by result, for the first and for later cycles. Those of the package were chosen by
joints 180 to 279 of seed 11, 0 to 90 of seed 31, 0 to 124 of seed 41 and 0 to 99 of seed 51.
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
from jointclosure.ensembles.simulation import Reading, simulate_row
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.status import FAILURE
from jointclosure.statistics.randomness import seed_of
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.numerical_error import (
    LEAST,
    NOT_STABLE,
    OF_JUMP,
    OF_SCATTER,
    log_scatter,
    numerical_error,
)
from jointclosure.uncertainty.ranged_results import CLOSURE_NET, STIFFNESS
from jointclosure.uncertainty.sources import coarser
from jointclosure.uncertainty.variants import COPIES

TRUE = 0.125
"""Tolerance by which the true closure is simulated, over that of `close`."""
SETTINGS = [(1.0, "as it is"), *((2.0, name) for name in ("as it is", "last digits", "mirrored"))]
QUANTITIES = {
    "max_closure_seated_net": ("net closure", CLOSURE_NET),
    "stiffness_net": ("net stiffness", STIFFNESS),
}
READ = (*QUANTITIES, "largest_jump", "status", "timing_simulation")
LONGEST = 10.0
"""Processor time [s] by the tolerance of `close` beyond which a joint is left out."""
CANDIDATES = [
    (least, of_jump, of_scatter)
    for least in (0.001, 0.002, 0.003, 0.005, 0.008, 0.012)
    for of_jump in (0.0, 0.05, 0.1, 0.2, 0.3, 0.6, 1.2)
    for of_scatter in (0.7, 1.0, 1.4, 2.0, 2.8)
]
"""Constants that are compared: least error, error over the jump, error over the scatter."""
KEPT = 0.92
"""Share of the joints of the comparison that keep the limit, so that at least 0.9 of others do."""
SHOWN = 5
"""Number of the best candidates of a result that are printed."""


def closed(seed: int, number: int, cells: tuple[int, int]) -> list[dict]:
    """Simulate a joint by all settings; return rows by setting and cycle, none if one fails."""
    conditions, walls = scene(seed, number, cells)
    conditions = conditions._replace(choices=jc.Choices(strength_bound="base"))
    pair = jc.wall_pair(spacing=SPACING, seed=seed_of(seed, "numerical error", number), **walls)
    rows = []
    for tolerance, name in (*SETTINGS, (TRUE, "as it is")):
        numerics = coarser(RESOLVED, tolerance)
        try:
            here = conditions._replace(numerics=numerics)
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
            row["jump"] = float(joint["largest_jump"])
            rows.append(row | {"seconds": float(joint["timing_simulation"])})
        if tolerance == 1.0 and rows[-1]["seconds"] > LONGEST:
            print(f"joint {number}: left out, as it takes {rows[-1]['seconds']:.0f} s")
            return []
    return rows


def compared(joints: pd.DataFrame) -> pd.DataFrame:
    """Return the stated and the true relative error of each joint, cycle and quantity.

    ``jump`` and ``scatter`` [1] are those from which an error is stated, and ``apart`` is the
    logarithm of the true result over that of the joint.
    """
    rows = []
    for (number, cycle), joint in joints.groupby(["joint", "cycle"]):
        by_setting = joint.set_index(["tolerance", "copy"])
        jump = float(by_setting.jump[1.0].iloc[0])
        for name, (title, column) in QUANTITIES.items():
            values = by_setting[name]
            value = values[1.0].iloc[0]
            true = values[TRUE].iloc[0]
            scatter = log_scatter([value, *values[2.0]])
            apart = np.log(true / value)
            seconds = by_setting.seconds
            rows.append({
                "joint": number, "quantity": title, "cycle": cycle,
                "stated": numerical_error(scatter, jump, column, int(cycle)),
                "true": np.expm1(abs(apart)),
                "jump": jump, "scatter": scatter, "apart": apart,
                "not_stable": scatter > NOT_STABLE,
                "cost": seconds[2.0].sum() / seconds[1.0].sum(),
            })  # fmt: skip
    return pd.DataFrame(rows)


def compared_constants(errors: pd.DataFrame) -> pd.DataFrame:
    """Compare constants of the limit by the joints of which a share of `KEPT` keeps it.

    Return the `SHOWN` best rows of `CANDIDATES` for the first and later cycles of each result, and
    that of the package: the ``limit`` over the expected error, and the median ``ratio`` of the
    limit and the true error.
    """
    rows = []
    for (quantity, first), part in errors.groupby(["quantity", errors.cycle == 1]):
        apart = part.apart.abs().to_numpy()
        own = LEAST, OF_JUMP[first], OF_SCATTER
        here = []
        for constants in dict.fromkeys([own, *CANDIDATES]):
            terms = np.stack([np.ones(len(part)), part.jump, part.scatter])
            expected = np.linalg.norm(np.array(constants)[:, None] * terms, axis=0)
            limit = np.quantile(apart / expected, KEPT)
            ratio = float(np.median(np.expm1(limit * expected) / np.expm1(apart)))
            row = dict(zip(("least", "of_jump", "of_scatter"), constants, strict=True))
            row |= {"limit": limit, "ratio": ratio, "of_package": constants == own}
            here.append({"quantity": quantity, "first": first} | row)
        table = pd.DataFrame(here).sort_values("ratio")
        rows.append(table[table.of_package | (table.ratio.rank() <= SHOWN)])
    return pd.concat(rows)


def coverage_of(errors: pd.DataFrame) -> pd.DataFrame:
    """Count the true errors within the stated ones by quantity and cycle, with medians of both.

    ``without_jump`` are the joints without a jump, and ``inside_without_jump`` those of them whose
    error is within. ``all_inside`` are joints of which all errors are.
    """
    errors = errors.assign(inside=errors.true <= errors.stated, over=errors.stated / errors.true)
    errors["without_jump"] = errors.jump == 0.0
    errors["inside_without_jump"] = errors.inside & errors.without_jump
    by_result = errors.groupby(["quantity", "cycle"])
    table = by_result.agg(
        joints=("joint", "nunique"),
        inside=("inside", "sum"),
        stated_percent=("stated", lambda stated: 100.0 * stated.median()),
        true_percent=("true", lambda true: 100.0 * true.median()),
        stated_over_true=("over", "median"),
        without_jump=("without_jump", "sum"),
        inside_without_jump=("inside_without_jump", "sum"),
        not_stable=("not_stable", "sum"),
        cost=("cost", "median"),
    )
    all_inside = int(errors.groupby("joint").inside.all().sum())
    return table.assign(all_inside=all_inside).reset_index()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--joints", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="number of the first joint")
    parser.add_argument("--seed", type=int, default=61)
    parser.add_argument("--compare", type=Path, nargs="+", help="compare constants by FOLDERs")
    parser.add_argument("--cells", type=int, nargs=2, default=(32, 64), metavar=("LEAST", "MOST"))
    parser.add_argument("--output", type=Path, default=Path("results/benchmarks/numerical_error"))
    asked = parser.parse_args()
    if asked.compare:
        errors = [compared(read_csv(folder / "joints.csv")) for folder in asked.compare]
        table = compared_constants(pd.concat(errors))
        print(table.to_string(index=False, float_format="{:.3g}".format))
        return
    asked.output.mkdir(parents=True, exist_ok=True)
    file = asked.output / "joints.csv"
    joints = read_csv(file) if file.exists() else pd.DataFrame(columns=["joint"])
    for number in range(asked.first, asked.first + asked.joints):
        if number in set(joints.joint):
            continue
        if rows := closed(asked.seed, number, tuple(asked.cells)):
            new = pd.DataFrame(rows)
            joints = pd.concat([joints, new]) if len(joints) else new
            write_csv(joints, file)
        print(f"joint {number}", flush=True)
    asked_for = joints.joint.between(asked.first, asked.first + asked.joints - 1)
    table = coverage_of(compared(joints[asked_for]))
    table = table.assign(left_out=asked.joints - table.joints, longest_s=LONGEST)
    print(table.to_string(index=False))
    write_csv(table, asked.output / "coverage.csv")
    write_origin(asked.output, f"seed {asked.seed}, {joints.joint.nunique()} joints")


if __name__ == "__main__":
    main()

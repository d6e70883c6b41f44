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
joints that its folder has. ``--fit FOLDER ...`` fits the factors of the limit to the joints of
these folders and prints them, by result, for the first and for later cycles. Those of the package
are rounded ones of joints 0 to 179 of seed 11, and 0 to 36 and 75 to 117 of seed 21.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
import scipy
from effects_auto import SPACING, scene

import jointclosure as jc
from jointclosure.ensembles.simulation import Reading, simulate_row
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.status import FAILURE
from jointclosure.statistics.randomness import seed_of
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.numerical_error import (
    NOT_STABLE,
    log_scatter,
    numerical_error,
)
from jointclosure.uncertainty.results import CLOSURE_NET, STIFFNESS
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
FREEDOM = 2.5
"""Degrees of freedom of Student's t, the distribution of errors to which terms are fitted."""
KEPT = 0.93
"""Share of the joints of the fit that keep the limit, so that at least 0.9 of others do."""


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


def fitted(errors: pd.DataFrame) -> pd.DataFrame:
    """Return the likeliest factors of the limit by result, for the first and for later cycles."""
    rows = {}
    for (quantity, first), part in errors.groupby(["quantity", errors.cycle == 1]):
        terms = np.stack([np.ones(len(part)), part.jump, part.scatter])
        apart = part.apart.to_numpy()

        def surprise(logs, terms=terms, apart=apart):
            expected = np.sqrt((np.exp(2.0 * logs) @ terms**2).clip(1e-30))
            return -scipy.stats.t.logpdf(apart / expected, FREEDOM).sum() + np.log(expected).sum()

        starts = [(-5.0, of_jump, of_scatter) for of_jump in (-2.0, 0.0) for of_scatter in (0, 1)]
        fits = [scipy.optimize.minimize(surprise, at, method="Nelder-Mead") for at in starts]
        factors = np.exp(min(fits, key=lambda fit: fit.fun).x)
        multiple = np.quantile(np.abs(apart) / np.sqrt(factors**2 @ terms**2), KEPT)
        rows[f"{quantity}, {'first' if first else 'later'} cycles"] = [*factors, multiple]
    return pd.DataFrame.from_dict(rows, "index", columns=["least", "jump", "scatter", "multiple"])


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
    parser.add_argument("--first", type=int, default=180, help="number of the first joint")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--fit", type=Path, nargs="+", help="only fit terms to joints of FOLDERs")
    parser.add_argument("--cells", type=int, nargs=2, default=(32, 64), metavar=("LEAST", "MOST"))
    parser.add_argument("--output", type=Path, default=Path("results/benchmarks/numerical_error"))
    asked = parser.parse_args()
    if asked.fit:
        errors = [compared(read_csv(folder / "joints.csv")) for folder in asked.fit]
        print(fitted(pd.concat(errors)).to_string(float_format="{:.2g}".format))
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

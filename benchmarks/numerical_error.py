"""Numerical errors that are stated of single joints, compared with true ones.

Conditions are those of `benchmarks/effects_auto.py`: E 5 to 80 GPa, strength 20 to 250 MPa, JRC 2
to 20, stress 0.001 to 0.5 of the strength, walls independent or mated beyond 1 to 10 mm, here with
32 to 64 cells along a side. A joint is simulated by the tolerance of `jointclosure close`, by twice
of it, and by the paper's steps, from which the error is stated
(`jointclosure.uncertainty.numerical_error`). The true error is the factor to the result by
an eighth of the tolerance, or its inverse, less 1. A joint that takes more than `LONGEST` seconds
by the tolerance of `close` is left out, because it takes about five times as long by an eighth of
it.

`python benchmarks/numerical_error.py` writes joints.csv and coverage.csv, and goes on with the
joints that its folder has. ``--compare FOLDER ...`` fits the weights of the limit to the joints of
these folders, by result, for the first and for later cycles: those for which the true errors are
most likely, if they are Student's t with `FREEDOM` degrees of freedom times the expected error. The
weights of the package were chosen by joints 0 to 90 of seed 31 and 0 to 99 of seed 51.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy.optimize
from effects_auto import SPACING, scene

import jointclosure as jc
from jointclosure.ensembles.simulation import read_joint, simulated_joint
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.conditions import RESOLVED
from jointclosure.joint.status import FAILURE
from jointclosure.statistics.randomness import seed_of
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.numerical_error import (
    WEIGHTS,
    Weights,
    differences_of_loading,
    log_change,
    numerical_error,
)
from jointclosure.uncertainty.ranged_results import CLOSURE_NET, STIFFNESS
from jointclosure.uncertainty.sources import by_paper_steps, coarser

CLOSE, TWICE, PAPER, TRUE = "tolerance of close", "twice", "paper's steps", "an eighth"
SETTINGS = {
    CLOSE: RESOLVED,
    TWICE: coarser(RESOLVED, 2.0),
    PAPER: by_paper_steps(RESOLVED),
    TRUE: coarser(RESOLVED, 0.125),
}
QUANTITIES = {
    CLOSURE_NET: ("net closure", "max_closure_seated_net"),
    STIFFNESS: ("net stiffness", "stiffness_net"),
}
READ = ("max_closure_seated_net", "stiffness_net", "largest_jump", "status", "timing_simulation")
LONGEST = 10.0
"""Processor time [s] by the tolerance of `close` beyond which a joint is left out."""
FREEDOM = 3.0
"""Degrees of freedom of the true errors over the expected ones, for the fit of weights."""
LEAST = 5e-4
"""Smallest least error that is fitted [1]."""
KEPT = (0.90, 0.92, 0.93, 0.94)
"""Shares of the joints of the comparison that keep the limits that are printed."""


def joint_of(
    seed: int, number: int, cells: tuple[int, int]
) -> tuple[CheckedConditions, tuple[np.ndarray, np.ndarray]]:
    """Draw the conditions of a joint and its walls (y, x) [m]; ``cells`` are bounds of its size."""
    conditions, walls = scene(seed, number, cells)
    conditions = conditions._replace(choices=jc.Choices(strength_bound="base"))
    pair = jc.wall_pair(spacing=SPACING, seed=seed_of(seed, "numerical error", number), **walls)
    return conditions, pair


def closed(seed: int, number: int, cells: tuple[int, int]) -> list[dict]:
    """Simulate a joint by all settings; return rows by setting and cycle, none if one fails."""
    conditions, pair = joint_of(seed, number, cells)
    rows = []
    for setting, numerics in SETTINGS.items():
        try:
            joint = simulated_joint(pair, conditions._replace(numerics=numerics))
        except jc.InputError as error:
            print(f"joint {number}: {error}")
            return []
        read = read_joint(joint, READ)
        if read["status"] >= FAILURE:
            print(f"joint {number}, {setting}: status {int(read['status'])}")
            return []
        if setting == CLOSE:
            own = joint.closed
        along = differences_of_loading(own, joint.closed)
        for cycle in range(len(read["stiffness_net"])):
            row = {"joint": number, "setting": setting, "cycle": cycle + 1}
            for quantity, (_, name) in QUANTITIES.items():
                row[name] = float(read[name][cycle])
                row[f"{name}_along"] = along[quantity]
            row["jump"] = float(read["largest_jump"])
            rows.append(row | {"seconds": float(read["timing_simulation"])})
        if setting == CLOSE and rows[-1]["seconds"] > LONGEST:
            print(f"joint {number}: left out, as it takes {rows[-1]['seconds']:.0f} s")
            return []
    return rows


def compared(joints: pd.DataFrame) -> pd.DataFrame:
    """Return the stated and the true relative error of each joint, cycle and quantity.

    ``jump``, ``change`` and ``curve`` [1] are those from which an error is stated, ``apart`` is the
    logarithm of the true result over that of the joint, and ``cost`` the time of the simulations
    from which the error is stated, over that of the joint.
    """
    rows = []
    for (number, cycle), joint in joints.groupby(["joint", "cycle"]):
        by_setting = joint.set_index("setting")
        jump = float(by_setting.jump[CLOSE])
        seconds = by_setting.seconds
        for quantity, (title, name) in QUANTITIES.items():
            values = by_setting[name]
            change = log_change(values[CLOSE], values[TWICE])
            curve = float(by_setting[f"{name}_along"][PAPER])
            apart = log_change(values[CLOSE], values[TRUE])
            rows.append({
                "joint": number, "result": quantity, "quantity": title, "cycle": cycle,
                "stated": numerical_error(change, curve, jump, quantity, int(cycle)),
                "true": np.expm1(abs(apart)),
                "jump": jump, "change": change, "curve": curve, "apart": apart,
                "cost": (seconds[TWICE] + seconds[PAPER]) / seconds[CLOSE],
            })  # fmt: skip
    return pd.DataFrame(rows)


def fitted_weights(
    errors: pd.DataFrame, terms: Sequence[str], weights: Mapping[tuple[str, bool], Weights]
) -> pd.DataFrame:
    """Fit the weights of each result, on the first and on later cycles, to true errors.

    Parameters
    ----------
    errors : DataFrame
        One row for each joint, result and cycle: the columns ``result``, ``quantity``, ``cycle``,
        ``apart``, the logarithm of the true result over that of the joint [1], and the ``terms``.
    terms : sequence of str
        Names of what is known of a joint [1], from which its error is expected, besides a least
        error.
    weights : mapping
        Those of the package.

    Returns
    -------
    DataFrame
        Each row has the fitted weights or those of the package, and for each of `KEPT` the
        ``limit`` over the expected error that this share of the joints keeps, with the median
        ``ratio`` of limit and true error.
    """
    rows = []
    for (quantity, first), part in errors.groupby(["result", errors.cycle == 1]):
        part = part.dropna(subset=["apart", *terms])
        apart = part.apart.abs().to_numpy()
        known = np.stack([np.ones(len(part)), *(part[name].abs() for name in terms)])

        def unlikely(
            logarithms: np.ndarray, known: np.ndarray = known, apart: np.ndarray = apart
        ) -> float:
            """Return the negative logarithm of the likelihood of the true errors, by joint."""
            expected = np.linalg.norm(np.exp(logarithms)[:, None] * known, axis=0)
            tails = np.log1p((apart / expected) ** 2 / FREEDOM)
            return float(np.mean(np.log(expected) + 0.5 * (FREEDOM + 1.0) * tails))

        bounds = [(np.log(LEAST), 0.0), *[(np.log(0.01), np.log(5.0))] * len(terms)]
        start = np.log([0.005, *[0.4] * len(terms)])
        found = np.exp(scipy.optimize.minimize(unlikely, start, bounds=bounds).x)
        candidates = {"fit": found}
        if (quantity, first) in weights:
            known_weights = weights[quantity, first]
            factors = [getattr(known_weights, f"of_{name}") for name in terms]
            candidates["package"] = np.array([known_weights.least, *factors])
        for of, values in candidates.items():
            expected = np.linalg.norm(values[:, None] * known, axis=0)
            row = {"quantity": quantity, "first": first, "weights": of, "joints": len(part)}
            row |= dict(zip(("least", *terms), values, strict=True))
            for share in KEPT:
                limit = float(np.quantile(apart / expected, share))
                ratio = np.median(np.expm1(limit * expected) / np.expm1(apart))
                row |= {f"limit {share:g}": limit, f"ratio {share:g}": float(ratio)}
            rows.append(row)
    return pd.DataFrame(rows)


COUNTS: dict[str, Any] = {
    "joints": ("joint", "nunique"),
    "inside": ("inside", "sum"),
    "stated_percent": ("stated", lambda stated: 100.0 * stated.median()),
    "true_percent": ("true", lambda true: 100.0 * true.median()),
    "stated_over_true": ("over", "median"),
    "largest_true_over_stated": ("over", lambda over: float(1.0 / over.min())),
}
"""Columns of a table of coverage, from errors with the columns ``inside`` and ``over``."""


def coverage_of(errors: pd.DataFrame) -> pd.DataFrame:
    """Count the true errors within the stated ones by quantity and cycle, with medians of both.

    ``without_jump`` are the joints without a jump, and ``inside_without_jump`` those of them whose
    error is within. ``all_inside`` are joints of which all errors are.
    """
    errors = errors.assign(inside=errors.true <= errors.stated, over=errors.stated / errors.true)
    errors["without_jump"] = errors.jump == 0.0
    errors["inside_without_jump"] = errors.inside & errors.without_jump
    table = errors.groupby(["quantity", "cycle"]).agg(
        **COUNTS,
        without_jump=("without_jump", "sum"),
        inside_without_jump=("inside_without_jump", "sum"),
        cost=("cost", "median"),
    )
    all_inside = int(errors.groupby("joint").inside.all().sum())
    return table.assign(all_inside=all_inside).reset_index()


def arguments(about: str, output: str) -> argparse.Namespace:
    """Return the options of a benchmark of errors of single joints; ``output`` is its folder."""
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("--joints", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="number of the first joint")
    parser.add_argument("--seed", type=int, default=61)
    parser.add_argument(
        "--compare", type=Path, nargs="+", help="fit weights to the joints of FOLDERs"
    )
    parser.add_argument("--cells", type=int, nargs=2, default=(32, 64), metavar=("LEAST", "MOST"))
    parser.add_argument("--output", type=Path, default=Path("results/benchmarks") / output)
    return parser.parse_args()


def compared_folders(
    folders: Sequence[Path], errors_of: Callable[[pd.DataFrame], pd.DataFrame]
) -> pd.DataFrame:
    """Return the errors of the joints of several folders."""
    return pd.concat([errors_of(read_csv(folder / "joints.csv")) for folder in folders])


def simulated_joints(
    asked: argparse.Namespace,
    simulated: Callable[[int, int, tuple[int, int]], pd.DataFrame],
) -> pd.DataFrame:
    """Simulate the joints that the output folder does not have yet; return those asked for."""
    asked.output.mkdir(parents=True, exist_ok=True)
    file = asked.output / "joints.csv"
    joints = read_csv(file) if file.exists() else pd.DataFrame(columns=["joint"])
    for number in range(asked.first, asked.first + asked.joints):
        if number in set(joints.joint):
            continue
        new = simulated(asked.seed, number, tuple(asked.cells))
        if len(new):
            joints = pd.concat([joints, new]) if len(joints) else new
            write_csv(joints, file)
        print(f"joint {number}", flush=True)
    return joints[joints.joint.between(asked.first, asked.first + asked.joints - 1)]


def write_coverage(asked: argparse.Namespace, table: pd.DataFrame, longest: float) -> None:
    """Print and write a table of coverage, with the joints that were left out, and its origin."""
    joints = int(table.joints.max())
    table = table.assign(left_out=asked.joints - joints, longest_s=longest)
    print(table.to_string(index=False))
    write_csv(table, asked.output / "coverage.csv")
    write_origin(asked.output, f"seed {asked.seed}, {joints} joints")


def main() -> None:
    asked = arguments(__doc__, "numerical_error")
    if asked.compare:
        errors = compared_folders(asked.compare, compared)
        table = fitted_weights(errors, ("jump", "change", "curve"), WEIGHTS)
        print(table.to_string(index=False, float_format="{:.3g}".format))
        return
    joints = simulated_joints(asked, lambda *of: pd.DataFrame(closed(*of)))
    write_coverage(asked, coverage_of(compared(joints)), LONGEST)


if __name__ == "__main__":
    main()

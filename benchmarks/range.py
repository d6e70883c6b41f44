"""Does the range of `jointclosure close` hold? `python benchmarks/range.py --joints 6 --sets 8`.

The range is made of closures with each source of uncertainty varied alone and of 19 joints with
random values of all sources; 9 in 10 of all such joints should lie within it. Here several sets of
19 joints are closed. Each set makes a range; the joints of the other sets that lie within are
counted, and the standard deviation of its ends between the sets is the error of a range. The
smallest and largest results of a set are compared. Joints are synthetic, of 25 mm (100 x 100
cells), in granite, to 10 MPa. Half a minute of processor time a joint, after compilation.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
import time

import numpy as np
import pandas as pd
from yardstick import machine

import jointclosure as jc
from jointclosure.engine.budget import ALL, ranges_of
from jointclosure.engine.scanned_joint import RESOLVED
from jointclosure.engine.uncertainty import (
    DRAWS,
    FURTHER,
    random_shares,
    result_rows,
    sources_of,
    uncertainty_budget,
    variants_of,
)
from jointclosure.joint.rocks import named_rock
from jointclosure.joint.simulation import close_walls
from jointclosure.statistics.randomness import seed_of

SPACING, SHAPE = 0.25e-3, (100, 100)
CLOSURE = "max_closure_seated_net_mm"
CONDITIONS = jc.Conditions(SPACING, named_rock("granite"), 10e6, numerics=RESOLVED).checked()


def joint_rows(joint: int, sets: int, root_seed: int) -> list[dict]:
    """Close a joint and its sets of joints with random values; return a row per cycle and way."""
    mismatch = None if joint % 2 else 3e-3
    seed = seed_of(root_seed, "range", joint)
    walls = jc.wall_pair(8.0, SHAPE, SPACING, seed, mismatch_wavelength=mismatch)
    start = time.process_time()
    budget = uncertainty_budget(*walls, CONDITIONS)
    about = {"joint": joint, "walls": "independent" if joint % 2 else "mated beyond 3 mm"}
    about["seconds"] = round(time.process_time() - start, 1)
    sources = sources_of(CONDITIONS, SHAPE)
    alone = budget.results[budget.results.source != ALL]
    further, drawn, ends = random_shares(sources, FURTHER, 1), [], []
    for number in range(sets):
        seed = seed_of(root_seed, "draws", joint, number)
        variants = [v for v in variants_of(CONDITIONS, sources, DRAWS, seed) if v.source == ALL]
        closed = [result_rows(v, close_walls(*v.walls(*walls), v.conditions)) for v in variants]
        rows = pd.concat([alone, *closed])
        ends.append(ranges_of(rows, sources, random_shares(sources, DRAWS, seed), further))
        drawn.append(pd.concat(closed))
    rows = []
    for cycle in budget.ranges.index.unique("cycle"):
        logs = np.log([part[part.cycle == cycle][CLOSURE] for part in drawn])
        both_ends = [end.loc[(cycle, CLOSURE), ["low", "high"]].astype(float) for end in ends]
        lows, highs = np.log(both_ends).T
        ways = {"range": (lows, highs), "extremes": (logs.min(axis=1), logs.max(axis=1))}
        rows += [
            about | {"cycle": cycle, "way": way} | _quality(logs, *both)
            for way, both in ways.items()
        ]
    return rows


def _quality(logs: np.ndarray, lows: np.ndarray, highs: np.ndarray) -> dict[str, float]:
    """Return coverage of the other sets (sets, draws), and standard deviations of ends (sets,)."""
    within = [
        np.mean((others >= low) & (others <= high))
        for number, (low, high) in enumerate(zip(lows, highs, strict=True))
        for others in [np.delete(logs, number, axis=0)]
    ]
    return {
        "within": float(np.mean(within)),
        "low_percent": 100.0 * float(np.std(lows, ddof=1)),
        "high_percent": 100.0 * float(np.std(highs, ddof=1)),
    }


def main() -> None:
    """Print a row per joint, cycle and way to a range, and their means with standard errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--sets", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rows = [row for n in range(given.joints) for row in joint_rows(n, given.sets, given.seed)]
    print(machine())
    table = pd.DataFrame(rows)
    print(table.round(2).to_string(index=False))
    means = table.groupby(["cycle", "way"])[["within", "low_percent", "high_percent"]]
    print(means.agg(["mean", "sem"]).round(3).to_string())


if __name__ == "__main__":
    main()

"""What a closure costs by the bearing-area law, and by simulation.

`python benchmarks/surrogate.py`. Walls of 100 x 100 cells, JRC 8, dolerite at 30 MPa, one cycle.
Medians, with FFT pairs of the same run; making the walls is shown apart.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from yardstick import DOLERITE, FULL, SPACING, Pair, close, machine, median_time, show

import jointclosure as jc
from jointclosure.surface.bearing import bearing_depths

STRESS = 30e6


def measured(repeats: int) -> pd.DataFrame:
    """Milliseconds and FFT pairs of every step."""
    shape = (100, 100)
    walls = jc.wall_pair(8.0, shape, SPACING, 1, roll_off=None)
    summed = walls[0] + walls[1]
    load = {"spacing": SPACING, "rock": DOLERITE}
    stresses = np.linspace(5e6, STRESS, 20)
    calls = {
        "walls made": (repeats, lambda: jc.wall_pair(8.0, shape, SPACING, 1, roll_off=None)),
        "depth of one area fraction": (repeats, lambda: bearing_depths(summed, 0.08)),
        "estimate at one stress": (
            repeats,
            lambda: jc.estimate(*walls, **load, max_normal_stress=STRESS),
        ),
        "estimate at 20 stresses": (
            repeats,
            lambda: jc.estimate(*walls, **load, max_normal_stress=stresses),
        ),
        "simulation of one cycle": (3, lambda: close(walls, FULL, STRESS)),
    }
    rows = []
    for name, (count, call) in calls.items():
        pair = Pair()
        seconds = median_time(call, count, pair.sample if count < 10 else lambda: None)
        pair.sample()
        rows.append({"what": name, "ms": 1e3 * seconds, "pairs": seconds / pair.seconds})
    return pd.DataFrame(rows)


def main(repeats: int, output: Path | None) -> None:
    """Measure, and print."""
    print(machine())
    show("A closure of a first loading", measured(repeats), output, "surrogate")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=200, help="of the fast calls")
    parser.add_argument("--output", type=Path, help="folder for the table as CSV")
    given = parser.parse_args()
    main(given.repeats, given.output)

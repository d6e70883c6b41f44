"""Errors of `jointclosure.estimate` at other spacings, sizes and roughnesses than its constants'.

Joints of dolerite are closed once to 30 MPa, with walls flat beyond 3 mm and with waves of all
lengths, at three spacings, numbers of cells and JRC. Run as
`python benchmarks/surrogate_domain.py`, six minutes of processor time; `python
docs/site/publish.py build/benchmarks surrogate_domain` stores its table, which the package ships.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))

import argparse
import itertools
from pathlib import Path

import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.engineering.stiffness import closures_at
from jointclosure.joint.history import GROSS
from jointclosure.statistics.randomness import seed_of
from jointclosure.storage.text import write_csv
from jointclosure.surface.bearing import bearing_depths
from jointclosure.surrogate.calibration import RATIOS, bounds_of
from jointclosure.surrogate.estimate import law_of, wall_measures

OUTPUT = Path(__file__).parents[1] / "build/benchmarks"
DOLERITE = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
STRESS = 30e6
ROLL_OFFS = (3e-3, None)
SPACINGS = (0.1e-3, 0.25e-3, 1e-3)
CELLS = {50: 4, 100: 4, 200: 2}
"""Number of joints of each number of cells a side."""
JRCS = (2.0, 6.0, 20.0)
MEASURED = 30
"""Number of walls of each node whose measures give the bounds of this kind of walls."""


def joint_rows(roll_off: float | None, spacing: float, cells: int, jrc: float, number: int) -> list:
    """Close a joint, and return the errors of its closures by stress."""
    seed = seed_of(1, "surrogate domain", roll_off, spacing, cells, jrc, number)
    walls = jc.wall_pair(jrc, (cells, cells), spacing, seed, roll_off=roll_off)
    ratios = np.array([*RATIOS, STRESS / DOLERITE.compressive_strength])
    history = jc.simulate(
        *walls, spacing=spacing, rock=DOLERITE, max_normal_stress=STRESS, cycles=1
    )
    closures = closures_at(history, ratios * DOLERITE.compressive_strength, GROSS)[0, 0]
    closures[-1] = float(history.max_closure[0])
    estimated = bearing_depths(walls[0] + walls[1], law_of(roll_off).fraction(ratios))
    return [
        {"stress_over_strength": ratio, "error": error}
        for ratio, error in zip(ratios, estimated / closures - 1.0, strict=True)
    ]


def node_table(roll_off: float | None, spacing: float, cells: int, jrc: float) -> pd.DataFrame:
    """Return the errors of a node's joints by stress, and the bounds of its walls' measures."""
    joints = CELLS[cells]
    rows = [row for n in range(joints) for row in joint_rows(roll_off, spacing, cells, jrc, n)]
    errors = pd.DataFrame(rows).groupby("stress_over_strength").error
    measures = []
    for number in range(MEASURED):
        seed = seed_of(2, "surrogate domain", roll_off, spacing, cells, jrc, number)
        walls = jc.wall_pair(jrc, (cells, cells), spacing, seed, roll_off=roll_off)
        measures.append(wall_measures(*walls, spacing))
    about = {"roll_off_mm": None if roll_off is None else 1e3 * roll_off, "spacing_m": spacing}
    about |= {"cells": cells, "jrc": jrc, "joints": joints} | bounds_of(measures)
    table = pd.DataFrame(
        {
            "rms_percent": 100.0 * errors.apply(lambda part: np.sqrt(np.mean(part**2))),
            "mean_percent": 100.0 * errors.mean(),
        }
    ).reset_index()
    return pd.concat([pd.DataFrame([about] * len(table)), table], axis=1)


def main() -> None:
    """Close all joints, and write the table of errors."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    nodes = []
    for node in itertools.product(ROLL_OFFS, SPACINGS, CELLS, JRCS):
        nodes.append(node_table(*node))
        print(*node, nodes[-1].rms_percent.iloc[-1], flush=True)
    write_csv(pd.concat(nodes, ignore_index=True), OUTPUT / "surrogate_domain.csv")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()

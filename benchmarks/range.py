"""Does the range of `jointclosure close` hold? `python benchmarks/range.py --joints 6 --draws 40`.

The range comes from 19 joints in which all sources of uncertainty have random values, and 9 in 10
of all such joints should lie within it. Other draws are closed here, and those within the range are
counted, joint by joint. Joints are synthetic, of 25 mm (100 x 100 cells), in granite, to 10 MPa.
Half a minute a joint on one core, after compilation.
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
from jointclosure.config.rocks import named_rock
from jointclosure.engineering.curves import cycle_table
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.scanned_joint import RESOLVED
from jointclosure.ensemble.uncertainty import ALL, sources_of, uncertainty_budget, variants_of
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.randomness import seed_of

SPACING, SHAPE = 0.25e-3, (100, 100)
CLOSURE = "closure_net_since_seating_mm"


def main() -> None:
    """Print a row per joint and cycle."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--draws", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    conditions = jc.Conditions(SPACING, named_rock("granite"), 10e6, numerics=RESOLVED).checked()
    rows, sources = [], sources_of(conditions, SHAPE)
    for joint in range(arguments.joints):
        walls = jc.wall_pair(
            8.0, SHAPE, SPACING, seed_of(arguments.seed, "range", joint),
            mismatch_wavelength=None if joint % 2 else 3e-3,
        )  # fmt: skip
        start = time.process_time()
        budget = uncertainty_budget(*walls, conditions)
        seconds = time.process_time() - start
        seed, closures = seed_of(arguments.seed, "draws", joint), []
        for variant in variants_of(conditions, sources, arguments.draws, seed):
            if variant.source != ALL:
                continue
            closed = close_walls(*variant.walls(*walls), variant.conditions)
            if int(closed.status) < FAILURE:
                closures.append(cycle_table(closed)[CLOSURE].to_numpy())
        for cycle, values in enumerate(np.array(closures).T, start=1):
            low, high = budget.ranges.loc[(cycle, CLOSURE), ["low", "high"]]
            within = float(np.mean((values >= low) & (values <= high)))
            error = float(np.sqrt(max(within * (1.0 - within), 1.0 / values.size) / values.size))
            rows.append(
                {
                    "joint": joint,
                    "walls": "independent" if joint % 2 else "mated beyond 3 mm",
                    "cycle": cycle,
                    "range_mm": budget.text(cycle, CLOSURE),
                    "draws_5_to_95_mm": "{:.2g} to {:.2g}".format(
                        *np.quantile(values, [0.05, 0.95])
                    ),
                    "within": within,
                    "error": error,
                    "seconds_of_range": round(seconds, 1),
                }
            )
    print(machine())
    table = pd.DataFrame(rows)
    print(table.round({"within": 2, "error": 2}).to_string(index=False))
    for cycle, rows_of_cycle in table.groupby("cycle"):
        mean, error = rows_of_cycle.within.mean(), rows_of_cycle.within.sem()
        print(f"cycle {cycle}: {mean:.2f} ± {error:.2f} of other draws lie within the range")


if __name__ == "__main__":
    main()

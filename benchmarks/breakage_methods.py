"""What resolved breakage costs beside the paper's steps, on the same walls.

Closes the study's own walls of each rock's base case (config/default.yaml), both cycles, with the
paper's fixed breakage steps and with resolved breakage, with one largest radius for both. Both
alternate, each repetition in the other order, and the least CPU time of all repetitions counts, as
others on the machine only add to it. Beside the times stand counts, which no machine changes, and
the difference of the mean closures. Run as `python benchmarks/breakage_methods.py`; --help lists
what can be changed. Twelve surfaces and three repetitions take a quarter of an hour.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from yardstick import (
    Pair,
    base_case,
    machine,
    paired_change,
    paper_study,
    ratio_of_sums,
    show,
    timing_parts,
)

METHODS = ("fixed_step", "resolved")
COUNTS = {
    "states": "settled_states",
    "equilibria": "equilibria",
    "Newton steps": "newton_steps",
    "products": "solver_iterations",
    "breakage steps": "breakage_steps",
}


def closed(configuration, case, realization: int) -> tuple[dict, np.ndarray]:
    """Seconds and counts of a simulation, and its maximum closures (cycle,) [mm]."""
    with timing_parts() as spent:
        seconds, found = base_case(configuration, case, realization)
    row = {"s": seconds} | {f"{part} s": each for part, each in spent.items()}
    row |= {name: int(found[variable]) for name, variable in COUNTS.items()}
    return row, 1e3 * found.max_closure.values


def compare(of_method: dict, number: int, arguments) -> dict:
    """One rock's base case by both methods: a row."""
    least: dict = {}
    closures = {}
    pair = Pair()
    for repetition in range(arguments.repeats):
        for realization in range(arguments.surfaces):
            order = METHODS if (repetition + realization) % 2 else METHODS[::-1]
            pair.sample()
            for method in order:
                configuration, cases = of_method[method]
                row, closure = closed(configuration, cases[number], realization)
                key = method, realization
                closures[key] = closure
                if key not in least or row["s"] < least[key]["s"]:
                    least[key] = row
    table = pd.DataFrame(least).T.rename_axis(["method", "realization"])
    sums = table.groupby("method").mean()
    ratios = table.s["resolved"] / table.s["fixed_step"]
    answer = {"rock": cases[number].rock, "surfaces": arguments.surfaces}
    ratio, error = ratio_of_sums(table.s["resolved"], table.s["fixed_step"])
    answer |= {"resolved over fixed": ratio, "resolved over fixed +-": error}
    answer |= {"least of a surface": ratios.min(), "largest of a surface": ratios.max()}
    for method in METHODS:
        answer |= {f"{method} {name}": value for name, value in sums.loc[method].items()}
        answer[f"{method} pairs"] = sums.s[method] / pair.seconds
    of_methods = (
        [closures[method, r] for r in range(arguments.surfaces)]
        for method in ("resolved", "fixed_step")
    )
    for cycle, (change, error) in enumerate(zip(*paired_change(*of_methods), strict=True), start=1):
        answer |= {f"cycle {cycle}: resolved less fixed %": change, f"cycle {cycle}: +- %": error}
    return answer | {"pair ms": 1e3 * pair.seconds}


def main(arguments) -> None:
    """Print the table."""
    print(machine(), flush=True)
    of_method = {
        method: paper_study(
            {"numerics": {"breakage": method}},
            {"choices": {"largest_radius_mm": arguments.radius}},
            {"study": {"rocks": arguments.rocks}} if arguments.rocks else {},
        )
        for method in METHODS
    }
    rows = []
    for number in range(len(of_method["resolved"][1])):
        for method in METHODS:  # compiled before anything is timed
            closed(*of_method[method][:1], of_method[method][1][number], 0)
        rows.append(compare(of_method, number, arguments))
        show(__doc__.splitlines()[0], pd.DataFrame(rows), arguments.output, "breakage_methods")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rocks", nargs="+", help="of the study; all, if left out")
    parser.add_argument("--surfaces", type=int, default=12)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--radius", type=float, default=20.0, help="largest, [mm]")
    parser.add_argument("--output", type=Path, help="folder for the table as CSV")
    main(parser.parse_args())

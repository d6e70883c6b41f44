"""What it saves to leave the interaction out while it is idle, and what that moves.

Closes the study's own walls of each rock's base case (config/default.yaml), both cycles, with the
interaction throughout and with `Numerics.idle_interaction` at each share. All alternate on each
surface, and the least CPU time of all repetitions counts, as others on the machine only add to it.
Differences are of means over the surfaces, with the standard error of a mean of paired differences.
Run as `python benchmarks/idle_interaction.py`; --help lists what can be changed.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from yardstick import base_case, machine, paired_change, paper_study, ratio_of_sums, show

from jointclosure.joint.history import closure_at_stresses


def closed(configuration, case, realization: int, stresses: np.ndarray) -> dict:
    """A simulation's seconds and counts, its maximum closures and those of its first loading."""
    seconds, found = base_case(configuration, case, realization)
    curve = closure_at_stresses(
        found.closure.values,
        found.normal_stress.values,
        found.cycle.values,
        found.branch.values,
        found.sizes["cycle"],
        stresses,
    )[0, 0]
    largest = float(found.normal_stress.max())
    first = found.normal_stress.values[: int(found.idle_steps) + 1]
    return {
        "s": seconds,
        "products": int(found.solver_iterations),
        "idle": float(first.max()) / largest,
        "closures": np.array([*found.max_closure.values, *curve]),
    }


def compare(settings: list, case_number: int, arguments) -> list[dict]:
    """One rock's base case at each share: rows. ``settings``: configuration and cases of no share,
    and of each."""
    stresses = 1e6 * np.array(arguments.stresses)
    case = settings[0][1][case_number]
    runs: dict = {}
    closed(settings[0][0], case, 0, stresses)  # compiled before anything is timed
    for _ in range(arguments.repeats):
        for realization in range(arguments.surfaces):
            for number, (configuration, _) in enumerate(settings):
                found = closed(configuration, case, realization, stresses)
                before = runs.get((number, realization), found)
                runs[number, realization] = found | {"s": min(found["s"], before["s"])}

    def of(number: int, name: str) -> np.ndarray:
        return np.array([runs[number, r][name] for r in range(arguments.surfaces)])

    rows = []
    for number, share in enumerate(arguments.shares, start=1):
        row = {"rock": case.rock, "share %": 100.0 * share}
        row["left out up to (% of 30 MPa)"] = 100.0 * float(np.median(of(number, "idle")))
        for name, what in (("time", "s"), ("products", "products")):
            ratio, error = ratio_of_sums(of(number, what), of(0, what))
            row |= {f"{name} saved %": 100.0 * (1.0 - ratio), f"{name} saved +- %": 100.0 * error}
        # of the first loading, joint by joint
        single = np.abs(of(number, "closures") / of(0, "closures") - 1.0)[:, 2:]
        row["single closures beyond %"] = 100.0 * float((single > share).mean())
        row["largest of single closures %"] = 100.0 * float(single.max())
        names = [
            "cycle 1",
            "cycle 2",
            *(f"loading, {stress:g} MPa" for stress in arguments.stresses),
        ]
        changes = paired_change(of(number, "closures"), of(0, "closures"))
        for name, moved, wrong in zip(names, *changes, strict=True):
            row |= {f"{name} %": moved, f"{name} +- %": wrong}
        rows.append(row)
    return rows


def main(arguments) -> None:
    """Print the table."""
    print(machine(), flush=True)
    rows: list[dict] = []
    rocks = {"study": {"rocks": arguments.rocks}} if arguments.rocks else {}
    settings = [
        paper_study({"numerics": {"idle_interaction": share}}, rocks)
        for share in (0.0, *arguments.shares)
    ]
    for number in range(len(settings[0][1])):
        rows += compare(settings, number, arguments)
        show(__doc__.splitlines()[0], pd.DataFrame(rows), arguments.output, "idle_interaction")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rocks", nargs="+", help="of the study; all, if left out")
    parser.add_argument("--shares", type=float, nargs="+", default=[0.02, 0.05])
    parser.add_argument("--surfaces", type=int, default=48)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--stresses", type=float, nargs="+", default=[1.0, 3.0, 10.0], help="[MPa]")
    parser.add_argument("--output", type=Path, help="folder for the table as CSV")
    main(parser.parse_args())

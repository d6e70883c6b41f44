"""How fast the solvers are, and what memory they take.

elastic     one cycle to 30 MPa without breakage in 20 stresses: 100 x 100 cells, 512 x 512 (or
            --cells), and as many of nearly mated walls, with the peak memory of a process
study       the base case of each rock of the paper's study, as the study closes it, or to another
            residual of equilibrium (--residual)
reference   the paper's own loop against the fast solver, one cycle to 3 MPa, on the largest grid
            whose first surface the loop closes within a --minute [s]; ratios of times mean what
            they say only where the closures of both are equal, which are given too

Medians and extremes over --repeats surfaces; kernels are compiled beforehand. Times are also given
in FFT pairs, timed in between (benchmarks/yardstick.py), on one thread.
Run as `python benchmarks/solver_speed.py --parts elastic study`, or all parts without an argument.
"""

import subprocess
from pathlib import Path

import yardstick

# isort: split
import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.storage.provenance import write_origin

SIZES = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512)


def curve_memory(cells: int, mated: bool) -> tuple[float, float]:
    """Return the peak memory [MB] of this process before and after a closure curve."""
    before = yardstick.peak_memory()
    yardstick.curve(yardstick.joint_walls(cells, 0, mated))
    return before, yardstick.peak_memory()


def elastic(arguments) -> pd.DataFrame:
    """Closure curves without breakage."""
    rows = []
    for cells, mated in ((100, False), (arguments.cells, False), (arguments.cells, True)):
        pair = yardstick.Pair()
        own = yardstick.Pair(2 * cells, 5)
        times = []
        curves = []
        for seed in range(arguments.repeats):
            walls = yardstick.joint_walls(cells, seed, mated)
            pair.sample()
            own.sample()
            seconds, found = yardstick.timed(lambda walls=walls: yardstick.curve(walls))
            if seconds < 0.1:
                seconds = yardstick.median_time(
                    lambda w=walls: yardstick.curve(w), arguments.repeats, pair.sample
                )
            times.append(seconds)
            curves.append(found)
        before, peak = yardstick.called_alone(curve_memory, cells, mated)
        products = np.median([int(found.solver_iterations) for found in curves])
        row = {"walls": "nearly mated" if mated else "independent", "cells": cells}
        row |= yardstick.spread(times, "ms", 1e3) | yardstick.spread(
            times, "pairs", 1.0 / pair.seconds
        )
        row |= {"pairs of own size": np.median(times) / own.seconds}
        row |= {
            "own pair ms": 1e3 * own.seconds,
            "products per stress": products / yardstick.POINTS,
        }
        contacts = [round(float(c.contact_fraction.max()) * cells**2) for c in curves]
        row |= {"contacts": int(np.median(contacts))}
        row |= {"contacts min": min(contacts), "contacts max": max(contacts)}
        row["worst status"] = max(int(found.status) for found in curves)
        rows.append(row | {"peak MB": peak, "before MB": before, "pair ms": 1e3 * pair.seconds})
    return pd.DataFrame(rows)


def study(arguments) -> pd.DataFrame:
    """The base cases of the paper's study."""
    configuration, cases = yardstick.paper_study(
        {"numerics": {"force_tolerance": arguments.residual}}
    )
    small = configuration._replace(grid=configuration.grid._replace(cells_x=24, cells_y=24))
    rows = []
    for case in cases:
        yardstick.base_case(small, case, 0)  # to compile
        pair = yardstick.Pair()
        times = []
        closed = []
        for realization in range(arguments.repeats):
            pair.sample()
            seconds, found = yardstick.base_case(configuration, case, realization)
            times.append(seconds)
            closed.append(found)
        steps = np.array([int(found.breakage_steps) for found in closed])
        row = {"rock": case.rock} | yardstick.spread(times, "ms", 1e3)
        row |= yardstick.spread(times, "pairs", 1.0 / pair.seconds)
        row |= {"breakage steps": np.median(steps)}
        row["ns of all time per step"] = 1e9 * np.median(times / steps)
        row["products"] = np.median([int(found.solver_iterations) for found in closed])
        row["worst status"] = max(int(found.status) for found in closed)
        rows.append(row | {"pair ms": 1e3 * pair.seconds})
    return pd.DataFrame(rows)


def largest_grid(scene: str, minute: float) -> int:
    """Return the largest of `SIZES` whose joint the reference solver simulates in time [s]."""
    done = SIZES[0]
    try:
        for cells in SIZES:
            seconds, _ = yardstick.called_alone(
                yardstick.by_solver, cells, 0, scene, "reference", timeout=minute + 9
            )
            if seconds > minute:
                break
            done = cells
    except subprocess.TimeoutExpired:
        pass
    return done


def reference(arguments) -> pd.DataFrame:
    """The paper's loop and the fast solver on the same walls."""
    rows = []
    for scene in yardstick.SCENES:
        cells = largest_grid(scene, arguments.minute)
        pair = yardstick.Pair()
        runs = []
        for seed in range(arguments.repeats):
            pair.sample()
            runs.append(
                [yardstick.by_solver(cells, seed, scene, name) for name in ("reference", "fast")]
            )
        (slow, closure), (fast, other) = np.array(runs).transpose(1, 2, 0)
        difference = 100.0 * (other - closure) / closure.mean()
        row = {"scene": scene, "cells": cells, "surfaces": arguments.repeats}
        row |= yardstick.spread(slow, "reference s", 1.0) | yardstick.spread(fast, "fast ms", 1e3)
        row |= yardstick.spread(slow / fast, "ratio", 1.0)
        row |= {"reference pairs": np.median(slow) / pair.seconds}
        row |= {"fast pairs": np.median(fast) / pair.seconds, "pair ms": 1e3 * pair.seconds}
        row |= {"reference closure um": closure.mean(), "fast closure um": other.mean()}
        row["difference %"] = difference.mean()
        row["standard error %"] = difference.std(ddof=1) / np.sqrt(difference.size)
        row["largest difference %"] = 100.0 * np.abs(other / closure - 1.0).max()
        rows.append(row)
    return pd.DataFrame(rows)


PARTS = {part.__name__: part for part in (elastic, study, reference)}


def main(arguments) -> None:
    """Print machine and tables."""
    print(yardstick.machine(), flush=True)
    yardstick.warm_up("fast", "reference")
    for name in arguments.parts:
        part = PARTS[name]
        yardstick.show(f"{name}: {part.__doc__}", part(arguments), arguments.output, name)
    if arguments.output:
        write_origin(arguments.output, f"parts {' '.join(arguments.parts)}")


if __name__ == "__main__":
    residual = jc.Numerics().force_tolerance
    defaults = {"parts": list(PARTS), "repeats": 5, "cells": 512, "minute": 60.0, "output": Path}
    main(yardstick.options(__doc__, residual=residual, **defaults))

"""Whether closures have a limit as the steps shrink, and how far from it each method is.

Closes the same random joints with the paper's fixed breakage step, both steps
scaled by a factor, and with resolved breakage at falling tolerances, without
and with a largest radius. Prints means over the surfaces, and paired
differences to the finest resolved result with their standard errors. Run as
`python benchmarks/limit_of_steps.py`; --help lists what can be changed.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse

import numpy as np
import pandas as pd
from yardstick import SPACING, machine, paper_study, timed

import jointclosure as jc

PAPER = jc.Numerics()


def fixed(factor: float) -> jc.Numerics:
    """The paper's steps, all scaled by a factor."""
    steps = {
        f"{prefix}{name}_step": factor * getattr(PAPER, f"{prefix}{name}_step")
        for prefix in ("", "later_")
        for name in ("displacement", "breakage")
    }
    return PAPER._replace(**steps)


def resolved(tolerance: float) -> jc.Numerics:
    """Resolved breakage at a tolerance."""
    return PAPER._replace(breakage="resolved", tolerance=tolerance)


def closures(walls, rock, stress: float, radius: float | None, numerics) -> list[float]:
    """Maximum closures of both cycles [mm], status, breakage steps and seconds."""
    seconds, closed = timed(
        lambda: jc.simulate(
            *walls,
            spacing=SPACING,
            rock=rock,
            max_normal_stress=stress,
            choices=jc.Choices(largest_radius=radius),
            numerics=numerics,
        )
    )
    first, second = 1e3 * closed.max_closure.values
    return [first, second, float(closed.status), float(closed.breakage_steps), seconds]


def compare(methods: dict, walls: list, rock, stress: float, radius) -> pd.DataFrame:
    """One row for each method; the last is what the others are held against."""
    found = {
        name: np.array([closures(pair, rock, stress, radius, numerics) for pair in walls])
        for name, numerics in methods.items()
    }
    finest = list(found.values())[-1]
    rows = []
    for name, values in found.items():
        row = {"method": name}
        for cycle in (0, 1):
            good = (values[:, 2] < 16) & (finest[:, 2] < 16)
            base = finest[good, cycle].mean()
            difference = values[good, cycle] - finest[good, cycle]
            error = difference.std(ddof=1) / np.sqrt(good.sum())
            row |= {
                f"closure_{cycle + 1}_mm": values[good, cycle].mean(),
                f"off_{cycle + 1}_%": 100 * difference.mean() / base,
                f"+-_{cycle + 1}_%": 100 * error / base,
            }
        row |= {"n": int(good.sum()), "million_steps": values[:, 3].mean() / 1e6}
        row["median_s"] = np.median(values[:, 4])
        rows.append(row)
    return pd.DataFrame(rows)


def main(arguments) -> None:
    """Print and write one table for each rock, stress and radius."""
    methods = {f"fixed_step x {f:g}": fixed(f) for f in arguments.factors}
    methods |= {f"resolved {t:g}": resolved(t) for t in arguments.tolerances}
    print(machine())
    tables = []
    for case in paper_study()[1]:
        if case.rock not in arguments.rocks:
            continue
        rock, shape = case.intact, (arguments.cells, arguments.cells)
        seeds = range(arguments.surfaces)
        walls = [jc.wall_pair(case.jrc, shape, SPACING, seed, roll_off=None) for seed in seeds]
        for stress in arguments.stresses:
            for radius_mm in arguments.radii:
                radius = 1e-3 * radius_mm if radius_mm > 0 else None
                for numerics in methods.values():  # compiled and warm before anything is timed
                    closures(walls[0], rock, 1e6, radius, numerics)
                table = compare(methods, walls, rock, 1e6 * stress, radius)
                about = {"rock": case.rock, "cells": arguments.cells, "stress_MPa": stress}
                about["largest_radius_mm"] = radius_mm if radius_mm > 0 else np.inf
                print(", ".join(f"{key} {value}" for key, value in about.items()))
                print(table.round(4).to_string(index=False), flush=True)
                tables.append(table.assign(**about))
    if arguments.output:
        pd.concat(tables).to_csv(arguments.output, index=False)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rocks", nargs="+", default=[c.rock for c in paper_study()[1]])
    parser.add_argument("--cells", type=int, default=48)
    parser.add_argument("--surfaces", type=int, default=12)
    parser.add_argument("--stresses", type=float, nargs="+", default=[5.0, 15.0], help="[MPa]")
    parser.add_argument(
        "--radii", type=float, nargs="+", default=[0.0, 20.0], help="largest, [mm]; 0: none"
    )
    parser.add_argument("--factors", type=float, nargs="+", default=[1.0, 0.25, 0.0625])
    parser.add_argument(
        "--tolerances", type=float, nargs="+", default=[0.1, 0.05, 0.02, 0.01, 0.005]
    )
    parser.add_argument("--output", help="CSV file")
    main(parser.parse_args())

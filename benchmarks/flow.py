"""How long the flow through a published gap takes, here and in reynoldsflow.

Both codes solve the same discretisation of Reynolds' equation on the same gap with periodic sides
(`published_gap`), and must give the published flux. Times are processor times of
whole calls, medians of runs in turn after one that is not counted. "scipy-spsolve" factorises by
SuperLU as we do, "scipy.amg-rs" is multigrid; "cholesky" needs scikit-sparse and SuiteSparse.

`pip install reynoldsflow`, then `python benchmarks/flow.py --output build/benchmarks`;
`python docs/site/publish.py build/benchmarks flow` stores the table for the page.
"""

import itertools
from collections.abc import Callable
from functools import partial
from pathlib import Path

from yardstick import machine, options, show, timed

# isort: split
import numpy as np
import pandas as pd
from published_gap import PUBLISHED_FLUXES, published_gap

from jointclosure.joint.flow import flow_along

SOLVERS = ("scipy-spsolve", "scipy.amg-rs", "cholesky")


def ours(gap: np.ndarray) -> float:
    """Return the flux [1] through a gap (y, x) by jointclosure."""
    return flow_along(gap, "y", "periodic").hydraulic_aperture ** 3


def theirs(gap: np.ndarray, solver: str) -> float:
    """Return the flux [1] through a gap (y, x) by reynoldsflow: mean outflow of the last row."""
    from reynoldsflow import transport

    _, _, flux = transport.solve_fluid_problem(gap, solver=solver)
    return abs(float(flux[-1, :, 0].mean()))


def codes() -> dict[str, Callable[[np.ndarray], float]]:
    """Return functions of the codes that are installed, by name; print those that are not."""
    runs = {"jointclosure": ours}
    for solver in SOLVERS:
        run = partial(theirs, solver=solver)
        try:
            run(published_gap(16) + 1.0)
            runs[f"reynoldsflow, {solver}"] = run
        except Exception as error:  # a package or a library of it that is missing
            print(f"reynoldsflow, {solver}, is left out: {error}")
    return runs


def main(cells: list[int], repeats: int, output: Path | None = None) -> None:
    """Print processor times and errors of all codes; write them as flow.csv in a folder."""
    runs = codes()
    rows = []
    for number in cells:
        gap = published_gap(number)
        times: dict[str, list[float]] = {name: [] for name in runs}
        for repeat, name in itertools.product(range(repeats + 1), runs):
            seconds, flux = timed(partial(runs[name], gap))
            times[name] += [seconds] if repeat else []
            if repeat == repeats:
                error = flux / PUBLISHED_FLUXES[number] - 1.0
                published = {"cells": number, "published": PUBLISHED_FLUXES[number]}
                rows.append(published | {"code": name, "relative error of flux": error})
        for row in rows[-len(runs) :]:
            row |= {"median s": np.median(times[row["code"]])}
            row |= {"least s": min(times[row["code"]]), "most s": max(times[row["code"]])}
            row["over ours"] = row["median s"] / np.median(times["jointclosure"])
    print(machine())
    show(f"{repeats} runs in turn", pd.DataFrame(rows).assign(runs=repeats), output, "flow")


if __name__ == "__main__":
    main(**vars(options(__doc__, cells=list(PUBLISHED_FLUXES), repeats=5, output=Path)))

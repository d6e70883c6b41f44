"""Does a plan hold? `python benchmarks/plan.py`: surfaces as planned are closed, and it is seen.

A pool of 60 surfaces of one rock is closed, small, and for each wish the number of surfaces is
planned from it, as `python -m studies plan` does. Then many other surfaces are closed, studies of
as many independent draws as planned are drawn from them, and what they reach is held against what
was wished. The time is held against the planned one. A minute.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from collections.abc import Callable

import numpy as np
import pandas as pd
import scipy.stats
import xarray as xr
from yardstick import machine

from jointclosure.engine.aggregation import join_cases
from jointclosure.engine.joints import close_surfaces
from jointclosure.engine.surfaces import surfaces_of
from jointclosure.statistics.indifference import indifference_interval
from jointclosure.statistics.randomness import generator
from jointclosure.statistics.standard_errors import bootstrap_error, elasticity
from jointclosure.storage.text import read_csv
from studies.frame.config.configuration import configured, merged
from studies.frame.config.files import DEFAULT, read_plain
from studies.frame.ensemble.cases import cases_of, pool_of
from studies.frame.ensemble.slices import block_settings
from studies.paper.claims import TARGET
from studies.paper.planning import Goal, plan
from studies.paper.responses import (
    Response,
    responses,
)

SIGNIFICANCE = 0.05
GOALS = (
    Goal("standard-error", 0.02),
    Goal("elasticity-error", 0.05),
    Goal("length", 15.0),
    Goal("width", 0.8),
    Goal("power", 0.8),
)
STUDIES = 400
"""Studies drawn for each wish."""


def own(samples: np.ndarray, response: Response) -> np.ndarray:
    """Samples at the rock's own level."""
    return samples[response.levels == response.base][0]


def ends_differ(samples: np.ndarray, response: Response) -> float:
    """Whether a study tells the lowest level from the highest."""
    return float(scipy.stats.ttest_ind(samples[0], samples[-1]).pvalue < SIGNIFICANCE)


def length(samples: np.ndarray, response: Response) -> float:
    """Length of a study's interval in percent of the rock's own value, infinite without root."""
    means, deviations = samples.mean(axis=1), samples.std(axis=1, ddof=1)
    found = indifference_interval(
        response.levels, means, deviations, samples.shape[1], SIGNIFICANCE, response.base
    )
    return 100.0 * found.length / response.base if np.isfinite(found.length) else np.inf


def slope(samples: np.ndarray, response: Response) -> float:
    """Elasticity that a study finds."""
    return elasticity(response.levels, samples, response.base, paired=False).value


def relative_width(lengths: np.ndarray) -> float:
    """Central 95 % of lengths over their median."""
    low, middle, high = np.quantile(lengths, (0.025, 0.5, 0.975), method="inverted_cdf")
    return float((high - low) / middle)


REACHED: dict[str, tuple[Callable, Callable]] = {
    "standard-error": (
        lambda samples, response: own(samples, response).mean(),
        lambda means: np.std(means, ddof=1) / np.mean(means),
    ),
    "elasticity-error": (slope, lambda slopes: np.std(slopes, ddof=1)),
    "length": (length, np.median),
    "width": (length, relative_width),
    "power": (ends_differ, np.mean),
}
"""For each wish a study's number, and what many studies tell of whether it was reached."""


def drawn(samples: np.ndarray, n: int, random: np.random.Generator) -> np.ndarray:
    """A study of n independent draws at every level (level, realization)."""
    return np.stack([level[random.integers(level.size, size=n)] for level in samples])


def closed(plain: dict) -> xr.Dataset:
    """Close the pool of a study, given by its keys."""
    configuration = pool_of(configured(plain, read_csv).typed)
    cases = {case.label: case for case in cases_of(configuration)}
    block = range(configuration.study.realizations)
    parts = []
    for label in cases:
        settings = block_settings(configuration, cases, label, block)
        pairs = xr.concat(list(surfaces_of(settings.surfaces)), "realization")
        parts.append(xr.concat(list(close_surfaces(pairs, settings)), "realization"))
    return join_cases(list(cases.values()), parts)


def main(cells: int, stress: float, fresh: int) -> None:
    """Plan, close, and print what is reached."""
    print(machine())
    keys = {
        "study": {"rocks": ["dolerite"], "pool": 60},
        "grid": {"cells_x": cells, "cells_y": cells},
        "rocks": {"dolerite": {"max_normal_stress_MPa": stress}},
    }
    plain = merged(read_plain(DEFAULT), keys)
    planned_from = closed(plain)
    plain = merged(plain, {"study": {"name": "fresh", "pool": fresh}})
    others = closed(plain)
    found = {(each.parameter, each.cycle): each for each in responses(others, TARGET)}
    rows = []
    for wish in GOALS:
        random, (one, all_) = generator(1), REACHED[wish.kind]
        for row in plan(planned_from, wish, SIGNIFICANCE).itertuples():
            response = found[row.parameter, row.cycle]
            # of studies that share most of their surfaces the scatter would be too small
            if not 4 <= row.surfaces <= fresh // 4:
                continue
            n = int(row.surfaces)
            drawn_studies = np.array(
                [one(drawn(response.samples, n, random), response) for _ in range(STUDIES)]
            )
            cases = (others.parameter.isin([row.parameter, "base"])).values
            seconds = float(others.timing_simulation[cases].mean("realization").sum())
            with np.errstate(invalid="ignore"):  # a range without an end has no error
                error = float(bootstrap_error(all_, drawn_studies, random))
            rows.append({
                "wish": wish.kind, "parameter": row.parameter, "cycle": row.cycle, "surfaces": n,
                "low_68": row.low_68, "high_68": row.high_68, "wished": wish.amount,
                "reached": float(all_(drawn_studies)),
                "error": error,
                "minutes_planned": row.core_minutes, "minutes_taken": n * seconds / 60.0,
            })  # fmt: skip
    print(f"dolerite, {cells} x {cells} cells, {stress:g} MPa; plans from 60 surfaces, seen on "
          f"{fresh} others, {STUDIES} studies each")  # fmt: skip
    print(pd.DataFrame(rows).to_string(index=False, float_format="{:.3g}".format))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=24)
    parser.add_argument("--stress", type=float, default=5.0, help="maximum stress [MPa]")
    parser.add_argument("--fresh", type=int, default=1000, help="surfaces to see it on")
    arguments = parser.parse_args()
    main(arguments.cells, arguments.stress, arguments.fresh)

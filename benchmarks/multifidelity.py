"""What cheaper models would save for a mean closure, by multifidelity Monte Carlo.

The result is the mean maximum closure with resolved breakage (preset `accurate`) over surfaces. A
cheaper model is closed on the same surfaces and on further ones: it is a control variate whose mean
is estimated too. What it saves follows from its correlation rho with the result and from its time
w over that of the result. With the best number of further surfaces, the variance at equal time is
(sqrt(1 - rho^2) + sqrt(w rho^2))^2 of the plain mean's; above 1, nothing is saved (Peherstorfer,
Willcox and Gunzburger 2016). The *gain* is the inverse.

Closes the study's walls of each rock's base case (config/default.yaml), both cycles, by all models
in turn on each surface. Correlations have standard errors by a bootstrap over surfaces, ratios of
times by pairs, gains the 95 % interval of the bootstrap. With MXMCPy (`pip install mxmcpy`, not in
the lock) the estimators of that library are optimised over all subsets of the --candidates models
of largest rho^2 / (1 - rho^2) / w. Models are chosen on the surfaces of which the gain is, which is
thus too large rather than too small.

Run as `python benchmarks/multifidelity.py`; sixty surfaces take about ten minutes. --read takes the
closures of an earlier run.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
import importlib.util
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from yardstick import ELASTIC, machine, paper_study, ratio_of_sums, show, timed

from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.slices import block_settings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.joint.conditions import Conditions
from jointclosure.statistics.randomness import generator
from jointclosure.surface.bearing import bearing_depths, bearing_excess

Walls = tuple[np.ndarray, np.ndarray]
Model = Callable[[Walls, Conditions], np.ndarray]
STEPS = ("displacement_step", "breakage_step", "later_displacement_step", "later_breakage_step")
RESULT = "resolved breakage (accurate)"
RESAMPLES = 1000


def closed(walls: Walls, conditions: Conditions, **changes) -> np.ndarray:
    """Maximum closure of each cycle [m] under changed conditions."""
    return close_walls(*walls, conditions._replace(**changes)).max_closure.values


def by_numerics(**changes) -> Model:
    """Model with other numerics."""
    return lambda walls, c: closed(walls, c, numerics=c.numerics._replace(**changes))


def long_steps(walls: Walls, conditions: Conditions) -> np.ndarray:
    """Maximum closures with steps four times as long and a residual of 1e-2."""
    numerics = conditions.numerics
    steps = {name: 4.0 * getattr(numerics, name) for name in STEPS}
    return closed(walls, conditions, numerics=numerics._replace(**steps, force_tolerance=1e-2))


def every_second(wall: np.ndarray) -> np.ndarray:
    """Every second cell of a wall (y, x)."""
    return wall[::2, ::2]


def averaged(wall: np.ndarray) -> np.ndarray:
    """Means of two by two cells of a wall (y, x)."""
    return wall.reshape(wall.shape[0] // 2, 2, wall.shape[1] // 2, 2).mean(axis=(1, 3))


def on_coarse(coarsen: Callable[[np.ndarray], np.ndarray]) -> Model:
    """Model on walls with a quarter of the cells, with long steps."""
    return lambda walls, c: long_steps(
        tuple(map(coarsen, walls)), c._replace(spacing=2.0 * c.spacing)
    )


def to_stress(share: float) -> Model:
    """Model loaded to a share of the maximum stress."""
    return lambda walls, c: closed(walls, c, max_normal_stress=share * c.max_normal_stress)


def cut_off(walls: Walls, conditions: Conditions) -> np.ndarray:
    """Elastic closure of walls whose summed heights are cut off at the highest 2 %."""
    upper, lower = walls
    summed = upper + lower
    above = np.maximum(summed - summed.max() + bearing_depths(summed, [0.02])[0], 0.0)
    return closed((upper - above, lower), conditions, effects=ELASTIC)


def one_quick_cycle(walls: Walls, conditions: Conditions) -> xr.Dataset:
    """Close one cycle at a residual of 1e-2."""
    numerics = conditions.numerics._replace(force_tolerance=1e-2)
    return close_walls(*walls, conditions._replace(cycles=1, numerics=numerics))


def crushed(walls: Walls, conditions: Conditions) -> np.ndarray:
    """Elastic closure on the walls that one cycle leaves."""
    coarse = one_quick_cycle(walls, conditions)
    left = coarse.upper_final.values, coarse.lower_final.values
    again = closed(left, conditions, effects=ELASTIC, cycles=1)
    return np.array([coarse.max_closure.values[0], again[0]])


def recovered(walls: Walls, conditions: Conditions) -> np.ndarray:
    """Closure and its recovered part of one cycle."""
    coarse = one_quick_cycle(walls, conditions)
    closure = coarse.max_closure.values[0]
    return np.array([closure, closure - coarse.residual_closure.values[0]])


def heights(walls: Walls, conditions: Conditions) -> np.ndarray:
    """Measures of the summed heights by which control variates adjust (docs/accuracy.md)."""
    summed = walls[0] + walls[1]
    return np.array([bearing_depths(summed, [0.05])[0], bearing_excess(summed, 0.05)])


MODELS: dict[str, Model] = {
    RESULT: by_numerics(breakage="resolved"),
    "the paper's steps": closed,
    "residual 1e-2 (quick)": by_numerics(force_tolerance=1e-2),
    "steps four times as long, residual 1e-2": long_steps,
    "every second cell, long steps": on_coarse(every_second),
    "cells averaged by four, long steps": on_coarse(averaged),
    "a third of the stress": to_stress(1.0 / 3.0),
    "a tenth of the stress": to_stress(0.1),
    "without interaction": lambda walls, c: closed(
        walls, c, effects=c.effects._replace(interaction=False)
    ),
    "one cycle (quick): closure, and its recovered part": recovered,
    "one cycle (quick), then elastic closure of the crushed walls": crushed,
    "elastic closure": lambda walls, c: closed(walls, c, effects=ELASTIC),
    "elastic closure, highest 2 % cut off": cut_off,
    "summed heights: depth, and excess of the highest 5 %": heights,
    "the same walls turned over": lambda walls, c: closed((-walls[0], -walls[1]), c),
}


def close_all(rocks: list[str], surfaces: int) -> pd.DataFrame:
    """Close all models on the same surfaces: a row for each rock, surface and model."""
    configuration, cases = paper_study({"study": {"rocks": rocks}})
    rows = []
    for case in cases:
        settings = block_settings(configuration, {case.label: case}, case.label, range(surfaces))
        conditions = settings.conditions()
        for surface, walls in enumerate(walls_of(settings.surfaces)):
            for name, model in MODELS.items():
                if surface == 0:
                    model(walls, conditions)  # compiled before anything is timed
                seconds, closures = timed(lambda m=model, w=walls, c=conditions: m(w, c))
                row = {"rock": case.rock, "surface": surface, "model": name, "seconds": seconds}
                rows.append(row | {f"cycle {i}": x for i, x in enumerate(closures, start=1)})
        print(f"closed {case.rock}", flush=True)
    return pd.DataFrame(rows)


def gain_of(correlation, time):
    """Variance of the plain mean over that of the best control variate at equal time."""
    square = np.square(correlation)
    return np.maximum((np.sqrt(1.0 - square) + np.sqrt(time * square)) ** -2, 1.0)


def correlations(values: np.ndarray) -> np.ndarray:
    """Correlation of each column of values (surface, model) with the first column."""
    return np.corrcoef(values, rowvar=False)[0]


def resampled(count: int) -> np.ndarray:
    """Indices (resample, surface) of a bootstrap over surfaces."""
    return generator(0).integers(0, count, (RESAMPLES, count))


def by_model(joints: pd.DataFrame, column: str) -> pd.DataFrame:
    """Values of a column of one rock, by surface and model."""
    return joints.pivot_table(index="surface", columns="model", values=column)


def table_of(joints: pd.DataFrame) -> pd.DataFrame:
    """Correlation, time and gain of each model, with their errors."""
    rows = []
    for rock, part in joints.groupby("rock", sort=False):
        seconds = by_model(part, "seconds")[list(MODELS)]
        for cycle in (1, 2):
            values = by_model(part, f"cycle {cycle}")[list(MODELS)].to_numpy()
            index = resampled(len(values))
            found, drawn = correlations(values), np.array([correlations(values[i]) for i in index])
            for k, name in list(enumerate(MODELS))[1:]:
                time, error = ratio_of_sums(seconds[name], seconds[RESULT])
                rho = found[k]
                low, high = np.percentile(gain_of(drawn[:, k], time), (2.5, 97.5))
                row = {"rock": rock, "cycle": cycle, "model": name, "surfaces": len(values)}
                row |= {"correlation": rho, "correlation +-": drawn[:, k].std(ddof=1)}
                row |= {"time": time, "time +-": error}
                rows.append(row | {"gain": gain_of(rho, time), "gain low": low, "gain high": high})
    return pd.DataFrame(rows)


def best_estimators(joints: pd.DataFrame, table: pd.DataFrame, candidates: int) -> pd.DataFrame:
    """Gain at equal time of the estimators of MXMCPy, each with its best subset of models."""
    import torch  # type: ignore[import-not-found]
    from mxmc import Optimizer  # type: ignore[import-not-found]

    # MXMCPy 1.0 calls a function that newer versions of torch have no more
    torch.solve = lambda right, left: (torch.linalg.solve(left, right), None)
    rows = []
    for (rock, cycle), part in table.groupby(["rock", "cycle"], sort=False):
        square = part.correlation**2
        worth = square / (1.0 - square) / part.time
        names = [RESULT, *part.model[worth.nlargest(candidates).index]]
        of_rock = joints[joints.rock == rock]
        values = by_model(of_rock, f"cycle {cycle}")[names]
        seconds = of_rock.groupby("model").seconds.mean()[names].to_numpy()
        for algorithm in ("mfmc", "mlmc", "acvmf", "acvis", "gmfmr"):

            def gain(sample: np.ndarray, by=algorithm, times=seconds) -> float:
                covariance = np.cov(sample.T) / sample[:, 0].var(ddof=1)
                target = 1000.0 * times[0]
                found = Optimizer(times, covariance).optimize(by, target, True)
                return 1.0 / (1000.0 * found.variance)

            row = {"rock": rock, "cycle": cycle, "estimator": algorithm}
            row["gain"] = gain(values.to_numpy())
            if algorithm == "mfmc":  # the others take seconds
                drawn = [gain(values.to_numpy()[i]) for i in resampled(len(values))[:100]]
                row["low"], row["high"] = np.percentile(drawn, (2.5, 97.5))
            rows.append(row | {"models": "; ".join(names[1:])})
            print(row, flush=True)
    return pd.DataFrame(rows)


def main(arguments) -> None:
    """Print and write the tables."""
    print(machine(), flush=True)
    if arguments.read:
        joints = pd.read_csv(arguments.read)
    else:
        joints = close_all(arguments.rocks, arguments.surfaces)
        if arguments.output:
            arguments.output.mkdir(parents=True, exist_ok=True)
            joints.to_csv(arguments.output / "multifidelity_joints.csv", index=False)
    table = table_of(joints)
    show("Cheaper models", table, arguments.output, "multifidelity")
    if importlib.util.find_spec("mxmc"):
        best = best_estimators(joints, table, arguments.candidates)
        show("Estimators of MXMCPy", best, arguments.output, "multifidelity_best")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rocks", nargs="+", default=["dolerite", "siltstone"])
    parser.add_argument("--surfaces", type=int, default=60)
    parser.add_argument("--candidates", type=int, default=3, help="models given to MXMCPy")
    parser.add_argument("--read", type=Path, help="closures of an earlier run (CSV)")
    parser.add_argument("--output", type=Path, help="folder for the tables as CSV")
    main(parser.parse_args())

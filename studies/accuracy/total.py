"""Work-precision diagram: total error of all methods over core-minutes.

Methods are the settings of the numerics and the elastic model, with and without control variates.
Errors of settings are those of an accuracy study at the size and stress of the default study, whose
stored repetitions give the scatter and the worth of control variates. The parts of a total error
are in `jointclosure.statistics.total_error`.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.engine.quantities import pair_seconds
from jointclosure.engine.settings import BASE
from jointclosure.engine.walls import walls_of_seed
from jointclosure.inputs import InputError
from jointclosure.statistics.control_variates import fewest_surfaces
from jointclosure.statistics.randomness import seed_of
from jointclosure.statistics.total_error import (
    REACH,
    bias_of,
    common_bias,
    front,
    method_of,
    shares,
)
from jointclosure.walls.roughness import z2_of_jrc
from studies.accuracy.design import Joint
from studies.frame.ensemble.covariates import OF_FIRST_CYCLE, OF_LATER_CYCLES, covariates_of_pair

RESPONSES = {"mean": "levels", "interval": "interval"}
"""Measure of `studies.accuracy.cost` whose error is the bias of each response.
That of a mean is of all levels of the property together."""
KEYS = ["response", "cycle", "method", "control_variates"]
"""Columns that identify a line of the diagram."""
_MOST, _STEP = 100_000, 1.19
"""Largest number of surfaces, and the factor between numbers."""
_MEASURED = (500, 1000, 2000, 4000, 8000, 16000, 32000, 64000)
"""Numbers of surfaces whose covariates are measured."""
_TIMED = 25


class Cheap(NamedTuple):
    """Times to make a pair of walls, and to measure its covariates [FFT pairs]."""

    walls: float
    covariates: float


def time_cheap(joint: Joint) -> Cheap:
    """Measure median times of operations on a surface without its closure [FFT pairs]."""
    grid, surface, jrc = joint.grid, joint.surface, joint.jrc
    z2 = z2_of_jrc(jrc, grid.spacing, surface.hurst, surface.jrc_relation)
    times = []
    for number in range(_TIMED):
        pair = pair_seconds()
        walls, made = _timed(lambda n=number: walls_of_seed(seed_of(n), jrc, grid, surface))
        _, measured = _timed(lambda w=walls: covariates_of_pair(w[0], w[1], z2))
        times.append(np.array([made, measured]) / pair)
    return Cheap(*np.median(times, axis=0).tolist())


def _timed(call: Callable):
    start = time.process_time()
    answer = call()
    return answer, time.process_time() - start


class Diagram(NamedTuple):
    """Settings of a diagram of total errors.

    ``total``: its keys (``accuracy.total`` of the configuration); ``parameter``: the property with
    the indifference interval, and the number of its ``levels``; ``measured``: number of surfaces
    that give the means of the covariates.
    """

    total: dict
    parameter: str
    levels: int
    measured: int


def method_table(
    diagram: Diagram, costs: pd.DataFrame, variance: pd.DataFrame, cheap: Cheap
) -> pd.DataFrame:
    """Compute bias, scatter and cost of every method, for each response, cycle and rock.

    ``response``, ``cycle``, ``rock``, ``method``, ``control_variates``; ``bias_percent`` with
    ``bias_low`` and ``bias_high``; the other fields of
    `jointclosure.statistics.total_error.Method`. A method without these ends for a rock,
    because an interval is absent from many resamples, has no row for that response and cycle.
    """
    scene = costs[costs.scene == diagram.total["scene"]]
    base = scene[scene.knob == BASE].iloc[0]
    second = base.seconds / base.pairs  # of an FFT pair, beside the simulations
    rows: list[dict] = []
    for response, measure in RESPONSES.items():
        times = 1 if response == "mean" else diagram.levels
        for rock, cycle in scene[["rock", "cycle"]].drop_duplicates().itertuples(index=False):
            cycles = diagram.total.get("interval_cycles") or [cycle]
            if response == "interval" and cycle not in cycles:
                continue
            about = {"response": response, "cycle": cycle, "rock": rock}
            scatter = _scatter(variance, about, diagram)
            for name in diagram.total["methods"]:
                row = _row(scene, diagram.total, name, rock, cycle)
                cost = times * (row.seconds + second * cheap.walls)
                bias = _error(row, measure)
                rows += [about | {"method": name} | _bias(bias, cost) | kind for kind in scatter]
    table = pd.DataFrame(rows).assign(measured_cost=second * (cheap.walls + cheap.covariates))
    # an error without a confidence interval is unknown
    known = table.bias_low.notna().groupby([table[key] for key in KEYS]).transform("all")
    return _common_to_rocks(table[known].reset_index(drop=True))


def _common_to_rocks(table: pd.DataFrame) -> pd.DataFrame:
    """Give the bias of intervals that all rocks have in common, as that of one is hardly known."""
    for _, part in table[table.response == "interval"].groupby(KEYS):
        measured = part[["bias_percent", "bias_low", "bias_high"]].itertuples(index=False)
        bias = common_bias([bias_of(*row) for row in measured])
        percent, half = 100.0 * bias.value, 100.0 * REACH * bias.error
        table.loc[part.index, "bias_percent"] = percent
        table.loc[part.index, "bias_low"] = percent - half
        table.loc[part.index, "bias_high"] = percent + half
    return table


def _bias(bias: tuple[float, ...], cost: float) -> dict:
    """Return columns of a method's bias [%], its confidence interval, and its cost [s]."""
    return dict(zip(("bias_percent", "bias_low", "bias_high"), bias, strict=True)) | {"cost": cost}


def _error(row: pd.Series, measure: str) -> tuple[float, ...]:
    """Return the error [%] of a measure with its confidence interval."""
    return tuple(row[f"{measure}_{of}"] for of in ("error_percent", "low", "high"))


def _row(scene: pd.DataFrame, total: dict, name: str, rock: str, cycle: int) -> pd.Series:
    """Return the row of a method's setting, of the costs of a variant of the model."""
    point = total["methods"][name]
    here = (scene.rock == rock) & (scene.cycle == cycle) & (scene.knob == point["knob"])
    here &= scene["value"].map(_text) == _text(point["value"])
    if not here.any():
        raise InputError(f"accuracy.total: {name} = {point}: is no setting of {total['scene']}")
    return scene[here].iloc[0]


def _text(value: object) -> str:
    """Return the text of a knob's value, which a file gives as number, text, or NaN for none."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except ValueError:
        return str(value)
    return "" if np.isnan(number) else f"{number:g}"


def _scatter(variance: pd.DataFrame, about: dict, diagram: Diagram) -> list[dict]:
    """Return the scatter of one surface, without and with control variates."""
    parameter, cycle = BASE if about["response"] == "mean" else diagram.parameter, about["cycle"]
    here = np.logical_and.reduce([variance[key] == value for key, value in about.items()])
    here &= (variance.parameter == parameter) & (variance.draws == "independent")
    if "value" not in variance or not here.any():
        missing = ", ".join(str(value) for value in about.values())
        raise InputError(f"variance_reduction.csv: has no worth of control variates for {missing}")
    row = variance[here].iloc[0]
    scatter = row.plain_error / abs(row["value"]) * np.sqrt(row.surfaces)
    left, explained = shares(row.worth, row.surfaces, diagram.measured)
    covariates = len(OF_FIRST_CYCLE if cycle == 1 else OF_LATER_CYCLES)
    return [
        {"control_variates": False, "scatter": scatter, "left": 1.0, "explained": 0.0, "least": 2},
        {"control_variates": True, "scatter": scatter, "left": left, "explained": explained}
        | {"least": fewest_surfaces(covariates)},
    ]


def point_table(methods: pd.DataFrame) -> pd.DataFrame:
    """Compute total error and core-minutes of every method with every split of a budget.

    For each response, cycle, method and control variates: ``surfaces`` closed and
    ``measured``, ``core_minutes`` of the rock where they are most; ``total_percent`` of the
    rock where it is largest, its parts ``bias_percent``, ``bias_error_percent`` (1.96 standard
    errors of it) and ``sampling_percent``.
    ``best``: whether no other row of the response and cycle is both faster and more exact.
    """
    rows = []
    for names, part in methods.groupby(KEYS, sort=False):
        about = dict(zip(KEYS, names, strict=True))
        methods_of_rocks = [method_of(row) for row in part.itertuples()]
        for surfaces, measured in _splits(
            max(method.least for method in methods_of_rocks), bool(names[-1])
        ):
            worst = max(methods_of_rocks, key=lambda method: method.total(surfaces, measured))
            seconds = max(
                method.seconds(surfaces, measured if names[-1] else 0.0)
                for method in methods_of_rocks
            )
            rows.append(
                about
                | {"surfaces": surfaces, "measured": measured if names[-1] else 0}
                | {"core_minutes": seconds / 60.0}
                | {"total_percent": 100.0 * worst.total(surfaces, measured)}
                | {"bias_percent": 100.0 * abs(worst.bias.value)}
                | {"bias_error_percent": 100.0 * REACH * worst.bias.error}
                | {"sampling_percent": 100.0 * worst.sampling(surfaces, measured)}
            )
    table = pd.DataFrame(rows)
    best = np.zeros(len(table), dtype=bool)
    for index in table.groupby(KEYS[:2], sort=False).indices.values():
        part = table.iloc[index]
        best[index[front(part.core_minutes.to_numpy(), part.total_percent.to_numpy())]] = True
    return table.assign(best=best)


def _splits(least: int, adjusted: bool) -> Iterator[tuple[int, float]]:
    """Generate numbers of closed and of measured surfaces."""
    count: float = least
    while count <= _MOST:
        for measured in _MEASURED if adjusted else (np.inf,):
            yield round(count), measured
        count = max(count + 1, count * _STEP)


def split_table(points: pd.DataFrame, budgets: Iterable[float]) -> pd.DataFrame:
    """Find the best split of every budget [core-minutes], by response and cycle."""
    rows = []
    for _, part in points.groupby(["response", "cycle"], sort=False):
        for budget in budgets:
            within = part[part.core_minutes <= budget]
            if len(within):
                best = within.loc[within.total_percent.idxmin()]
                rows.append({"budget": budget} | best.to_dict())
    return pd.DataFrame(rows)

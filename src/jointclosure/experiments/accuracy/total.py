"""One work-precision diagram: the total error of every way to a result, against its core-minutes.

Ways are the settings of the numerics, the elastic model and the bearing-area law, each plain and
with control variates. Errors of settings are those of an accuracy study at the size and
stress of a second study, whose repetitions tell the scatter and what control variates are
worth. How a total error is put together is in `jointclosure.statistics.total_error`.
"""

import functools
import time
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.ensemble.cases import BASE
from jointclosure.ensemble.covariates import (
    OF_FIRST_CYCLE,
    OF_LATER_CYCLES,
    covariates_of_pair,
)
from jointclosure.ensemble.surfaces import walls_of_seed
from jointclosure.ensemble.timing import pair_seconds
from jointclosure.experiments.accuracy.design import Joint
from jointclosure.inputs import InputError
from jointclosure.statistics.control_variates import fewest_surfaces
from jointclosure.statistics.randomness import seed_of
from jointclosure.statistics.total_error import REACH, front, method_of, shares
from jointclosure.surface.roughness import z2_of_jrc
from jointclosure.surrogate.estimate import ALL_ROCKS, estimate

SURROGATE = "surrogate"
RESPONSES = ("mean", "interval")
KEYS = ["response", "cycle", "method", "control_variates"]
"""What a line of the diagram is of."""
_MOST, _STEP = 100_000, 1.19
"""Surfaces that are gone up to, by so large a factor a step."""
_MEASURED = (500, 1000, 2000, 4000, 8000, 16000, 32000, 64000)
"""Surfaces whose covariates are measured."""
_TIMED = 25


class Cheap(NamedTuple):
    """FFT pairs that it takes to make a pair of walls, to measure its covariates, to estimate."""

    walls: float
    covariates: float
    estimate: float


def time_cheap(joint: Joint) -> Cheap:
    """What is done with a surface that is not closed, timed: medians of a few [FFT pairs]."""
    grid, surface, jrc = joint.grid, joint.surface, joint.jrc
    z2 = z2_of_jrc(jrc, grid.spacing, surface.hurst, surface.jrc_relation)
    law = functools.partial(
        estimate,
        spacing=grid.spacing,
        rock=joint.rock,
        max_normal_stress=joint.stress,
        extrapolate=True,
    )
    found = []
    for number in range(_TIMED):
        pair = pair_seconds()
        walls, made = _timed(lambda n=number: walls_of_seed(seed_of(n), jrc, grid, surface))
        _, measured = _timed(lambda w=walls: covariates_of_pair(w[0], w[1], z2))
        _, estimated = _timed(lambda w=walls: law(*w))
        found.append(np.array([made, measured, estimated]) / pair)
    return Cheap(*np.median(found, axis=0).tolist())


def _timed(call: Callable):
    start = time.process_time()
    answer = call()
    return answer, time.process_time() - start


class Told(NamedTuple):
    """What is told of a study whose total errors are asked for.

    ``total``: the keys of the diagram (``accuracy.total`` of the configuration); ``parameter``:
    whose interval is followed; ``levels`` of it; ``measured``: surfaces that told the means of the
    covariates.
    """

    total: dict
    parameter: str
    levels: int
    measured: int


def method_table(
    told: Told, costs: pd.DataFrame, variance: pd.DataFrame, surrogate: pd.DataFrame, cheap: Cheap
) -> pd.DataFrame:
    """Bias, scatter and cost of every method, for each response, cycle and rock.

    Parameters
    ----------
    told : Told
    costs : DataFrame
        As from `jointclosure.experiments.accuracy.cost.cost_table`.
    variance : DataFrame
        ``variance_reduction.csv`` of the study.
    surrogate : DataFrame
        ``surrogate.csv`` of the study: what the bearing-area law is off by on its joints.
    cheap : Cheap

    Returns
    -------
    DataFrame
        ``response``, ``cycle``, ``rock``, ``method``, ``control_variates``; ``bias_percent`` with
        ``bias_low`` and ``bias_high``; the other fields of
        `jointclosure.statistics.total_error.Method`. A method of which these ends are not known for
        a rock, as an interval is absent from many resamples, has no row in that response and cycle.

    Raises
    ------
    InputError
        A setting that the accuracy study does not have, or a rock or response that a table lacks.
    """
    scene = costs[costs.scene == told.total["scene"]]
    base = scene[scene.knob == BASE].iloc[0]
    second = base.seconds / base.pairs  # of an FFT pair, beside the simulations
    rows: list[dict] = []
    for response in RESPONSES:
        times = 1 if response == "mean" else told.levels
        for rock, cycle in scene[["rock", "cycle"]].drop_duplicates().itertuples(index=False):
            cycles = told.total.get("interval_cycles") or [cycle]
            if response == "interval" and cycle not in cycles:
                continue
            about = {"response": response, "cycle": cycle, "rock": rock}
            scatter = _scatter(variance, about, told)
            for name in told.total["methods"]:
                seconds = _row(costs, told.total, name, "mean", rock, cycle).seconds
                row = _row(costs, told.total, name, response, rock, cycle)
                bias = tuple(row[f"{response}_{of}"] for of in ("error_percent", "low", "high"))
                cost = times * (seconds + second * cheap.walls)
                rows += [about | {"method": name} | _bias(bias, cost) | kind for kind in scatter]
            if response == "mean" and cycle == 1:
                # what the law gives is known of all that is measured: nothing is left to adjust
                bias = _of_surrogate(surrogate, scene, rock)
                cost = second * (cheap.walls + cheap.estimate)
                rows.append(about | {"method": SURROGATE} | _bias(bias, cost) | scatter[0])
    table = pd.DataFrame(rows).assign(measured_cost=second * (cheap.walls + cheap.covariates))
    # where resamples have no interval nothing is known of its error
    known = table.bias_low.notna().groupby([table[key] for key in KEYS]).transform("all")
    return table[known].reset_index(drop=True)


def _bias(bias: tuple[float, ...], cost: float) -> dict:
    """A method's bias [%], its confidence interval, and its cost [s]."""
    return dict(zip(("bias_percent", "bias_low", "bias_high"), bias, strict=True)) | {"cost": cost}


def _row(costs: pd.DataFrame, total: dict, name: str, response: str, rock: str, cycle: int):
    """The row of a method's setting that tells of a response."""
    scene, points = total["scene"], total["methods"]
    of_intervals = total.get("interval_methods", {})
    if response == "interval" and name in of_intervals:
        scene, points = total["interval_scene"], of_intervals
    point = points[name]
    here = (costs.scene == scene) & (costs.rock == rock) & (costs.cycle == cycle)
    here &= (costs.knob == point["knob"]) & (costs["value"].map(_text) == _text(point["value"]))
    if not here.any():
        raise InputError(f"accuracy.total: {name} = {point}: is not turned in {scene}")
    return costs[here].iloc[0]


def _text(value: object) -> str:
    """A knob's value as text: that of a file may be a number, a text of it, or NaN for none."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except ValueError:
        return str(value)
    return "" if np.isnan(number) else f"{number:g}"


def _of_surrogate(table: pd.DataFrame, scene: pd.DataFrame, rock: str) -> tuple[float, ...]:
    """Mean error [%] of the bearing-area law at a rock's largest stress and own roughness.

    It was fitted to closures with the study's own steps, so what these are off by is in it too.
    """
    part = table[(table.constants == ALL_ROCKS) & (table.rock == rock)]
    if part.empty:
        raise InputError(
            f"surrogate.csv: has no joints of {rock}; run `.venv/bin/snakemake surrogate`"
        )
    row = part[part.stress_MPa == part.stress_MPa.max()].iloc[0]
    half = REACH * row.rms_percent / np.sqrt(row.joints)
    own = scene[(scene.knob == BASE) & (scene.rock == rock) & (scene.cycle == 1)].iloc[0]
    steps = (own.mean_error_percent, own.mean_low, own.mean_high)
    law = (row.mean_percent, row.mean_percent - half, row.mean_percent + half)
    both = zip(law, steps, strict=True)
    return tuple(100.0 * ((1.0 + 0.01 * a) * (1.0 + 0.01 * b) - 1.0) for a, b in both)


def _scatter(variance: pd.DataFrame, about: dict, told: Told) -> list[dict]:
    """Scatter of one surface, plain and with control variates."""
    parameter, cycle = BASE if about["response"] == "mean" else told.parameter, about["cycle"]
    here = np.logical_and.reduce([variance[key] == value for key, value in about.items()])
    here &= (variance.parameter == parameter) & (variance.draws == "independent")
    if "value" not in variance or not here.any():
        wanted = ", ".join(str(value) for value in about.values())
        raise InputError(
            f"variance_reduction.csv: does not say what control variates are worth for {wanted}; "
            "run that study with enough surfaces, and with statistics.control_variates"
        )
    row = variance[here].iloc[0]
    scatter = row.plain_error / abs(row["value"]) * np.sqrt(row.surfaces)
    left, explained = shares(row.worth, row.surfaces, told.measured)
    covariates = len(OF_FIRST_CYCLE if cycle == 1 else OF_LATER_CYCLES)
    return [
        {"control_variates": False, "scatter": scatter, "left": 1.0, "explained": 0.0, "least": 2},
        {"control_variates": True, "scatter": scatter, "left": left, "explained": explained}
        | {"least": fewest_surfaces(covariates)},
    ]


def point_table(methods: pd.DataFrame) -> pd.DataFrame:
    """Total error and core-minutes of every method with every split of a budget.

    Parameters
    ----------
    methods : DataFrame
        As from `method_table`.

    Returns
    -------
    DataFrame
        For each response, cycle, method and control variates: ``surfaces`` closed and
        ``measured``, ``core_minutes`` of the rock where they are most; ``total_percent`` of the
        rock where it is largest, its parts ``bias_percent``, ``bias_error_percent`` (1.96 standard
        errors of it) and ``sampling_percent``.
        ``best``: that nothing of the response and cycle beats in both.
    """
    rows = []
    for names, part in methods.groupby(KEYS, sort=False):
        about = dict(zip(KEYS, names, strict=True))
        ways = [method_of(row) for row in part.itertuples()]
        for surfaces, measured in _splits(max(way.least for way in ways), bool(names[-1])):
            worst = max(ways, key=lambda way: way.total(surfaces, measured))
            seconds = max(way.seconds(surfaces, measured if names[-1] else 0.0) for way in ways)
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
    """Surfaces closed, and measured."""
    count: float = least
    while count <= _MOST:
        for measured in _MEASURED if adjusted else (np.inf,):
            yield round(count), measured
        count = max(count + 1, count * _STEP)


def split_table(points: pd.DataFrame, budgets: Iterable[float]) -> pd.DataFrame:
    """The best split of every budget [core-minutes], by response and cycle; as `point_table`."""
    rows = []
    for _, part in points.groupby(["response", "cycle"], sort=False):
        for budget in budgets:
            within = part[part.core_minutes <= budget]
            if len(within):
                best = within.loc[within.total_percent.idxmin()]
                rows.append({"budget": budget} | best.to_dict())
    return pd.DataFrame(rows)

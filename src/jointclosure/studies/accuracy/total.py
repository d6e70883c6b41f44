"""One work-precision diagram: the total error of every way to a result, against its core-minutes.

Ways are the settings of the numerics, the elastic model and the bearing-area law, each plain and
with control variates. Errors of settings are those of an accuracy study at the size and
stress of a second study, whose repetitions tell the scatter and what control variates are
worth. How a total error is put together is in `jointclosure.statistics.total_error`.
"""

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
from jointclosure.inputs import InputError
from jointclosure.randomness import seed_of
from jointclosure.statistics.control_variates import fewest_surfaces
from jointclosure.statistics.total_error import Method, front, shares
from jointclosure.studies.accuracy.design import Joint
from jointclosure.surface.roughness import z2_of_jrc
from jointclosure.surrogate import estimate

SURROGATE = "surrogate"
RESPONSES = ("mean", "interval")
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
    told = {"spacing": grid.spacing, "rock": joint.rock}
    told |= {"normal_stress": joint.stress, "extrapolate": True}
    found = []
    for number in range(_TIMED):
        pair = pair_seconds()
        walls, made = _timed(lambda n=number: walls_of_seed(seed_of(n), jrc, grid, surface))
        _, measured = _timed(lambda w=walls: covariates_of_pair(*w, z2))
        _, estimated = _timed(lambda w=walls: estimate(*w, **told))
        found.append(np.array([made, measured, estimated]) / pair)
    return Cheap(*np.median(found, axis=0).tolist())


def _timed(call: Callable):
    start = time.process_time()
    answer = call()
    return answer, time.process_time() - start


class Told(NamedTuple):
    """What is told of a study whose total errors are asked for.

    ``scene``: the variant of the accuracy study that has its size and stress; ``points``: knob and
    value of each method by name; ``parameter``: whose interval is followed; ``levels`` of it;
    ``measured``: surfaces that told the means of the covariates.
    """

    scene: str
    points: dict[str, dict]
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
        As from `jointclosure.studies.accuracy.cost.cost_table`.
    variance : DataFrame
        ``variance_reduction.csv`` of the study.
    surrogate : DataFrame
        ``surrogate.csv`` of the study: what the bearing-area law is off by on its joints.
    cheap : Cheap

    Returns
    -------
    DataFrame
        ``response``, ``cycle``, ``rock``, ``method``, ``control_variates``; ``bias_percent`` with
        ``bias_low`` and ``bias_high`` where they are known; the fields of
        `jointclosure.statistics.total_error.Method`.

    Raises
    ------
    InputError
        A setting that the accuracy study does not have.
    """
    scene = costs[costs.scene == told.scene]
    base = scene[scene.knob == BASE].iloc[0]
    second = base.seconds / base.pairs  # of an FFT pair, beside the simulations
    rows: list[dict] = []
    for response in RESPONSES:
        for (rock, cycle), own in scene.groupby(["rock", "cycle"], sort=False):
            about = {"response": response, "cycle": cycle, "rock": rock}
            scatter = _scatter(variance, about, told)
            biases = list(_biases(own, response, told))
            if response == "mean" and cycle == 1:
                biases.append(_of_surrogate(surrogate, rock, cheap, second))
            for name, bias, seconds in biases:
                times = 1 if response == "mean" else told.levels
                cost = times * (seconds + second * cheap.walls)
                for kind in scatter:
                    # what the law gives is known of all that is measured: nothing is left to adjust
                    if name == SURROGATE and kind["control_variates"]:
                        continue
                    rows.append(about | {"method": name} | bias | kind | {"cost": cost})
    table = pd.DataFrame(rows)
    return table.assign(measured_cost=second * (cheap.walls + cheap.covariates))


def _biases(own: pd.DataFrame, response: str, told: Told) -> Iterator[tuple[str, dict, float]]:
    """Name, bias and seconds a simulation of every setting, at a rock and cycle."""
    for name, point in told.points.items():
        found = own[(own.knob == point["knob"]) & (own["value"].fillna("") == str(point["value"]))]
        if found.empty:
            raise InputError(
                f"accuracy.total.methods.{name} = {point}: is not turned in {told.scene}"
            )
        row = found.iloc[0]
        bias = {
            f"bias_{to}": row[f"{response}_{of}"]
            for to, of in (("percent", "error_percent"), ("low", "low"), ("high", "high"))
        }
        yield name, bias, row.seconds


def _of_surrogate(table: pd.DataFrame, rock: str, cheap: Cheap, second: float):
    """The same of the bearing-area law, at the rock's largest stress and own roughness."""
    part = table[(table.constants == "all") & (table.rock == rock)]
    part = part[part.stress_MPa == part.stress_MPa.max()]
    bias = {"bias_percent": part.mean_percent.iloc[0], "bias_low": np.nan, "bias_high": np.nan}
    return SURROGATE, bias, second * cheap.estimate


def _scatter(variance: pd.DataFrame, about: dict, told: Told) -> list[dict]:
    """Scatter of one surface, plain and with control variates."""
    parameter, cycle = BASE if about["response"] == "mean" else told.parameter, about["cycle"]
    here = np.logical_and.reduce([variance[key] == value for key, value in about.items()])
    here &= (variance.parameter == parameter) & (variance.draws == "independent")
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
        rock where it is largest, its parts ``bias_percent`` and ``sampling_percent``.
        ``best``: that nothing of the response and cycle beats in both.
    """
    rows = []
    keys = ["response", "cycle", "method", "control_variates"]
    for names, part in methods.groupby(keys, sort=False):
        about = dict(zip(keys, names, strict=True))
        ways = [_method(row) for row in part.itertuples()]
        for surfaces, measured in _splits(max(way.least for way in ways), bool(names[-1])):
            worst = max(ways, key=lambda way: way.total(surfaces, measured))
            seconds = max(way.seconds(surfaces, measured if names[-1] else 0.0) for way in ways)
            rows.append(
                about
                | {"surfaces": surfaces, "measured": measured if names[-1] else 0}
                | {"core_minutes": seconds / 60.0}
                | {"total_percent": 100.0 * worst.total(surfaces, measured)}
                | {"bias_percent": 100.0 * abs(worst.bias)}
                | {"sampling_percent": 100.0 * worst.sampling(surfaces, measured)}
            )
    table = pd.DataFrame(rows)
    best = np.zeros(len(table), dtype=bool)
    for index in table.groupby(keys[:2], sort=False).indices.values():
        part = table.iloc[index]
        best[index[front(part.core_minutes.to_numpy(), part.total_percent.to_numpy())]] = True
    return table.assign(best=best)


def _method(row) -> Method:
    return Method(
        0.01 * row.bias_percent,
        row.scatter,
        row.left,
        row.explained,
        row.cost,
        row.measured_cost,
        row.least,
    )


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

"""Quantities in which simulated joints are compared with a measured curve: closure, stiffness."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.measured.likelihood import Readings
from jointclosure.statistics.standard_errors import CONFIDENCE


class ComparedQuantity(NamedTuple):
    """Quantity of a measured curve or of simulated joints, by which the two are compared."""

    name: str  # in words
    unit: str
    values: np.ndarray  # (...)
    error: np.ndarray  # standard errors (...) of the values
    first_loading: bool  # whether it depends on the first loading alone


def about_share(unit: str, low: float) -> str:
    """Return what a negative share of the closure that stays means, to be put behind its values.

    The text is empty unless the ``unit`` is "%" and the lowest value ``low`` is below 0.
    """
    negative = unit == "%" and low < 0.0
    return " (negative: the joint opens beyond the start of the loading)" if negative else ""


def compared_quantities(
    values: np.ndarray, readings: Readings, error: float = 0.0
) -> list[ComparedQuantity]:
    """Compute, by cycle, the closure at the maximum, the stiffness and the share that stays.

    ``values`` (..., n) [m] are closures at the places of ``readings``, with a relative ``error`` of
    one standard deviation. The stiffness is the chord between the two highest stresses at which the
    cycle is read, and left out if there is one. The share of the closure that stays is left out for
    a cycle that was not unloaded. Ratios of the stiffness of later cycles to that of the first come
    last.
    """
    places = readings.places()
    result = []
    stiffnesses = []
    for cycle in range(1, readings.cycles + 1):
        levels = [level for number, level in places if number == cycle and level is not None]
        closures = [values[..., places.index((cycle, level))] for level in levels]
        whole = closures[-1]
        first = cycle == 1
        name = f"closure of cycle {cycle}"
        result.append(ComparedQuantity(name, "mm", 1e3 * whole, 1e3 * error * whole, first))
        if len(levels) > 1:
            rise = levels[-1] - levels[-2]
            run = whole - closures[-2]
            with np.errstate(divide="ignore", invalid="ignore"):
                stiffness = 1e-9 * rise / run
                spread = stiffness * error * np.hypot(whole, closures[-2]) / run
            between = " to ".join(f"{1e-6 * level:.3g}" for level in levels[-2:])
            name = f"stiffness of cycle {cycle}, {between} MPa"
            stiffnesses.append(ComparedQuantity(name, "MPa/mm", stiffness, spread, first))
            result.append(stiffnesses[-1])
        if (cycle, None) in places:
            recovered = values[..., places.index((cycle, None))] / whole
            name = f"share of the closure of cycle {cycle} that stays"
            spread = 100.0 * recovered
            spread = math.sqrt(2.0) * error * spread
            result.append(ComparedQuantity(name, "%", 100.0 * (1.0 - recovered), spread, False))
    for later in stiffnesses[1:] if stiffnesses and stiffnesses[0].first_loading else ():
        base = stiffnesses[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = later.values / base.values
            spread = ratio * np.hypot(later.error / later.values, base.error / base.values)
        name = f"{later.name.partition(',')[0]} over the first"
        result.append(ComparedQuantity(name, "1", ratio, spread, False))
    return result


def prediction_intervals(
    measured: Readings, joints: np.ndarray, error: float
) -> Iterator[tuple[ComparedQuantity, np.ndarray, np.ndarray]]:
    """Generate each measured quantity with the 95 % interval that one more simulated joint keeps.

    ``joints`` (nodes, joints, n) [m] are readings of simulated joints at neighbouring values of a
    parameter, NaN where a joint failed. ``error`` is the relative error of the readings
    ``measured``, which the interval contains. The ends of the interval (nodes,) are NaN at nodes at
    which all joints failed. The scatter of the joints is pooled over neighbouring nodes, and is
    that of the logarithms if all values are positive. For a share of the closure that stays, it is
    the scatter of the share that is recovered.
    """
    both = (compared_quantities(values, measured, error) for values in (joints, measured.values))
    for simulated, one in zip(*both, strict=True):
        values = simulated.values
        value = float(one.values)
        spread = float(one.error)
        if share := one.unit == "%":
            values = 100.0 - values
            value = 100.0 - value
        positive = bool((values[np.isfinite(values)] > 0.0).all()) and value > 0.0
        rows, spread = (np.log(values), spread / value) if positive else (values, spread)
        nodes = np.flatnonzero(np.isfinite(rows).any(axis=1))  # where not all joints failed
        ends = np.full((2, len(rows)), np.nan)
        rows = rows[nodes]
        count = np.isfinite(rows).sum(axis=1)
        weights = np.exp(-0.5 * (nodes[:, None] - nodes) ** 2) * (count > 1)
        weights /= weights.sum(axis=1, keepdims=True)
        mean = np.nanmean(rows, axis=1)
        scatter = np.nanvar(rows, axis=1)
        variance = weights @ np.nan_to_num(scatter * count / np.maximum(count - 1, 1))
        freedom = 1.0 / (weights**2 @ (1.0 / np.maximum(count - 1, 1)))
        factor = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)
        half = factor * np.sqrt(variance * (1.0 + 1.0 / count) + spread**2)
        ends[:, nodes] = mean - half, mean + half
        ends = np.exp(ends) if positive else ends
        yield one, *(100.0 - ends[::-1] if share else ends)

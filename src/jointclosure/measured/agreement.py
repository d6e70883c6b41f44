"""Readings of a measured curve beside those of simulated joints: closure, stiffness, what stays."""

import math
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.measured.calibration import CONFIDENCE, Likelihood, Readings


class Quantity(NamedTuple):
    """Reading of a curve in words, with its unit, values (...), and their standard errors."""

    name: str
    unit: str
    values: np.ndarray
    error: np.ndarray
    first_loading: bool  # whether it is of the first loading alone


class Agreement(NamedTuple):
    """Range of a fitted parameter at which simulated joints have a measured reading."""

    name: str
    unit: str
    measured: float
    low: float  # wavelength [m], or strength [Pa] if the wavelength is known; NaN if there is none
    high: float
    least: float  # ends of the 95 % interval of a single joint nearest to the measured value
    most: float
    first_loading: bool

    @property
    def missed(self) -> bool:
        """Whether no simulated joint has the measured reading."""
        return math.isnan(self.low)


def quantities_of(values: np.ndarray, readings: Readings, error: float) -> list[Quantity]:
    """Compute closure at the maximum, stiffness, and the share that stays, of every cycle."""
    places = readings.places()
    result: list[Quantity] = []
    for cycle in range(1, readings.cycles + 1):
        levels = [level for number, level in places if number == cycle and level is not None]
        closures = [values[..., places.index((cycle, level))] for level in levels]
        whole, first = closures[-1], cycle == 1
        name = f"closure of cycle {cycle}"
        result.append(Quantity(name, "mm", 1e3 * whole, 1e3 * error * whole, first))
        if len(levels) > 1:
            rise, run = levels[-1] - levels[-2], whole - closures[-2]
            with np.errstate(divide="ignore", invalid="ignore"):
                stiffness = 1e-9 * rise / run
                spread = stiffness * error * np.hypot(whole, closures[-2]) / run
            between = " to ".join(f"{1e-6 * level:.3g}" for level in levels[-2:])
            name = f"stiffness of cycle {cycle}, {between} MPa"
            result.append(Quantity(name, "MPa/mm", stiffness, spread, first))
        if (cycle, None) in places:
            share = 1.0 - values[..., places.index((cycle, None))] / whole
            spread = np.full(share.shape, 100.0 * math.sqrt(2.0) * error)
            name = f"share of the closure of cycle {cycle} that stays"
            result.append(Quantity(name, "%", 100.0 * share, spread, False))
    return result


def quantities(values: np.ndarray, readings: Readings) -> dict[str, tuple[str, np.ndarray]]:
    """Compute quantities of readings (..., n) with units, and later over first stiffness."""
    found = {one.name: (one.unit, one.values) for one in quantities_of(values, readings, 0.0)}
    stiffness = [(name, each) for name, (unit, each) in found.items() if unit == "MPa/mm"]
    for name, later in stiffness[1:] if stiffness and "cycle 1," in stiffness[0][0] else ():
        found[f"{name.partition(',')[0]} over the first"] = "1", later / stiffness[0][1]
    return found


def agreements(
    measured: Readings, logs: np.ndarray, likelihood: Likelihood, error: float
) -> list[Agreement]:
    """Compare each reading with the 95 % interval of a single simulated joint, by wavelength."""
    axis = 0 if likelihood.wavelengths.size > 1 else 1
    fine = (likelihood.wavelengths, likelihood.strengths)[axis]
    other = likelihood.nodes(likelihood.best, logs.shape[:2])[1 - axis]
    joints = np.exp(logs.take(other, axis=1 - axis))
    nodes, at = np.linspace(0.0, 1.0, len(joints)), np.linspace(0.0, 1.0, fine.size)
    both = (quantities_of(values, measured, error) for values in (joints, measured.values))
    result = []
    for simulated, one in zip(*both, strict=True):
        value = float(one.values)
        ends_of_one = _intervals(simulated.values, value, one.error)
        least, most = (np.interp(at, nodes, end) for end in ends_of_one)
        apart = np.maximum(np.maximum(least - value, value - most), 0.0)
        within, nearest = np.flatnonzero(apart == 0.0), int(apart.argmin())
        low, high = (fine[within[0]], fine[within[-1]]) if within.size else (math.nan, math.nan)
        ends = float(low), float(high), float(least[nearest]), float(most[nearest])
        result.append(Agreement(one.name, one.unit, value, *ends, one.first_loading))
    return result


def _intervals(
    values: np.ndarray, measured: float, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends (nodes,) of the 95 % interval of one more joint, with its measuring error."""
    positive = bool((values[np.isfinite(values)] > 0.0).all()) and measured > 0.0
    rows = np.log(values) if positive else values
    spread = float(error) / measured if positive else float(error)
    count = np.maximum(np.isfinite(rows).sum(axis=1), 1)
    number = np.arange(len(rows))
    weights = np.exp(-0.5 * (number[:, None] - number) ** 2) * (count > 1)
    weights /= weights.sum(axis=1, keepdims=True)
    mean = np.nanmean(rows, axis=1)
    variance = weights @ np.nan_to_num(np.nanvar(rows, axis=1) * count / np.maximum(count - 1, 1))
    freedom = 1.0 / (weights**2 @ (1.0 / np.maximum(count - 1, 1)))
    factor = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)
    half = factor * np.sqrt(variance * (1.0 + 1.0 / count) + spread**2)
    ends = mean - half, mean + half
    return (np.exp(ends[0]), np.exp(ends[1])) if positive else ends

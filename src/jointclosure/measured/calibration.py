"""Likelihood of mismatch wavelength, and strength, from a measured closure curve.

Joints of a rock and roughness are closed at mismatch wavelengths from mated to independent walls,
and at several strengths if these are fitted too. A measured curve is one draw of them: its readings
are compared with the mean and the scatter of theirs.
"""

import itertools
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy
import xarray as xr

from jointclosure.engine.workers import Failed, shared
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.joint.simulation import close_walls
from jointclosure.joint.stiffness import closures_at
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.parameters import both_walls

PARTS = (0.25, 0.5, 1.0)
"""Stresses at which closures of a loading are read, as shares of the range above seating."""
CONFIDENCE = 0.95
CURVE_POINTS = 25
"""Number of stresses, from seating to the maximum, at which curves of joints are kept."""
_STEPS = 161
"""Number of wavelengths, and of strengths, at which the likelihood is computed."""
_SAME_STRESS = 1e-3
"""Largest difference of equal stresses, over the largest stress of a curve."""
_SAME_LOAD = 0.02
"""Largest allowed relative difference of the largest stresses of cycles."""


class Readings(NamedTuple):
    """Readings of a curve: closures since seating on loading, and recovered closures on unloading.

    ``cycles`` were measured, from the first on; ``unloaded`` are those unloaded back to seating.
    ``levels`` [Pa] are the stresses of the loadings; ``seating`` [Pa]; ``values`` (n,) [m]. Levels
    at which a loading has too few points are not read: ``read`` has the numbers of those that are,
    by cycle, and is empty if all are.
    """

    cycles: int
    unloaded: tuple[int, ...]
    levels: np.ndarray
    seating: float
    values: np.ndarray
    read: tuple[tuple[int, ...], ...] = ()

    def places(self) -> list[tuple[int, float | None]]:
        """Return the cycle and the stress [Pa] of each value, None for a recovered closure."""
        places: list[tuple[int, float | None]] = []
        for cycle in range(1, self.cycles + 1):
            numbers = self.read[cycle - 1] if self.read else range(len(self.levels))
            places += [(cycle, float(self.levels[number])) for number in numbers]
            places += [(cycle, None)] * (cycle in self.unloaded)
        return places

    def names(self) -> list[str]:
        """Return a description of each value."""
        return [
            f"closure recovered in cycle {cycle}"
            if level is None
            else f"closure of cycle {cycle} at {1e-6 * level:.3g} MPa"
            for cycle, level in self.places()
        ]


class Simulated(NamedTuple):
    """Simulated joints (wavelengths, strengths, joints, ...) of a fit.

    ``logs`` (..., readings) are logarithms of their readings; all readings of a joint are NaN if
    one is missing. ``closures`` (..., cycles, 2, stresses) are net closures [m] on loading and
    unloading since the seating of each cycle, at ``stresses`` [Pa].
    """

    logs: np.ndarray
    closures: np.ndarray
    stresses: np.ndarray


class Interval(NamedTuple):
    """Estimate, and the ends of its 95 % interval."""

    value: float
    low: float
    high: float


class Likelihood(NamedTuple):
    """Likelihood of a curve over mismatch wavelengths [m] and strengths [Pa].

    ``log`` (wavelengths, strengths) is the log likelihood. ``means`` (wavelengths, strengths,
    readings) and ``scatter`` (wavelengths, readings) are mean and standard deviation of the
    logarithms of the readings. ``p_value`` is the probability that a joint of the most likely
    wavelength and strength is at least as far from their mean as the measured one.
    """

    wavelengths: np.ndarray
    strengths: np.ndarray
    log: np.ndarray
    means: np.ndarray
    scatter: np.ndarray
    p_value: float

    def least_distances(self, measured: Readings) -> np.ndarray:
        """Compute each reading's smallest distance (readings,) from a mean, over its scatter."""
        distances = np.abs(np.log(measured.values) - self.means) / self.scatter[:, None, :]
        return distances.min(axis=(0, 1))

    def interval(self, axis: int) -> Interval:
        """Compute the interval of the wavelength (axis 0) or strength (1) by profile likelihood."""
        values = (self.wavelengths, self.strengths)[axis]
        profile = self.log.max(axis=1 - axis)
        best = int(profile.argmax())
        threshold = profile[best] - 0.5 * scipy.stats.chi2.ppf(CONFIDENCE, 1)
        within = np.flatnonzero(profile >= threshold)
        estimate = [float(values[i]) for i in (best, within[0], within[-1])]
        if (
            axis == 0 and values.size > 1
        ):  # the ends of the simulated wavelengths represent all beyond
            ends = {0: 0.0, values.size - 1: np.inf}
            estimate = [
                ends.get(int(i), value)
                for i, value in zip((best, within[0], within[-1]), estimate, strict=True)
            ]
        return Interval(*estimate)


def readings_of_curve(curve: MeasuredCurve, seating_stress: float) -> Readings:
    """Read a measured curve, whose cycles must be 1, 2, ... to one largest stress."""
    cycles = curve.cycles
    if cycles != list(range(1, len(cycles) + 1)):
        raise InputError(f"cycles {cycles}: must be 1, 2 and so on without gaps")
    largest = [float(curve.branches(cycle)[LOADING][0].max()) for cycle in cycles]
    for cycle, stress in zip(cycles, largest, strict=True):
        if abs(stress - largest[0]) > _SAME_LOAD * largest[0]:
            raise InputError(
                f"cycle {cycle} is loaded to {1e-6 * stress:g} MPa and cycle 1 to "
                f"{1e-6 * largest[0]:g} MPa: must be the same"
            )
    levels = seating_stress + np.array(PARTS) * (min(largest) - seating_stress)
    unloaded = tuple(
        cycle
        for cycle in cycles
        if curve.branches(cycle)[UNLOADING][0].min(initial=np.inf) <= seating_stress
    )
    read = tuple(
        _levels_read(curve.branches(cycle)[LOADING][0], seating_stress) for cycle in cycles
    )
    asked = Readings(len(cycles), unloaded, levels, seating_stress, np.empty(0), read)
    values = readings_of_history(_as_history(curve), asked)
    if not np.all(values > 0.0):
        cycle, level = asked.places()[int(np.argmin(values > 0.0))]
        branch = "decrease on unloading" if level is None else "increase with stress on loading"
        raise InputError(f"closure of cycle {cycle} must {branch}")
    return asked._replace(values=values)


def _levels_read(stress: np.ndarray, seating_stress: float) -> tuple[int, ...]:
    """Return the numbers of the levels for which a loading has points enough."""
    between = int(((stress > seating_stress) & (stress < stress.max())).sum())
    return tuple(range(max(len(PARTS) - 1 - between, 0), len(PARTS)))


def _as_history(curve: MeasuredCurve) -> xr.Dataset:
    """Convert a measured curve to a history, to be read like that of a simulated joint."""
    branches: list[tuple[int, str, np.ndarray, np.ndarray]] = []
    cycles_read = [curve.branches(cycle) for cycle in curve.cycles]
    for of_cycle, following in itertools.pairwise(cycles_read):
        if not of_cycle[UNLOADING][0].size:
            stress, closure = following[LOADING]
            of_cycle[UNLOADING] = stress[:1], closure[:1]
    for cycle, of_cycle in zip(curve.cycles, cycles_read, strict=True):
        first, zero = (points[0] for points in of_cycle[LOADING])
        offset = 0.0
        if branches and branches[-1][2].size:
            before, end = branches[-1][2][-1], branches[-1][3][-1]
            again = abs(before - first) <= _SAME_STRESS * curve.stress.max()
            offset = end - zero if again else 0.0
        branches += [
            (cycle, branch, stress, closure + offset)
            for branch, (stress, closure) in of_cycle.items()
        ]
    names = np.concatenate([[branch] * stress.size for _, branch, stress, _ in branches])
    cycles = np.concatenate([np.full(stress.size, cycle) for cycle, _, stress, _ in branches])
    columns = {
        "normal_stress": np.concatenate([stress for *_, stress, _ in branches]),
        "closure": np.concatenate([closure for *_, closure in branches]),
        "bulk_indentation": np.zeros(cycles.size),
        "cycle": cycles,
        "branch": names,
    }
    return xr.Dataset({name: ("step", values) for name, values in columns.items()})


def readings_of_history(history: xr.Dataset, asked: Readings) -> np.ndarray:
    """Return the same readings of a simulated joint, net of bulk indentation; NaN if missing."""
    stresses = np.append(asked.seating, asked.levels)
    closures = closures_at(history, stresses)
    values = []
    for cycle, level in asked.places():
        loading, unloading = closures[cycle - 1]
        if level is None:
            values.append(loading[-1] - unloading[0])
        else:
            values.append(loading[int(np.argmax(stresses == level))] - loading[0])
    return np.array(values)


def simulated_readings(
    walls: Callable[[int, float], tuple[np.ndarray, np.ndarray]],
    conditions: Conditions,
    asked: Readings,
    wavelengths: np.ndarray,
    strengths: np.ndarray,
    surfaces: int,
    workers: int = 1,
    report: Callable[[float], None] = lambda share: None,
) -> Simulated:
    """Close joints at all wavelengths and strengths, and read them as a measured curve."""
    shape = (len(wavelengths), len(strengths), surfaces)
    intact = both_walls(conditions.rock)[0]
    logs = np.full((*shape, asked.values.size), np.nan)
    stresses = np.linspace(asked.seating, asked.levels[-1], CURVE_POINTS)
    closures = np.full((*shape, asked.cycles, 2, CURVE_POINTS), np.nan)
    places = [(i, j, k) for k, i, j in np.ndindex(surfaces, *shape[:2])]
    tasks = []
    for i, j, k in places:
        number = int(np.ravel_multi_index((i, j, k), shape)) + 1
        rock = intact._replace(compressive_strength=float(strengths[j]))
        made = partial(walls, number, float(wavelengths[i]))
        tasks.append((made, conditions._replace(rock=rock), asked, stresses))
    answers = itertools.chain(
        shared(_read_joint, tasks[:1], 1),
        ((place + 1, answer) for place, answer in shared(_read_joint, tasks[1:], workers)),
    )
    for count, (task, answer) in enumerate(answers, start=1):
        if isinstance(answer, Failed):
            raise answer.error
        logs[places[task]], closures[places[task]] = answer
        report(count / len(tasks))
    return Simulated(logs, closures, stresses)


def _read_joint(
    walls: Callable[[], tuple[np.ndarray, np.ndarray]],
    conditions: Conditions,
    asked: Readings,
    stresses: np.ndarray,
) -> tuple[np.ndarray | float, np.ndarray | float]:
    """Close a joint, and return its entries of `Simulated.logs` and `closures`, or NaN."""
    closed = close_walls(*walls(), conditions)
    values = readings_of_history(closed, asked)
    if closed.status >= FAILURE or not np.all(values > 0.0):
        return np.nan, np.nan
    along = closures_at(closed, stresses)
    return np.log(values), along - along[:, :1, :1]


def joints_needed(nodes: tuple[int, ...], readings: int) -> int:
    """Return the least number of joints for a fit, over numbers of wavelengths and strengths."""
    varied = nodes[0] > 1, nodes[1] > 1
    return 3 * (_terms(np.zeros((1, 2)), varied).shape[1] + readings)


def likelihood_of(
    measured: Readings,
    simulated: np.ndarray,
    wavelengths: np.ndarray,
    strengths: np.ndarray,
    error: float,
) -> Likelihood:
    """Compute the likelihood of a measured curve from simulated joints.

    The mean of the log readings is a polynomial of the logarithms of wavelength (cubic) and
    strength (quadratic), fitted to all joints. The scatter about it, of surfaces, is the covariance
    of the residuals, pooled over neighbouring wavelengths by a Gaussian weight as wide as their
    distance. The measured curve is one more draw, so that its distance has a multivariate t
    distribution (synthetic likelihood with an estimated covariance).
    """
    x, y = _scaled(wavelengths), _scaled(strengths)
    at = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    rows = np.broadcast_to(at[:, :, None, :], (*simulated.shape[:3], 2)).reshape(-1, 2)
    logs = simulated.reshape(-1, simulated.shape[-1])
    known = np.isfinite(logs).all(axis=1)
    rows, logs = rows[known], logs[known]
    size, varied = logs.shape[1], (x.size > 1, y.size > 1)
    if len(logs) < joints_needed(simulated.shape[:2], size):
        raise InputError(
            f"{len(logs)} of {known.size} joints could be read: too few to fit; a longer range of "
            "stresses or more surfaces are needed"
        )
    weights, *_ = np.linalg.lstsq(_terms(rows, varied), logs, rcond=None)
    residuals = logs - _terms(rows, varied) @ weights
    fine_x, fine_y = (np.linspace(0.0, 1.0, _STEPS if part.size > 1 else 1) for part in (x, y))
    width = 1.0 / max(x.size - 1, 1)
    log = np.empty((fine_x.size, fine_y.size))
    distances, spread = np.empty_like(log), np.empty((fine_x.size, size))
    means = np.empty((*log.shape, size))
    for i, place in enumerate(fine_x):
        near = np.exp(-0.5 * ((rows[:, 0] - place) / width) ** 2)
        near /= near.sum()
        freedom = 1.0 / float(np.sum(near**2)) - 1.0
        scatter = (residuals * near[:, None]).T @ residuals * (1.0 + 1.0 / freedom)
        scatter += error**2 * np.eye(size)
        means[i] = _terms(np.column_stack([np.full(fine_y.size, place), fine_y]), varied) @ weights
        spread[i] = np.sqrt(np.diag(scatter))
        apart = np.log(measured.values) - means[i]
        squares = np.einsum("ij,ij->i", apart @ np.linalg.inv(scatter), apart)
        half_sum = 0.5 * (freedom + size)
        log[i] = -0.5 * np.linalg.slogdet(scatter)[1] - half_sum * np.log1p(squares / freedom)
        distances[i] = scipy.stats.f.sf(squares / size, size, freedom)
    best = np.unravel_index(int(log.argmax()), log.shape)
    return Likelihood(
        _unscaled(fine_x, wavelengths),
        _unscaled(fine_y, strengths),
        log,
        means,
        spread,
        float(distances[best]),
    )


def _scaled(values: np.ndarray) -> np.ndarray:
    """Return logarithms of ascending values, scaled from 0 to 1."""
    logs = np.log(np.asarray(values, dtype=float))
    return (logs - logs[0]) / max(logs[-1] - logs[0], np.finfo(float).tiny)


def _unscaled(part: np.ndarray, values: np.ndarray) -> np.ndarray:
    first, last = np.log(values[0]), np.log(values[-1])
    return np.exp(first + part * (last - first))


def _terms(rows: np.ndarray, varied: tuple[bool, bool]) -> np.ndarray:
    """Return terms of the mean: cubic in the first column, quadratic in the second, if varied."""
    x, y = rows.T
    terms = [np.ones_like(x)]
    terms += [x, x**2, x**3] if varied[0] else []
    terms += [y, y**2] if varied[1] else []
    terms += [x * y, x**2 * y] if all(varied) else []
    return np.stack(terms, axis=1)

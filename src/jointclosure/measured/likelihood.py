"""Readings of a measured curve, and the likelihood of mismatch wavelength and strength.

Joints of a rock and roughness are simulated at mismatch wavelengths from mated to independent
walls, and at several strengths if these are fitted too. A measured curve is one draw of them: its
readings are compared with the mean and the scatter of theirs.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.joint.history import history_of
from jointclosure.joint.status import LOADING, UNLOADING
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.dense_logs import LEAST_POINTS, exceeds_former
from jointclosure.statistics.number_texts import percent, significant
from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.statistics.two_level import Interval

PARTS = (0.25, 0.5, 1.0)
"""Stresses at which closures of a loading are read, as shares of the range above seating."""
CURVE_POINTS = 25
"""Number of stresses, from seating to the maximum, at which curves of joints are kept."""
_STEPS = 161
"""Number of wavelengths, and of strengths, at which the likelihood is computed."""
_SAME_STRESS = 1e-3
"""Largest difference of equal stresses, over the largest stress of a curve."""
_SAME_LOAD = 0.02
"""Largest allowed relative difference of the largest stresses of cycles."""


class Readings(NamedTuple):
    """Readings of a measured curve, with which simulated joints are compared.

    ``values`` are closures since seating on loading, at stresses with enough points, and the
    closures that were recovered on unloading.
    """

    cycles: int
    unloaded: tuple[int, ...]  # cycles that were unloaded back to seating
    levels: np.ndarray  # stresses of the loadings [Pa]
    seating: float
    values: np.ndarray  # (n,) [m]
    read: tuple[tuple[int, ...], ...] = ()  # numbers of the levels of each cycle; (): all
    errors: np.ndarray | None = None  # (n,) [m], standard errors by the scatter of points

    def places(self) -> list[tuple[int, float | None]]:
        """Return the cycle and the stress [Pa] of each value, None for a recovered closure."""
        places: list[tuple[int, float | None]] = []
        for cycle in range(1, self.cycles + 1):
            numbers = self.read[cycle - 1] if self.read else range(len(self.levels))
            places += [(cycle, float(self.levels[number])) for number in numbers]
            places += [(cycle, None)] * (cycle in self.unloaded)
        return places

    def names(self) -> list[str]:
        """Return a description of each reading, such as "closure of cycle 1 at 2.5 MPa"."""
        recovered = "closure recovered in cycle {}"
        closed = "closure of cycle {} at {:.3g} MPa"
        return [
            recovered.format(cycle) if level is None else closed.format(cycle, 1e-6 * level)
            for cycle, level in self.places()
        ]


class Simulated(NamedTuple):
    """Simulated joints (wavelengths, strengths, joints, ...) of a fit."""

    logs: np.ndarray  # (..., readings), logarithms; NaN for a joint of which one is missing
    closures: np.ndarray  # (..., cycles, 2, stresses) [m], net since the seating of each cycle
    stresses: np.ndarray  # [Pa]


class Likelihood(NamedTuple):
    """Likelihood of a curve over mismatch wavelengths [m] and strengths [Pa]."""

    wavelengths: np.ndarray
    strengths: np.ndarray
    log: np.ndarray  # (wavelengths, strengths)
    means: np.ndarray  # (wavelengths, strengths, readings), of logarithms
    scatter: np.ndarray  # (wavelengths, readings), standard deviations of logarithms
    p_values: np.ndarray  # (wavelengths, strengths), of as large a distance from the mean

    @property
    def best(self) -> tuple[int, int]:
        """Place of the most likely wavelength and strength."""
        i, j = np.unravel_index(int(self.log.argmax()), self.log.shape)
        return int(i), int(j)

    def nodes(self, place: Sequence[int], counts: Sequence[int]) -> tuple[int, int]:
        """Return the simulated node next to a ``place`` on the finer grid of the likelihood.

        Both are indices of (wavelength, strength). ``counts`` are the numbers of wavelengths and
        strengths at which joints were simulated.
        """
        i, j = (
            round(at / max(fine - 1, 1) * (count - 1))
            for at, fine, count in zip(place, self.log.shape, counts, strict=True)
        )
        return i, j

    @property
    def p_value(self) -> float:
        """P-value at the most likely wavelength and strength."""
        return float(self.p_values.flat[self.log.argmax()])

    def interval(self, axis: int) -> Interval:
        """Compute the interval of the wavelength (axis 0) or strength (1) by profile likelihood."""
        values = np.array((self.wavelengths, self.strengths)[axis])
        profile = self.log.max(axis=1 - axis)
        threshold = profile.max() - 0.5 * scipy.stats.chi2.ppf(CONFIDENCE, 1)
        within = np.flatnonzero(profile >= threshold)
        if axis == 0 and values.size > 1:  # the ends represent all wavelengths beyond
            values[0] = 0.0
            values[-1] = np.inf
        return Interval(*values[[profile.argmax(), within[0], within[-1]]].tolist())


def readings_of_curve(curve: MeasuredCurve, seating_stress: float) -> Readings:
    """Return the readings of a measured curve, whose closure counts from a seating stress [Pa].

    Raise `InputError` unless its cycles are 1, 2, ... to the same largest stress, and closures
    increase on loading and decrease on unloading.
    """
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
    lowest = {c: curve.branches(c)[UNLOADING][0].min(initial=np.inf) for c in cycles}
    unloaded = tuple(cycle for cycle in cycles if lowest[cycle] <= seating_stress)
    read: tuple[tuple[int, ...], ...] = ()
    for loading in (curve.branches(cycle)[LOADING][0] for cycle in cycles):
        between = int(((loading > seating_stress) & (loading < loading.max())).sum())
        read += (tuple(range(max(len(PARTS) - 1 - between, 0), len(PARTS))),)
    asked = Readings(len(cycles), unloaded, levels, seating_stress, np.empty(0), read)
    values = readings_of_history(_history_of_curve(curve), asked)
    if not np.all(values > 0.0):
        cycle, level = asked.places()[int(np.argmin(values > 0.0))]
        branch = "decrease on unloading" if level is None else "increase with stress on loading"
        raise InputError(f"closure of cycle {cycle} must {branch}")
    return asked._replace(values=values, errors=_reading_errors(curve, asked))


def _reading_errors(curve: MeasuredCurve, asked: Readings) -> np.ndarray | None:
    """Compute standard errors (n,) [m] of readings of averaged points; None if none are."""
    cycles = {cycle: curve.ascending(cycle) for cycle in curve.cycles}
    if not any(branch.errors.any() for both in cycles.values() for branch in both.values()):
        return None

    def error(cycle: int, branch: str, stress: float) -> float:
        of_branch = cycles[cycle][branch]
        if not of_branch.stress.size:
            return 0.0
        return float(np.interp(stress, of_branch.stress, of_branch.errors))

    errors = []
    for cycle, level in asked.places():
        largest = float(asked.levels[-1])
        branch = UNLOADING if level is None else LOADING
        closed = error(cycle, LOADING, largest if level is None else level)
        errors.append(math.hypot(closed, error(cycle, branch, asked.seating)))
    return np.array(errors)


def curve_sentences(curve: MeasuredCurve) -> list[str]:
    """Return sentences on the cycles of a curve, and on its points that are not read."""
    sentences: list[str] = []
    if (starts := np.flatnonzero(curve.line[1:] == curve.line[:-1]) + 1).size:
        lines = ", ".join(str(line) for line in curve.line[starts])
        sentences.append(
            f"without a column of cycles, the {len(curve.cycles)} loadings of the curve are its "
            f"cycles; they meet at line {lines}"
        )
    plain = [b for c in curve.cycles for b in curve.ascending(c).values() if not b.averaged]
    if passed_over := sum(int((~exceeds_former(branch.stress)).sum()) for branch in plain):
        sentences.append(caution(
            f"{passed_over} of {curve.stress.size} measured points do not exceed all stresses "
            "before them on their branch and are not read, which biases readings if stresses "
            f"scatter: measure more densely (branches of {LEAST_POINTS} points are averaged)"
        ))  # fmt: skip
    return sentences


def reading_sentences(curve: MeasuredCurve, measured: Readings, closure_error: float) -> list[str]:
    """Return sentences on how a curve was read, with a caution if it scatters more than stated."""
    sentences = curve_sentences(curve)
    if measured.errors is None:
        return sentences
    branches = [curve.ascending(cycle)[LOADING] for cycle in curve.cycles]
    scatter = np.max([branch.scatter for branch in branches], axis=0)
    relative = measured.errors / measured.values
    worst = int(np.argmax(relative))
    uncertain = (
        f"{measured.names()[worst]} is uncertain to {percent(relative[worst])} by their scatter"
    )
    sentences.append(
        f"closures are read by regression, from means of the {curve.stress.size} measured points, "
        f"which scatter by up to {significant(1e6 * scatter[1], 2)} um and "
        f"{significant(1e-6 * scatter[0], 2)} MPa; {uncertain} (one standard deviation), and to "
        f"{percent(closure_error)} as stated (closure_error)"
    )
    if relative[worst] > closure_error:
        sentences.append(caution(
            f"{uncertain}, which is more than the stated closure_error of "
            f"{percent(closure_error)}: state at least the former (--closure-error), or intervals "
            "are too narrow"
        ))  # fmt: skip
    return sentences


def _history_of_curve(curve: MeasuredCurve) -> xr.Dataset:
    """Convert a measured curve to a history, to be read like that of a simulated joint.

    If a loading starts at the stress at which the cycle before ended, its closures continue from
    the last one of that cycle. Before a further cycle, a cycle without a measured unloading gets
    one point of it, the first of the next loading.
    """
    cycles = [curve.branches(cycle) for cycle in curve.cycles]
    parts = []
    end = np.inf, 0.0  # last stress and closure of the cycle before
    for number, (here, later) in enumerate(itertools.zip_longest(cycles, cycles[1:]), start=1):
        if later and not here[UNLOADING][0].size:
            stress, closure = later[LOADING]
            here[UNLOADING] = stress[:1], closure[:1]
        first, zero = (points[0] for points in here[LOADING])
        again = abs(end[0] - first) <= _SAME_STRESS * curve.stress.max()
        offset = end[1] - zero if again else 0.0
        for branch, (x, y) in here.items():
            cycle = np.full(x.size, number)
            parts.append((x, y + offset, 0.0 * x, cycle, np.full(x.size, branch)))
            end = (x[-1], y[-1] + offset) if x.size else end
    names = ("normal_stress", "closure", "bulk_indentation", "load_cycle", "branch")
    columns = zip(names, map(np.concatenate, zip(*parts, strict=True)), strict=True)
    return xr.Dataset({name: ("step", values) for name, values in columns})


def readings_of_history(history: xr.Dataset, asked: Readings) -> np.ndarray:
    """Return the readings ``asked`` (n,) [m] of the net closure of a joint, NaN if missing."""
    stresses = np.append(asked.seating, asked.levels)
    return readings_of_closures(history_of(history).net.at(stresses), stresses, asked)


def readings_of_closures(closures: np.ndarray, stresses: np.ndarray, asked: Readings) -> np.ndarray:
    """Return readings (..., n) of closures (..., cycles, 2, stresses) on loading and unloading."""
    at = stresses.searchsorted(asked.levels)
    seat = int(stresses.searchsorted(asked.seating))
    levels = dict(zip(asked.levels, at, strict=True))
    values = []
    for cycle, level in asked.places():
        loading, unloading = np.moveaxis(closures[..., cycle - 1, :, :], -2, 0)
        recovered = loading[..., at[-1]] - unloading[..., seat]
        read = recovered if level is None else loading[..., levels[level]] - loading[..., seat]
        values.append(read)
    return np.stack(values, axis=-1)


def log_readings(closures: np.ndarray, stresses: np.ndarray, asked: Readings) -> np.ndarray:
    """Return logarithms of `readings_of_closures` (..., n).

    All readings of a joint are NaN if one of them is not above 0.
    """
    with np.errstate(invalid="ignore"):
        values = readings_of_closures(closures, stresses, asked)
        return np.log(np.where((values > 0.0).all(axis=-1, keepdims=True), values, np.nan))


def joints_needed(nodes: tuple[int, ...], readings: int) -> int:
    """Return the least number of joints for a fit of some readings.

    ``nodes`` are the numbers of wavelengths and strengths.
    """
    varied = nodes[0] > 1, nodes[1] > 1
    return 3 * (_polynomial_terms(np.zeros((1, 2)), varied).shape[1] + readings)


def likelihood_of(
    measured: Readings,
    simulated: np.ndarray,
    wavelengths: np.ndarray,
    strengths: np.ndarray,
    error: float,
) -> Likelihood:
    """Compute the likelihood of a measured curve from readings of simulated joints.

    ``simulated`` (wavelengths, strengths, joints, readings) are logarithms of readings, NaN for
    failed joints. ``error`` is the relative error of the measured ones. The mean of the log
    readings is a polynomial of the logarithms of wavelength (cubic) and strength (quadratic),
    fitted to all joints. Surfaces scatter about it with the covariance of the residuals, pooled
    over neighbouring wavelengths by a Gaussian weight as wide as their distance. The measured curve
    is one more draw, so that its distance has a multivariate t distribution (synthetic likelihood
    with an estimated covariance).

    Raise `InputError` if there are too few joints.
    """
    x = _scaled_logarithms(wavelengths)
    y = _scaled_logarithms(strengths)
    at = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    rows = np.broadcast_to(at[:, :, None, :], (*simulated.shape[:3], 2)).reshape(-1, 2)
    logs = simulated.reshape(-1, simulated.shape[-1])
    known = np.isfinite(logs).all(axis=1)
    rows = rows[known]
    logs = logs[known]
    size = logs.shape[1]
    varied = (x.size > 1, y.size > 1)
    if len(logs) < joints_needed(simulated.shape[:2], size):
        raise InputError(
            f"{len(logs)} of {known.size} joints could be read: too few to fit; a longer range of "
            "stresses or more surfaces are needed"
        )
    weights, *_ = np.linalg.lstsq(_polynomial_terms(rows, varied), logs, rcond=None)
    residuals = logs - _polynomial_terms(rows, varied) @ weights
    fine_x, fine_y = (np.linspace(0.0, 1.0, _STEPS if part.size > 1 else 1) for part in (x, y))
    width = 1.0 / max(x.size - 1, 1)
    log, distances = np.empty((2, fine_x.size, fine_y.size))
    means = np.empty((*log.shape, size))
    scatter = np.empty((fine_x.size, size))
    for i, place in enumerate(fine_x):
        near = np.exp(-0.5 * ((rows[:, 0] - place) / width) ** 2)
        near /= near.sum()
        freedom = 1.0 / float(np.sum(near**2)) - 1.0
        covariance = (residuals * near[:, None]).T @ residuals * (1.0 + 1.0 / freedom)
        covariance += error**2 * np.eye(size)
        means[i] = (
            _polynomial_terms(np.column_stack([np.full(fine_y.size, place), fine_y]), varied)
            @ weights
        )
        scatter[i] = np.sqrt(np.diagonal(covariance))
        apart = np.log(measured.values) - means[i]
        squares = np.einsum("ij,ij->i", apart @ np.linalg.inv(covariance), apart)
        half_sum = 0.5 * (freedom + size)
        log[i] = -0.5 * np.linalg.slogdet(covariance)[1] - half_sum * np.log1p(squares / freedom)
        distances[i] = scipy.stats.f.sf(squares / size, size, freedom)
    return Likelihood(
        _values_of_scaled(fine_x, wavelengths),
        _values_of_scaled(fine_y, strengths),
        log,
        means,
        scatter,
        distances,
    )


def _scaled_logarithms(values: np.ndarray) -> np.ndarray:
    """Return logarithms of ascending values, scaled from 0 to 1."""
    logs = np.log(np.asarray(values, dtype=float))
    return (logs - logs[0]) / max(logs[-1] - logs[0], np.finfo(float).tiny)


def _values_of_scaled(part: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the values whose logarithms, scaled as `_scaled_logarithms` does, are ``part``.

    These are 0 for the first of ``values`` and 1 for the last.
    """
    first = np.log(values[0])
    last = np.log(values[-1])
    return np.exp(first + part * (last - first))


def _polynomial_terms(rows: np.ndarray, varied: tuple[bool, bool]) -> np.ndarray:
    """Return terms of the mean: cubic in the first column, quadratic in the second, if varied."""
    x, y = rows.T
    terms = [np.ones_like(x)]
    terms += [x, x**2, x**3] if varied[0] else []
    terms += [y, y**2] if varied[1] else []
    terms += [x * y, x**2 * y] if all(varied) else []
    return np.stack(terms, axis=1)

"""Readings of a measured curve, and the likelihood of mismatch wavelength and strength.

A reading is the closure at a stress, or the closure recovered on unloading. Joints of a rock and
roughness are simulated at mismatch wavelengths from mated to independent walls, and at several
strengths if these are fitted too. The measured joint is taken as one more of these joints: the
readings of the curve are compared with the mean and the scatter of the simulated readings.
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
"""Difference of two stresses over the largest stress of a curve, up to which they are equal."""
_SAME_LOAD = 0.02
"""Largest allowed relative difference of the largest stresses of cycles."""


class Readings(NamedTuple):
    """Readings of a measured curve, with which simulated joints are compared.

    ``values`` are, cycle by cycle, the closures on loading since seating, at those ``levels`` at
    which the loading has enough points, and then the closure that was recovered on unloading to
    seating, if the cycle is among ``unloaded``.
    """

    cycles: int
    unloaded: tuple[int, ...]  # cycles that were unloaded back to seating
    levels: np.ndarray  # stresses of the loadings [Pa]
    seating: float
    values: np.ndarray  # (n,) [m]
    read: tuple[tuple[int, ...], ...] = ()  # numbers of the levels of each cycle; (): all
    errors: np.ndarray | None = None  # (n,) [m], standard errors by the scatter of points

    def places(self) -> list[tuple[int, float | None]]:
        """Return the cycle and the stress [Pa] of each reading, with None for a recovered one."""
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
    """Joints that were simulated for a fit; the first axes are (wavelengths, strengths, joints)."""

    logs: np.ndarray  # (..., readings), logarithms; all NaN if a reading of the joint is missing
    closures: np.ndarray  # (..., cycles, 2, stresses) [m], net since the seating of each cycle
    stresses: np.ndarray  # [Pa]


class Likelihood(NamedTuple):
    """Likelihood of a measured curve over a fine grid of mismatch wavelengths and strengths.

    The ``wavelengths`` [m] and ``strengths`` [Pa] are those of the grid.
    """

    wavelengths: np.ndarray
    strengths: np.ndarray
    log: np.ndarray  # (wavelengths, strengths)
    means: np.ndarray  # (wavelengths, strengths, readings), of logarithms
    scatter: np.ndarray  # (wavelengths, readings), standard deviations of logarithms
    p_values: np.ndarray  # (wavelengths, strengths), of a distance from the mean as large as this

    @property
    def best(self) -> tuple[int, int]:
        """Indices of the most likely wavelength and strength."""
        i, j = np.unravel_index(int(self.log.argmax()), self.log.shape)
        return int(i), int(j)

    def nodes(self, place: Sequence[int], counts: Sequence[int]) -> tuple[int, int]:
        """Return the simulated wavelength and strength nearest to a ``place`` of the likelihood.

        The likelihood has a finer grid than the simulated joints. ``place`` are indices of
        wavelength and strength on the finer grid, the result are indices among the simulated ones,
        of which there are ``counts``.
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
        """Return the 95 % interval of the wavelength [m] (axis 0) or the strength [Pa] (axis 1).

        It is by profile likelihood: the other parameter has its likeliest value everywhere. The
        smallest of several wavelengths is returned as 0, mated walls, the largest as infinite,
        independent walls.
        """
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

    Each loading is read at the shares `PARTS` of the range from seating to the smallest of the
    largest stresses of the cycles. A loading with fewer measured points between seating and its
    largest stress than there are levels is not read at the lowest levels. A cycle that was unloaded
    to seating or below also has the recovered closure: that at the highest level on loading, less
    that at seating on unloading.

    Raise `InputError` unless the cycles are 1, 2 and so on, the largest stress of each is within
    2 % of that of cycle 1, and all readings are above 0. Closures between the levels are not
    checked; the curve is expected to have passed `check_curve`.
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
    """Compute the standard errors (n,) [m] of the readings of a curve whose points were averaged.

    They follow from the scatter of the points. None if no branch of the curve was averaged.
    """
    cycles = {cycle: curve.ascending(cycle) for cycle in curve.cycles}
    if not any(branch.errors.any() for both in cycles.values() for branch in both.values()):
        return None

    def error(cycle: int, branch: str, stress: float) -> float:
        """Return the standard error [m] of the closure of a branch at a stress [Pa]."""
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
    """Convert a measured curve to a history, which can be read like that of a simulated joint.

    If a loading starts at the stress at which the cycle before ended, a constant is added to the
    closures of its cycle, so that they continue from the last closure before. A cycle without a
    measured unloading, if another one follows, gets an unloading of one point: the first point of
    the next loading. The bulk indentation is 0, as measured closures are net.
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
    """Return the net closures (n,) [m] of a history at the places of the readings ``asked``.

    A reading is NaN if the history does not reach its stress.
    """
    stresses = np.append(asked.seating, asked.levels)
    return readings_of_closures(history_of(history).net.at(stresses), stresses, asked)


def readings_of_closures(closures: np.ndarray, stresses: np.ndarray, asked: Readings) -> np.ndarray:
    """Return the readings (..., n) [m] of closures (..., cycles, 2, stresses) [m].

    The last axis but one is loading and unloading. The ``stresses`` [Pa], ascending, must contain
    the seating stress and the levels of the readings ``asked``.
    """
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
    """Return the logarithms (..., n) of `readings_of_closures`, with its arguments.

    All readings of a joint are NaN if one of them is missing or not above 0.
    """
    with np.errstate(invalid="ignore"):
        values = readings_of_closures(closures, stresses, asked)
        return np.log(np.where((values > 0.0).all(axis=-1, keepdims=True), values, np.nan))


def joints_needed(nodes: tuple[int, ...], readings: int) -> int:
    """Return the least number of simulated joints for a likelihood of so many ``readings``.

    It is three times the number of coefficients of the mean and of readings. ``nodes`` are the
    numbers of wavelengths and of strengths at which joints are simulated.
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
    joints that failed, which are left out. ``wavelengths`` [m] and ``strengths`` [Pa] ascend at
    equal ratios. ``error`` is the relative error of the measured readings.

    The mean of the logarithms is a polynomial of the logarithms of wavelength (cubic) and strength
    (quadratic), fitted to all joints. Joints scatter about it with the covariance of the residuals,
    pooled over neighbouring wavelengths by a Gaussian weight as wide as their distance. The
    measured joint is one more draw, so that its distance from the mean has a multivariate t
    distribution (synthetic likelihood with an estimated covariance).

    Raise `InputError` if there are fewer joints than `joints_needed`.
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
    """Return the logarithms of ascending values (n,), scaled from 0 to 1; 0 for a single value."""
    logs = np.log(np.asarray(values, dtype=float))
    return (logs - logs[0]) / max(logs[-1] - logs[0], np.finfo(float).tiny)


def _values_of_scaled(part: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the values that belong to scaled logarithms ``part`` (m,).

    The scale is that of `_scaled_logarithms`: 0 is the first of ``values`` and 1 the last.
    """
    first = np.log(values[0])
    last = np.log(values[-1])
    return np.exp(first + part * (last - first))


def _polynomial_terms(rows: np.ndarray, varied: tuple[bool, bool]) -> np.ndarray:
    """Return the terms (n, terms) of the polynomial of the mean at ``rows`` (n, 2) of x and y.

    They are 1; x, x^2 and x^3 if x, of the wavelength, is ``varied``; y and y^2 if y, of the
    strength, is varied; and xy and x^2 y if both are.
    """
    x, y = rows.T
    terms = [np.ones_like(x)]
    terms += [x, x**2, x**3] if varied[0] else []
    terms += [y, y**2] if varied[1] else []
    terms += [x * y, x**2 * y] if all(varied) else []
    return np.stack(terms, axis=1)

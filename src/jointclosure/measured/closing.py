"""Joints that are closed beside a measured curve, and kept in a folder."""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engine.cache import Entry, make_missing
from jointclosure.engine.scanned_joint import RESOLVED
from jointclosure.engine.uncertainty import coarser
from jointclosure.engine.workers import number_of_workers
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.curves import closures_at
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.simulation import close_walls
from jointclosure.joint.warmup import compile_kernels
from jointclosure.measured.agreement import quantities
from jointclosure.measured.calibration import CURVE_POINTS, Readings, readings_of_closures
from jointclosure.measured.joints import AskedJoints, SimulatedWalls
from jointclosure.parameters import Numerics
from jointclosure.statistics.standard_errors import mean_of, rounded
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls import shifted

CHECKED, FINER = 4, 5.0
"""Number of nearest joints that are closed by a finer tolerance too, and the tolerance over it."""


class Later(NamedTuple):
    """What differs after the first loading: shift of the upper wall [cells], and a choice."""

    shift: int = 0
    crushed_strength_ratio: float = 1.0


class Closing(NamedTuple):
    """How joints are closed: at strengths [Pa], read at stresses [Pa], and after the first loading.

    ``conditions`` are those of the first cycle. Joints of neighbouring wavelengths, strengths and
    surfaces are ``strides`` numbers apart.
    """

    conditions: Conditions
    cycles: int
    strengths: tuple[float, ...]
    stresses: tuple[float, ...]
    strides: tuple[int, int, int]
    laters: tuple[Later, ...] = (Later(),)

    def number(self, wavelength: int, strength: int, surface: int) -> int:
        """Return the number of a joint, on which its walls depend."""
        places = wavelength, strength, surface
        return 1 + sum(n * stride for n, stride in zip(places, self.strides, strict=True))


def stresses_of(measured: Readings) -> tuple[float, ...]:
    """Return the stresses [Pa] at which joints are read: those of a curve, and those read of it."""
    even = np.linspace(measured.seating, measured.levels[-1], CURVE_POINTS)
    return tuple(np.unique(np.concatenate([even, measured.levels])).tolist())


def changed(conditions: Conditions, strength: float, later: Later) -> Conditions:
    """Return the conditions of a strength, and of loadings after the first."""
    rock = conditions.rock._replace(compressive_strength=strength)
    ratio = later.crushed_strength_ratio * conditions.choices.crushed_strength_ratio
    choices = conditions.choices._replace(crushed_strength_ratio=ratio)
    return conditions._replace(rock=rock, choices=choices)


def first_conditions(asked: AskedJoints, numerics: Numerics) -> Conditions:
    """Return the conditions of the first cycle."""
    measured, joint = asked.measured, asked.joint
    return Conditions(
        asked.walls.spacing, asked.rock, float(measured.levels[-1]), 1, measured.seating,
        joint.effects, joint.choices, numerics,
    )  # fmt: skip


class Joints(NamedTuple):
    """Joints beside a measured curve, kept in a folder (``cache``) and closed by ``workers``."""

    closing: Closing
    asked: AskedJoints
    cache: str | Path | None
    workers: int | None
    report: Callable[[str], None]

    def closures(self) -> np.ndarray:
        """Close all; (laters, wavelengths, strengths, surfaces, cycles, 2, stresses) [m]."""
        surfaces, wavelengths = self.asked.joint.surfaces, self.asked.wavelengths.size
        places = [(i, k) for k in range(surfaces) for i in range(wavelengths)]
        closures = self._closed(self.closing, places)
        closures = closures.reshape(surfaces, wavelengths, *closures.shape[1:])
        return closures.transpose(2, 1, 3, 0, 4, 5, 6)

    def _closed(
        self, closing: Closing, places: Sequence[tuple[int, int]], strength: int = 0
    ) -> np.ndarray:
        """Close what is not kept; closures (joints, laters, strengths, cycles, 2, stresses) [m].

        ``places`` are those of wavelength and surface, ``strength`` is that of the first strength.
        A joint that failed has NaN.
        """
        given, numerics, asked = closing.conditions, closing.conditions.numerics, self.asked
        workers = number_of_workers(self.workers)
        entries = [
            Entry(
                f"wavelength_{i}_surface_{k}_{numerics.breakage}_{numerics.tolerance:.4g}",
                close_surface,
                (closing, asked.walls, closing.number(i, strength, k), float(asked.wavelengths[i])),
                {"scans": asked.scans}, joints=len(closing.strengths),
            )
            for i, k in places
        ]  # fmt: skip
        compile_first = partial(
            compile_kernels, given.effects, given.choices, numerics.solver, numerics.breakage
        )
        kept = tempfile.TemporaryDirectory() if self.cache is None else nullcontext(self.cache)
        with kept as name:
            folder = Path(name)
            make_missing(entries, folder, workers, self.report, prepare=compile_first, apart=False)
            return np.stack([read_netcdf(entry.file(folder)).closure.values for entry in entries])

    def numerical_changes(
        self, place: tuple[int, int, int], closures: np.ndarray
    ) -> dict[str, tuple[float, float]]:
        """Return relative changes of quantities from a finer tolerance, with standard errors.

        They are of `CHECKED` joints at a place (later, wavelength, strength) of ``closures``.
        Without breakage there is no tolerance, and none are returned.
        """
        closing, measured = self.closing, self.asked.measured
        conditions, (kind, i, j) = closing.conditions, place
        if not conditions.effects.breakage:
            return {}
        resolved = conditions.numerics.breakage == "resolved"
        numerics = coarser(conditions.numerics, 1.0 / FINER) if resolved else RESOLVED
        nearest = closing._replace(
            conditions=conditions._replace(numerics=numerics),
            strengths=(closing.strengths[j],), laters=(closing.laters[kind],),
        )  # fmt: skip
        fine = self._closed(nearest, [(i, k) for k in range(CHECKED)], j)[:, 0, 0]
        given, finer = (
            quantities(readings_of_closures(each, np.array(closing.stresses), measured), measured)
            for each in (closures[kind, i, j, :CHECKED], fine)
        )
        changes: dict[str, tuple[float, float]] = {}
        for name, (unit, values) in given.items():
            with np.errstate(divide="ignore", invalid="ignore"):
                ratios = values / finer[name][1] - 1.0
            if unit != "%" and np.isfinite(ratios).all():
                changes[name] = mean_of(ratios)
        return changes


def numerical_sentence(changes: Mapping[str, tuple[float, float]]) -> list[str]:
    """Describe `numerical_changes`, if there are any."""
    if not changes:
        return []
    texts = (
        f"{name} {rounded(100.0 * value, 100.0 * error)} %"
        for name, (value, error) in changes.items()
    )
    checked = f"{CHECKED} nearest joints against {1.0 / FINER:g} of their tolerance"
    return [f"numerical error, {checked}: {'; '.join(texts)}"]


def close_surface(
    closing: Closing,
    walls: SimulatedWalls,
    first: int,
    wavelength: float,
    *,
    scans: Any,
    report: Any,
) -> xr.Dataset:
    """Close a surface at each strength, and all that may follow its first loading.

    If nothing differs after it, all loadings are of one history.
    """
    stresses = np.array(closing.stresses)
    shape = len(closing.laters), len(closing.strengths), closing.cycles, 2, stresses.size
    closures = np.full(shape, np.nan)
    several = closing.laters != (Later(),)
    for place, strength in enumerate(closing.strengths):
        number = first + closing.strides[1] * place
        conditions = changed(closing.conditions, strength, Later())
        pair = walls.pair(number, wavelength, scans)
        cycles = 1 if several else closing.cycles
        once = close_walls(*pair, conditions._replace(cycles=cycles))
        if once.status >= FAILURE:
            report(f"joint {number}: status {int(once.status)}")
            continue
        closures[:, place, :cycles] = closures_at(once, stresses)
        crushed = once.upper_final.values, once.lower_final.values
        for kind, later in enumerate(closing.laters if cycles < closing.cycles else ()):
            conditions = changed(closing.conditions, strength, later)
            conditions = conditions._replace(cycles=closing.cycles - 1)
            seated, pristine = (shifted(both, (0, later.shift)) for both in (crushed, pair))
            again = close_walls(*seated, conditions, pristine=pristine)
            if again.status < FAILURE:
                closures[kind, place, 1:] = closures_at(again, stresses)
        report(f"joint {number} of {strength:.3g} Pa closed")
    dims = ("later", "strength", "cycle", "branch", "stress")
    return xr.Dataset({"closure": (dims, closures, {"units": "m"})})

"""Simulation of joints for comparison with a measured curve, with a folder that keeps them."""

import math
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.execution.cache import Entry, make_missing
from jointclosure.execution.workers import number_of_workers
from jointclosure.inputs import InputError, naming
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.history import history_of
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.stated_conditions import check_carried
from jointclosure.joint.status import failed
from jointclosure.joint.warmup import prepare_kernels
from jointclosure.measured.compared_quantities import compared_quantities
from jointclosure.measured.joint_arguments import AskedJoints, WallRecipe
from jointclosure.measured.likelihood import (
    CURVE_POINTS,
    joints_needed,
    readings_of_closures,
)
from jointclosure.parameters import RESOLVED
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.uncertainty.expected_cost import (
    EXPONENTS,
    rough_time,
    seconds_of_joint,
    time_of_window,
    window_of,
)
from jointclosure.uncertainty.sources import coarser
from jointclosure.walls import Walls, shifted

CHECKED = 4  # nearest joints that are simulated with a finer tolerance too
FINER = 5.0  # tolerance over the finer one
COMPARED = 48  # cells along a side of the windows in which times by strength are compared
ABOUT_RANGES = (
    "ranges of readings of joints are 95 % intervals of a single joint, with the error of the "
    "measured closures"
)
"""Explanation of the ranges that `fit` and `validate` print beside measured readings."""
ADVICE = "check rock, roughness, roll-off, size and units"
"""Advice where no joint is like the measured one."""


class LaterLoading(NamedTuple):
    """Changes of a joint before its second loading: shifted walls, weaker crushed rock."""

    shift: int = 0  # of the upper wall along x [cells]
    crushed_strength_ratio: float = 1.0  # strength of crushed rock over that of the rock


class ComparisonJoints(NamedTuple):
    """Joints to be simulated for comparison with a measured curve, at all values of constants.

    The constants are the mismatch wavelengths [m] that were ``asked``, the compressive
    ``strengths`` [Pa], and the changes ``laters`` after the first loading. ``conditions`` are those
    of the first cycle. The walls of a joint follow from its number: 1 plus the sum of the indices
    of its wavelength, strength and surface, each times one of the ``strides``. ``cache`` is the
    folder in which joints are kept, None if they are not. ``report`` receives lines on progress.
    """

    asked: AskedJoints
    conditions: Conditions
    strengths: tuple[float, ...]
    strides: tuple[int, int, int]
    laters: tuple[LaterLoading, ...]
    cache: str | Path | None
    workers: int | None
    report: Callable[[str], None]

    @property
    def stresses(self) -> np.ndarray:
        """Stresses (n,) [Pa] at which closures of joints are kept, ascending.

        They are evenly spaced from seating to the maximum, and those of the readings.
        """
        measured = self.asked.measured
        even = np.linspace(measured.seating, measured.levels[-1], CURVE_POINTS)
        return np.unique(np.concatenate([even, measured.levels]))

    def check(self, strengths: Sequence[float]) -> None:
        """Raise `InputError` if the joints cannot be simulated, or are too few for a fit.

        Conditions with each of the ``strengths`` [Pa] are checked, and the walls of one joint are
        made. There must be as many surfaces as the number of readings needs (`joints_needed`).
        """
        asked = self.asked
        for strength in strengths:
            for later in self.laters:
                with naming(f"joints of a compressive strength of {1e-6 * strength:.3g} MPa"):
                    check_carried(with_strength(self.conditions, strength, later).checked())
        asked.walls.pair(1, float(asked.wavelengths[0]), asked.scans)
        nodes = (asked.wavelengths.size, len(self.strengths))
        surfaces = asked.joint.surfaces
        needed = joints_needed(nodes, asked.measured.values.size)
        count = math.prod(nodes)
        if surfaces * count < needed:
            least = math.ceil(needed / count)
            raise InputError(f"surfaces = {surfaces}: must be at least {least} for this curve")

    def closures(self) -> np.ndarray:
        """Return the net closures [m] of all joints for comparison, read at `stresses`.

        Joints that are not kept in the folder are simulated and kept there, after a report of the
        expected time. The closures are (laters, wavelengths, strengths, surfaces, cycles, 2,
        stresses), with loading and unloading along the last axis but one, and count from first
        touch. They are NaN for joints that failed, and for stresses that were not reached.
        """
        surfaces = self.asked.joint.surfaces
        wavelengths = self.asked.wavelengths.size
        closures = self._simulate_missing(
            [(i, k) for k in range(surfaces) for i in range(wavelengths)], foresee=True
        )
        closures = closures.reshape(surfaces, wavelengths, *closures.shape[1:])
        return closures.transpose(2, 1, 3, 0, 4, 5, 6)

    def _simulate_missing(
        self, places: Sequence[tuple[int, int]], strength: int = 0, foresee: bool = False
    ) -> np.ndarray:
        """Simulate those joints at ``places`` that are not kept yet, and return closures of all.

        ``places`` are indices (wavelength, surface). The closures [m] are (places, laters,
        strengths, cycles, 2, stresses), NaN for a joint that failed. ``strength`` is the index of
        the first strength among those of the whole comparison, from which the number of a joint and
        its file follow. ``foresee`` is whether the time is estimated and reported first.
        """
        asked = self.asked
        conditions = self.conditions
        numerics = conditions.numerics
        stresses = tuple(self.stresses.tolist())
        entries = []
        for i, k in places:
            for j, value in enumerate(self.strengths, start=strength):
                number = 1 + int(np.dot((i, j, k), self.strides))
                arguments = (
                    conditions, asked.measured.cycles, stresses, asked.walls,
                    float(asked.wavelengths[i]), {number: value}, self.laters,
                )  # fmt: skip
                steps = f"{numerics.breakage}_{numerics.tolerance:.4g}"
                file = f"wavelength_{i}_strength_{j}_surface_{k}_{steps}"
                scans = {"scans": asked.scans}
                entries.append(Entry(file, simulate_surface, arguments, scans))
        workers = number_of_workers(self.workers)

        def prepare() -> None:
            """Compile the kernels, and report the expected time if that is asked for."""
            prepare_kernels([conditions.model], 1 if foresee else workers)
            if foresee:
                self.report(self._forecast(len(places) * len(self.strengths), workers))

        kept = tempfile.TemporaryDirectory() if self.cache is None else nullcontext(self.cache)
        with kept as name:
            folder = Path(name)
            make_missing(entries, folder, workers, self.report, prepare=prepare, apart=False)
            made = [read_netcdf(entry.file(folder)).closure.values for entry in entries]
        by_place = [
            np.concatenate(made[start : start + len(self.strengths)], axis=1)
            for start in range(0, len(made), len(self.strengths))
        ]
        return np.stack(by_place)

    def _forecast(self, count: int, workers: int) -> str:
        """Return a sentence on the time of all ``count`` joints, and on what is kept.

        Windows of one joint are simulated for it. Joints of weak rock take many times as long as
        others, and so do later loadings of weaker crushed rock: their times relative to the first
        loading are measured in smaller windows.
        """
        asked = self.asked
        walls = asked.walls.pair(1, float(asked.wavelengths[0]), asked.scans)
        middle = self.strengths[len(self.strengths) // 2]
        first = with_strength(self.conditions, middle, LaterLoading()).checked()
        seconds = seconds_of_joint(*walls, first)
        loadings = [
            time_of_loadings(
                walls, COMPARED, self.conditions, asked.measured.cycles, strength, self.laters
            )
            for strength in self.strengths
        ]
        window, cells = time_of_window(*walls, COMPARED, first)
        over_first = float(np.mean(loadings)) / window
        # the times of weak rock grow faster with the number of cells than that of the first loading
        growth = (walls[0].size / cells) ** (EXPONENTS[1] - EXPONENTS[0])
        each = count * over_first / workers
        least, most = seconds
        low, high = rough_time(each * least), rough_time(each * most * growth)
        kept = "finished joints are kept, and a later run goes on with them"
        if self.cache is None:
            kept = "no joint is kept without a folder (--output, or cache= in Python)"
        one_or_more = "1 process" if workers == 1 else f"{workers} processes"
        return (
            f"all {count} joints take about {low} to {high} in {one_or_more}, or longer if other "
            f"work uses their processors; {kept}"
        )

    def numerical_changes(
        self, place: tuple[int, int, int], closures: np.ndarray
    ) -> dict[str, tuple[float, float]]:
        """Return the relative numerical errors of compared quantities, with standard errors [1].

        `CHECKED` joints at a ``place`` (later, wavelength, strength) of ``closures``, as from
        `closures`, are simulated again with a tolerance and steps that are `FINER` times smaller,
        or with resolved breakage if theirs is by fixed steps. An error is the mean of the ratios of
        the quantity to that of the finer simulation, less 1. Shares in percent are left out, and
        quantities that are not known of all these joints. Without breakage there is no tolerance,
        and the result is empty.
        """
        conditions = self.conditions
        measured = self.asked.measured
        kind, i, j = place
        if not conditions.effects.breakage:
            return {}
        resolved = conditions.numerics.breakage == "resolved"
        numerics = coarser(conditions.numerics, 1.0 / FINER) if resolved else RESOLVED
        nearest = self._replace(
            conditions=conditions._replace(numerics=numerics),
            strengths=self.strengths[j : j + 1], laters=self.laters[kind : kind + 1],
        )  # fmt: skip
        fine = nearest._simulate_missing([(i, k) for k in range(CHECKED)], j)[:, 0, 0]
        given, finer = (
            compared_quantities(readings_of_closures(each, self.stresses, measured), measured)
            for each in (closures[kind, i, j, :CHECKED], fine)
        )
        changes: dict[str, tuple[float, float]] = {}
        for one, other in zip(given, finer, strict=True):
            with np.errstate(divide="ignore", invalid="ignore"):
                ratios = one.values / other.values - 1.0
            if one.unit != "%" and np.isfinite(ratios).all():
                changes[one.name] = mean_of(ratios)
        return changes


def numerical_sentence(changes: Mapping[str, tuple[float, float]]) -> list[str]:
    """Return a sentence on the changes from `ComparisonJoints.numerical_changes`; none without."""
    if not changes:
        return []
    texts = (
        f"{name} {rounded(100.0 * value, 100.0 * error)} %"
        for name, (value, error) in changes.items()
    )
    checked = f"{CHECKED} nearest joints against {1.0 / FINER:g} of their tolerance"
    return [f"numerical error, {checked} (mean ± its standard error): {'; '.join(texts)}"]


def with_strength(conditions: Conditions, strength: float, later: LaterLoading) -> Conditions:
    """Return conditions with a compressive strength [Pa] and the crushed strength of ``later``.

    The crushed-strength ratio is multiplied by that of ``later``, whose shift is not used.
    """
    rock = conditions.rock._replace(compressive_strength=strength)
    ratio = later.crushed_strength_ratio * conditions.choices.crushed_strength_ratio
    choices = conditions.choices._replace(crushed_strength_ratio=ratio)
    return conditions._replace(rock=rock, choices=choices)


def loadings_of(
    pair: Walls, first: Conditions, cycles: int, strength: float, laters: Sequence[LaterLoading]
) -> Iterator[xr.Dataset]:
    """Simulate a joint, and its later loadings after each of the changes ``laters``.

    Generate the history of the joint with walls ``pair`` (y, x) [m], then one history of later
    loadings for each change. The first history has one cycle, and the others have the rest of the
    ``cycles``. If ``laters`` is no change alone, there is one history with all cycles. There is
    also only one if the joint failed in it, or if ``cycles`` is 1.
    """
    unchanged = tuple(laters) == (LaterLoading(),)
    conditions = with_strength(first, strength, LaterLoading())
    of_first = conditions._replace(cycles=cycles if unchanged else 1, unusual_values=True)
    once = simulate_walls(*pair, of_first.checked())
    yield once
    crushed = once.upper_final.values, once.lower_final.values
    for later in () if unchanged or cycles == 1 or failed(once) else laters:
        conditions = with_strength(first, strength, later)._replace(
            cycles=cycles - 1, unusual_values=True
        )
        seated, pristine = (shifted(both, (0, later.shift)) for both in (crushed, pair))
        yield simulate_walls(*seated, conditions.checked(), pristine=pristine)


def time_of_loadings(
    pair: Walls,
    size: int,
    first: Conditions,
    cycles: int,
    strength: float,
    laters: Sequence[LaterLoading],
) -> float:
    """Simulate `loadings_of` in the middle of two walls (y, x) [m]; return the processor time [s].

    The window has up to ``size`` cells along a side.
    """
    window = window_of(pair, size)
    start = time.process_time()
    for _ in loadings_of(window, first, cycles, strength, laters):
        pass
    return time.process_time() - start


def simulate_surface(
    first: Conditions,
    cycles: int,
    stresses: Sequence[float],
    walls: WallRecipe,
    wavelength: float,
    numbered: Mapping[int, float],
    laters: Sequence[LaterLoading],
    *,
    scans: Any,
    report: Any,
) -> xr.Dataset:
    """Simulate one surface at each strength, with each of ``laters`` after its first loading.

    ``numbered`` are the strengths [Pa] by the numbers of the joints, from which the walls follow
    (`WallRecipe.pair`). Return the variable ``closure`` (later, strength, cycle, branch, stress):
    net closures [m] from first touch at the ``stresses`` [Pa]. They are NaN for loadings that
    failed, and all loadings of a joint are NaN if its first one failed.
    """
    levels = np.array(stresses)
    closures = np.full((len(laters), len(numbered), cycles, 2, levels.size), np.nan)
    for place, (number, strength) in enumerate(numbered.items()):
        pair = walls.pair(number, wavelength, scans)
        once, *again = loadings_of(pair, first, cycles, strength, laters)
        if failed(once):
            report(f"joint {number}: status {int(once.status)}")
            continue
        closures[:, place, : once.sizes["cycle"]] = history_of(once).net.at(levels)
        for kind, history in enumerate(again):
            if not failed(history):
                closures[kind, place, 1:] = history_of(history).net.at(levels)
        report(f"joint {number} of {strength:.3g} Pa closed")
    dims = ("later", "strength", "cycle", "branch", "stress")
    return xr.Dataset({"closure": (dims, closures, {"units": "m"})})

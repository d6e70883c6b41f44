"""Closure of a joint whose two walls were scanned: registration and simulation."""

import time
import warnings
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import NamedTuple, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.execution.progress import bar, load_cycle_bar
from jointclosure.execution.workers import number_of_workers
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution, cautions, without_word
from jointclosure.joint.checked_conditions import CheckedConditions, check_named_stresses, on_grid
from jointclosure.joint.conditions import (
    SCAN_DEFAULTS,
    Changes,
    Conditions,
    conditions_from,
    takes_scans,
)
from jointclosure.joint.cycling import StepReport
from jointclosure.joint.history import history_of, with_snapshots
from jointclosure.joint.laws import (
    LAB_LENGTH,
    JointLaws,
    check_joint_lengths,
    laws_of_joint,
)
from jointclosure.joint.result_tables import cycle_table, stress_table
from jointclosure.joint.rocks import rock_text
from jointclosure.joint.simulation import Simulation
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.joint.status import failed
from jointclosure.joint.warmup import prepare_kernels
from jointclosure.statistics.number_texts import grid_text, percent
from jointclosure.uncertainty.budget import Budget, uncertainty_budget
from jointclosure.uncertainty.expected_cost import expected_cost, rough_time, seconds_of_range
from jointclosure.uncertainty.ranged_results import CLOSURE_GROSS, CLOSURE_NET
from jointclosure.uncertainty.sources import check_ranges
from jointclosure.uncertainty.tested_domain import beyond_tested
from jointclosure.uncertainty.uncertain_joint import UncertainJoint, threads_for, uncertain_joint
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.registration_summary import summary_of
from jointclosure.walls.scan_errors import ScanErrors
from jointclosure.walls.wall_files import Wall, registered_walls
from jointclosure.walls.wall_roughness import joint_jrc

ANNOUNCED = 10.0
"""Expected processor time [s] of a range above which `close` states it beforehand."""


_STOPPED = caution("the range was stopped: these are results of the joint alone")


class ClosedJoint(NamedTuple):
    """Simulated joint of two scanned walls, as `jointclosure.close` returns it.

    ``pair`` has the registered walls that were closed, and describes their registration in its
    ``remarks``. ``history`` is as from `jointclosure.simulate`. ``rock_name`` is "rock" if the rock
    is given only by its properties. ``budget`` has the ranges of the results; it is None for a
    single run, a joint that failed, and a range that was interrupted. ``at`` are stresses [Pa] that
    ``curves`` have besides round ones. ``lab_length`` [m] is the length of the laboratory joint to
    which the JRC of the walls and the strength refer. ``joint_length`` [m] is the length of the
    joint in the rock mass to which ``laws`` are scaled, None if they are not scaled.
    """

    pair: RegisteredPair
    history: xr.Dataset
    conditions: CheckedConditions
    rock_name: str = "rock"
    budget: Budget | None = None
    at: tuple[float, ...] = ()
    joint_length: float | None = None
    lab_length: float = LAB_LENGTH

    @property
    def curves(self) -> pd.DataFrame:
        """Table of closure, stiffness, aperture and flow over stress, with bands if known.

        It is as from `jointclosure.joint.result_tables.stress_table`, at round stresses and those
        of `at`.
        """
        if self.budget is not None:
            return self.budget.curves
        return stress_table(self.history, history_of(self.history).table_levels(self.at))

    def __repr__(self) -> str:
        seating = 1e-6 * float(self.history.attrs["seating_stress_Pa"])
        table = cycle_table(self.history)
        net, gross = (self._closures_text(column, table) for column in (CLOSURE_NET, CLOSURE_GROSS))
        outcome = ", failed" if failed(self.history) else ""
        return (
            f"<ClosedJoint: {self.description}, closes {net} mm net and {gross} mm gross since "
            f"{seating:g} MPa; load: {self.conditions.load.description()}{outcome}>"
        )

    def __str__(self) -> str:
        """Return the line of `repr`, and below it the ranges of all results with their sources."""
        return repr(self) if self.budget is None else f"{self!r}\n{self.budget}"

    @property
    def description(self) -> str:
        """Rock, cells and size of the joint in words."""
        return _description(self.pair, self.conditions, self.rock_name)

    @property
    def laws(self) -> JointLaws:
        """Laws of Barton and Bandis of the joint, with the lower strength of the two rocks."""
        jrc = joint_jrc((self.pair.upper, self.pair.lower), self.pair.spacing)
        strength = min(wall.compressive_strength for wall in self.conditions.rock)
        seating = float(self.history.attrs["seating_stress_Pa"])
        lengths = self.joint_length, self.lab_length
        return laws_of_joint(jrc, strength, seating, self.conditions.cycle_count, *lengths)

    def _closures_text(self, column: str, table: pd.DataFrame) -> str:
        """Format the closures of all cycles in a ``column`` [mm], with their ranges if known."""
        if self.budget is None:
            return ", ".join(f"{value:.4g}" for value in table[column])
        return ", ".join(self.budget.text(cycle, column) for cycle in table.cycle)


@takes_scans
def close(
    upper: Wall,
    lower: Wall,
    *,
    conditions: Conditions | CheckedConditions | None = None,
    units: str | tuple[str, str] | None = None,
    scan_spacing: float | tuple[float, float] | None = None,
    variable: str | None = None,
    orientation: str | None = None,
    shift: str | None = None,
    spikes: str = "cut",
    single: bool = False,
    ranges: Mapping[str, tuple[float, float]] = {},
    workers: int | None = None,
    report: StepReport | None = None,
    snapshots: Sequence[float] = (),
    at: Sequence[float] = (),
    joint_length: float | None = None,
    lab_length: float = LAB_LENGTH,
    rock_name: str | None = None,
    progress: bool = False,
    **changes: Unpack[Changes],
) -> ClosedJoint:
    """Register two scanned walls, and simulate the joint under load cycles with a range of results.

    Without ``conditions`` breakage is resolved, unless ``numerics`` are given; ``conditions`` keep
    their numerics, by default the paper's steps, which `jointclosure.simulate` has too. Resolved
    breakage and the paper's steps give different results for the same walls
    (docs/reference.md#steps-of-breakage has the size of the difference).

    Parameters
    ----------
    upper, lower : path, three paths, Scan, Cloud or "flat"
        Files for `jointclosure.read_scan`, or what it returned. One of both may be flat, such as a
        saw cut; see `jointclosure.walls.registration.registered`.
    units : {"m", "mm", "um", "nm", "inch"} or a pair of them, optional
        Units of both files, or of the upper and the lower one, if the files do not state them.
    scan_spacing : float or a pair, optional
        Spacing of both scans [m], or of the upper and the lower one, if the files do not state it.
    variable : str, optional
        Name of the array or channel, or columns of a text file, in both files, as for
        `jointclosure.read_scan`.
    orientation, shift, spikes
        As for `jointclosure.walls.registration.registered`.
    single : bool
        Whether to simulate the joint once, without the range of its results.
    ranges : mapping
        Lowest and highest value [SI] of inputs that are known only to a range: a property of rock,
        ``peak_modulus_ratio``, ``base_radius_in_cells`` or ``spacing``
        (`jointclosure.uncertainty.sources`).
    workers : int, optional
        Number of joints of the range that are simulated at the same time, by default that of the
        processors available to this process.
    report, snapshots
        As for `jointclosure.simulate`.
    at : sequence of float
        Stresses [Pa] at which stiffness kn, closure and aperture on loading are printed, from the
        seating stress to the maximum.
    joint_length : float, optional
        Length [m] of the joint in the rock mass to which the JRC and JCS of the law of Barton and
        Bandis are scaled. By default they are not scaled.
    lab_length : float
        Length [m] of the laboratory joint to which the JRC and JCS of the walls refer.
    rock_name : str, optional
        Name of the rock in reports, by default the one that ``rock`` gives.
    progress : bool
        Whether to print a summary of the registration, the joint and its expected cost before it is
        closed, and to show progress bars on a terminal, in place of ``report``; an interrupt while
        the range is computed then leaves it out. Without it, doubts and the cost are warnings.
    conditions, **changes
        As for `jointclosure.simulate`. ``spacing`` [m] is that of the joint's grid, by default as
        for `jointclosure.walls.registration.registered`, which also receives
        ``unusual_values``. Without ``conditions`` breakage is resolved, unless ``numerics`` are
        given; ``conditions`` keep their numerics, by default the paper's steps.

    Returns
    -------
    ClosedJoint
        Registered walls, history and ranges of the results. A joint whose simulation failed has a
        status of 16 or more in its history, and no ranges.

    Raises
    ------
    InputError
        If a file cannot be read, units are not stated, no orientation of the walls fits clearly
        best, the walls do not overlap, `registered` refuses the pair, or a number is out of its
        range.
    TypeError
        If a keyword is unknown, or without ``conditions`` the rock or the maximum stress is
        missing.
    """
    stated = conditions_from(conditions, changes, "close", defaults=SCAN_DEFAULTS)
    checked = checked_as_stated(stated, snapshots)
    check_named_stresses(at, checked)
    check_joint_lengths(joint_length, lab_length)
    _check_arguments_of_range(checked, single, ranges, workers)
    name = rock_name or (stated.rock if isinstance(stated.rock, str) else "rock")

    pair = registered_walls(
        upper,
        lower,
        {"units": units, "scan_spacing": scan_spacing, "variable": variable},
        checked.spacing,
        orientation=orientation,
        shift=shift,
        spikes=spikes,
        unusual_values=checked.unusual_values,
    )
    checked = on_grid(checked, pair.spacing)
    remark = _Remarks(progress, checked.unusual_values)
    remark(summary_of(pair, not single), pair.warnings, heading="Registration")
    uncertain = _joint_and_variants(pair, checked, ranges, single)
    if progress:
        print(f"Joint: {_description(pair, checked, name)}: {checked.load.description()}")
    untested = [] if single else beyond_tested(pair)
    scan_remarks = [*_about_noise(pair, uncertain.errors), *untested]
    remark(untested, doubts=untested)

    simulation = Simulation(pair.upper, pair.lower, checked, snapshots)
    slow = [] if checked.unusual_values else simulation.near_strength()
    for lines in (slow, _about_cost(uncertain, workers)):
        remark(lines, costs=lines)
    # compile first, so that the time of the joint, from which the time of the range is estimated,
    # does not contain it
    if not single:
        prepare_kernels([checked.model])
    history, seconds, hole_remarks = _run_with_holes(simulation, pair, report, progress)
    remark(hole_remarks, doubts=cautions(hole_remarks))

    budget = None
    stopped = list[str]()
    if not single and not failed(history):  # a failed joint has no range
        remark(_about_time_of_range(uncertain, seconds, workers) if progress else [])
        budget = _budget_or_none(uncertain, history, at, workers, progress)
        stopped = [] if budget else [_STOPPED]
        remark(stopped)
    pair = pair._replace(remarks=[*pair.remarks, *scan_remarks, *hole_remarks, *stopped])
    lengths = joint_length, lab_length
    return ClosedJoint(pair, history, checked, name, budget, tuple(at), *lengths)


def _check_arguments_of_range(
    conditions: CheckedConditions,
    single: bool,
    ranges: Mapping[str, tuple[float, float]],
    workers: int | None,
) -> None:
    """Raise `InputError` if arguments of the range are not allowed, or given with ``single``."""
    number_of_workers(workers)  # only for its check
    if single and ranges:
        raise InputError("ranges (--range): must be left out with single (--single)")
    check_ranges(conditions, ranges)


def _joint_and_variants(
    pair: RegisteredPair,
    conditions: CheckedConditions,
    ranges: Mapping[str, tuple[float, float]],
    single: bool,
) -> UncertainJoint:
    """Return the joint of a registered pair, with its sources and variants unless ``single``."""
    if single:
        return UncertainJoint(pair.upper, pair.lower, conditions)
    errors, finest = pair.errors, pair.finest[:2]
    return uncertain_joint(pair.upper, pair.lower, conditions, ranges, errors, finest)


def _run_with_holes(
    simulation: Simulation, pair: RegisteredPair, report: StepReport | None, progress: bool
) -> tuple[xr.Dataset, float, list[str]]:
    """Run a simulation; return the history, the processor time [s], and remarks on holes of scans.

    If the scans have holes, a snapshot at the largest stress is added to those of ``simulation``,
    in place, to read the force on holes. The returned history is without it. Without holes there
    are no remarks.
    """
    if not pair.holes.any():
        return *_timed_run(simulation, report, progress), []
    stated = simulation.snapshots
    largest = float(simulation.conditions.largest_stress)
    simulation.snapshots = (*stated, largest)
    history, seconds = _timed_run(simulation, report, progress)
    return with_snapshots(history, stated), seconds, _force_in_holes(pair, history, largest)


def _timed_run(
    simulation: Simulation, report: StepReport | None, progress: bool
) -> tuple[xr.Dataset, float]:
    """Run a simulation; return the history of the joint and the processor time [s].

    With ``progress`` a bar is shown on a terminal, in place of calls of ``report``.
    """
    start = time.process_time()
    cycles = simulation.conditions.cycle_count
    with load_cycle_bar(cycles) if progress else nullcontext(report) as watch:
        history = simulation.run(watch)
    return history, time.process_time() - start


def _budget_or_none(
    joint: UncertainJoint,
    history: xr.Dataset,
    at: Sequence[float],
    workers: int | None,
    progress: bool,
) -> Budget | None:
    """Simulate the variants of a joint and return its budget.

    If it is interrupted, the result is None with ``progress``; else `KeyboardInterrupt` is raised.
    """
    try:
        with bar("range") if progress else nullcontext(_no_bar) as show:
            return uncertainty_budget(joint, history, show, workers, at)
    except KeyboardInterrupt:
        if not progress:
            raise
        return None


class _Remarks:
    """Function that makes the remarks of `close` known while it runs.

    Either all lines are ``printed``, or the doubts and costs among them are issued as warnings. If
    ``unusual_values`` are accepted, there are no warnings of doubts, but still those of costs.
    """

    def __init__(self, printed: bool, unusual_values: bool) -> None:
        self.printed = printed
        self.unusual_values = unusual_values

    def __call__(
        self,
        lines: Sequence[str],
        doubts: Sequence[str] = (),
        costs: Sequence[str] = (),
        heading: str = "",
    ) -> None:
        """Print ``lines`` below a ``heading``, or warn of the ``doubts`` and ``costs``."""
        if self.printed:
            first = [f"{heading}\n"] if heading else []
            print("".join([*first, *(f"- {line}\n" for line in lines)]), end="", flush=True)
            return
        for warned in (*(() if self.unusual_values else doubts), *costs):
            warnings.warn(without_word(warned), stacklevel=3)  # at the line that called `close`


def _no_bar(share: float, variant: str) -> None:
    """Show no progress."""


def _description(pair: RegisteredPair, conditions: CheckedConditions, rock_name: str) -> str:
    """Describe the rock, cells and size of the joint of a registered pair."""
    ny, nx = pair.upper.shape
    step = 1e3 * pair.spacing
    cells = grid_text((ny, nx), pair.spacing)
    size = f"{nx * step:.3g} x {ny * step:.3g} mm"
    return f"{rock_text(conditions.rock, rock_name)}, {cells} ({size})"


def _about_cost(joint: UncertainJoint, workers: int | None) -> list[str]:
    """Return a sentence on the expected cost of a joint and its range; none for a small joint.

    Windows of a large joint are simulated for it (`expected_cost`).
    """
    cost = expected_cost(joint, workers)
    return [cost.sentence(joint.upper.shape, joint.conditions.grid_spacing)] if cost else []


def _about_time_of_range(
    joint: UncertainJoint, seconds: float, workers: int | None = None
) -> list[str]:
    """Return a sentence on the time of the range of a joint; none if it is at most `ANNOUNCED`.

    It is estimated from the processor time ``seconds`` that the joint itself took. The time on the
    clock is that with ``workers``, as far as no other program uses the processors.
    """
    of_range = seconds_of_range(joint, seconds)
    if of_range <= ANNOUNCED:
        return []
    at_once = min(threads_for(joint.cells, workers), len(joint.variants))
    return [
        f"the range takes {len(joint.variants)} further simulations, together about "
        f"{rough_time(of_range)} of processor time; with {at_once} at the same time they take "
        f"about {rough_time(of_range / at_once)}, or longer if other programs run"
    ]


def _about_noise(pair: RegisteredPair, errors: ScanErrors | None) -> list[str]:
    """Return sentences on the noise of each scan, and on how far both walls together depart.

    The latter is at the shortest waves of the grid, and left out if ``errors`` have no noise.
    """
    lines = []
    for side, low, high in pair.scan_noise:
        if high <= 0.0:
            lines.append(
                f"{side} wall: no noise of the scanner is found, as the heights are smooth at the "
                "shortest waves of the grid (noise that was smoothed does not show)"
            )
        elif np.isfinite(high):
            least = f"{1e6 * low:.2g} to" if low > 0.0 else "0 (not significant) to"
            lines.append(
                f"{side} wall: the noise of the scanner is {least} {1e6 * high:.2g} um (white "
                "noise of each height, 95 % interval)"
            )
        else:
            lines.append(
                f"{side} wall: the noise of the scanner cannot be distinguished from roughness"
            )
    if errors and errors.noise[1] > 0.0:
        size = " to ".join(dict.fromkeys(f"{1e6 * noise:.2g}" for noise in errors.noise))
        lines.append(
            f"at the shortest waves of the grid, both walls together depart from a smooth spectrum "
            f"or from each other by {size} um rms. This is noise of the scanner, and roughness too "
            "short for the grid, which is smoothed where a wall is turned. The range of the "
            "results contains both"
        )
    return lines


def _force_in_holes(pair: RegisteredPair, history: xr.Dataset, largest: float) -> list[str]:
    """Return a sentence on the force on holes of a scan; a caution if they carry any.

    It is at the highest stress of a snapshot of the ``history`` that was reached, which for a joint
    that did not fail is the ``largest`` [Pa]. A joint that failed may have no snapshot, or only
    ones without force.
    """
    stresses = history.snapshot_stress.values
    forces = history.snapshot_force.values
    reached = stresses * (forces.sum(axis=(1, 2)) > 0.0)
    if not reached.any():
        return [
            "the force on holes of a scan is not known, as the joint reached no stress for which "
            "forces are stored"
        ]
    highest = reached.argmax()
    force = forces[highest]
    share = force[pair.holes].sum() / force.sum()
    stress = 1e-6 * stresses[highest]
    words = f"holes of a scan carry {percent(share)} of the force at {stress:g} MPa"
    if stresses[highest] < largest:
        words += f" (not known at {1e-6 * largest:g} MPa, which was not reached)"
    return [caution(words) if share > 0.0 else words]

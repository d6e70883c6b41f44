"""Simulation of many joints of one rock and load, and reading of their quantities."""

import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from typing import Any, NamedTuple, Unpack

import numpy as np
import xarray as xr

from jointclosure.ensembles.quantities import QUANTITIES, names_of_case
from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.execution.progress import bar
from jointclosure.execution.workers import Failed, ProcessLostError, in_processes, number_of_workers
from jointclosure.inputs import InputError, check_count
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.conditions import Changes, Conditions, conditions_from, takes_conditions
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.joint.status import FLAGS, LOADING, UNLOADING, failed
from jointclosure.joint.wall_checks import checked_walls
from jointclosure.joint.warmup import prepare_kernels
from jointclosure.walls import CrushedWalls, Walls
from jointclosure.walls.plausibility import doubts

NOT_SIMULATED = np.int16(2 * max(FLAGS))
"""Status bit of a joint that could not be simulated; its ``error`` states the reason."""
Row = dict[str, Any]  # quantities of a joint by name; a failed joint has only those of effort


class Reading(NamedTuple):
    """What is read of each joint: names of quantities, and the stresses of curves (n,) [Pa].

    ``conditions`` are those of the joints.
    """

    conditions: CheckedConditions
    names: tuple[str, ...]
    stresses: np.ndarray = np.empty(0)


def simulated_joint(
    walls: Walls | CrushedWalls,
    conditions: CheckedConditions,
    stresses: np.ndarray = np.empty(0),
    snapshots: Sequence[float] = (),
) -> SimulatedJoint:
    """Simulate the joint of two walls (y, x) [m], and measure the processor time.

    ``stresses`` [Pa] are those at which curves are read later, ``snapshots`` [Pa] those at which
    states are stored.
    """
    pair, pristine = walls if isinstance(walls, CrushedWalls) else (walls, None)
    start = time.process_time()
    closed = simulate_walls(*pair, conditions, snapshots=tuple(snapshots), pristine=pristine)
    return SimulatedJoint(pair, closed, conditions, time.process_time() - start, stresses)


def simulate_row(walls: Walls | CrushedWalls, reading: Reading) -> Row:
    """Simulate the joint of two walls (y, x) [m], and read its quantities by name.

    Raise `ValueError` if the ``oracle_ratio`` of crushed walls is to be read.
    """
    judged = "oracle_ratio" in reading.names
    conditions = reading.conditions
    if judged and isinstance(walls, CrushedWalls):
        raise ValueError("oracle_ratio: not of walls that were crushed before")
    kept = (float(conditions.largest_stress),) if judged else ()
    return read_joint(simulated_joint(walls, conditions, reading.stresses, kept), reading.names)


def read_joint(joint: SimulatedJoint, names: Iterable[str]) -> Row:
    """Read the quantities ``names`` of a simulated joint; only those of effort if it failed."""
    has_failed = failed(joint.closed)
    read = {name: QUANTITIES[name] for name in names}
    return {name: q.rule(joint) for name, q in read.items() if q.of_effort or not has_failed}


def stack_rows(rows: Sequence[Row], realizations: Any, seeds: Any, reading: Reading) -> xr.Dataset:
    """Return the quantities of joints as one dataset along the dimension ``realization``.

    ``rows`` has those of each joint by name. A quantity that a row does not have, because the joint
    failed, is NaN, or 0 if it is a count. ``realizations`` and ``seeds`` are coordinates.
    """
    about = {"long_name": "nominal normal stress", "units": "Pa"}
    joined = xr.Dataset(
        coords={
            "realization": realizations,
            "seed": ("realization", seeds),
            "cycle": np.arange(1, reading.conditions.cycle_count + 1),
            "branch": np.array([LOADING, UNLOADING], dtype=object),
            "stress": ("stress", reading.stresses, about),
        }
    )
    if reading.conditions.flow:
        from jointclosure.joint.flow import COORDINATE

        joined = joined.assign_coords(COORDINATE)
    for name in reading.names:
        quantity = QUANTITIES[name]
        known = [np.asarray(row[name]) for row in rows if name in row]
        counted = bool(known) and known[0].dtype.kind in "iu"
        missing = np.full([joined.sizes[of] for of in quantity.dims], 0 if counted else np.nan)
        values = np.stack([row.get(name, missing) for row in rows])
        joined[name] = ("realization", *quantity.dims), values, quantity.attributes
    return joined


@takes_conditions
def simulate_ensemble(
    walls: Iterable[Walls] | Callable[[int], Walls],
    *,
    conditions: Conditions | CheckedConditions | None = None,
    seeds: Iterable[int] = range(20),
    stress_points: int = 31,
    workers: int | None = None,
    progress: bool = False,
    **changes: Unpack[Changes],
) -> xr.Dataset:
    """Simulate many joints of the same rock under the same load, like a case of a study.

    Parameters
    ----------
    walls : iterable of (upper, lower), or callable
        Pairs of walls as for `jointclosure.simulate`; or a function that returns the pair
        of a seed, such as ``lambda seed: jc.wall_pair(8, (50, 50), 0.25e-3, seed)``.
    conditions, **changes
        As for `jointclosure.simulate`.
    seeds : iterable of int
        Arguments of the function; not used if pairs of walls are given.
    stress_points : int
        Number of evenly spaced stresses, from 0 to the largest, at which curves are stored; at
        least 2.
    workers : int, optional
        Number of processes, by default that of the processors available to this process. It
        affects only ``timing_simulation`` [s].
    progress : bool
        Whether to show a progress bar on a terminal.

    Returns
    -------
    Dataset
        Over ``realization``, ``cycle``, ``branch`` and ``stress`` [Pa], with the variables of
        a study's case: gross ``closure`` [m] from first touch, ``bulk_indentation`` [m], for each
        cycle ``max_closure``, ``residual_closure`` [m] and others, ``status``. The coordinate
        ``seed`` is the seed, or the position of a given pair. ``error`` states why a joint could
        not be simulated, and is empty otherwise. Such a joint has the status `NOT_SIMULATED` and
        results of NaN, does not affect other joints, and is named in a warning. A joint whose
        simulation failed has a status of 16 or more, its counts, and results of NaN. A joint whose
        process was killed is first tried once more.

    Raises
    ------
    InputError
        If there are no walls, or an argument is not allowed. If no joint could be simulated, the
        error of the first joint is raised, which may be of another type.
    TypeError
        If a keyword is unknown, or without ``conditions`` the rock, the spacing or the maximum
        stress is missing.
    """
    check_count("stress_points", stress_points, 2, 100_000)
    stated = conditions_from(conditions, changes, "simulate_ensemble", "spacing")
    checked = checked_as_stated(stated)
    spacing = checked.grid_spacing
    stresses = np.linspace(0.0, checked.largest_stress, stress_points)
    reading = Reading(checked, names_of_case(checked.flow), stresses)
    labels, pairs = _pairs(walls, seeds, spacing)
    if not checked.unusual_values and (doubtful := _doubts(pairs, labels, spacing)):
        warnings.warn(doubtful, stacklevel=2)
    answers = _rows(pairs, reading, labels, number_of_workers(workers), progress)
    if all(isinstance(answer, Failed) for answer in answers):
        raise answers[0].error
    rows = [{"status": NOT_SIMULATED} if isinstance(a, Failed) else a for a in answers]
    errors = [
        f"{type(a.error).__name__}: {a.error}" if isinstance(a, Failed) else "" for a in answers
    ]
    ensemble = stack_rows(rows, np.arange(len(rows)), labels, reading)
    about = ensemble.status.attrs
    why = {"long_name": "why a joint failed"}
    about["flag_masks"] = np.append(about["flag_masks"], np.int16(NOT_SIMULATED))
    about["flag_meanings"] += " not_simulated"
    ensemble["error"] = "realization", np.array(errors, dtype=object), why
    title = "closure of many rough joints"
    return ensemble.assign_attrs({"title": title} | checked.attributes())


def _rows(
    pairs: list[Any], reading: Reading, labels: np.ndarray, workers: int, progress: bool
) -> list[Any]:
    """Simulate all joints and return their rows, with `Failed` for those that are not simulated.

    ``pairs`` are walls, or `Failed` if these are not allowed. Joints whose process was lost are
    tried once more. Warnings name, by ``labels``, the joints that are tried again and those that
    are not simulated.
    """
    rows = pairs.copy()

    def simulate(places: list[int], workers: int, show: Callable[[float, str], None]) -> None:
        """Simulate the joints at some places, and put their rows into ``rows``."""
        tasks = [(pairs[place], reading) for place in places]
        for done, (at, row) in enumerate(in_processes(simulate_row, tasks, workers), start=1):
            rows[places[at]] = row
            show(done / len(tasks), f"joint {done} of {len(tasks)}")

    def numbers_of(kind: type[Exception]) -> list[int]:
        """Return the places of the joints that were not simulated because of a kind of error."""
        return [i for i, row in enumerate(rows) if isinstance(getattr(row, "error", None), kind)]

    valid = [i for i, pair in enumerate(pairs) if not isinstance(pair, Failed)]
    if workers > 1 and valid:  # before processes need them, which would each compile them
        prepare_kernels([reading.conditions.model], workers)
    with bar("simulating") if progress else nullcontext(lambda share, text: None) as show:
        simulate(valid, workers, show)
        if lost := numbers_of(ProcessLostError):
            again = f"simulating again: seeds {labels[lost].tolist()}: {rows[lost[0]].error}"
            warnings.warn(again, stacklevel=3)
            # fewer at a time, because the usual reason is lack of memory; never in this process
            simulate(lost, min(workers, 2), show)
    if 0 < len(without := numbers_of(Exception)) < len(rows):
        warnings.warn(
            f"{len(without)} of {len(rows)} joints could not be simulated and are NaN: seeds "
            f"{labels[without].tolist()}; `error` states the reasons, the first is "
            f"{rows[without[0]].error}",
            stacklevel=3,
        )
    return rows


def _pairs(walls: Any, seeds: Iterable[int], spacing: float) -> tuple[np.ndarray, list[Any]]:
    """Return the labels and the checked pairs of walls, with `Failed` for walls not allowed.

    Labels are the ``seeds`` if ``walls`` is a function, which is called here for each, else the
    positions of the pairs. Raise `InputError` if there are none.
    """
    numbers = list(seeds) if callable(walls) else []
    # in this process, so that functions are not pickled
    made = [walls(number) for number in numbers] if callable(walls) else list(walls)
    if not made:
        raise InputError("walls: there are none")
    pairs: list[Any] = []
    for upper, lower in made:
        try:
            pairs.append(checked_walls(upper, lower, spacing))
        except InputError as error:
            pairs.append(Failed(error))
    return np.array(numbers or range(len(pairs))), pairs


def _doubts(pairs: list[Any], labels: np.ndarray, spacing: float) -> str:
    """Return a text on probable errors in pairs of walls; empty if none has any.

    Pairs that are `Failed` are left out.
    """
    known = {at: pair for at, pair in enumerate(pairs) if not isinstance(pair, Failed)}
    doubtful = [(at, words) for at, (a, b) in known.items() if (words := doubts(a, b, spacing))]
    if not doubtful:
        return ""
    first, words = doubtful[0]
    of = f"{len(doubtful)} of {len(pairs)} pairs of walls, the first {labels[first]}: "
    return of + "; ".join(words)

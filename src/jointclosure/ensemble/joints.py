"""Many joints closed under the same conditions, without a workflow."""

import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import xarray as xr

from jointclosure.config.rocks import named_rock
from jointclosure.ensemble.closing import close_pair, labelled
from jointclosure.ensemble.settings import Conditions
from jointclosure.ensemble.workers import Failed, ProcessLostError, shared
from jointclosure.inputs import InputError, check_number
from jointclosure.jobs.progress import bar
from jointclosure.joint.given_walls import checked_walls
from jointclosure.joint.loading import SEATING_STRESS, largest_stress
from jointclosure.joint.protocol import FLAGS
from jointclosure.joint.simulation import checked_conditions
from jointclosure.parameters import Choices, Effects, Numerics, Rock
from jointclosure.surface.plausibility import doubts

NOT_SIMULATED = 2 * max(FLAGS)
"""Bit of the status of a joint that could not be closed at all; its ``error`` says why."""

Walls = tuple[np.ndarray, np.ndarray]


def simulate_ensemble(
    walls: Iterable[Walls] | Callable[[int], Walls],
    *,
    spacing: float,
    rock: str | Rock | tuple[Rock, Rock],
    max_normal_stress: float | Sequence[float],
    seeds: Iterable[int] = range(20),
    cycles: int | None = None,
    seating_stress: float = SEATING_STRESS,
    stress_points: int = 31,
    effects: Effects = Effects(),
    choices: Choices = Choices(),
    numerics: Numerics = Numerics(),
    unusual_values: bool = False,
    flow: bool = False,
    workers: int | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Close many joints of the same rock under the same load, as a study closes those of a case.

    Parameters
    ----------
    walls : iterable of (upper, lower), or callable
        Pairs of walls as `jointclosure.simulate` takes them; or a rule that gives the pair
        of a seed, as ``lambda seed: jc.wall_pair(8, (50, 50), 0.25e-3, seed)``.
    spacing : float
        Grid spacing [m].
    rock : str, Rock or (Rock, Rock)
        As for `jointclosure.close`.
    max_normal_stress, cycles, seating_stress, effects, choices, numerics, unusual_values, flow
        As for `jointclosure.simulate`.
    seeds : iterable of int
        Of the rule; not used where walls are given.
    stress_points : int
        Evenly spaced stresses, from 0 to the largest, at which curves are read; at least 2.
    workers : int, optional
        Processes, by default as many as this one may use processors. Their number changes
        nothing but ``timing_simulation`` [s].
    progress : bool
        Whether a bar shows how far it is, on a terminal.

    Returns
    -------
    Dataset
        Over ``realization``, ``cycle``, ``branch`` and ``stress`` [Pa], with the variables of
        a study's case: ``closure`` [m] from first touch, ``bulk_indentation`` [m], by cycle
        ``max_closure``, ``residual_closure`` [m] and others, ``status``. Coordinate ``seed`` (of
        walls that were given, their place), and ``error``: why a joint could not be closed, else
        empty. Such a joint has status `NOT_SIMULATED` and NaN, spoils no other, and is named in a
        warning. One whose process was killed is closed once more first.

    Raises
    ------
    InputError
        Nothing to close, or none of the joints could be closed: what the first one said.
    """
    check_number("stress_points", stress_points, whole=True)
    if stress_points < 2:
        raise InputError(f"stress_points = {stress_points!r}: must be at least 2")
    intact, load = checked_conditions(
        named_rock(rock) if isinstance(rock, str) else rock, spacing, max_normal_stress, cycles,
        seating_stress, effects, choices, numerics, unusual_values,
    )  # fmt: skip
    conditions = Conditions(
        spacing, intact, max_normal_stress, len(load), seating_stress, effects, choices, numerics,
        flow,
    )  # fmt: skip
    stresses = np.linspace(0.0, largest_stress(max_normal_stress), stress_points)
    labels, pairs = _pairs(walls, seeds)
    if not unusual_values and (doubtful := _doubts(pairs, labels, spacing)):
        warnings.warn(doubtful, stacklevel=2)
    tasks = [(upper, lower, stresses, conditions) for upper, lower in pairs]
    rows = _rows(tasks, labels, _workers(workers), progress)
    return _together(rows, labels, len(load), stresses)


def _rows(tasks: list[tuple], labels: np.ndarray, workers: int, progress: bool) -> list:
    """Rows of all joints; those whose process ended before it was done are closed once more."""
    rows: list[Any] = [None] * len(tasks)
    with _shown(progress, len(tasks)) as show:
        for place, row in shared(_closed, tasks, workers):
            rows[place] = row
            show()
    lost = [i for i, row in enumerate(rows) if _lost(row)]
    if lost:
        _warn(f"closing again: seeds {labels[lost].tolist()}: {rows[lost[0]].error}")
        # fewer at a time, as it is most often memory that was short; never in this process
        for place, row in shared(_closed, [tasks[i] for i in lost], min(workers, 2)):
            rows[lost[place]] = row
    failed = [i for i, row in enumerate(rows) if isinstance(row, Failed)]
    if failed and len(failed) < len(rows):
        _warn(
            f"{len(failed)} of {len(rows)} joints are not closed and NaN: seeds "
            f"{labels[failed].tolist()}; `error` has the reasons, the first is "
            f"{rows[failed[0]].error}"
        )
    return rows


def _lost(row: Any) -> bool:
    return isinstance(row, Failed) and isinstance(row.error, ProcessLostError)


def _warn(message: str) -> None:
    warnings.warn(message, stacklevel=4)


def _pairs(walls, seeds: Iterable[int]) -> tuple[np.ndarray, list[Walls]]:
    """Seeds and pairs of walls; made here, so that a rule need not reach another process."""
    if callable(walls):
        numbers = list(seeds)
        pairs = [walls(number) for number in numbers]
    else:
        pairs = list(walls)
        numbers = list(range(len(pairs)))
    if not pairs:
        raise InputError("walls: there are none")
    return np.array(numbers), pairs


def _closed(upper, lower, stresses: np.ndarray, conditions: Conditions) -> dict:
    """A joint closed as those of a study; walls that cannot be are its own failure."""
    walls = checked_walls(upper, lower, conditions.spacing)
    return close_pair(*walls, stresses, conditions)


def _doubts(pairs: list[Walls], labels: np.ndarray, spacing: float) -> str:
    """What looks like a slip in some of the pairs; those that are no walls fail by themselves."""
    doubtful = {}
    for label, (upper, lower) in zip(labels, pairs, strict=True):
        try:
            walls = checked_walls(upper, lower, spacing)
        except InputError:
            continue
        if sentences := doubts(*walls, spacing):
            doubtful[label] = sentences
    if not doubtful:
        return ""
    first, sentences = next(iter(doubtful.items()))
    return f"{len(doubtful)} of {len(pairs)} pairs of walls, the first {first}: " + "; ".join(
        sentences
    )


def _workers(workers: int | None) -> int:
    if workers is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    check_number("workers", workers, whole=True)
    if workers < 1:
        raise InputError(f"workers = {workers!r}: must be at least 1")
    return workers


@contextmanager
def _shown(progress: bool, total: int) -> Iterator[Callable[[], None]]:
    """What counts the joints that are done, on a bar if one is wanted."""
    if not progress:
        yield lambda: None
        return
    with bar("closing") as show:
        done = iter(range(1, total + 1))

        def count() -> None:
            number = next(done)
            show(number / total, f"joint {number} of {total}")

        yield count


def _together(rows: list, seeds: np.ndarray, cycles: int, stresses: np.ndarray) -> xr.Dataset:
    good = [row for row in rows if not isinstance(row, Failed)]
    if not good:
        raise rows[0].error
    errors = [
        f"{type(row.error).__name__}: {row.error}" if isinstance(row, Failed) else ""
        for row in rows
    ]
    filled = [_nothing(good[0]) if isinstance(row, Failed) else row for row in rows]
    ensemble = labelled(filled, np.arange(len(rows)), seeds, cycles, stresses)
    about = ensemble.status.attrs
    about["flag_masks"] = np.append(about["flag_masks"], np.int16(NOT_SIMULATED))
    about["flag_meanings"] += " not_simulated"
    return ensemble.assign(
        error=("realization", np.array(errors, dtype=object), {"long_name": "why a joint failed"})
    )


def _nothing(row: dict) -> dict:
    """A row like another of what was not simulated."""
    empty = {
        name: (dimensions, np.full(np.shape(values), np.nan))
        for name, (dimensions, values) in row.items()
    }
    counts = {
        name: ((), np.zeros_like(values)[()])
        for name, (_, values) in row.items()
        if np.asarray(values).dtype.kind in "iu"
    }
    return empty | counts | {"status": ((), np.int16(NOT_SIMULATED))}

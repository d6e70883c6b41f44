"""Closure of many joints: an ensemble of the same rock and load, and points of an experiment.

An experiment states as points which joints are closed. This module closes, times and reads them, as
a table with one row per joint and cycle. Failed joints stay in datasets and tables, with their
status and without readings.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from importlib import import_module
from typing import Any, NamedTuple, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.cache import Entry
from jointclosure.engine.joints import Reading, close_joint, stacked
from jointclosure.engine.progress import bar
from jointclosure.engine.quantities import QUANTITIES, names_of_case
from jointclosure.engine.settings import ClosureSettings, CrushedWalls, Walls, walls_of
from jointclosure.engine.workers import Failed, ProcessLostError, number_of_workers, shared
from jointclosure.inputs import InputError, check_number
from jointclosure.joint.conditions import (
    Changes,
    Conditions,
    conditions_from,
    takes_conditions,
)
from jointclosure.joint.given_walls import checked_walls
from jointclosure.joint.protocol import FLAGS
from jointclosure.statistics.standard_errors import Estimate, mean_of
from jointclosure.walls.plausibility import doubts

NOT_SIMULATED = np.int16(2 * max(FLAGS))
"""Status bit of a joint that could not be closed; its ``error`` states the reason."""


@takes_conditions
def simulate_ensemble(
    walls: Iterable[Walls] | Callable[[int], Walls],
    *,
    conditions: Conditions | None = None,
    seeds: Iterable[int] = range(20),
    stress_points: int = 31,
    workers: int | None = None,
    progress: bool = False,
    **changes: Unpack[Changes],
) -> xr.Dataset:
    """Close many joints of the same rock under the same load, as a study does for a case.

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
        a study's case: ``closure`` [m] from first touch, ``bulk_indentation`` [m], for each cycle
        ``max_closure``, ``residual_closure`` [m] and others, ``status``. Coordinate ``seed`` is
        the seed, or the position of a given pair. ``error`` states why a joint could not be
        closed, and is empty otherwise. Such a joint has status `NOT_SIMULATED` and NaN, does not
        affect other joints, and is named in a warning; one whose simulation failed has a status of
        16 or more, counts and NaN. A joint whose process was killed is first
        tried once more.

    Raises
    ------
    InputError
        If there is nothing to close, or if no joint could be closed; the message is that of the
        first joint.
    """
    check_number("stress_points", stress_points, whole=True)
    if stress_points < 2:
        raise InputError(f"stress_points = {stress_points!r}: must be at least 2")
    stated = conditions_from(conditions, changes, "simulate_ensemble", "spacing")
    spacing = stated.grid_spacing
    conditions = stated.checked()
    stresses = np.linspace(0.0, conditions.largest_stress, stress_points)
    reading = Reading(conditions, names_of_case(conditions.flow), stresses)
    labels, pairs = _pairs(walls, seeds, spacing)
    if not conditions.unusual_values and (doubtful := _doubts(pairs, labels, spacing)):
        warnings.warn(doubtful, stacklevel=2)
    answers = _rows(pairs, reading, labels, number_of_workers(workers), progress)
    if all(isinstance(answer, Failed) for answer in answers):
        raise answers[0].error
    rows = [{"status": NOT_SIMULATED} if isinstance(a, Failed) else a for a in answers]
    errors = [
        f"{type(a.error).__name__}: {a.error}" if isinstance(a, Failed) else "" for a in answers
    ]
    ensemble = stacked(rows, np.arange(len(rows)), labels, reading)
    about = ensemble.status.attrs
    about["flag_masks"] = np.append(about["flag_masks"], np.int16(NOT_SIMULATED))
    about["flag_meanings"] += " not_simulated"
    why = {"long_name": "why a joint failed"}
    attributes = {"title": "closure of many rough joints"} | conditions.attributes()
    return ensemble.assign(error=("realization", np.array(errors, dtype=object), why)).assign_attrs(
        attributes
    )


def _rows(
    pairs: list[Any], reading: Reading, labels: np.ndarray, workers: int, progress: bool
) -> list[Any]:
    """Return rows of all joints; joints whose process was lost are tried once more."""
    rows = pairs.copy()

    def close(places: list[int], workers: int, show: Callable[[float, str], None]) -> None:
        tasks = [(pairs[place], reading) for place in places]
        for done, (at, row) in enumerate(shared(close_joint, tasks, workers), start=1):
            rows[places[at]] = row
            show(done / len(tasks), f"joint {done} of {len(tasks)}")

    def failed(kind: type[Exception]) -> list[int]:
        return [i for i, row in enumerate(rows) if isinstance(getattr(row, "error", None), kind)]

    valid = [i for i, pair in enumerate(pairs) if not isinstance(pair, Failed)]
    with bar("closing") if progress else nullcontext(lambda share, text: None) as show:
        close(valid, workers, show)
        if lost := failed(ProcessLostError):
            _warn(f"closing again: seeds {labels[lost].tolist()}: {rows[lost[0]].error}")
            # fewer at a time, because the usual reason is lack of memory; never in this process
            close(lost, min(workers, 2), show)
    if 0 < len(without := failed(Exception)) < len(rows):
        _warn(
            f"{len(without)} of {len(rows)} joints could not be closed and are NaN: seeds "
            f"{labels[without].tolist()}; `error` states the reasons, the first is "
            f"{rows[without[0]].error}"
        )
    return rows


def _warn(message: str) -> None:
    warnings.warn(message, stacklevel=4)


def _pairs(walls: Any, seeds: Iterable[int], spacing: float) -> tuple[np.ndarray, list[Any]]:
    """Return seeds, and checked pairs of walls, `Failed` for those that are not allowed.

    They are made in this process, so that functions are not pickled.
    """
    numbers = list(seeds) if callable(walls) else []
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
    """Describe probable errors in pairs of walls."""
    known = {at: pair for at, pair in enumerate(pairs) if not isinstance(pair, Failed)}
    doubtful = [(at, words) for at, (a, b) in known.items() if (words := doubts(a, b, spacing))]
    if not doubtful:
        return ""
    first, words = doubtful[0]
    of = f"{len(doubtful)} of {len(pairs)} pairs of walls, the first {labels[first]}: "
    return of + "; ".join(words)


class Point(NamedTuple):
    """Joints of an experiment that are closed under the same conditions, one a realisation.

    ``coordinates`` are columns of the table [SI]. ``maker`` names a function of a study, as
    ``module:function``, that generates the walls from the settings and ``options``; without it they
    are `walls_of` the settings.
    """

    coordinates: dict[str, Any]
    settings: ClosureSettings
    maker: str = ""
    options: Mapping[str, Any] = {}

    def walls(self) -> Iterator[Walls | CrushedWalls]:
        """Generate the walls of each realisation."""
        module, _, function = self.maker.partition(":")
        if not function:
            return walls_of(self.settings.surfaces)
        return getattr(import_module(module), function)(self.settings, **self.options)


Jobs = Mapping[str, Sequence[Point]]
"""Points by the name of the job that closes them; names are never parsed."""


class Sample(NamedTuple):
    """Similar points whose mean time is that of a number of ``joints``."""

    points: Sequence[Point]
    joints: int


Samples = Mapping[str, Sequence[Sample]]
"""Samples by the row of the estimate to which they belong, usually a job."""


def close_points(
    points: Iterable[Point],
    quantities: Sequence[str],
    report: Callable[[str], None] = lambda line: None,
) -> pd.DataFrame:
    """Close all joints of points and read quantities of them (`QUANTITIES`).

    One row per joint and cycle: the coordinates of its point, ``realization``, ``cycle``,
    ``status``, processor ``seconds`` of the closure, and the quantities [SI], NaN for a failed
    joint. ``report`` receives a line for each point.
    """
    parts = []
    for point in points:
        settings, rows = point.settings, []
        reading = Reading(settings.conditions(), ("status", "timing_simulation", *quantities))
        first = settings.surfaces.first_realization
        for realization, walls in enumerate(point.walls(), first):
            row = close_joint(walls, reading)
            at = point.coordinates | {
                "realization": realization,
                "cycle": np.arange(1, settings.cycles + 1),
                "status": int(row["status"]),
                "seconds": row["timing_simulation"],
            }
            rows.append(pd.DataFrame(at | {name: row.get(name, np.nan) for name in quantities}))
        parts.append(part := pd.concat(rows))
        at_point = ", ".join(f"{name} {value}" for name, value in point.coordinates.items())
        statuses = np.unique(part.status).tolist()
        report(f"{at_point}: {part.seconds.mean():.2f} s a joint, statuses {statuses}")
    return pd.concat(parts, ignore_index=True)


def closed_table(
    points: Sequence[Point], quantities: Sequence[str], report: Callable[[str], None]
) -> xr.Dataset:
    """Return `close_points` as a dataset (`as_dataset`)."""
    return as_dataset(close_points(points, quantities, report))


def samples_of(jobs: Jobs) -> dict[str, list[Sample]]:
    """Sample the first point of every grid in each job."""
    samples = {}
    for job, points in jobs.items():
        alike: dict[tuple, list[Point]] = {}
        for point in points:
            grid = point.settings.surfaces.grid, tuple(sorted(point.options))
            alike.setdefault(grid, []).append(point)
        samples[job] = [Sample(group[:1], joints_of(group)) for group in alike.values()]
    return samples


def estimated_time(
    samples: Samples, report: Callable[[str], None] = lambda line: None
) -> pd.DataFrame:
    """Estimate processor time by closing one joint of each point of the samples.

    A row has ``job``, its number of ``joints``, ``seconds``, and the standard ``error`` of these,
    NaN where a sample is a single point.
    """
    closed: dict[str, float] = {}

    def seconds(point: Point) -> float:
        key = repr(point)
        if key not in closed:
            if not closed:
                _seconds_of_one(point)  # loads the kernels
            closed[key] = _seconds_of_one(point)
        return closed[key]

    rows = []
    for job, parts in samples.items():
        times = [_mean([seconds(point) for point in part.points]) for part in parts]
        counts = np.array([part.joints for part in parts], dtype=float)
        means, errors = np.array(times).reshape(-1, 2).T
        rows.append(
            {
                "job": job,
                "joints": sum(part.joints for part in parts),
                "seconds": float(counts @ means),
                "error": float(np.hypot.reduce(counts * errors)),
            }
        )
        report(f"{job}: about {rows[-1]['seconds']:.0f} s")
    return pd.DataFrame(rows)


def _mean(times: list[float]) -> Estimate:
    return mean_of(times) if len(times) > 1 else Estimate(times[0], np.nan)


def _seconds_of_one(point: Point) -> float:
    """Measure the processor time of the first joint of a point [s]."""
    return float(close_points([one_joint(point)], ()).seconds.iloc[0])


def one_joint(point: Point) -> Point:
    """Return the point with only its first realisation."""
    surfaces = point.settings.surfaces._replace(realizations=1)
    return point._replace(settings=point.settings._replace(surfaces=surfaces))


def entries_of(name: str, jobs: Jobs, quantities: Sequence[str]) -> list[Entry]:
    """Return the files of a cache with the joints of each job of an experiment."""
    return [
        Entry(
            f"{name}/{job}",
            closed_table,
            (list(points), tuple(quantities)),
            joints=joints_of(points),
            uses=tuple(sorted({point.maker for point in points if point.maker})),
        )
        for job, points in jobs.items()
    ]


def joints_of(points: Iterable[Point]) -> int:
    """Return the number of joints that are closed at some points."""
    return sum(point.settings.surfaces.realizations for point in points)


def gridded(joints: pd.DataFrame, over: Sequence[str], quantities: Sequence[str]) -> xr.Dataset:
    """Arrange joints of `close_points` over columns, including ``realization``, and the cycle.

    ``status`` and ``seconds`` do not depend on the cycle.
    """
    grid = joints.set_index([*over, "cycle"])[["status", "seconds", *quantities]].to_xarray()
    for name in ("status", "seconds"):
        grid[name] = grid[name].isel(cycle=0, drop=True)
    return grid


def as_dataset(table: pd.DataFrame) -> xr.Dataset:
    """Convert a table of `close_points` to a dataset over (entry), with units and titles."""
    dataset = xr.Dataset({name: ("entry", table[name].to_numpy()) for name in table})
    for name in set(table) & set(QUANTITIES):
        dataset[name].attrs = QUANTITIES[name].attributes
    if "seconds" in dataset:
        dataset["seconds"].attrs = {"long_name": "processor time of the closure", "units": "s"}
    return dataset


def as_table(*datasets: xr.Dataset) -> pd.DataFrame:
    """Convert datasets of `as_dataset` back to one table; empty without any."""
    tables = (
        pd.DataFrame({str(name): values.values for name, values in dataset.data_vars.items()})
        for dataset in datasets
    )
    return pd.concat(tables, ignore_index=True) if datasets else pd.DataFrame()

"""Joints closed at the points of an experiment, as one table with a row a joint and cycle.

An experiment says which joints are closed, as points; here they are closed, timed and read. The
table keeps failed joints, with their status and without readings.
"""

import time
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.plain import from_plain, to_plain
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.quantities import QUANTITIES, ClosedJoint
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.walls import MAKERS, Walls
from jointclosure.joint.protocol import FAILURE
from jointclosure.statistics.standard_errors import Estimate, mean_of


class Point(NamedTuple):
    """Joints that are closed under the same conditions.

    Attributes
    ----------
    coordinates : dict
        Coordinates of the point in its experiment [SI], columns of the table.
    settings : ClosureSettings
        Complete before the job starts. One joint is closed for each of its realisations.
    walls : str
        Maker of the walls, of `jointclosure.ensemble.walls.MAKERS`.
    options : mapping
        Further arguments of the maker.
    """

    coordinates: dict[str, Any]
    settings: ClosureSettings
    walls: str = "synthetic"
    options: Mapping[str, Any] = MappingProxyType({})


Jobs = Mapping[str, Sequence[Point]]
"""Points by the name of the job that closes them; names are never taken apart."""


class JobsOnDemand(Mapping[str, Sequence[Point]]):
    """Jobs whose points are made when they are asked for, and kept.

    Parameters
    ----------
    arguments : mapping
        By the name of the job, the arguments of ``points_of``.
    points_of : callable
        Makes the points of a job.
    """

    def __init__(
        self, arguments: Mapping[str, tuple], points_of: Callable[..., Sequence[Point]]
    ) -> None:
        self._arguments, self._points_of = arguments, points_of
        self._made: dict[str, Sequence[Point]] = {}

    def __getitem__(self, name: str) -> Sequence[Point]:
        if name not in self._made:
            self._made[name] = self._points_of(*self._arguments[name])
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arguments)

    def __len__(self) -> int:
        return len(self._arguments)


class Sample(NamedTuple):
    """Points of which one joint is closed to estimate the time of many.

    Attributes
    ----------
    points : sequence of Point
        Alike, so that the mean of their times is that of all joints.
    joints : int
        Number of joints that they stand for.
    """

    points: Sequence[Point]
    joints: int


Samples = Mapping[str, Sequence[Sample]]
"""Samples by the row of the estimate that they belong to, a job mostly."""


def close_points(
    points: Iterable[Point],
    quantities: Sequence[str],
    report: Callable[[str], None] = lambda line: None,
) -> pd.DataFrame:
    """Close all joints of some points, and read quantities of them.

    Parameters
    ----------
    points : iterable of Point
    quantities : sequence of str
        Names of `jointclosure.ensemble.quantities.QUANTITIES`.
    report : callable
        Receives a line for each point.

    Returns
    -------
    DataFrame
        A row a joint and cycle: the coordinates of its point, ``realization``, ``cycle``,
        ``status``, processor ``seconds`` of the closure, and the quantities [SI], NaN of a joint
        that failed.
    """
    parts = []
    for point in points:
        part = pd.concat(
            [
                closed_joint(point, realization, walls, quantities)
                for realization, walls in _numbered(point)
            ]
        )
        parts.append(part)
        at = ", ".join(f"{name} {value}" for name, value in point.coordinates.items())
        report(
            f"{at}: {part.seconds.mean():.2f} s a joint, statuses {np.unique(part.status).tolist()}"
        )
    return pd.concat(parts, ignore_index=True)


def _numbered(point: Point) -> Iterable[tuple[int, Walls]]:
    """Walls of a point with the numbers of their realisations."""
    surfaces = point.settings.surfaces
    return enumerate(MAKERS[point.walls](surfaces, **point.options), surfaces.first_realization)


def closed_joint(
    point: Point, realization: int, walls: Walls, quantities: Sequence[str]
) -> pd.DataFrame:
    """Close one joint of a point: its rows of the table, one a cycle."""
    conditions = point.settings.conditions()
    start = time.process_time()
    joint = ClosedJoint(walls, close_walls(*walls, conditions), conditions)
    seconds = time.process_time() - start
    status = int(joint.closed.status)
    return pd.DataFrame(
        point.coordinates
        | {
            "realization": realization,
            "cycle": np.arange(1, point.settings.cycles + 1),
            "status": status,
            "seconds": seconds,
        }
        | {
            name: QUANTITIES[name].rule(joint) if status < FAILURE else np.nan
            for name in quantities
        }
    )


def samples_of(jobs: Jobs) -> dict[str, list[Sample]]:
    """Sample the first point of every grid in each job."""
    samples = {}
    for job, points in jobs.items():
        alike: dict[tuple, list[Point]] = {}
        for point in points:
            grid = point.settings.surfaces.grid, tuple(sorted(point.options))
            alike.setdefault(grid, []).append(point)
        samples[job] = [Sample(each[:1], joints_of(each)) for each in alike.values()]
    return samples


def estimated_time(
    samples: Samples, report: Callable[[str], None] = lambda line: None
) -> pd.DataFrame:
    """Estimate processor time, by one joint of each point of some samples.

    Returns
    -------
    DataFrame
        ``job``, its number of ``joints``, ``seconds``, and the standard ``error`` of these, NaN
        where a sample is a single point.
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
    """Processor time of the first joint of a point [s]."""
    number, walls = next(iter(_numbered(one_joint(point))))
    return float(closed_joint(point, number, walls, ()).seconds.iloc[0])


def one_joint(point: Point) -> Point:
    """The point with its first realisation only."""
    surfaces = point.settings.surfaces._replace(realizations=1)
    return point._replace(settings=point.settings._replace(surfaces=surfaces))


def joints_of(points: Iterable[Point]) -> int:
    """Number of joints that are closed at some points."""
    return sum(point.settings.surfaces.realizations for point in points)


def packed(points: Sequence[Point]) -> dict:
    """Points as plain data: the settings of the first, and what is changed at each.

    Parameters of rules are made of this, so that a job of hundreds of points stays small.
    """
    first = points[0].settings
    return {
        "settings": to_plain(first),
        "points": [
            {
                "coordinates": dict(point.coordinates),
                "settings": _changes(first, point.settings),
                "walls": point.walls,
                "options": dict(point.options),
            }
            for point in points
        ],
    }


def unpacked(plain: Mapping) -> list[Point]:
    """The points of `packed`."""
    first = from_plain(ClosureSettings, plain["settings"])
    return [
        Point(**dict(point) | {"settings": _changed(first, point["settings"])})
        for point in plain["points"]
    ]


def _changes(before: tuple, after: tuple) -> dict:
    """Fields of nested named tuples of one type that differ, as plain data."""
    changes: dict = {}
    for name in after._fields:  # type: ignore[attr-defined]
        old, new = getattr(before, name), getattr(after, name)
        if old is new or (type(old) is type(new) and old == new):
            continue
        nested = hasattr(new, "_fields") and type(old) is type(new)
        changes[name] = _changes(old, new) if nested else to_plain(new)
    return changes


def _changed(before, changes: dict):
    """Nested named tuples with the entries of `_changes`."""
    hints = typing.get_type_hints(type(before)) if changes else {}
    new = {}
    for name, value in changes.items():
        old = getattr(before, name)
        nested = hasattr(old, "_fields") and isinstance(value, dict)
        new[name] = _changed(old, value) if nested else from_plain(hints[name], value)
    return before._replace(**new)


def gridded(joints: pd.DataFrame, over: Sequence[str], quantities: Sequence[str]) -> xr.Dataset:
    """Put joints on a grid of their coordinates.

    Parameters
    ----------
    joints : DataFrame
        As from `close_points`, with one row for each place of the grid.
    over : sequence of str
        Columns, ``realization`` among them.
    quantities : sequence of str

    Returns
    -------
    Dataset
        The quantities over these columns and the cycle; ``status`` and ``seconds`` over the
        columns alone.
    """
    grid = joints.set_index([*over, "cycle"])[["status", "seconds", *quantities]].to_xarray()
    for name in ("status", "seconds"):
        grid[name] = grid[name].isel(cycle=0, drop=True)
    return grid


def as_dataset(table: pd.DataFrame) -> xr.Dataset:
    """A table of `close_points` over (entry), with units and titles of its quantities."""
    dataset = xr.Dataset({name: ("entry", table[name].to_numpy()) for name in table})
    for name in set(table) & set(QUANTITIES):
        quantity = QUANTITIES[name]
        dataset[name].attrs = {"long_name": quantity.title, "units": quantity.unit}
    dataset["seconds"].attrs = {"long_name": "processor time of the closure", "units": "s"}
    return dataset


def as_table(*datasets: xr.Dataset) -> pd.DataFrame:
    """The tables of `as_dataset` as one; empty without any."""
    tables = (
        pd.DataFrame({str(name): values.values for name, values in each.data_vars.items()})
        for each in datasets
    )
    return pd.concat(tables, ignore_index=True) if datasets else pd.DataFrame()

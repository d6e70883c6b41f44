"""Closure of joints at the points of an experiment, as a table with one row per joint and cycle.

An experiment states as points which joints are closed. This module closes, times and reads them.
Failed joints stay in the table with their status and without readings.
"""

import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
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


class Point(NamedTuple):
    """Joints that are closed under the same conditions.

    Attributes
    ----------
    coordinates : dict
        Coordinates of the point in its experiment [SI], columns of the table.
    settings : ClosureSettings
        Settings, complete before the job starts. One joint is closed for each realisation.
    walls : str
        Name of the maker of the walls in `jointclosure.ensemble.walls.MAKERS`.
    options : mapping
        Further arguments of the maker.
    """

    coordinates: dict[str, Any]
    settings: ClosureSettings
    walls: str = "synthetic"
    options: Mapping[str, Any] = MappingProxyType({})


Jobs = Mapping[str, Sequence[Point]]
"""Points by the name of the job that closes them; names are never parsed."""


def close_points(
    points: Iterable[Point],
    quantities: Sequence[str],
    report: Callable[[str], None] = lambda line: None,
) -> pd.DataFrame:
    """Close all joints of the given points and evaluate quantities of them.

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
        One row per joint and cycle: the coordinates of its point, ``realization``, ``cycle``,
        ``status``, processor ``seconds`` of the closure, and the quantities [SI], NaN for a
        failed joint.
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
    """Return the walls of a point with the numbers of their realisations."""
    surfaces = point.settings.surfaces
    return enumerate(MAKERS[point.walls](surfaces, **point.options), surfaces.first_realization)


def closed_joint(
    point: Point, realization: int, walls: Walls, quantities: Sequence[str]
) -> pd.DataFrame:
    """Close one joint of a point and return its rows of the table, one per cycle."""
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


def estimated_time(jobs: Jobs, report: Callable[[str], None] = lambda line: None) -> pd.DataFrame:
    """Estimate the processor time of each job by closing one joint of every grid in it.

    Returns
    -------
    DataFrame
        ``job``, its number of ``joints``, and ``seconds``.
    """
    rows = []
    for job, points in jobs.items():
        seconds, first = 0.0, {}
        for point in points:
            grid = point.settings.surfaces.grid, tuple(sorted(point.options))
            if grid not in first:
                number, walls = next(iter(_numbered(one_joint(point))))
                first[grid] = float(closed_joint(point, number, walls, ()).seconds.iloc[0])
            seconds += first[grid] * point.settings.surfaces.realizations
        rows.append({"job": job, "joints": joints_of(points), "seconds": seconds})
        report(f"{job}: about {seconds:.0f} s")
    return pd.DataFrame(rows)


def one_joint(point: Point) -> Point:
    """Return the point with only its first realisation."""
    surfaces = point.settings.surfaces._replace(realizations=1)
    return point._replace(settings=point.settings._replace(surfaces=surfaces))


def joints_of(points: Iterable[Point]) -> int:
    """Return the number of joints that are closed at some points."""
    return sum(point.settings.surfaces.realizations for point in points)


def packed(points: Sequence[Point]) -> dict:
    """Convert points to plain data: the settings of the first, and the changes at the others.

    It keeps the parameters of rules small for a job with hundreds of points.
    """
    first = to_plain(points[0].settings)
    return {
        "settings": first,
        "points": [
            {
                "coordinates": dict(point.coordinates),
                "settings": _changes(first, to_plain(point.settings)),
                "walls": point.walls,
                "options": dict(point.options),
            }
            for point in points
        ],
    }


def unpacked(plain: Mapping) -> list[Point]:
    """Restore points from the plain data of `packed`."""
    return [
        Point(**dict(point) | {"settings": _settings(plain["settings"], point["settings"])})
        for point in plain["points"]
    ]


def _settings(first: dict, changes: dict) -> ClosureSettings:
    return from_plain(ClosureSettings, _changed(first, changes))


def _changes(before: dict, after: dict) -> dict:
    """Return the entries that differ between nested mappings with the same keys."""
    changes: dict = {}
    for key, value in after.items():
        if (
            isinstance(value, dict)
            and isinstance(before[key], dict)
            and value.keys() == before[key].keys()
        ):
            if below := _changes(before[key], value):
                changes[key] = below
        elif json.dumps(value) != json.dumps(before[key]):
            changes[key] = value
    return changes


def _changed(before: dict, changes: dict) -> dict:
    """Apply the entries of `_changes` to nested mappings."""
    return before | {
        key: _changed(before[key], value)
        if isinstance(value, dict)
        and isinstance(before[key], dict)
        and value.keys() <= before[key].keys()
        else value
        for key, value in changes.items()
    }


def gridded(joints: pd.DataFrame, over: Sequence[str], quantities: Sequence[str]) -> xr.Dataset:
    """Arrange joints on a grid of their coordinates.

    Parameters
    ----------
    joints : DataFrame
        As from `close_points`, with one row for each node of the grid.
    over : sequence of str
        Columns that are the dimensions of the grid, including ``realization``.
    quantities : sequence of str

    Returns
    -------
    Dataset
        The quantities over these columns and the cycle; ``status`` and ``seconds`` only over
        the columns.
    """
    grid = joints.set_index([*over, "cycle"])[["status", "seconds", *quantities]].to_xarray()
    for name in ("status", "seconds"):
        grid[name] = grid[name].isel(cycle=0, drop=True)
    return grid


def as_dataset(table: pd.DataFrame) -> xr.Dataset:
    """Convert a table of `close_points` to a dataset over (row), with units and titles."""
    dataset = xr.Dataset({name: ("row", table[name].to_numpy()) for name in table})
    for name in set(table) & set(QUANTITIES):
        quantity = QUANTITIES[name]
        dataset[name].attrs = {"long_name": quantity.title, "units": quantity.unit}
    dataset["seconds"].attrs = {"long_name": "processor time of the closure", "units": "s"}
    return dataset


def as_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Convert a dataset of `as_dataset` back to a table."""
    return pd.DataFrame({str(name): values.values for name, values in dataset.data_vars.items()})

"""Points of an experiment: which joints are closed, and what is read of them into a table."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.joints import Reading, close_joint
from jointclosure.engine.quantities import COLUMNS, COORDINATES, QUANTITIES, shown_as
from jointclosure.statistics.standard_errors import Estimate, harmonic_mean, ratio_of_means
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls import CrushedWalls, Walls
from studies.frame.settings import ClosureSettings, walls_of


class Point(NamedTuple):
    """Joints of an experiment that are closed under the same conditions, one a realisation.

    ``coordinates`` are columns of the table [SI]. ``maker`` names a function (``module:function``)
    that generates the walls from settings and ``options``; without it they are `walls_of` these.
    """

    coordinates: dict[str, Any]
    settings: ClosureSettings
    maker: str = ""
    options: Mapping[str, Any] = {}

    def walls(self) -> Iterator[Walls | CrushedWalls]:
        """Generate the walls of each realisation."""
        module, _, function = self.maker.partition(":")
        if not function:
            return walls_of(self.settings)
        return getattr(import_module(module), function)(self.settings, **self.options)


Jobs = Mapping[str, Sequence[Point]]
"""Points by the name of the job that closes them; names are never parsed."""


def close_points(
    points: Iterable[Point],
    quantities: Sequence[str],
    report: Callable[[str], None] = lambda line: None,
) -> pd.DataFrame:
    """Close all joints of points, and read quantities [SI] in a row per joint and cycle.

    Failed joints stay in the table, with their status and NaN.
    """
    parts = []
    for point in points:
        settings, rows = point.settings, []
        reading = Reading(settings.conditions, ("status", "timing_simulation", *quantities))
        for realization, walls in enumerate(point.walls(), settings.first_realization):
            row = close_joint(walls, reading)
            at = point.coordinates | {
                "realization": realization,
                "cycle": np.arange(1, settings.conditions.cycle_count + 1),
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


def joints_of(points: Iterable[Point]) -> int:
    """Return the number of joints that are closed at some points."""
    return sum(point.settings.realizations for point in points)


def gridded(joints: pd.DataFrame, over: Sequence[str], quantities: Sequence[str]) -> xr.Dataset:
    """Arrange joints over columns, including ``realization``; quantities over cycles too."""
    grid = joints.set_index([*over, "cycle"])[["status", "seconds", *quantities]].to_xarray()
    for name in ("status", "seconds"):
        grid[name] = grid[name].isel(cycle=0, drop=True)
    return grid


def as_dataset(table: pd.DataFrame) -> xr.Dataset:
    """Convert a table of `close_points` to a dataset over (entry), with units and titles."""
    dataset = xr.Dataset({name: ("entry", table[name].to_numpy()) for name in table})
    for name in set(table) & set(QUANTITIES):
        dataset[name].attrs = QUANTITIES[name].attributes
    dataset["seconds"].attrs = {"long_name": "processor time of the closure", "units": "s"}
    return dataset


def as_table(*datasets: xr.Dataset) -> pd.DataFrame:
    """Convert datasets of `as_dataset` back to one table."""
    return pd.concat([dataset.to_dataframe() for dataset in datasets], ignore_index=True)


Joints = Annotated[pd.DataFrame, lambda path: as_table(read_netcdf(path))]
"""Table of all joints of an experiment, read from its file."""


def grouped(joints: pd.DataFrame, *by: str) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Generate the joints with equal coordinates, and these in the columns of a published table."""
    for values, part in joints.groupby(list(by), sort=False, dropna=False):
        at = {}
        for name, value in zip(by, values, strict=True):
            column, scale = shown_as(name, COORDINATES.get(name, ("", "1"))[1])
            at[column] = value if scale == 1.0 else scale * value
        yield at, part


def mean_shown(name: str, values: np.ndarray) -> Estimate:
    """Compute the mean (harmonic for stiffnesses) of a quantity (n,) [SI] in the unit of tables."""
    shown = COLUMNS[name][1] * np.asarray(values, dtype=float)
    if QUANTITIES[name].harmonic:
        return harmonic_mean(shown)
    return ratio_of_means(shown, np.ones(shown.size))

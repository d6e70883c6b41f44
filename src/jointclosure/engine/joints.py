"""Joints closed, timed and read: one, and all of a case."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engine.closed_joint import ClosedJoint
from jointclosure.engine.quantities import QUANTITIES, names_of_case
from jointclosure.engine.settings import ClosureSettings
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.joint.simulation import close_walls

Walls = tuple[np.ndarray, np.ndarray]
"""Upper and lower wall (y, x), heights towards the other [m]."""
Row = dict[str, Any]
"""Quantities of a joint by name; a failed joint has only those of effort."""
_TOGETHER = 100
"""Number of realisations that are joined before they are written."""


class Reading(NamedTuple):
    """Conditions of joints, names of the quantities that are read, and stresses of curves [Pa]."""

    conditions: Conditions
    names: tuple[str, ...]
    stresses: np.ndarray = np.empty(0)


def reading_of_case(settings: ClosureSettings) -> Reading:
    """Return what is stored of the joints of a case."""
    stresses = np.linspace(0.0, settings.largest_stress, settings.stress_points)
    return Reading(settings.conditions(), names_of_case(settings.flow), stresses)


def close_joint(walls: Walls, reading: Reading) -> Row:
    """Close two walls (y, x) [m], and read quantities of the joint."""
    start = time.process_time()
    closed = close_walls(*walls, reading.conditions)
    return read_joint(walls, closed, time.process_time() - start, reading)


def read_joint(walls: Walls, closed: xr.Dataset, seconds: float, reading: Reading) -> Row:
    """Read quantities of a closed joint; of one that failed only those of effort."""
    joint = ClosedJoint(walls, closed, reading.conditions, seconds, reading.stresses)
    failed = int(closed.status) >= FAILURE
    read = {name: QUANTITIES[name] for name in reading.names}
    return {name: q.rule(joint) for name, q in read.items() if q.of_effort or not failed}


def stacked(rows: Sequence[Row], realizations: Any, seeds: Any, reading: Reading) -> xr.Dataset:
    """Join rows of joints along ``realization``, with coordinates, titles and units.

    What a row lacks is NaN, a count 0.
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


def close_surfaces(
    surfaces: xr.Dataset,
    settings: ClosureSettings,
    *,
    report: Callable[[str], None] = lambda line: None,
    repeated_by: str = "",
    known: Mapping[str, Row] = MappingProxyType({}),
) -> Iterator[xr.Dataset]:
    """Close all surface pairs of a case (`make_surfaces`), up to a hundred in memory at a time.

    ``report`` receives a line for each realisation, in which ``repeated_by`` is the command that
    repeats a failed one, without its number. ``known`` has the quantities of pairs that were closed
    with these settings before, by seed (`rows_by_seed`). Datasets are over (realization, cycle,
    branch, stress); a failed realisation has a status of 16 or more, counts, and otherwise NaN.
    """
    reading = reading_of_case(settings)
    realizations, seeds = surfaces.realization.values, surfaces.seed.values
    for first in range(0, realizations.size, _TOGETHER):
        few = slice(first, first + _TOGETHER)
        rows = []
        for number, realization in enumerate(realizations[few], start=first):
            again = f"; to repeat it: {repeated_by} {realization}" if repeated_by else ""
            upper, lower = (surfaces[name][number].values for name in ("upper", "lower"))
            try:
                row = known.get(seeds[number]) or close_joint((upper, lower), reading)
            except Exception as error:
                report(f"realisation {realization}: {type(error).__name__}: {error}{again}")
                raise
            report(f"realisation {realization}: {_described(row, again)}")
            rows.append(row)
        yield stacked(rows, realizations[few], seeds[few], reading)


def closed_before(
    surfaces: Iterable[xr.Dataset],
    closed: Iterable[tuple[xr.Dataset, float]],
    settings: ClosureSettings,
) -> xr.Dataset:
    """Join results that were closed for another purpose, in the form of `close_surfaces`.

    ``closed`` are results of `close_walls` and processor times [s] for the first of the surfaces
    (`make_surfaces`), closed with these settings.
    """
    reading = reading_of_case(settings)
    rows, realizations, seeds = [], [], []
    for (dataset, seconds), pair in zip(closed, surfaces, strict=False):
        walls = pair.upper.values[0], pair.lower.values[0]
        rows.append(read_joint(walls, dataset, seconds, reading))
        realizations.append(int(pair.realization[0]))
        seeds.append(str(pair.seed.values[0]))
    return stacked(rows, np.array(realizations), np.array(seeds, dtype=object), reading)


def rows_by_seed(closed: xr.Dataset) -> dict[str, Row]:
    """Return the quantities of joints of `close_surfaces` by the seeds of their walls."""
    joints = (closed.isel(realization=number) for number in range(closed.sizes["realization"]))
    return {
        str(joint.seed.values): {str(name): array.values for name, array in joint.data_vars.items()}
        for joint in joints
    }


def _described(row: Row, again: str) -> str:
    words = [f"status {int(row['status'])}", f"{row['timing_simulation']:.2f} s"]
    if row["status"] >= FAILURE:
        return ", ".join([*words, f"failed{again}"])
    closures = ", ".join(f"{1e3 * value:.5f}" for value in row["max_closure"])
    return ", ".join([words[0], f"maximum closure {closures} mm", words[1]])

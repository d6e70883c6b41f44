"""Joints that are closed, timed and read, and datasets of many."""

import time
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engine.quantities import QUANTITIES, ClosedWalls
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.joint.simulation import close_walls
from jointclosure.walls.pairs import CrushedWalls, Walls

Row = dict[str, Any]
"""Quantities of a joint by name; a failed joint has only those of effort."""


class Reading(NamedTuple):
    """Conditions of joints, names of the quantities that are read, and stresses of curves [Pa]."""

    conditions: Conditions
    names: tuple[str, ...]
    stresses: np.ndarray = np.empty(0)


def closed_walls(
    walls: Walls | CrushedWalls,
    conditions: Conditions,
    stresses: np.ndarray = np.empty(0),
    snapshots: Sequence[float] = (),
) -> ClosedWalls:
    """Close two walls (y, x) [m], and measure the processor time."""
    pair, pristine = walls if isinstance(walls, CrushedWalls) else (walls, None)
    start = time.process_time()
    closed = close_walls(*pair, conditions, snapshots=tuple(snapshots), pristine=pristine)
    return ClosedWalls(pair, closed, conditions, time.process_time() - start, stresses)


def close_joint(walls: Walls | CrushedWalls, reading: Reading) -> Row:
    """Close two walls (y, x) [m], and read quantities of the joint."""
    judged, conditions = "oracle_ratio" in reading.names, reading.conditions
    if judged and isinstance(walls, CrushedWalls):
        raise ValueError("oracle_ratio: not of walls that were crushed before")
    kept = (float(conditions.largest_stress),) if judged else ()
    return read_joint(closed_walls(walls, conditions, reading.stresses, kept), reading.names)


def read_joint(joint: ClosedWalls, names: Iterable[str]) -> Row:
    """Read quantities of a closed joint; of one that failed only those of effort."""
    failed = int(joint.closed.status) >= FAILURE
    read = {name: QUANTITIES[name] for name in names}
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

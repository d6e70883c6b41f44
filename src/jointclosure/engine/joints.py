"""Joints closed, timed and read: one, and all of a case."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engine.quantities import QUANTITIES, ClosedWalls, names_of_case
from jointclosure.engine.settings import ClosureSettings, CrushedWalls, Walls, seeds_of, walls_of
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.joint.simulation import close_walls

Row = dict[str, Any]
"""Quantities of a joint by name; a failed joint has only those of effort."""


class Reading(NamedTuple):
    """Conditions of joints, names of the quantities that are read, and stresses of curves [Pa]."""

    conditions: Conditions
    names: tuple[str, ...]
    stresses: np.ndarray = np.empty(0)


def reading_of_case(settings: ClosureSettings) -> Reading:
    """Return what is stored of the joints of a case."""
    stresses = np.linspace(0.0, settings.largest_stress, settings.stress_points)
    return Reading(settings.conditions(), names_of_case(settings.flow), stresses)


def close_joint(walls: Walls | CrushedWalls, reading: Reading) -> Row:
    """Close two walls (y, x) [m], and read quantities of the joint."""
    judged, start = "oracle_ratio" in reading.names, time.process_time()
    kept = (float(reading.conditions.largest_stress),) if judged else ()
    pair, pristine = walls if isinstance(walls, CrushedWalls) else (walls, None)
    if judged and pristine:
        raise ValueError("oracle_ratio: not of walls that were crushed before")
    closed = close_walls(*pair, reading.conditions, snapshots=kept, pristine=pristine)
    return read_joint(pair, closed, time.process_time() - start, reading)


def read_joint(walls: Walls, closed: xr.Dataset, seconds: float, reading: Reading) -> Row:
    """Read quantities of a closed joint; of one that failed only those of effort."""
    joint = ClosedWalls(walls, closed, reading.conditions, seconds, reading.stresses)
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


def close_case(
    settings: ClosureSettings,
    walls: Iterable[Walls] | None = None,
    *,
    known: Mapping[str, Row] = {},
    report: Callable[[str], None] = lambda line: None,
    again: str = "",
) -> xr.Dataset:
    """Close the walls of a case's block, over (realization, cycle, branch, stress).

    Walls are made from their seeds unless given. ``known`` has the quantities of joints that were
    closed with these settings before, by seed (`rows_by_seed`). ``report`` receives a line for each
    realisation, in which ``again`` is the command that repeats a failed one, without its number. A
    failed realisation has a status of 16 or more, counts, and otherwise NaN.
    """
    reading, first = reading_of_case(settings), settings.surfaces.first_realization
    pairs = walls_of(settings.surfaces) if walls is None else walls
    seeds = [f"{seed:032x}" for seed in seeds_of(settings.surfaces)]
    rows: list[Row] = []
    for realization, (seed, pair) in enumerate(zip(seeds, pairs, strict=True), start=first):
        repeat = f"; to repeat it: {again} {realization}" if again else ""
        try:
            row = known.get(seed) or close_joint(pair, reading)
        except Exception as error:
            error.add_note(f"realisation {realization}{repeat}")
            raise
        report(f"realisation {realization}: {_described(row, repeat)}")
        rows.append(row)
    numbers = np.arange(first, first + len(rows))
    return stacked(rows, numbers, np.array(seeds, dtype=object), reading)


def rows_by_seed(closed: xr.Dataset) -> dict[str, Row]:
    """Return the quantities of joints of `close_case` by the seeds of their walls."""
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

"""Simulation of the joints at points of a study: of its cases, its pool and its experiments."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from jointclosure.ensembles.quantities import QUANTITIES
from jointclosure.ensembles.simulation import Reading, Row, simulate_row, stack_rows
from jointclosure.joint.status import FAILURE
from jointclosure.parameters import Effects, scene_name
from jointclosure.walls import CrushedWalls, Walls
from studies.frame.settings import ClosureSettings, Point, seeds_of

Report = Callable[[str], None]
ALWAYS = ("status", "timing_simulation")
"""Quantities that are read of every joint."""


def reading_of(settings: ClosureSettings, names: Iterable[str]) -> Reading:
    """Return what is read of the joints of a point: the quantities ``names`` and `ALWAYS`.

    Curves are read at the common stresses [Pa] of the study. If no quantity is a curve, there are
    no stresses.
    """
    names = tuple(dict.fromkeys((*ALWAYS, *names)))
    curves = any("stress" in QUANTITIES[name].dims for name in names)
    stresses = np.linspace(0.0, settings.largest_stress, settings.stress_points)
    return Reading(settings.conditions, names, stresses if curves else stresses[:0])


def close_joints(
    point: Point,
    walls: Iterable[Walls | CrushedWalls],
    names: Iterable[str],
    *,
    report: Report = lambda line: None,
    closed: Mapping[str, Row] = {},
    repeat: str = "",
    ends: Callable[[Row], bool] = lambda row: False,
) -> xr.Dataset:
    """Simulate the joints of a point, one for each pair of walls, and read their quantities.

    Parameters
    ----------
    point : Point
    walls : iterable of (upper, lower) or CrushedWalls
        Heights (y, x) [m] of each realisation, towards the other wall.
    names : iterable of str
        Quantities to read, of `QUANTITIES`.
    report : callable
        Called with a line for each joint.
    closed : mapping
        Rows of joints already simulated under these conditions, by the seed of their walls (32
        hexadecimal digits).
    repeat : str
        Command that repeats a realisation, without its number; for the log.
    ends : callable
        Called with the row of each joint; no further joint is simulated after one for which it
        returns True.

    Returns
    -------
    Dataset
        Quantities [SI] over ``joint``, with ``realization``, the coordinates of the point and
        ``seed``. A failed joint has a status of 16 (`FAILURE`) or more, and NaN.
    """
    rows = list[Row]()
    first = point.settings.first_realization
    seeds = [f"{seed:032x}" for seed in seeds_of(point.settings)]
    reading = reading_of(point.settings, names)
    for seed, pair in zip(seeds, walls, strict=True):
        number = first + len(rows)
        again = f"; to repeat it: {repeat} {number}" if repeat else ""
        try:
            row = closed[seed] if seed in closed else simulate_row(pair, reading)
        except Exception as error:
            error.add_note(f"realisation {number}{again}")
            raise
        report(f"realisation {number}: {_described(row, again)}")
        rows.append(row)
        if ends(row):
            break
    return joined_rows(rows, point, reading)


def close_points(
    points: Iterable[Point],
    names: Sequence[str],
    report: Report = lambda line: None,
    walls: Sequence[Walls] | None = None,
    ends: Callable[[Point, Row], bool] = lambda point, row: False,
) -> xr.Dataset:
    """Simulate the joints of several points; return them along ``joint``, as `close_joints`.

    Each point makes its own walls; if ``walls`` are given, every point has these. ``report`` is
    called with a line for each point and each joint. The joints of a point end after one for which
    ``ends`` is true of the point and the row of the joint.
    """
    parts = []
    for point in points:
        report(", ".join(f"{name} {value}" for name, value in point.coordinates.items()))
        of_point = walls or point.walls()
        here = partial(ends, point)
        parts.append(close_joints(point, of_point, names, report=report, ends=here))
    # joints with fewer load cycles than others in their file have NaN in the later cycles
    return xr.concat(
        parts,
        "joint",
        coords="minimal",
        compat="override",
        join="outer",
        combine_attrs="override",
    )


def joined_rows(rows: Sequence[Row], point: Point, reading: Reading) -> xr.Dataset:
    """Return the rows of joints as a dataset along ``joint``, with the coordinates of their point.

    The rows are those of the first realisations of the point, in order.
    """
    numbers = point.settings.first_realization + np.arange(len(rows))
    seeds = np.array([f"{seed:032x}" for seed in seeds_of(point.settings)][: len(rows)], object)
    joints = stack_rows(rows, numbers, seeds, reading)
    if not reading.stresses.size:  # no curves
        joints = joints.drop_vars(["branch", "stress"])
    at = {name: _column(value, len(rows)) for name, value in point.coordinates.items()}
    # points of one file may differ in their number of cycles
    at["cycles"] = _column(reading.conditions.cycle_count, len(rows))
    joints = joints.rename_dims(realization="joint").reset_index("realization")
    joints = joints.assign_coords({name: ("joint", values) for name, values in at.items()})
    return joints.assign_attrs(scene=scene_name(reading.conditions.effects))


def _column(value: Any, count: int) -> np.ndarray:
    """Return an array (count,) that repeats a value; an array of texts has the type object."""
    return np.full(count, value, dtype=object if isinstance(value, str) else None)


def _described(row: Row, again: str) -> str:
    """Return words on a joint: its status and time, and its closures.

    For a joint that failed the words ``again`` on how to repeat it replace the closures.
    """
    about = f"status {int(row['status'])}, {row['timing_simulation']:.2f} s"
    if row["status"] >= FAILURE:
        return f"{about}, failed{again}"
    if "max_closure" not in row:
        return about
    closures = ", ".join(f"{1e3 * value:.5f}" for value in np.ravel(row["max_closure"]))
    return f"{about}, maximum closure {closures} mm"


def under_chosen(point: Point, pilot: xr.Dataset) -> tuple[Point, dict[str, Row]]:
    """Return a point with the effects that were chosen for its rock, and joints already simulated.

    ``pilot`` is the dataset of `choose_rock_effects`, whose joints all belong to one case. If the
    point belongs to this case too, these joints are returned as rows by seed (32 hexadecimal
    digits), else none.
    """
    effects = Effects(**json.loads(pilot.attrs["chosen"])["effects"])
    settings = point.settings.under(effects=effects)
    if pilot.attrs["case"] != settings.case.label:
        return point._replace(settings=settings), {}
    joints = (pilot.isel(joint=place) for place in range(pilot.sizes["joint"]))
    rows = {
        str(joint.seed.item()): {str(name): values.values for name, values in joint.items()}
        for joint in joints
    }
    return point._replace(settings=settings), rows

"""Joints that are simulated before a study, to choose a rock's effects and to estimate times."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import pandas as pd
import xarray as xr

from jointclosure.assessment.effect_selection import MOST_PAIRS, Pilot, choose_among
from jointclosure.ensembles.simulation import read_joint
from jointclosure.execution.progress import duration
from jointclosure.statistics.number_texts import percent, rounded
from jointclosure.walls import Walls
from studies.frame.settings import BASE, Point, joints_of
from studies.frame.simulation import Report, close_points, joined_rows, reading_of

TRIED = 3
"""Largest number of points of a group at which a joint is simulated to estimate times."""


class Choice(NamedTuple):
    """Point on whose joints the effects of a rock are chosen, and for how many joints they hold."""

    point: Point
    cases: int  # number of cases of the rock
    joints: int  # number of joints of all these cases


def examined(points: Mapping[str, Point]) -> Choice:
    """Return the point on whose joints the effects of a rock are chosen.

    ``points`` are those of all cases of the rock, by label. The point of the case with the largest
    ratio of maximum stress to compressive strength is taken, as effects matter most there. Of
    several such cases the base case is preferred.
    """

    def order(label: str) -> tuple[float, bool]:
        case = points[label].settings.case
        ratio = case.max_normal_stress / case.number("compressive_strength")
        return (-round(ratio, 12), case.parameter != BASE)

    return Choice(points[min(points, key=order)], len(points), joints_of(points.values()))


def choose_rock_effects(
    choice: Choice,
    walls: Iterable[Walls],
    names: Iterable[str],
    report: Report = lambda line: None,
) -> xr.Dataset:
    """Simulate joints to choose the effects that a rock needs, and return those with these effects.

    Effects are chosen to the tolerance of the settings, on at most `MOST_PAIRS` of the ``walls``.
    The joints are returned as by `close_joints`, with the quantities ``names``. Attributes are the
    label of the ``case``, and ``chosen``: effects, error and reasons as JSON. ``report`` is called
    with lines on the choice.
    """
    point, cases, joints = choice
    settings = choice.point.settings
    label = settings.case.label
    report(f"{label}, for {cases} cases of {joints} joints together:")
    pilot = Pilot(list(islice(walls, MOST_PAIRS)), settings.conditions, joints)
    selected = choose_among(pilot, settings.effects_chosen_to or 0.0, report)
    reading = reading_of(settings.under(effects=selected.effects), names)
    stored = (replace(one, stresses=reading.stresses) for one in selected.closed)
    rows = [read_joint(one, reading.names) for one in stored]
    about = {"effects": selected.effects._asdict(), "error": selected.error}
    details = {"reasons": selected.reasons, "changes": selected.changes.to_dict("records")}
    chosen = about | {"cases": {label: about | details}}
    under = point._replace(settings=settings.under(effects=selected.effects))
    return joined_rows(rows, under, reading).assign_attrs(case=label, chosen=json.dumps(chosen))


def tried(points: Iterable[Point]) -> list[tuple[list[Point], int]]:
    """Return points at which joints are tried, by groups of the same rock, grid, effects, numerics.

    Of each group at most `TRIED` points are returned, with the number of joints of all points of
    the group. Points with different names of ``options`` are in different groups.
    """
    alike: dict[tuple, list[Point]] = {}
    for point in points:
        settings = point.settings
        model = point.settings.conditions
        kind = settings.case.rock, model.effects, model.numerics, settings.grid, *point.options
        alike.setdefault(kind, []).append(point)
    return [(group[:: -(-len(group) // TRIED)], joints_of(group)) for group in alike.values()]


def estimate_time(
    groups: Iterable[tuple[Sequence[Point], int]],
    report: Report,
    scanned: Mapping[str, Sequence[Walls]] = {},
) -> pd.DataFrame:
    """Simulate one joint of each point of `tried` groups, to estimate the time of all joints.

    ``scanned`` has one pair of walls of each rock whose walls were scanned. The table has a row for
    each group: ``rock``, ``cells``, ``joints``, ``tried`` (number of joints that were timed),
    ``seconds`` (processor time [s] of all joints) and its standard ``error`` (NaN for one timed
    joint).
    """
    rows = []
    loaded = set()
    for points, joints in groups:
        first = [one._replace(settings=one.settings._replace(realizations=1)) for one in points]
        rock = points[0].settings.case.rock
        walls = scanned.get(rock)
        model = points[0].settings.conditions.model
        if model not in loaded:  # its kernels are loaded before a joint is timed
            close_points(first[:1], (), walls=walls)
            loaded.add(model)
        times = close_points(first, (), walls=walls).timing_simulation.to_series()
        grid = points[0].settings.grid
        row = {"rock": rock, "cells": grid.cells_x * grid.cells_y, "joints": joints}
        row |= {"tried": len(times), "seconds": joints * times.mean()}
        rows.append(row | {"error": joints * times.sem()})
        report(f"{rock}, {row['cells']} cells: about {rows[-1]['seconds']:.0f} s")
    return pd.DataFrame(rows)


def described_time(estimate: pd.DataFrame, notes: Sequence[str] = (), assessed: float = 0.0) -> str:
    """Return a sentence on a table of `estimate_time`, and ``notes`` on what it leaves out.

    ``assessed`` is the expected time of the assessment of the report over that of all joints.
    """
    seconds = float(estimate.seconds.sum())
    if assessed > 0.0:
        notes = [*notes, _of_assessment(seconds, assessed)]
    unit, size = ("minutes", 60.0) if seconds >= 60.0 else ("seconds", 1.0)
    value = seconds / size
    error = math.hypot(*estimate.error) / size
    known = rounded(value, error) if error > 0.0 else f"{value:.2g}"
    words = f"± standard error, from {estimate.tried.sum()} joints"
    return "; ".join([
        f"{estimate.joints.sum()} joints will take about {known} {unit} of processor time on this "
        f"machine ({words if error > 0.0 else 'from one joint of each kind'})",
        *notes,
    ])  # fmt: skip


def _of_assessment(seconds: float, share: float) -> str:
    """Say how long the assessment of a report takes: a share of the time [s] of all joints."""
    again = "about as long again" if 0.75 <= share < 1.5 else f"about {share:.1f} times as long"
    words = f"about {percent(share)} of this time" if share < 0.75 else again
    return f"the assessment of make report takes {words}, {duration(share * seconds)}"

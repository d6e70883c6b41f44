"""Joints that are simulated before a study: to choose a rock's effects, and to estimate times."""

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
"""Largest number of points of a group of which a joint is simulated to estimate its time."""


class Choice(NamedTuple):
    """Point on which the effects of a rock are chosen, and numbers of its cases and joints."""

    point: Point
    cases: int
    joints: int


def examined(points: Mapping[str, Point]) -> Choice:
    """Return the point on which the effects of a rock are chosen.

    ``points`` are those of all cases of the rock, by label. The case with the largest maximum
    stress over compressive strength is taken, as effects matter most there; the base case if it is
    among several.
    """

    def order(label: str) -> tuple[float, bool]:
        case = points[label].settings.case  # of the largest stress over the strength
        ratio = case.max_normal_stress / case.number("compressive_strength")
        return (-round(ratio, 12), case.parameter != BASE)

    return Choice(points[min(points, key=order)], len(points), joints_of(points.values()))


def choose_rock_effects(
    choice: Choice,
    walls: Iterable[Walls],
    names: Iterable[str],
    report: Report = lambda line: None,
) -> xr.Dataset:
    """Select the effects that a rock needs, to the tolerance of the configuration.

    The joints that were simulated with these effects are returned as by `close_joints`, with the
    quantities ``names``. Attributes are the label of the ``case``, and ``chosen``: effects, error
    and reasons as JSON.
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
    """Group points by rock, grid, effects and numerics.

    Of each group at most `TRIED` points are returned, with the number of joints of all its points.
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
    """Estimate the processor time [s] of groups of points (`tried`) from one joint of each point.

    ``scanned`` has one pair of walls of each rock whose walls were scanned. A row per group:
    ``rock``, ``cells``, ``joints``, ``tried`` (joints that were timed), ``seconds`` of all joints
    and their standard ``error``.
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
    """Describe a table of `estimate_time` in a sentence, with ``notes`` on what it leaves out.

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

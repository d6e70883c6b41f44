"""Requests of accuracy at random conditions, judged by surfaces that no request saw.

The conditions are those of `effects_auto.py`. Each request for mean closures is run as `make study`
runs it, from the paper's steps and the finest numerics, until it is met or `MOST` surfaces are
closed. The truth are other surfaces, ``--surfaces`` by the finest numerics and `CHEAPER` times as
many by the paper's steps; it has an interval too. The cheapest way that is known afterwards takes
the least time of three: joints by the paper's steps alone, whose bias counts, by the finest
numerics alone, and by both, with the bias and the deviations of all surfaces of a condition.

`python benchmarks/accuracy_requests.py` goes on with the conditions that its folder has.
"""

import itertools
import math

import numpy as np
import pandas as pd
import xarray as xr
from effects_auto import SPACING, continued, options, scene, write_summary

import jointclosure as jc
from jointclosure.assessment.assessed_results import JUDGED
from jointclosure.assessment.numerical_settings import FINEST
from jointclosure.ensembles.simulation import Reading, Row, simulate_row, stack_rows
from jointclosure.statistics.randomness import seed_of
from studies.frame.keys import Accuracy
from studies.paper.accuracy import START, Counts, next_counts, reached_table

WITHIN, MOST = (0.02, 0.05, 0.1, 0.2), 100
NUMERICS = jc.Numerics(), FINEST
CHEAPER = 5
"""Surfaces of the truth that are simulated by the paper's steps, over those by the finest."""
NORMAL = 1.96
"""Half of a 95 % interval over the standard error, if the standard deviation is known."""


class Joints:
    """Joints of a condition, each simulated at most once by the paper's steps and by the finest."""

    def __init__(self, asked, number: int, kind: str):
        conditions, self.walls = scene(asked.seed, number, asked.cells)
        self.named = asked.seed, kind, number
        names = (*JUDGED, "status", "timing_simulation")
        self.readings = [Reading(conditions._replace(numerics=of), names) for of in NUMERICS]
        self.rows: tuple[list[Row], list[Row]] = [], []

    def closed(self, counts: Counts) -> list[xr.Dataset]:
        """Return datasets, as of a study with one case, of the first joints by both numerics."""
        levels = []
        for rows, reading, count in zip(self.rows, self.readings, counts, strict=True):
            for surface in range(len(rows), count):
                seed = seed_of(*self.named, surface)
                pair = jc.wall_pair(spacing=SPACING, seed=seed, **self.walls)
                rows.append(simulate_row(pair, reading))
            numbers = np.arange(count)
            case = stack_rows(rows[:count], numbers, numbers, reading).expand_dims("case")
            about = {key: ("case", ["base"]) for key in ("rock", "parameter", "level")}
            levels.append(case.assign_coords(about))
        return levels


def cheapest_seconds(within: float, seconds: list[float], known: list[np.ndarray]) -> float:
    """Return the shortest time [s] in which a request for all means is met; infinite if none.

    ``seconds`` are those of a joint by both numerics. ``known`` has four arrays over the means, all
    relative to them: the bias of the paper's steps, and the standard deviations of joints by the
    paper's steps, of differences, and of joints by the finest numerics.
    """
    bias, cheap, difference, fine = known
    squares = (within / NORMAL) ** 2
    room = np.maximum(within - np.abs(bias), 0.0) / NORMAL
    with np.errstate(divide="ignore"):
        counts = [np.max((cheap / room) ** 2), np.max(fine**2 / squares)]
        ways = list(zip(counts, seconds, strict=True))
        times = [max(2, math.ceil(n)) * cost for n, cost in ways if n <= MOST]
        for k in range(2, MOST + 1):
            left = squares - difference**2 / k
            joints = np.max(cheap**2 / left)
            if (left > 0.0).all() and joints <= MOST:
                times.append(max(k, math.ceil(joints)) * seconds[0] + k * seconds[1])
    return min(times, default=math.inf)


def known_afterwards(parts: list[list[xr.Dataset]]) -> tuple[list[float], list[np.ndarray]]:
    """Return the arguments ``seconds`` and ``known`` of `cheapest_seconds`.

    ``parts`` are groups of joints by both numerics; the first surfaces of a group have both.
    """
    groups = [xr.concat(level, "realization") for level in zip(*parts, strict=True)]
    seconds = [float(group.timing_simulation.mean()) for group in groups]
    known = []
    for name, cycle in itertools.product(JUDGED, (1, 2)):
        cheap, fine = (group[name].sel(cycle=cycle).values[0] for group in groups)
        pairs = ([level[name].sel(cycle=cycle).values[0] for level in part] for part in parts)
        apart = np.concatenate([of_fine - of_cheap[: of_fine.size] for of_cheap, of_fine in pairs])
        spreads = [np.nanstd(values, ddof=1) for values in (cheap, apart, fine)]
        known.append(np.array([np.nanmean(apart), *spreads]) / np.nanmean(fine))
    return seconds, [*np.transpose(known)]


def judged(number: int, asked) -> tuple[list[dict]]:
    """Run all requests at a condition; return a row for each request, closure and cycle."""
    own, truth = (Joints(asked, number, kind) for kind in ("walls", "truth"))
    whole = truth.closed(Counts(CHEAPER * asked.surfaces, asked.surfaces))
    true = reached_table(*whole, Accuracy(within=WITHIN[0]), 0.05)
    tables = []
    for within in WITHIN:
        accuracy = Accuracy(within=within, most=MOST)
        counts = START
        while counts:
            levels = own.closed(counts)
            table = reached_table(*levels, accuracy, 0.05)
            counts = next_counts(table, accuracy, counts)
        spent = sum(float(level.timing_simulation.sum()) for level in levels)
        tables.append(table.assign(scene=number, answered=table.met.all(), spent=spent))
    seconds, known = known_afterwards([own.closed(Counts(*map(len, own.rows))), whole])
    for table, within in zip(tables, WITHIN, strict=True):
        table["cheapest"] = cheapest_seconds(within, seconds, known)
        table["truth"] = true.value
        table["truth_error"] = (true.high - true.low) / 2 / NORMAL
    return (pd.concat(tables).to_dict("records"),)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Summarise the results of `judged` by request."""
    apart = (table.value - table.truth).abs() / table.truth
    room = table.truth_error / table.truth
    table = table.assign(apart=apart, room=room)
    half = 0.5 * (table.high - table.low) / table.truth
    table["covered"] = apart <= np.hypot(half, NORMAL * room)
    rows = []
    for within, part in table.groupby("within_percent"):
        met = part[part.answered]
        runs = part.drop_duplicates("scene")
        answered = runs[runs.answered]
        row = {
            "within_percent": within,
            "scenes": len(runs),
            "answered": len(answered),
            "none_exists": int((~np.isfinite(runs.cheapest)).sum()),
            "refused_wrongly": int((~runs.answered & np.isfinite(runs.cheapest)).sum()),
            "means": len(met),
            "within": int((100.0 * met.apart <= within).sum()),
            "beyond_by_two_errors": int((100.0 * (met.apart - 2.0 * met.room) > within).sum()),
            "truth_error_percent": 100.0 * met.room.median(),
            "covered": int(part.covered.sum()),
            "of": len(part),
            "time_ratio": (answered.spent / answered.cheapest).median(),
            "seconds": answered.spent.median(),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def main() -> None:
    """Run the requests that are missing, and write the tables."""
    asked = options(__doc__, "accuracy_requests", 40)
    (requests,) = continued(asked, judged, ["requests"])
    write_summary(summary(requests), asked)


if __name__ == "__main__":
    main()

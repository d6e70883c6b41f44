"""A joint of which not all is known: its variants are simulated, and give the ranges of results."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.execution.workers import in_threads, number_of_workers
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.cycle_results import largest_jump
from jointclosure.joint.history import history_of
from jointclosure.joint.protocol import Report
from jointclosure.joint.rocks import both_walls
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.status import FAILURE
from jointclosure.joint.tables import stress_table
from jointclosure.parameters import acting
from jointclosure.uncertainty.budget import Budget
from jointclosure.uncertainty.numerical_error import limits_of_error, numerical_errors_of
from jointclosure.uncertainty.ranges import bands_of, ranges_of
from jointclosure.uncertainty.results import QUANTITIES, results_of
from jointclosure.uncertainty.sources import MULTIPLE, SHARED, TITLES, Source, sources_of
from jointclosure.uncertainty.variants import (
    DRAWS,
    SEED,
    Variant,
    random_shares,
    value_text,
    variants_of,
)
from jointclosure.walls.scan_errors import ScanErrors

FURTHER = 10_000  # further joints with random values whose results are estimated for the range
CELLS = 2_000_000  # of all joints that are simulated at the same time; each cell takes 1 kB


class UncertainJoint(NamedTuple):
    """A joint and what is not known of it, made once by `uncertain_joint`.

    ``upper`` and ``lower`` are its walls (y, x) [m], ``conditions`` as `Conditions.checked` returns
    them with the grid spacing, ``errors`` those of scanned walls. ``sources`` of uncertainty, by
    name, make the ``variants`` of the joint; a joint without a range has none.
    """

    upper: np.ndarray
    lower: np.ndarray
    conditions: Conditions
    errors: ScanErrors | None = None
    sources: Mapping[str, Source] = {}
    variants: tuple[Variant, ...] = ()

    @property
    def cells(self) -> int:
        """Number of cells of its largest variant."""
        return max(self.upper.size, self.errors.cells if self.errors else 0)

    def simulated(self, variant: Variant, report: Report | None = None) -> xr.Dataset | None:
        """Simulate a variant; None if it is refused, such as for more steps than allowed."""
        with suppress(InputError):
            walls = variant.walls(self.upper, self.lower, self.errors)
            return simulate_walls(*walls, variant.conditions, report)
        return None


def uncertain_joint(
    upper: np.ndarray,
    lower: np.ndarray,
    conditions: Conditions,
    ranges: Mapping[str, tuple[float, float]] = {},
    errors: ScanErrors | None = None,
) -> UncertainJoint:
    """Return a joint with its sources of uncertainty and variants; arguments as for its fields.

    ``ranges`` are stated ones of `jointclosure.uncertainty.sources.VARIED`; `InputError` if one is
    not allowed.
    """
    sources = sources_of(conditions, upper.shape, ranges, errors)
    variants = tuple(variants_of(conditions, sources))
    return UncertainJoint(upper, lower, conditions, errors, sources, variants)


def uncertainty_budget(
    joint: UncertainJoint,
    closed: xr.Dataset | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
    workers: int | None = None,
    at: Sequence[float] = (),
) -> Budget:
    """Return the uncertainty budget of a joint.

    The joint is simulated with each source changed alone, and with all at random. ``closed`` is the
    history of the joint itself, if it is simulated already. ``report`` receives the finished share
    and the name of the variant. ``at`` are stresses [Pa] that curves have besides round ones.
    """
    sources = joint.sources
    variants = [Variant("", "", joint.conditions), *joint.variants]
    closed = (
        simulate_walls(joint.upper, joint.lower, joint.conditions) if closed is None else closed
    )
    levels = history_of(closed).table_levels(at)
    known = stress_table(closed, levels)

    def tables_of(variant: Variant, going_on: Report) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Return the rows of a variant, and its curves; values are unknown if it failed."""
        history = joint.simulated(variant, going_on) if variant.source else closed
        status = -1 if history is None else int(history.status)
        if history is None or status >= FAILURE:
            rows = pd.DataFrame({"cycle": known.cycle.unique()})
            rows = rows.assign(**dict.fromkeys(QUANTITIES, np.nan))
            curves = known[["cycle", "branch", "normal_stress_MPa"]]
        else:
            curves = known if history is closed else stress_table(history, levels)
            rows = results_of(history)
        about = {"source": variant.source, "value": variant.value, "status": status}
        return rows.assign(**about), curves.assign(source=variant.source)

    answers = {}
    threads = threads_for(joint.cells, workers)
    for number, answer in in_threads(tables_of, variants, threads):
        answers[number], name = answer, variants[number].source
        report(len(answers) / len(variants), TITLES.get(name, name or "joint"))
    rows, curves = zip(*(answers[number] for number in range(len(variants))), strict=True)
    results = pd.concat(rows, ignore_index=True)
    exact = "registration", *acting(both_walls(joint.conditions.rock)[0])
    omitted = tuple(name for name in exact if name not in sources)
    shares, further = (random_shares(sources, *drawn) for drawn in ((DRAWS, SEED), (FURTHER, 1)))
    shares[:, [source.kind == SHARED for source in sources.values()]] = 0.5  # no change
    numerical = numerical_errors_of(results, largest_jump(closed))
    limits = limits_of_error(numerical)
    ranges = ranges_of(results, sources, shares, further, limits)
    bands = bands_of(pd.concat(curves), sources, shares, further, limits, ranges)
    return Budget(results, ranges, omitted, bands, _choices(sources), numerical)


def _choices(sources: Mapping[str, Source]) -> tuple[str, ...]:
    """Describe the choices of the model that are not varied in the range, and their values."""
    lines = []
    for name, source in sources.items():
        if source.varied or source.kind == SHARED:
            continue
        if source.kind == MULTIPLE:
            lines.append(f"half or twice the {TITLES[name]}")
        else:
            low, high = (value_text(name, value) for value in source.values)
            between = "to" if source.kind == "range" else "or"
            lines.append(f"{TITLES[name]} {low} {between} {high}")
    return tuple(lines)


def threads_for(cells: int, workers: int | None = None) -> int:
    """Return the number of joints of so many cells that are simulated at the same time."""
    return max(1, min(number_of_workers(workers), CELLS // cells))

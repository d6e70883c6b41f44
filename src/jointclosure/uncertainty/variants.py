"""Simulations of a joint with other values of what is not known of it, or chosen by the model.

Each source of uncertainty is varied alone. Then those that the range is due to are varied together:
16 joints have random values, drawn as a Latin hypercube (McKay, Beckman & Conover 1979). Choices of
the model without a stated range keep their usual values in these. Random numbers of a source do not
depend on the other sources. With resolved breakage all variants have twice the tolerance, which
halves their time and hardly changes the effect of a source.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.execution.workers import in_threads, number_of_workers
from jointclosure.inputs import InputError, check_number, naming
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.cycles import largest_jump
from jointclosure.joint.history import history_of
from jointclosure.joint.protocol import Report
from jointclosure.joint.rocks import both_walls
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.status import FAILURE
from jointclosure.joint.tables import stress_table
from jointclosure.parameters import (
    OF_ROCK,
    PLAUSIBLE,
    Choices,
    Effects,
    Numerics,
    acting,
    key_of,
    without_effect,
)
from jointclosure.parameters.units import in_unit, name_and_unit
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.uncertainty.budget import Budget
from jointclosure.uncertainty.ranges import (
    bands_of,
    limits_of_error,
    numerical_errors_of,
    ranges_of,
)
from jointclosure.uncertainty.results import QUANTITIES, results_of
from jointclosure.uncertainty.sources import ALL, MULTIPLE, ORDER, SHARED, TITLES, Source
from jointclosure.walls import Walls
from jointclosure.walls.scan_errors import ScanErrors

COARSER = 2  # spacing of the coarser grid, over that of the joint
VARIED = {name: key_of(name) for name in OF_ROCK} | {
    "peak_modulus_ratio": "peak_modulus_ratio",
    "base_radius_in_cells": "base_radius_in_cells",
    "spacing": "spacing_mm",
}
"""Sources whose range can be stated, and their keys with units."""
DRAWS = 16  # joints that are simulated with random values of all sources
SEED = 3496
"""Seed of their random values: of 4,000 one with small correlations (at most 0.24 between the
sources that are always there, 0.35 with those of the rock; medians of all seeds 0.50, 0.56), so
that sources are not confounded."""
FURTHER = 10_000  # further joints with random values whose results are estimated for the range
FEWER = 10  # every so many of them are used for bands of curves
CELLS = 2_000_000  # of all joints that are simulated at the same time; each cell takes 1 kB
COPIES: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "as it is": lambda wall: wall,
    "last digits": lambda wall: wall * (1.0 + 1e-12),
    "mirrored": lambda wall: np.ascontiguousarray(wall[:, ::-1]),
    "transposed": lambda wall: np.ascontiguousarray(wall.T),
}
"""Copies of a wall whose results are equal but for rounding and the order of breakage."""
_FIELDS = {"spacing": "step", "registration": "place", ORDER: "copy"} | {
    name: name for name in ("noise", "resolution", "scale", "holes")
}
"""Fields of a variant by the names of the sources that change its walls."""


class Variant(NamedTuple):
    """A joint with other values of one source or of all.

    Its walls have every ``step``-th cell of the grid, random draws of errors of the scans by their
    number (``place``, ``noise``, ``resolution``, ``scale``, ``holes``; 0 for none), and are one of
    `COPIES`. A step below 1 is that of the finer grid of walls that the scans do not resolve.
    """

    source: str
    value: str
    conditions: Conditions
    step: float = 1
    place: int = 0
    noise: int = 0
    resolution: int = 0
    scale: int = 0
    holes: int = 0
    copy: str = "as it is"

    def walls(self, upper: np.ndarray, lower: np.ndarray, errors: ScanErrors | None) -> Walls:
        """Return the walls (y, x) [m] of the variant."""
        step = round(self.step)
        if errors and errors.walls:
            upper, lower = errors.walls
            step = round(self.step * errors.step)
        if errors and self.scale:
            upper, lower = errors.with_one_scale(upper, lower, self.scale)
        if errors and self.resolution:
            upper, lower = errors.with_lost_waves(upper, lower, self.resolution)
        if errors and self.noise:
            upper, lower = errors.with_other_noise(upper, lower, self.noise)
        if errors and self.place:
            upper = errors.displaced(upper, self.place)
        if errors and self.holes:
            upper, lower = errors.with_filled_holes(upper, lower, self.holes)
        upper, lower = (COPIES[self.copy](wall) for wall in (upper, lower))
        return upper[::step, ::step], lower[::step, ::step]

    def changed(self, name: str, value: Any) -> "Variant":
        """Return the variant with another value of a source."""
        conditions = self.conditions
        choices = self.conditions.choices
        if name in _FIELDS:
            changed = self._replace(**{_FIELDS[name]: value})
            spacing = value * conditions.grid_spacing if name == "spacing" else conditions.spacing
            return changed._replace(conditions=conditions._replace(spacing=spacing))
        if name == "breakage":
            return self._replace(conditions=conditions._replace(numerics=value))
        if name in PLAUSIBLE:
            choices = choices._replace(**{name: value})
            return self._replace(conditions=conditions._replace(choices=choices))
        rock = tuple(wall._replace(**{name: value}) for wall in both_walls(conditions.rock))
        return self._replace(conditions=conditions._replace(rock=rock))


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

    ``ranges`` are stated ones of `VARIED`; `InputError` if one is not allowed.
    """
    sources = sources_of(conditions, upper.shape, ranges, errors)
    variants = tuple(variants_of(conditions, sources))
    return UncertainJoint(upper, lower, conditions, errors, sources, variants)


def coarser(numerics: Numerics, factor: float) -> Numerics:
    """Return numerics with the tolerance and the steps that act multiplied by a factor."""
    steps = [name for name in Numerics._fields if "_step" in name and "most" not in name]
    scaled = {
        name: factor * getattr(numerics, name)
        for name in (*steps, "tolerance")
        if not without_effect(name, Effects(), Choices(), numerics)
    }
    return numerics._replace(**scaled)


def sources_of(
    conditions: Conditions,
    shape: tuple[int, ...],
    ranges: Mapping[str, tuple[float, float]] = {},
    errors: ScanErrors | None = None,
) -> dict[str, Source]:
    """Return the sources of uncertainty of a joint of (ny, nx) cells by name.

    ``ranges`` are stated ones of `VARIED`, ``errors`` those of scanned walls. Raise `InputError` if
    a range is not allowed.
    """
    _check_ranges(conditions, ranges)
    effects = conditions.effects
    numerics = conditions.numerics
    choices = conditions.choices
    sources = {}
    if "spacing" in ranges:
        sources["spacing"] = Source((1, round(ranges["spacing"][1] / conditions.grid_spacing)))
    elif errors and errors.step > 1:
        sources["spacing"] = Source((1, 1 / errors.step))
    elif min(shape) >= 8 * COARSER:
        sources["spacing"] = Source((1, COARSER), MULTIPLE, False)
    if effects.breakage and numerics.solver == "fast" and numerics.target == "equilibrate":
        resolved = numerics.breakage == "resolved"
        if resolved and numerics.tolerance <= 0.05:  # it is at most 0.1
            sources["breakage"] = Source((numerics, coarser(numerics, 2.0)), SHARED)
        else:
            other = coarser(numerics, 0.5) if resolved else numerics._replace(breakage="resolved")
            sources["breakage"] = Source((numerics, other))
    if errors and errors.covariance.any():
        sources["registration"] = Source((0, 1, 2, 3), "random")
    if errors and errors.noise[1] > 0.0:
        sources["noise"] = Source((0, 1, 2), "random")
    if errors and max(errors.waves) > 0.0:
        sources["resolution"] = Source((0, 1, 2), "random")
    if errors and errors.scale != 1.0:
        sources["scale"] = Source((0, 1, 2), "random")
    if errors and errors.holes.any():
        sources["holes"] = Source((0, 1, 2), "random")
    if effects.breakage:
        sources[ORDER] = Source(("as it is", "last digits", "mirrored"), "random")
    for name, ends in PLAUSIBLE.items():
        values = tuple(ranges.get(name, ends))
        stated = name in ranges
        if without_effect(name, effects, choices, numerics):
            continue
        joint = getattr(choices, name)
        if isinstance(joint, str):
            others = (value for value in values if value != joint)
            sources[name] = Source((joint, *others), "choice", stated)
        else:
            sources[name] = _range_about(joint, values, stated)
    for name in OF_ROCK:
        if name in ranges:
            joint = getattr(both_walls(conditions.rock)[0], name)
            sources[name] = _range_about(joint, ranges[name], True)
    return sources


def _range_about(joint: float, ends: tuple[float, float], varied: bool) -> Source:
    """Return the source of a number that the joint has and that may be between two ends."""
    low = min(joint, ends[0])
    high = max(joint, ends[1])
    part = (
        math.log(joint / low) / math.log(high / low) if low > 0.0 else (joint - low) / (high - low)
    )
    return Source((low, high), "range", varied, part)


def variants_of(
    conditions: Conditions, sources: Mapping[str, Source], draws: int = DRAWS, seed: int = SEED
) -> Iterator[Variant]:
    """Generate the variants of a joint: each source changed alone, then all ``draws`` times."""
    joint = Variant("", "", conditions)
    for name, source in sources.items():
        if source.kind == SHARED:
            joint = joint.changed(name, source.values[1])
    for name, source in sources.items():
        for value in source.values[0 if source.kind == "range" else 1 :]:
            yield joint.changed(name, value)._replace(source=name, value=_text(name, value))
    fixed = {name for name, source in sources.items() if source.kind == SHARED or not source.varied}
    for number, row in enumerate(random_shares(sources, draws, seed)):
        drawn = joint._replace(source=ALL)
        texts = []
        if not sources.keys() - fixed - {ORDER}:  # only the order of breakage is left
            copy = list(COPIES)[1 + number % (len(COPIES) - 1)]
            drawn = drawn.changed(ORDER, copy)
            texts = [f"{TITLES[ORDER]} {copy}"]
        for share, (name, source) in zip(row, sources.items(), strict=True):
            if name == ORDER or name in fixed:  # another order, and the same steps, in all
                continue
            value = source.at(float(share))
            drawn = drawn.changed(name, value)
            texts.append(f"{TITLES[name]} {_text(name, value)}")
        yield drawn._replace(value="; ".join(texts))


def random_shares(names: Iterable[str], draws: int, seed: int) -> np.ndarray:
    """Draw a share of the range of each source (draws, sources) in [0, 1), as a Latin hypercube."""
    columns = []
    for name in names:
        random = generator(seed_of(seed, "range", name))
        columns.append((random.permutation(draws) + random.random(draws)) / draws)
    return np.stack(columns, axis=1)


def _text(name: str, value: Any) -> str:
    """Describe a value of a source."""
    if name == "spacing":
        if value < 1:
            return f"a spacing {1 / value:.0f} times as fine"
        return f"every {value}. cell" if value > 1 else "every cell"
    if name in ("registration", "noise", "resolution", "scale", "holes"):
        return f"draw {value}"
    if name == "breakage":
        resolved = value.breakage == "resolved"
        return f"tolerance {value.tolerance:.3g}" if resolved else "fixed steps"
    if name in OF_ROCK:
        return f"{value / OF_ROCK[name].size:.4g}{OF_ROCK[name].in_brackets}"
    return value if isinstance(value, str) else f"{value:.3g}"


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
    of_steps = sources.get("breakage")
    shared = of_steps is not None and of_steps.kind == SHARED
    numerical = numerical_errors_of(results, shared, largest_jump(closed))
    limits = limits_of_error(numerical)
    bands = bands_of(pd.concat(curves), sources, shares, further[::FEWER], limits)
    ranges = ranges_of(results, sources, shares, further, limits)
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
            low, high = (_text(name, value) for value in source.values)
            between = "to" if source.kind == "range" else "or"
            lines.append(f"{TITLES[name]} {low} {between} {high}")
    return tuple(lines)


def threads_for(cells: int, workers: int | None = None) -> int:
    """Return the number of joints of so many cells that are simulated at the same time."""
    return max(1, min(number_of_workers(workers), CELLS // cells))


def _check_ranges(conditions: Conditions, ranges: Mapping[str, tuple[float, float]]) -> None:
    first, second = both_walls(conditions.rock)
    for name, ends in ranges.items():
        if name not in VARIED:
            raise InputError(f"ranges: {name!r}: must be one of {', '.join(VARIED)}")
        if np.shape(ends) != (2,):
            raise InputError(f"ranges: {name} = {ends!r}: must be (lowest, highest)")
        for end in ends:
            check_number(f"ranges: {name}", end)
        if not ends[0] < ends[1]:
            raise InputError(f"ranges: {name} = {ends!r}: the lowest value must come first")
        if name in OF_ROCK and first != second:
            raise InputError(f"ranges: {name}: both walls must be of one rock")
        if name == "spacing":
            grid = conditions.grid_spacing
            if round(ends[1] / grid) < 2 or not np.isclose(ends[0], grid, rtol=1e-3):
                raise InputError(
                    f"ranges: spacing_mm = {1e3 * ends[0]:.4g} to {1e3 * ends[1]:.4g}: must begin "
                    f"at the spacing of the joint's grid, {1e3 * grid:.4g} mm, which is the "
                    "finest, and end at least at twice of it"
                )
            continue
        given = first if name in OF_ROCK else conditions.choices
        for end in ends:
            with naming("ranges"):
                type(given)(**given._asdict() | {name: end})
        if not ends[0] <= getattr(given, name) <= ends[1]:
            unit = name_and_unit(VARIED[name])[1]
            low, high, joint = (in_unit(each, unit) for each in (*ends, getattr(given, name)))
            raise InputError(
                f"ranges: {VARIED[name]} = {low:g} to {high:g}: must contain that of the joint, "
                f"{joint:g}"
            )

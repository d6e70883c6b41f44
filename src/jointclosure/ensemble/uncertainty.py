"""Range of a joint's closure over what the model leaves open: an uncertainty budget.

The range is that of 19 joints in which every source of uncertainty has a random value, drawn as a
Latin hypercube (McKay, Beckman & Conover 1979) and propagated through the model as in JCGM
101:2008. A further such joint lies within it with a probability of 18/20, whatever the distribution
(Wilks 1941). The share of a source is that of its squared changes if each source is varied alone,
to each end of its range. Changes of positive results are changes of logarithms, because the model's
open choices act as factors. ``benchmarks/range.py`` counts how many other draws lie in the range.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.config.measured_joints import measured_range
from jointclosure.engineering.curves import cycle_table, net_responses
from jointclosure.ensemble.closing import close_walls
from jointclosure.inputs import InputError, check_number
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import OF_ROCK, PLAUSIBLE, Choices, Numerics, both_walls, key_of
from jointclosure.statistics.randomness import generator

Walls = tuple[np.ndarray, np.ndarray]

QUANTITIES = {
    "closure_net_since_seating_mm": "net closure (mm)",
    "residual_net_at_seating_mm": "net residual closure (mm)",
    "closure_gross_since_seating_mm": "gross closure (mm)",
    "stiffness_net_MPa_per_mm": "net stiffness (MPa/mm)",
    "mean_aperture_at_max_mm": "mean aperture (mm)",
    "contact_at_max": "share of cells in contact",
}
"""Results with a range, by column: of `cycle_table`, and the net stiffness of
`jointclosure.engineering.curves.net_responses`."""

TITLES = {
    "spacing": "grid spacing",
    "breakage": "breakage rule",
    "alignment": "alignment",
    "peak_modulus_ratio": "peak modulus ratio",
    "base_radius_in_cells": "base radius",
    "peaks": "peaks while walls break",
} | {name: about.long_name for name, about in OF_ROCK.items()}
"""Sources of uncertainty by name."""

MEASURED = (
    "measured joints: {:.2g} to {:.2g} mm of closure on the first loading to 10 MPa; a later "
    "loading was {:.2g} to {:.2g} times as stiff, as the model's second cycle is, but {:.2g} to "
    "{:.2g} % of its closure stayed, of which the model has none unless the joint is reseated "
    "(docs/validation.md)"
).format(
    *measured_range("first_closure"),
    *measured_range("stiffness_ratio"),
    *measured_range("later_residual_share"),
)
"""What is known of the model from three measured granodiorite joints."""

COARSER = 2
"""Spacing of the coarser grid, over that of the joint."""
VARIED = {name: key_of(name) for name in OF_ROCK} | {
    "peak_modulus_ratio": "peak_modulus_ratio",
    "base_radius_in_cells": "base_radius_in_cells",
    "spacing": "spacing_mm",
}
"""Sources whose range can be stated, and their keys with units."""


DRAWS = 19
"""Number of joints in which all sources have random values; the range contains (DRAWS - 1)/(DRAWS +
1) of further ones."""
_UNMOVED = (0, 0)
_SHIFTS = (_UNMOVED, (0, 1), (0, -1), (1, 0), (-1, 0))
ALL = "all together"
"""Source of the variants in which all sources have random values."""


class Variant(NamedTuple):
    """A joint in which sources of uncertainty have other values.

    ``shift`` is that of the upper wall in cells (y, x); of the grid every ``step``-th cell is kept.
    """

    source: str
    value: str
    conditions: Conditions
    shift: tuple[int, int] = _UNMOVED
    step: int = 1

    def walls(self, upper: np.ndarray, lower: np.ndarray) -> Walls:
        """Return the walls (y, x) [m] of the variant."""
        upper, lower = shifted_walls(upper, lower, self.shift)
        return upper[:: self.step, :: self.step], lower[:: self.step, :: self.step]

    def changed(self, name: str, value: Any) -> "Variant":
        """Return the variant with another value of a source."""
        conditions, choices = self.conditions, self.conditions.choices
        if name == "alignment":
            return self._replace(shift=value)
        if name == "spacing":
            coarse = conditions._replace(spacing=value * conditions.grid_spacing)
            return self._replace(step=value, conditions=coarse)
        if name == "breakage":
            return self._replace(conditions=conditions._replace(numerics=value))
        if name in PLAUSIBLE:
            choices = choices._replace(**{name: value})
            return self._replace(conditions=conditions._replace(choices=choices))
        rock = tuple(wall._replace(**{name: value}) for wall in both_walls(conditions.rock))
        return self._replace(conditions=conditions._replace(rock=rock))


def shifted_walls(upper: np.ndarray, lower: np.ndarray, shift: tuple[int, int]) -> Walls:
    """Return walls (y, x) with the upper one shifted by cells, where they still overlap."""
    for axis, cells in enumerate(shift):
        kept = np.arange(upper.shape[axis] - abs(cells))
        upper = upper.take(kept + max(cells, 0), axis)
        lower = lower.take(kept + max(-cells, 0), axis)
    return upper, lower


class Source(NamedTuple):
    """A source of uncertainty: its ends, or its alternatives (the value of the joint first)."""

    values: tuple
    continuous: bool = False

    def at(self, share: float) -> Any:
        """Return the value at a share, in [0, 1), of its range or of its alternatives."""
        if not self.continuous:
            return self.values[int(share * len(self.values))]
        low, high = self.values
        return low * (high / low) ** share if low > 0.0 else low + share * (high - low)


class Budget(NamedTuple):
    """Uncertainty budget of a closed joint.

    Attributes
    ----------
    results : DataFrame
        One row per variant and cycle: ``source``, ``value``, ``status``, ``cycle`` and `QUANTITIES`
        (NaN if the variant could not be closed). The source of the joint itself is "", that of
        joints in which all sources have random values is `ALL`.
    ranges : DataFrame
        Over (cycle, quantity): ``best``; ``low`` and ``high``, those of the joints with random
        values, between which 9 in 10 of further ones lie; and the share of each source, which
        sum to 1.
    omitted : tuple of str
        Sources that were not varied because no range of them is stated.
    """

    results: pd.DataFrame
    ranges: pd.DataFrame
    omitted: tuple[str, ...]

    def sentences(self) -> list[str]:
        """Describe what the range is due to, what it leaves out, and what is known of the model."""
        closure = next(iter(QUANTITIES))
        cycles = self.ranges.index.unique("cycle")
        lines = [
            f"{QUANTITIES[closure]}, cycle {cycle}: the range is due to "
            f"{self.largest_shares(cycle, closure)}"
            for cycle in (cycles if len(cycles) < 3 else cycles[[0, -1]])
        ]
        failed = self.results.loc[self.results[closure].isna(), ["source", "value"]]
        for source, rows in failed.drop_duplicates().groupby("source"):
            count = f"{len(rows)} of {DRAWS} joints" if source == ALL else TITLES[source]
            lines.append(f"not closed, and not in the range: {count} ({rows.value.iloc[0]})")
        if self.omitted:
            names = ", ".join(TITLES[name] for name in self.omitted)
            lines.append(
                f"taken as exact: {names} (--range {key_of(self.omitted[-1])} LOW HIGH, or "
                "ranges= in Python, adds what is known of them)"
            )
        return [*lines, MEASURED]

    def record(self) -> list[dict]:
        """Return `ranges` for JSON, one entry per cycle and quantity."""
        rows = self.ranges.astype(object).where(self.ranges.notna(), None)
        return [
            {"cycle": cycle, "quantity": quantity, "text": self.text(cycle, quantity)}
            | row[["best", "low", "high"]].to_dict()
            | {"shares": row.drop(["best", "low", "high"]).to_dict()}
            for (cycle, quantity), row in rows.iterrows()
        ]

    def table(self) -> pd.DataFrame:
        """Return the results as text, quantities over cycles."""
        cycles = self.ranges.index.unique("cycle")
        return pd.DataFrame(
            {f"cycle {cycle}": [self.text(cycle, name) for name in QUANTITIES] for cycle in cycles},
            index=list(QUANTITIES.values()),
        )

    def text(self, cycle: int, quantity: str) -> str:
        """Format a result with two digits, as in "0.18 (0.13 to 0.24)"."""
        row = self.ranges.loc[cycle, quantity]
        best, low, high = (_two_digits(float(row[name])) for name in ("best", "low", "high"))
        return f"{best} ({low} to {high})"

    def largest_shares(self, cycle: int, quantity: str, count: int = 3) -> str:
        """Name the sources with the largest shares in a range, as in "alignment 60 %"."""
        shares = self.ranges.loc[cycle, quantity].drop(["best", "low", "high"]).dropna()
        largest = shares.astype(float).sort_values(ascending=False).head(count)
        return ", ".join(f"{TITLES[name]} {100.0 * share:.0f} %" for name, share in largest.items())


def sources_of(
    conditions: Conditions, shape: tuple[int, int], ranges: Mapping[str, tuple[float, float]] = {}
) -> dict[str, Source]:
    """Return the sources of uncertainty of a joint by name.

    Parameters
    ----------
    conditions : Conditions
        Checked conditions of the joint.
    shape : (ny, nx)
        Cells of its walls.
    ranges : mapping
        Lowest and highest value [SI] by name of `VARIED`; they replace `PLAUSIBLE`.

    Raises
    ------
    InputError
        If a name or a range is not allowed.
    """
    _check_ranges(conditions, ranges)
    effects, numerics, choices = conditions.effects, conditions.numerics, conditions.choices
    sources = {}
    step = _coarser(conditions.grid_spacing, ranges)
    if min(shape) >= 8 * step:
        sources["spacing"] = Source((1, step))
    if effects.breakage and numerics.solver == "fast" and numerics.target == "equilibrate":
        resolved = numerics.breakage == "resolved"
        other = Numerics() if resolved else numerics._replace(breakage="resolved")
        sources["breakage"] = Source((numerics, other))
    if min(shape) >= 8:
        sources["alignment"] = Source(_SHIFTS)
    acting = {"peak_modulus_ratio": effects.soft_peaks, "base_radius_in_cells": True}
    acting["peaks"] = effects.soft_peaks and effects.breakage
    for name, ends in PLAUSIBLE.items():
        values = tuple(ranges.get(name, ends))
        if acting[name] and isinstance(values[0], str):
            joint = getattr(choices, name)
            sources[name] = Source((joint, *(value for value in values if value != joint)))
        elif acting[name]:
            sources[name] = Source(values, continuous=True)
    return sources | {name: Source(ranges[name], True) for name in OF_ROCK if name in ranges}


def variants_of(
    conditions: Conditions, sources: Mapping[str, Source], draws: int = DRAWS, seed: int = 0
) -> Iterator[Variant]:
    """Generate the variants of a joint: each source changed alone, then all of them at random.

    Parameters
    ----------
    conditions : Conditions
        Conditions of the joint.
    sources : mapping
        As from `sources_of`.
    draws : int
        Number of variants in which all sources have random values.
    seed : int
    """
    joint = Variant("", "", conditions)
    for name, source in sources.items():
        for value in source.values[0 if source.continuous else 1 :]:
            yield joint.changed(name, value)._replace(source=name, value=_text(name, value))
    shares = scipy.stats.qmc.LatinHypercube(len(sources), rng=generator(seed)).random(draws)
    for row in shares:
        drawn = joint._replace(source=ALL)
        texts = []
        for share, (name, source) in zip(row, sources.items(), strict=True):
            value = source.at(float(share))
            drawn = drawn.changed(name, value)
            texts.append(f"{TITLES[name]} {_text(name, value)}")
        yield drawn._replace(value="; ".join(texts))


def _text(name: str, value: Any) -> str:
    """Describe a value of a source."""
    if name == "spacing":
        return f"every {value}. cell" if value > 1 else "every cell"
    if name == "alignment":
        return f"{value} cells (y, x)"
    if name == "breakage":
        return value.breakage
    if name in OF_ROCK:
        return f"{value / OF_ROCK[name].size:.4g}{OF_ROCK[name].in_brackets}"
    return value if isinstance(value, str) else f"{value:.3g}"


def uncertainty_budget(
    upper: np.ndarray,
    lower: np.ndarray,
    conditions: Conditions,
    ranges: Mapping[str, tuple[float, float]] = {},
    closed: xr.Dataset | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
) -> Budget:
    """Close a joint with each source of uncertainty changed in turn, and with all at random.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights towards the other wall [m].
    conditions : Conditions
    ranges : mapping
        As for `sources_of`.
    closed : Dataset, optional
        Result of `jointclosure.simulate` at the conditions, by default computed here.
    report : callable
        Receives the finished share and the name of the next variant.

    Returns
    -------
    Budget
    """
    conditions = conditions._replace(flow=False).checked()
    variants = list(variants_of(conditions, sources_of(conditions, upper.shape, ranges)))
    closed = close_walls(upper, lower, conditions) if closed is None else closed
    parts = [_results(Variant("", "", conditions), closed)]
    for number, variant in enumerate(variants):
        report(number / len(variants), TITLES.get(variant.source, variant.source))
        try:
            joint = close_walls(*variant.walls(upper, lower), variant.conditions)
        except InputError:  # such as more steps than the numerics allow
            joint = None
        parts.append(_results(variant, joint, parts[0].cycle))
    results = pd.concat(parts, ignore_index=True)
    omitted = tuple(name for name in OF_ROCK if name not in ranges)
    return Budget(results, _ranges(results), omitted)


def _two_digits(value: float) -> str:
    """Format a number with two significant digits and no exponent."""
    if not abs(value) > 1e-12:  # rounding of closures that are 0
        return "nan" if np.isnan(value) else "0"
    decimals = 1 - int(np.floor(np.log10(abs(float(f"{value:.1e}")))))
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def _check_ranges(conditions: Conditions, ranges: Mapping[str, tuple[float, float]]) -> None:
    for name, ends in ranges.items():
        if name not in VARIED:
            raise InputError(f"ranges: {name!r}: must be one of {', '.join(VARIED)}")
        if np.shape(ends) != (2,):
            raise InputError(f"ranges: {name} = {ends!r}: must be (lowest, highest)")
        for end in ends:
            check_number(f"ranges: {name}", end)
        if not ends[0] < ends[1]:
            raise InputError(f"ranges: {name} = {ends!r}: the lowest value must come first")
        if name in OF_ROCK:
            first, second = both_walls(conditions.rock)
            if first != second:
                raise InputError(f"ranges: {name}: both walls must be of one rock")
            for end in ends:
                OF_ROCK[name].check(f"ranges: {name}", end)
        elif name in PLAUSIBLE:
            for end in ends:
                changed: dict[str, Any] = {name: end}
                Choices(**changed)  # raises the error that names its range


def _coarser(spacing: float, ranges: Mapping[str, tuple[float, float]]) -> int:
    """Return the spacing of the coarser grid over that of the joint."""
    if "spacing" not in ranges:
        return COARSER
    low, high = ranges["spacing"]
    step = round(high / spacing)
    if step < 2 or not np.isclose(low, spacing, rtol=1e-3):
        raise InputError(
            f"ranges: spacing = {(low, high)!r}: must begin at the spacing of the joint's grid, "
            f"{spacing:.4g} m, which is the finest, and end at least at twice of it"
        )
    return step


def _results(
    variant: Variant, joint: xr.Dataset | None, cycles: pd.Series | None = None
) -> pd.DataFrame:
    """Return the rows of a variant in `Budget.results`."""
    about = {"source": variant.source, "value": variant.value}
    if joint is None or int(joint.status) >= FAILURE:
        status = -1 if joint is None else int(joint.status)
        failed = pd.DataFrame({"cycle": [1] if cycles is None else cycles})
        return failed.assign(**about, status=status, **dict.fromkeys(QUANTITIES, np.nan))
    table = cycle_table(joint)
    stiffness = net_responses(joint, variant.conditions.largest_stress)["stiffness_net"]
    table["stiffness_net_MPa_per_mm"] = 1e-9 * stiffness[table.cycle - 1]
    return table[["cycle", *QUANTITIES]].assign(**about, status=int(joint.status))


def _ranges(results: pd.DataFrame) -> pd.DataFrame:
    """Return `Budget.ranges`."""
    rows = {}
    for cycle, of_cycle in results.groupby("cycle"):
        for quantity in QUANTITIES:
            values = of_cycle.groupby("source")[quantity].apply(np.array).to_dict()
            best, drawn = float(values.pop("")[0]), values.pop(ALL, np.empty(0))
            drawn = np.append(drawn[np.isfinite(drawn)], best)
            ends = {"best": best, "low": drawn.min(), "high": drawn.max()}
            rows[cycle, quantity] = ends | _shares(best, values)
    index = pd.MultiIndex.from_tuples(rows, names=["cycle", "quantity"])
    return pd.DataFrame(list(rows.values()), index=index)


def _shares(best: float, others: dict[str, np.ndarray]) -> dict[str, float]:
    """Return the share of each source in the sum of squared changes, up and down."""
    known = np.concatenate([[best], *others.values()])
    factors = bool(np.all(known[np.isfinite(known)] > 0.0))
    squares = {}
    for name, values in others.items():
        changes = (np.log(values / best) if factors else values - best)[np.isfinite(values)]
        squares[name] = changes.max(initial=0.0) ** 2 + changes.min(initial=0.0) ** 2
    total = sum(squares.values()) or np.nan
    return {name: square / total for name, square in squares.items()}

"""Range of a joint's closure over what the model leaves open: an uncertainty budget.

Every source of uncertainty is varied alone, to each of its plausible values, and the changes of a
result are combined by the root of their summed squares, separately for increases and decreases
(JCGM 100:2008, 5.1, with changes instead of derivatives). Changes of positive results are changes
of logarithms, because the model's open choices act as factors. ``benchmarks/range.py`` compares
these ranges with those of joints in which all sources vary together.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.measured_joints import measured_range
from jointclosure.engineering.curves import cycle_table, net_responses
from jointclosure.ensemble.closing import close_walls
from jointclosure.inputs import InputError, check_number
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import OF_ROCK, PLAUSIBLE, Choices, Numerics, both_walls, key_of

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


class Variant(NamedTuple):
    """A joint in which one source of uncertainty has another value.

    ``shift`` is that of the upper wall in cells (y, x); of the grid every ``step``-th cell is kept.
    """

    source: str
    value: str
    conditions: Conditions
    shift: tuple[int, int] = (0, 0)
    step: int = 1

    def walls(self, upper: np.ndarray, lower: np.ndarray) -> Walls:
        """Return the walls (y, x) [m] of the variant."""
        for axis, cells in enumerate(self.shift):
            kept = np.arange(upper.shape[axis] - abs(cells))
            upper = upper.take(kept + max(cells, 0), axis)
            lower = lower.take(kept + max(-cells, 0), axis)
        return upper[:: self.step, :: self.step], lower[:: self.step, :: self.step]


class Budget(NamedTuple):
    """Uncertainty budget of a closed joint.

    Attributes
    ----------
    results : DataFrame
        One row per variant and cycle: ``source``, ``value``, ``status``, ``cycle`` and `QUANTITIES`
        (NaN if the variant could not be closed). The source of the joint itself is "".
    ranges : DataFrame
        Over (cycle, quantity): ``best``, ``low``, ``high``, and the share of each source in the
        range, which sum to 1.
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
        failed = self.results.loc[self.results.status.mod(2 * FAILURE) >= FAILURE]
        for row in failed.drop_duplicates(["source", "value"]).itertuples():
            lines.append(f"not closed, and not in the range: {TITLES[row.source]} {row.value}")
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


def variants_of(
    conditions: Conditions, shape: tuple[int, int], ranges: Mapping[str, tuple[float, float]] = {}
) -> Iterator[Variant]:
    """Generate the variants of a joint: one source of uncertainty changed in each.

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
    step = _coarser(conditions.grid_spacing, ranges)
    if min(shape) >= 8 * step:
        coarse = conditions._replace(spacing=step * conditions.grid_spacing)
        yield Variant("spacing", f"{1e3 * coarse.grid_spacing:.3g} mm", coarse, step=step)
    effects, numerics = conditions.effects, conditions.numerics
    if effects.breakage and numerics.solver == "fast" and numerics.target == "equilibrate":
        resolved = numerics.breakage == "resolved"
        other = Numerics() if resolved else numerics._replace(breakage="resolved")
        yield Variant("breakage", other.breakage, conditions._replace(numerics=other))
    if min(shape) >= 8:
        for shift in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            yield Variant("alignment", f"{shift} cells (y, x)", conditions, shift)
    acting = {"peak_modulus_ratio": effects.soft_peaks, "peaks": effects.soft_peaks}
    acting["peaks"] = effects.soft_peaks and effects.breakage
    for name, values in (PLAUSIBLE | {k: ranges[k] for k in PLAUSIBLE if k in ranges}).items():
        for value in values if acting.get(name, True) else ():
            if value != getattr(conditions.choices, name):
                choices = conditions.choices._replace(**{name: value})
                yield Variant(name, f"{value}", conditions._replace(choices=choices))
    for name in OF_ROCK:
        for value in ranges.get(name, ()):
            rock = tuple(wall._replace(**{name: value}) for wall in both_walls(conditions.rock))
            size, unit = OF_ROCK[name].size, OF_ROCK[name].in_brackets
            yield Variant(name, f"{value / size:g}{unit}", conditions._replace(rock=rock))


def uncertainty_budget(
    upper: np.ndarray,
    lower: np.ndarray,
    conditions: Conditions,
    ranges: Mapping[str, tuple[float, float]] = {},
    closed: xr.Dataset | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
) -> Budget:
    """Close a joint with each source of uncertainty changed in turn.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights towards the other wall [m].
    conditions : Conditions
    ranges : mapping
        As for `variants_of`.
    closed : Dataset, optional
        Result of `jointclosure.simulate` at the conditions, by default computed here.
    report : callable
        Receives the finished share and the name of the next variant.

    Returns
    -------
    Budget
    """
    conditions = conditions._replace(flow=False).checked()
    variants = list(variants_of(conditions, upper.shape, ranges))
    closed = close_walls(upper, lower, conditions) if closed is None else closed
    parts = [_results(Variant("", "", conditions), closed)]
    for number, variant in enumerate(variants):
        report(number / len(variants), TITLES[variant.source])
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
            best = float(of_cycle.loc[of_cycle.source == "", quantity].iloc[0])
            others = of_cycle[of_cycle.source != ""].groupby("source")[quantity].apply(np.array)
            rows[cycle, quantity] = _combined(best, others.to_dict())
    index = pd.MultiIndex.from_tuples(rows, names=["cycle", "quantity"])
    return pd.DataFrame(list(rows.values()), index=index)


def _combined(best: float, others: dict[str, np.ndarray]) -> dict[str, float]:
    """Return best, lowest and highest value, and the share of each source in the range."""
    known = np.concatenate([[best], *others.values()])
    factors = bool(np.all(known[np.isfinite(known)] > 0.0))
    changes = {
        name: (np.log(values / best) if factors else values - best)[np.isfinite(values)]
        for name, values in others.items()
    }
    up = {name: float(change.max(initial=0.0)) ** 2 for name, change in changes.items()}
    down = {name: float(change.min(initial=0.0)) ** 2 for name, change in changes.items()}
    rise, fall = np.sqrt(sum(up.values())), np.sqrt(sum(down.values()))
    low, high = (
        (best * np.exp(-fall), best * np.exp(rise)) if factors else (best - fall, best + rise)
    )
    total = (rise**2 + fall**2) or np.nan
    return {"best": best, "low": low, "high": high} | {
        name: (up[name] + down[name]) / total for name in others
    }

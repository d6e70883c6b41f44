"""Uncertainty budget of a joint: ranges of its results, and the share of each source in them.

The range is due to what is not known of this joint: errors of the scans and of the numerics, the
order of breakage, and properties whose ranges are stated. The change of a result is expected to be
the sum of its changes with each source varied alone. The departures from it are those of joints
that were closed with random values of all these sources. The range is between the 5 and 95 %
quantiles of the expected changes for further random values, which need no closures, with
departures of a further joint: Student's t of the few that are known (JCGM 101:2008). Changes of
positive results are those of logarithms, those of a share are of its odds. The range contains the
joint as it was closed.

Choices of the model, such as the grid spacing, hold for all joints. Each is changed alone; their
effects are added in the wider range with other choices, centred on the usual ones.

The share of a source is its total index: the part of the variance that it takes part in, alone or
together with others (Homma & Saltelli 1996). Variances of random sources are those among their
draws, less that of the order of breakage, which is another one in any joint. What is then left of
the departures is due to pairs of sources, in proportion to the products of their variances.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.ensembles.quantities import CURVES, HEADINGS
from jointclosure.joint.cycles import net_responses
from jointclosure.joint.interpolation import monotone_curve
from jointclosure.joint.laws import BENDS, fitted_laws, parameter
from jointclosure.joint.status import LOADING
from jointclosure.joint.tables import FLOW_STATUSES, ONLY_BOUNDS, cycle_table, with_transmissivity
from jointclosure.parameters import OF_ROCK, key_of
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import significant
from jointclosure.uncertainty.numerical_error import NOT_STABLE, numerical_error, scatter_of
from jointclosure.uncertainty.published_joints import measured_range

RESIDUAL_NET = "residual_closure_seated_net_mm"
CLOSURE_NET, CLOSURE_GROSS = "max_closure_seated_net_mm", "max_closure_seated_mm"
CONTACT = "contact_at_max"
_ALMOST_ALL = 1.0 - 1e-6  # largest share of cells in contact whose odds are used
STIFFNESS, KNI, VM = "stiffness_net_MPa_per_mm", "kni_net_MPa_per_mm", "vm_net_mm"
QUANTITIES = {
    column: HEADINGS[column]
    for column in (
        CLOSURE_NET,
        RESIDUAL_NET,
        CLOSURE_GROSS,
        STIFFNESS,
        KNI,
        VM,
        "mean_aperture_at_max_mm",
        CONTACT,
    )
}
"""Headings of results with a range, by column of `results_of`."""
UNDETERMINED = "undetermined"
"""Text of a largest closure Vm that a loading which hardly bends does not determine."""
ORDER = "order"  # source of another order of breakage: copies that differ in rounding, or mirrored
TITLES = {
    "spacing": "grid spacing",
    "breakage": "numerical error",
    "registration": "registration",
    "noise": "noise of the scans",
    "resolution": "waves that the scans lost",
    "scale": "scale of heights",
    "holes": "missing heights",
    ORDER: "order of breakage",
    "peak_modulus_ratio": "peak modulus ratio",
    "base_radius_in_cells": "base radius",
    "peaks": "choice of soft peaks",
} | {name: about.long_name for name, about in OF_ROCK.items()}
"""Sources of uncertainty by name."""
MEASURED = (
    "measured joints: {:.2g} to {:.2g} mm of closure on the first loading to 10 MPa; a later "
    "loading was {:.2g} to {:.2g} times as stiff as the first, and {:.2g} to {:.2g} % of its "
    "closure remained; in second cycles of the model nothing remains, unless the joint is reseated "
    "or its crushed rock weakens (docs/measured.md)"
).format(
    *measured_range("first_closure"),
    *measured_range("stiffness_ratio"),
    *measured_range("later_residual_share"),
)
"""What is known of the model from three measured granodiorite joints."""
ALL = "all together"  # source of the variants in which all sources have random values
OUTLYING = 0.15  # share of joints with random values beyond a best value that lies at their edge
OUTSIDE = 0.05  # probability of a result below the range, and of one above it
WIDENED = {"aperture": 1.6, "hydraulic": 1.6, "contact": 1.6}
"""Factors of the width of ranges of apertures and contact, by a word of the name of the result.
Nine in ten of 34 pairs of known truth (seeds 2000 to 2042 of benchmarks/range_coverage.py) needed
them: the sources above do not have all that noise and interpolation do to cells that just touch."""
WIDENED_LATER = 1.25
"""The same for all other results from the second cycle on, which depend on what the first broke."""
ENDS = ["low", "high"]  # of a range
WIDER = [
    "low_with_choices",
    "high_with_choices",
]  # of that which has other choices of the model too
NUMBERS = ["best", *ENDS, *WIDER]
"""Columns of `Budget.ranges` that are no shares."""
NOT_MODELLED = "not modelled"  # of a result that is 0 in all variants: the model cannot give it
ROUNDING = 1e-12  # largest closure [mm] that is the rounding of 0
UNRESOLVED = 0.005
"""Share of the net closure of a cycle below which what stays of it is the error of its steps."""
MULTIPLE = "multiple"
"""Kind of a source with the value of the joint, a multiple of it, or its inverse, whose change is
opposite."""
SHARED = "shared"  # kind of a source whose second value all variants have


class Source(NamedTuple):
    """A source of uncertainty, by its kind.

    Of a "range" the ends, of a "choice" the alternatives, that of the joint first; of what is
    "random" the draws, that of the joint (none) first. Of a "shared" source all other variants have
    the second value, and are compared with the joint that differs by it alone. A source that is not
    ``varied`` is a choice of the model: it is changed alone, and is no part of the range.
    """

    values: tuple
    kind: str = "choice"
    varied: bool = True
    usual: float = 0.5  # share of a "range" at which the joint lies

    def at(self, share: float) -> Any:
        """Return the value at a share, in [0, 1), of its range or of its alternatives."""
        if self.kind == "random":
            return len(self.values) + int(share * 2**32)  # another draw
        if self.kind == "choice":
            return self.values[int(share * len(self.values))]
        low, high = self.values
        return low * (high / low) ** share if low > 0.0 else low + share * (high - low)

    def changes_at(self, changes: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Return the expected change of a result at shares (n,), from that at each value (k,)."""
        if self.kind == "random":
            return np.zeros(shares.shape)
        changes = np.nan_to_num(changes)  # what is not known counts as 0
        if self.kind == "range":
            return np.interp(shares, [0.0, self.usual, 1.0], [changes[0], 0.0, changes[1]])
        if self.kind == SHARED:  # the error may as well have the other sign
            return (2.0 * shares - 1.0) * changes[0]
        if self.kind == MULTIPLE:
            return np.array([-changes[0], 0.0, changes[0]])[(3.0 * shares).astype(int)]
        return np.append(0.0, changes)[(shares * len(self.values)).astype(int)]


class Budget(NamedTuple):
    """Uncertainty budget of a closed joint.

    ``results`` has a row per variant and cycle: ``source`` ("" for the joint itself, `ALL` for
    random values of all), ``value``, ``status``, ``cycle`` and `QUANTITIES`, NaN if not closed.
    ``ranges``, over (cycle, quantity), has the ``best`` value, that of the joint; ``low`` and
    ``high``, between which 9 in 10 joints with random values lie; the same with other choices of
    the model too (`WIDER`); and the share of each source in the latter, interactions included.
    Sources taken as exact are ``omitted``. ``curves`` is the `stress_table` of the joint, with low
    and high of each of `CURVES`; ``flow_status`` is there that of the variant of whose flow least
    is known. ``choices`` describes the choices of the model that were changed. ``numerical`` is
    that of `numerical_errors_of`.
    """

    results: pd.DataFrame
    ranges: pd.DataFrame
    omitted: tuple[str, ...]
    curves: pd.DataFrame = pd.DataFrame()
    choices: tuple[str, ...] = ()
    numerical: pd.DataFrame = pd.DataFrame(columns=["cycle", "quantity", "error", "scatter", "by"])

    def __str__(self) -> str:
        return "\n".join([*self.tables(), *(f"- {line}" for line in self.sentences())])

    def tables(self) -> list[str]:
        """Format the results, and below them the ranges with other choices of the model."""
        lines = [self.table().to_string()]
        if self.choices:
            about = ", ".join(self.choices)
            lines += [f"range with other choices of the model ({about})"]
            lines += [self.wider_table().to_string()]
        return lines

    def sentences(self) -> list[str]:
        """Describe what the range is due to, what it leaves out, and what is known of the model."""
        closure = next(iter(QUANTITIES))
        cycles = self.ranges.index.unique("cycle")
        lines = [
            f"{QUANTITIES[closure]}, cycle {cycle}: shares of sources in the range"
            f"{' with other choices of the model' if self.choices else ''}, interactions included: "
            f"{self._shares(cycle, closure)}"
            for cycle in (cycles if len(cycles) < 3 else cycles[[0, -1]])
        ]
        for quantity in (closure, STIFFNESS):
            lines += self._numerical_error(quantity)
        lines += [line for cycle in cycles for line in self._about_draws(cycle, closure)]
        for quantity, rows in self.ranges.groupby("quantity", sort=False):
            absent = [str(cycle) for cycle, _ in rows.index if not self.modelled(cycle, quantity)]
            if absent:
                lines.append(
                    f"{QUANTITIES[quantity]}, cycle {', '.join(absent)}: {NOT_MODELLED}, as it is "
                    "0 in the model whatever the inputs are"
                )
        lines += self._undetermined()
        failed = self.results.loc[self.results[closure].isna(), ["source", "value"]]
        for source, rows in failed.drop_duplicates().groupby("source"):
            count = f"{len(rows)} random sets of inputs" if source == ALL else TITLES[source]
            lines.append(f"failed, and not in the range: {count} ({rows.value.iloc[0]})")
        if "registration" in self.omitted:
            lines.append("not varied in the range: the position of the walls, as no fit moved them")
        if exact := [name for name in self.omitted if name in OF_ROCK]:
            names = ", ".join(TITLES[name] for name in exact)
            lines.append(
                f"not varied in the range: {names} (--range {key_of(exact[-1])} LOW HIGH, or "
                "ranges= in Python, adds their ranges)"
            )
        return [*lines, MEASURED]

    def _undetermined(self) -> list[str]:
        """Describe how many joints have no largest closure Vm, as their loading does not bend."""
        lines = []
        for cycle, rows in self.results[self.results[KNI].notna()].groupby("cycle"):
            if absent := int(rows[VM].isna().sum()):
                lines.append(
                    f"{QUANTITIES[VM]}, cycle {cycle}: undetermined for {absent} of {len(rows)} "
                    "variants of the joint, whose loading hardly bends (Vm is more than "
                    f"{BENDS:g} times the largest closure, or less than its standard error); a "
                    "range is that of the others"
                )
        return lines

    def _numerical_error(self, quantity: str) -> list[str]:
        """Describe the numerical error of a result, and of which cycles it is not stable."""
        known = self.numerical[self.numerical.quantity == quantity].dropna(subset="error")
        if known.empty:
            return []
        errors = (f"{100.0 * row.error:.2g} % on cycle {row.cycle}" for row in known.itertuples())
        by = ", ".join(known.by.unique())
        lines = [
            f"{QUANTITIES[quantity]}: numerical error at most {', '.join(errors)} in nine of ten "
            f"joints (by {by})"
        ]
        unstable = known[known.scatter > NOT_STABLE]
        if len(unstable):
            scatter = (
                f"{100.0 * row.scatter:.2g} % on cycle {row.cycle}" for row in unstable.itertuples()
            )
            lines.append(
                f"{QUANTITIES[quantity]}: this joint is not stable, as copies that should give "
                f"equal results scatter by {', '.join(scatter)} (stable: up to "
                f"{100.0 * NOT_STABLE:.0f} %)"
            )
        return lines

    def _about_draws(self, cycle: int, quantity: str) -> list[str]:
        """Describe a joint whose best value is at the edge of those of random inputs."""
        of_all = self.results.source == ALL
        drawn = self.results.loc[of_all & (self.results.cycle == cycle), quantity].dropna()
        best = self.ranges.loc[(cycle, quantity), "best"]
        below = (drawn < best).mean() if len(drawn) else 0.5
        if OUTLYING <= below <= 1.0 - OUTLYING:
            return []
        return [
            f"{QUANTITIES[quantity]}, cycle {cycle}: that of the walls as registered, with the "
            f"usual values of all inputs, is {_two_digits(best)}, "
            f"{'smaller' if below < 0.5 else 'larger'} than {100.0 * max(below, 1.0 - below):.0f} "
            "% of the results of random inputs"
        ]

    def record(self) -> list[dict]:
        """Return `ranges` and numerical errors for JSON, one entry per cycle and quantity."""
        rows = self.ranges.astype(object).where(self.ranges.notna(), None)
        numerical = self.numerical.dropna(subset="error").set_index(["cycle", "quantity"])
        errors = numerical.error.astype(float).to_dict()
        return [
            {"cycle": cycle, "quantity": quantity, "text": self.text(cycle, quantity)}
            | row[NUMBERS].to_dict()
            | {"numerical_error": errors.get((cycle, quantity))}
            | {"shares": row.drop(NUMBERS).to_dict()}
            for (cycle, quantity), row in rows.iterrows()
        ]

    def table(self) -> pd.DataFrame:
        """Return the results as text, quantities over cycles."""
        return table_of(self.ranges.index.unique("cycle"), self.text)

    def text(self, cycle: int, quantity: str) -> str:
        """Format a result of the joint and its range with two digits: "0.18 (0.13 to 0.24)"."""
        if not self.modelled(cycle, quantity):
            return NOT_MODELLED
        row = self.ranges.loc[cycle, quantity]
        if quantity == VM and np.isnan(row.best):
            return UNDETERMINED
        first, low, high = _shown(row.best, row.low, row.high)
        return f"{first} ({low} to {high})"

    def wider_table(self) -> pd.DataFrame:
        """Return the ranges with other choices of the model as text, as in `table`."""

        def text(cycle: int, quantity: str) -> str:
            row = self.ranges.loc[cycle, quantity]
            if not self.modelled(cycle, quantity) or np.isnan(row[WIDER].astype(float)).any():
                return ""
            return " to ".join(_shown(*row[WIDER]))

        return table_of(self.ranges.index.unique("cycle"), text)

    def modelled(self, cycle: int, quantity: str) -> bool:
        """Return whether any variant has a result other than 0."""
        rows = self.results[self.results.cycle == cycle].dropna(subset=quantity)
        least = UNRESOLVED * rows[CLOSURE_NET] if quantity == RESIDUAL_NET else ROUNDING
        return rows.empty or bool((rows[quantity].abs() > least).any())

    def _shares(self, cycle: int, quantity: str) -> str:
        """Name the sources with at least half a percent of a range, as in "registration 60 %"."""
        shares = self.ranges.loc[cycle, quantity].drop(NUMBERS).dropna()
        known = shares[shares >= 0.005].astype(float).sort_values(ascending=False)
        return ", ".join(f"{TITLES[name]} {100.0 * share:.0f} %" for name, share in known.items())


def _shown(*values: float) -> tuple[str, ...]:
    """Format numbers with two digits, and as 0 what is little beside the distance of the last."""
    least = 0.005 * (values[-1] - values[-2])
    return tuple(_two_digits(0.0 if abs(value) < least else value) for value in values)


def _two_digits(value: float) -> str:
    """Format a number with two significant digits and no exponent."""
    if not abs(value) > ROUNDING:
        return "nan" if np.isnan(value) else "0"
    return significant(value, 2)


def results_of(history: xr.Dataset) -> pd.DataFrame:
    """Return cycles and `QUANTITIES` of a joint that did not fail."""
    table = cycle_table(history)
    laws = fitted_laws(history, ["hyperbolic"], [LOADING])
    stiffness = net_responses(history)["stiffness_net"]
    table[STIFFNESS] = 1e-9 * stiffness[table.cycle - 1]
    for column, name in ((KNI, "kni_MPa_per_mm"), (VM, "vm_mm")):
        table[column] = [parameter(laws, cycle, LOADING, name) for cycle in table.cycle]
    return table[["cycle", *QUANTITIES]]


def table_of(cycles: Iterable[int], text: Callable[[int, str], str]) -> pd.DataFrame:
    """Arrange texts of results, quantities over cycles."""
    columns = {f"cycle {cycle}": [text(cycle, name) for name in QUANTITIES] for cycle in cycles}
    return pd.DataFrame(columns, index=list(QUANTITIES.values()))


def numerical_errors_of(results: pd.DataFrame, shared: bool, cells: int) -> pd.DataFrame:
    """Return the numerical error of net closure and net stiffness, from the rows of a budget.

    Parameters
    ----------
    results : DataFrame
        As `Budget.results`.
    shared : bool
        Whether copies have the changed steps, and not those of the joint.
    cells : int
        Number of cells of the joint.

    Returns
    -------
    DataFrame
        One row per ``cycle`` and ``quantity``: ``error`` [1], as `numerical_error` (NaN where no
        other steps are known), the ``scatter`` of copies [1], and ``by`` which steps and copies.
    """
    rows = []
    for cycle, here in results.groupby("cycle"):
        joint, steps, copies = (here[here.source == name] for name in ("", "breakage", ORDER))
        for quantity in (CLOSURE_NET, STIFFNESS):
            value = float(joint[quantity].iloc[0])
            others = steps[quantity].tolist()
            alike = copies[quantity].tolist()
            if shared:
                same = changed = [*others, *alike]
                every = [value, *same]
            else:
                changed = others
                same = [value, *alike]
                every = same
            contacts = float(joint[CONTACT].iloc[0]) * cells
            error = numerical_error(value, changed, every, contacts, cycle)
            by = f"{', '.join(steps.value)} and {len(alike)} copies"
            rows.append((cycle, quantity, error, scatter_of(same), by))
    return pd.DataFrame(rows, columns=["cycle", "quantity", "error", "scatter", "by"])


def limits_of_error(numerical: pd.DataFrame) -> dict[tuple[int, str], float]:
    """Return the known numerical errors [1] of `numerical_errors_of` by cycle and quantity."""
    known = numerical.dropna(subset="error")
    return {(row.cycle, row.quantity): row.error for row in known.itertuples()}


def ranges_of(
    results: pd.DataFrame,
    sources: Mapping[str, Source],
    shares: np.ndarray,
    further: np.ndarray,
    limits: Mapping[tuple[int, str], float] = {},
) -> pd.DataFrame:
    """Compute `Budget.ranges` of `Budget.results`, of which ``shares`` (draws, sources) are the
    random values of the joints closed with `ALL`, as for `Source.at`, and ``further`` (n, sources).

    A range is at least as wide as the limit of the numerical error of its result
    (`limits_of_error`).
    """
    rows = {}
    for cycle, of_cycle in results.groupby("cycle"):
        for quantity in QUANTITIES:
            of_quantity = of_cycle[quantity]
            if quantity == CONTACT:  # odds have no upper limit, so that a share stays below 1
                touching = of_quantity.clip(upper=_ALMOST_ALL)
                of_quantity = touching / (1.0 - touching)
            values = of_quantity.groupby(of_cycle.source).apply(np.array).to_dict()
            widened = widening_of(quantity, int(cycle))
            # the gross closure has that of the net one besides an indentation that is known well
            limited = CLOSURE_NET if quantity == CLOSURE_GROSS else quantity
            error = limits.get((int(cycle), limited), 0.0)
            rows[cycle, quantity] = _range_of(
                values, sources, shares, further, widened=widened, error=error
            )
        share = rows[cycle, CONTACT]
        share.update({end: share[end] / (1.0 + share[end]) for end in NUMBERS[1:]})
        share[NUMBERS[0]] = float(of_cycle.loc[of_cycle.source == "", CONTACT].iloc[0])
        net = rows[cycle, CLOSURE_NET]
        gross = rows[cycle, CLOSURE_GROSS]
        for end in NUMBERS[1:]:  # of every joint the net closure is the smaller one
            net[end], gross[end] = sorted((net[end], gross[end]))
    index = pd.MultiIndex.from_tuples(rows, names=["cycle", "quantity"])
    return pd.DataFrame(list(rows.values()), index=index)


def widening_of(quantity: str, cycle: int) -> float:
    """Return the factor of the width of the range of a result or of a band in a cycle."""
    later = WIDENED_LATER if cycle > 1 else 1.0
    return next((factor for word, factor in WIDENED.items() if word in quantity), later)


def _range_of(
    values: dict[str, np.ndarray],
    sources: Mapping[str, Source],
    shares: np.ndarray,
    further: np.ndarray,
    least: float | None = None,
    widened: float = 1.0,
    error: float = 0.0,
) -> dict[str, float]:
    """Return a row of `Budget.ranges` from the results of the variants of each source.

    Changes are factors if the ``least`` result, by default of the variants, is positive. Ranges
    are ``widened`` about the joint by a factor, and contain the numerical ``error`` [1] of it.
    """
    best = float(values.pop("")[0])
    known = np.concatenate([[best], *values.values()])
    if np.isnan(known).all():
        return dict.fromkeys((*NUMBERS, *sources), np.nan)
    factors = bool((np.nanmin(known) if least is None else least) > 0.0)
    shared = next((name for name in sources if sources[name].kind == SHARED), "")
    by_shared = values[shared][0] if shared else best
    changes = {}
    for name, of_source in values.items():
        from_here = best if name == shared or np.isnan(by_shared) else by_shared
        changes[name] = np.log(of_source / from_here) if factors else of_source - from_here
    drawn = changes.pop(ALL)
    expected, of_further = (
        {
            name: source.changes_at(changes[name], at)
            for (name, source), at in zip(sources.items(), of_joints.T, strict=True)
        }
        for of_joints in (shares, further)
    )
    slope, departures = _departures(drawn, _sum(expected, sources, True))
    centre = departures.mean()
    scatter = np.sqrt((departures.size + 1) / departures.size)
    scatter *= departures.std(ddof=1) if departures.size > 1 else 0.0
    further_departures = centre + scatter * _student_t(len(further), max(departures.size - 1, 1))
    of_range = slope * _sum(of_further, sources, True) + further_departures
    wider = of_range + _sum(of_further, sources, False)
    ends = np.quantile([of_range, wider], [OUTSIDE, 1.0 - OUTSIDE], axis=1).T
    ends = widened * np.column_stack([np.minimum(ends[:, 0], 0.0), np.maximum(ends[:, 1], 0.0)])
    if error > 0.0:
        below = np.log1p(-min(error, _ALMOST_ALL)) if factors else -error * abs(best)
        above = np.log1p(error) if factors else error * abs(best)
        ends = np.column_stack([np.minimum(ends[:, 0], below), np.maximum(ends[:, 1], above)])
    ends[1] = min(ends[0, 0], ends[1, 0]), max(ends[0, 1], ends[1, 1])
    numbers = best * np.exp(ends.ravel()) if factors else best + ends.ravel()
    numbers = np.maximum(numbers, min(0.0, np.nanmin(known)))  # below 0 where a joint was
    variances = {
        name: (slope**2 if sources[name].varied else 1.0) * float(of_source.var())
        for name, of_source in of_further.items()
    }
    random = {name: changes[name] for name in sources if sources[name].kind == "random"}
    row = dict(zip(NUMBERS, (best, *numbers), strict=True))
    return row | total_indices(variances, random, float(departures.var()))


@lru_cache
def _student_t(count: int, freedom: int) -> np.ndarray:
    """Return quantiles (count,) of Student's t at equal probabilities, in random order."""
    order = generator(seed_of(1, "departures")).permutation(count)
    return scipy.stats.t.ppf((order + 0.5) / count, freedom)


def _sum(
    changes: Mapping[str, np.ndarray], sources: Mapping[str, Source], varied: bool
) -> np.ndarray:
    """Return the sum of the changes (n,) by sources that are varied in the range, or not."""
    chosen = [values for name, values in changes.items() if sources[name].varied == varied]
    return np.sum(chosen, axis=0) if chosen else np.zeros(next(iter(changes.values())).shape)


_LIMIT_OF_BAND = {
    "closure_net_since_seating_mm": CLOSURE_NET,
    "normal_stiffness_net_MPa_per_mm": STIFFNESS,
}
"""Result whose numerical error a band contains at each stress, by column of `stress_table`."""


def bands_of(
    curves: pd.DataFrame,
    sources: Mapping[str, Source],
    shares: np.ndarray,
    further: np.ndarray,
    limits: Mapping[tuple[int, str], float] = {},
) -> pd.DataFrame:
    """Compute `Budget.curves` from `stress_table` of all variants; arguments as for `ranges_of`."""
    places = ["cycle", "branch", "normal_stress_MPa"]
    rows = []
    shown = [name for name in CURVES if name in curves]
    above = curves.normal_stress_MPa > curves.normal_stress_MPa.min()  # where closures begin
    least = {True: curves.loc[above, shown].min(), False: dict.fromkeys(shown)}
    for (cycle, _, stress), here in curves.groupby(places, sort=False):
        row = here[here.source == ""].iloc[0].drop("source")
        of_source = here.groupby("source")
        if "flow_status" in row:
            known_statuses = [word for word in FLOW_STATUSES if (here.flow_status == word).any()]
            row["flow_status"] = known_statuses[-1] if known_statuses else ""
        for name in shown:
            values = of_source[name].apply(np.array).to_dict()
            known = np.isfinite(row[name])
            if name == "hydraulic_aperture_mm":  # quantiles of those with a known flow mislead
                known &= row["flow_status"] not in ONLY_BOUNDS
            smallest = least[stress > curves.normal_stress_MPa.min()][name]
            widened = widening_of(name, int(cycle))
            error = limits.get((int(cycle), _LIMIT_OF_BAND.get(name, "")), 0.0)
            numbers = {}
            if known:
                numbers = _range_of(values, sources, shares, further, smallest, widened, error)
            for number in ENDS:
                row[f"{name}_{number}"] = numbers.get(number, np.nan)
        rows.append(row)
    bands = pd.DataFrame(rows).infer_objects().reset_index(drop=True)
    for name in shown:
        rises = CURVES[name][1]
        low, high = (f"{name}_{end}" for end in ENDS)
        for _, rows in bands.groupby(places[:2]):
            known = rows[[name, low, high]].dropna()
            if known.empty:
                continue
            stress = rows.normal_stress_MPa[known.index].to_numpy()
            joint = known[name].to_numpy()
            ends = [monotone_curve(stress, known[end].to_numpy(), rises) for end in (low, high)]
            if (np.diff(joint) * (1.0 if rises else -1.0) >= 0.0).all():
                ends = [np.minimum(ends[0], joint), np.maximum(ends[1], joint)]
            bands.loc[known.index, [low, high]] = np.transpose(ends)
    return with_transmissivity(bands)


def _departures(drawn: np.ndarray, sums: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the slope of changes (draws,) against those expected, and departures from the line.

    It is at most 1, as sources with the same effect do not add up.
    """
    known = np.isfinite(drawn)
    drawn = drawn[known]
    sums = sums[known]
    if drawn.size < 2:
        return 1.0, np.zeros(1)
    centred = sums - sums.mean()
    square = float(centred @ centred)
    slope = float(np.clip(centred @ drawn / square, 0.0, 1.0)) if square > 0.0 else 1.0
    return slope, drawn - slope * sums


def total_indices(
    alone: Mapping[str, float], random: Mapping[str, np.ndarray], departures: float
) -> dict[str, float]:
    """Return the total index of each source, from the variances by each source ``alone``, the
    changes of a result in the draws of each ``random`` source, and the variance of departures.
    """
    scatter = {}
    for name, values in random.items():
        draws = values[np.isfinite(values)]
        draws = np.append(draws, 0.0) if name == ORDER else draws  # the joint is a copy too
        scatter[name] = float(draws.var(ddof=1)) if draws.size > 1 else 0.0
    order = scatter.get(ORDER, 0.0)
    scatter = {name: v if name == ORDER else max(v - order, 0.0) for name, v in scatter.items()}
    most = departures / total if (total := sum(scatter.values())) > departures else 1.0
    variances = dict(alone) | {name: most * variance for name, variance in scatter.items()}
    left = departures - most * total
    acting = {name: variance for name, variance in variances.items() if name != ORDER}
    whole = sum(acting.values())
    pairs = {name: variance * (whole - variance) for name, variance in acting.items()}
    if not any(pairs.values()):  # less than two sources act
        pairs = variances
        left = 0.5 * left
    products = 0.5 * sum(pairs.values()) or np.nan
    everything = sum(alone.values()) + departures or np.nan
    return {
        name: (variance + left * pairs.get(name, 0.0) / products) / everything
        for name, variance in variances.items()
    }

"""Uncertainty budget of a joint: ranges of its results, from simulations of its variants."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.execution.workers import in_threads
from jointclosure.inputs.remarks import caution, cautions
from jointclosure.joint.cycle_results import largest_jump
from jointclosure.joint.cycling import StepReport
from jointclosure.joint.history import history_of
from jointclosure.joint.laws import BENDS
from jointclosure.joint.result_tables import stress_table
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.status import failed
from jointclosure.parameters import OF_ROCK, acting, key_of
from jointclosure.statistics.number_texts import percent, significant, with_equal_decimals
from jointclosure.uncertainty.numerical_error import (
    NOT_STABLE,
    differences_of_loading,
    limits_of_error,
    numerical_errors_of,
)
from jointclosure.uncertainty.published_joints import measured_range
from jointclosure.uncertainty.ranged_results import (
    CLOSURE_NET,
    FITTED,
    KNI,
    RANGED_RESULTS,
    RESIDUAL_NET,
    STIFFNESS,
    UNRESOLVED,
    VM,
    results_of,
    table_of,
)
from jointclosure.uncertainty.ranges import ENDS, NUMBERS, WIDER, bands_of, ranges_of
from jointclosure.uncertainty.sources import ALL, MULTIPLE, OTHER_RULE, SHARED, TITLES, Source
from jointclosure.uncertainty.uncertain_joint import UncertainJoint, threads_for
from jointclosure.uncertainty.variants import (
    FURTHER_SEED,
    RANDOM_JOINTS,
    SEED,
    Variant,
    random_positions,
    value_text,
)

UNDETERMINED = "undetermined"
"""Text in place of a kni or Vm that a loading does not determine, and of the share of a source that
the joints with random values are too few to distinguish from 0."""
MEASURED = (
    "measured joints (three of granodiorite, E 11 GPa, 122 mm wide): {:.2g} to {:.2g} mm of "
    "closure on the first loading to 10 MPa; a later loading was {:.2g} to {:.2g} times as stiff "
    "as the first, and {:.2g} to {:.2g} % of its closure remained; in second cycles of the model "
    "nothing remains, unless the joint is reseated or its crushed rock weakens (docs/measured.md)"
).format(
    *measured_range("first_closure"),
    *measured_range("stiffness_ratio"),
    *measured_range("later_residual_share"),
)
"""Sentence that compares the model with three measured granodiorite joints."""
AT_EDGE = (
    "* all results of random inputs are smaller, or all are larger, than the value before the "
    "bracket: quote the range, and not this value"
)
"""Note below a table of results with asterisks."""
OUTLYING = 0.15  # share of random joints beyond the joint's value, below which it is at their edge
NOT_MODELLED = "not modelled"  # of a result that is 0 in all variants: the model cannot give it
FURTHER = 10_000  # further joints with random values whose results are estimated for the range
ROUNDING = 1e-12  # largest closure [mm] that is the rounding of 0
LEAST_SHARE = 0.005  # smallest share of a source that is named: half a percent
MOVES = 0.1
"""Change of a result by one source alone, over the width of the range, from which a share below
`LEAST_SHARE` is called undetermined: few random joints do not show what the source does."""
AT_END = 0.05
"""Distance of the usual value from an end of its range, over the width of the range, up to which
the range is called one-sided."""
_OF_SCANS = ("registration", "noise", "resolution", "scale", "holes")
"""Sources that are errors of the scans and of their position."""
_WHY_UNDETERMINED = {
    KNI: "whose loading begins so flat that the fitted kni is less than its standard error",
    VM: "whose loading hardly bends (Vm is more than "
    f"{BENDS:g} times the largest closure, or less than its standard error)",
}


class Budget(NamedTuple):
    """Uncertainty budget of a simulated joint.

    Attributes
    ----------
    results : DataFrame
        A row per variant and cycle: ``source`` ("" for the joint itself, `ALL` for random values of
        all sources), ``value``, ``status``, ``cycle`` and `RANGED_RESULTS`, which are NaN if the
        variant failed. The status of a variant that was refused is -1.
    ranges : DataFrame
        Over (cycle, quantity): ``best``, the value of the joint; ``low`` and ``high``, the ends of
        the range in which 9 in 10 joints with random values lie; the ends of the wider range with
        other choices of the model too (`WIDER`); and the share of each source in the variance of
        the result within the wider range, interactions included.
    omitted : tuple of str
        Names of sources that are not varied, because they are taken as exact.
    curves : DataFrame
        The `stress_table` of the joint, with low and high ends of the band of each of `CURVES`, and
        `WIDER` ends if there are ``choices``. With flow, the column `RANGE_FLOW_STATUS` has the
        status of the variant whose flow is known least: where only bounds of it are known, the
        hydraulic aperture has no range.
    choices : tuple of str
        Descriptions of the choices of the model that were changed.
    numerical : DataFrame
        As from `numerical_errors_of`.
    one_rock : bool
        Whether both walls are of one rock, so that ranges of its properties can be stated.
    """

    results: pd.DataFrame
    ranges: pd.DataFrame
    omitted: tuple[str, ...]
    curves: pd.DataFrame = pd.DataFrame()
    choices: tuple[str, ...] = ()
    numerical: pd.DataFrame = pd.DataFrame(columns=["cycle", "quantity", "error", "scatter", "by"])
    one_rock: bool = True

    def __str__(self) -> str:
        return "\n".join([*self.tables(), *(f"- {line}" for line in [*self.sentences(), MEASURED])])

    def tables(self) -> list[str]:
        """Return the table of results with their ranges as text.

        If choices of the model were changed, the title and the table of the wider ranges follow.
        """
        lines = [self.table().to_string(), *self.notes()]
        if self.choices:
            lines += [self.wider_title(), self.wider_table().to_string()]
        return lines

    def sentences(self) -> list[str]:
        """Return all sentences on the ranges: their sources, errors, and what they leave out.

        Some of the sentences are cautions.
        """
        closure = next(iter(RANGED_RESULTS))
        cycles = self.ranges.index.unique("cycle")
        shown = cycles if len(cycles) < 3 else cycles[[0, -1]]
        lines = [
            f"{RANGED_RESULTS[closure]}, cycle {cycle}: shares of sources: "
            f"{self._shares_text(cycle, closure)}"
            for cycle in shown
        ]
        lines.append(f"shares of sources: {self.about_shares()}")
        if any(self.undetermined_shares(cycle, closure) for cycle in shown):
            lines.append(
                f"{UNDETERMINED} share: the source alone moves the result by more than "
                f"{100.0 * MOVES:.0f} % of its range, but {self._random_joints()} joints with "
                "random values do not distinguish its share from 0"
            )
        for quantity in (closure, STIFFNESS):
            lines += self._numerical_error(quantity)
        lines += self.one_sided()
        lines += [line for cycle in cycles for line in self._about_draws(cycle, closure)]
        for quantity, rows in self.ranges.groupby("quantity", sort=False):
            absent = [str(cycle) for cycle, _ in rows.index if not self.modelled(cycle, quantity)]
            if absent:
                lines.append(
                    f"{RANGED_RESULTS[quantity]}, cycle {', '.join(absent)}: {NOT_MODELLED}, as it "
                    "is 0 in the model whatever the inputs are"
                )
        lines += self._undetermined()
        return lines + self._left_out()

    def _left_out(self) -> list[str]:
        """Return sentences on variants that failed, and on what is not varied in the range."""
        lines = []
        closure = next(iter(RANGED_RESULTS))
        failures = self.results.loc[self.results[closure].isna(), ["source", "value"]]
        for source, rows in failures.drop_duplicates().groupby("source"):
            count = f"{len(rows)} random sets of inputs" if source == ALL else TITLES[source]
            lines.append(f"failed, and not in the range: {count} ({rows.value.iloc[0]})")
        if "registration" in self.omitted:
            lines.append("not varied in the range: the position of the walls, as no fit moved them")
        if exact := [name for name in self.omitted if name in OF_ROCK]:
            names = ", ".join(TITLES[name] for name in exact)
            remedy = (
                f"--range {key_of(exact[-1])} LOW HIGH, or ranges= in Python, adds their ranges"
                if self.one_rock
                else "ranges of them can be stated only if both walls are of one rock"
            )
            lines.append(f"taken as exact, and not varied in the range: {names} ({remedy})")
        return lines

    def one_sided(self) -> list[str]:
        """Return a sentence on the results that lie at an end of their range; none without any."""
        names: dict[str, list[str]] = {}
        for (cycle, quantity), row in self.ranges.iterrows():
            best, low, high = row[["best", *ENDS]].astype(float)
            if not self.modelled(cycle, quantity) or not high > low:
                continue
            if min(best - low, high - best) <= AT_END * (high - low):
                name = RANGED_RESULTS[quantity].partition(" (")[0]
                names.setdefault(name, []).append(str(cycle))
        if not names:
            return []
        here = [TITLES[name] for name in _OF_SCANS if (self.results.source == name).any()]
        due = f" ({', '.join(here)})" if here else ""
        results = "; ".join(f"{name}, cycle {', '.join(of)}" for name, of in names.items())
        return [
            f"range on one side of the usual value: {results}: the value is that of the walls as "
            f"registered, with usual inputs, and what is not known{due} changes it almost only in "
            "one direction"
        ]

    def main_sentences(self) -> list[str]:
        """Return the main sentences on the ranges: sides, sources, errors, and what is left out.

        All cautions of `sentences`, which has the details, are among them.
        """
        closure = next(iter(RANGED_RESULTS))
        cycles = self.ranges.index.unique("cycle")
        shown = cycles if len(cycles) < 3 else cycles[[0, -1]]
        parts = [f"cycle {cycle}: {self._shares_text(cycle, closure)}" for cycle in shown]
        choices = " with other choices of the model" if self.choices else ""
        shares = f"shares in the range of net closure{choices}, {'; '.join(parts)}"
        lines = [*self.one_sided(), shares]
        errors = [line for name in (closure, STIFFNESS) for line in self._numerical_error(name)]
        all_lines = self.sentences()
        kept = [line for line in all_lines if line in (*errors, *cautions(all_lines))]
        return lines + kept + self._left_out()

    def _undetermined(self) -> list[str]:
        """Return sentences on how many variants of the joint have no kni or Vm, and why."""
        lines = []
        for (cycle, rows), name in product(self.results.groupby("cycle"), FITTED):
            fitted = rows[rows[CLOSURE_NET].notna() & (rows.source != OTHER_RULE)]
            if fitted[list(FITTED)].isna().all(axis=None):  # the loading has no hyperbola
                continue
            if absent := int(fitted[name].isna().sum()):
                lines.append(
                    f"{RANGED_RESULTS[name]}, cycle {cycle}: undetermined for {absent} of "
                    f"{len(fitted)} variants of the joint, {_WHY_UNDETERMINED[name]}; a range is "
                    "that of the others"
                )
        return lines

    def _numerical_error(self, quantity: str) -> list[str]:
        """Return sentences on the numerical error of a result, and on cycles with unstable results.

        There are none if the error is not known.
        """
        known = self.numerical[self.numerical.quantity == quantity].dropna(subset="error")
        if known.empty:
            return []
        errors = (f"{percent(row.error)} on cycle {row.cycle}" for row in known.itertuples())
        at_limit = [
            str(row.cycle)
            for row in known.itertuples()
            if self._ends_at_limit(row.cycle, quantity, row.error)
        ]
        ends = ""
        if len(at_limit) == 1:
            ends = f"; the range of cycle {at_limit[0]} ends at it"
        elif at_limit:
            ends = f"; the ranges of cycles {', '.join(at_limit)} end at it"
        lines = [
            f"{RANGED_RESULTS[quantity]}: limit of the numerical error {', '.join(errors)} (about "
            f"nine in ten joints keep such a limit){ends}"
        ]
        unstable = known[known.scatter > NOT_STABLE]
        if len(unstable):
            scatter = (
                f"{percent(row.scatter)} on cycle {row.cycle}" for row in unstable.itertuples()
            )
            lines.append(
                f"{RANGED_RESULTS[quantity]}: this joint is not stable, as its results with other "
                "steps and those of copies, which should be equal, scatter by "
                f"{', '.join(scatter)} (stable: up to {100.0 * NOT_STABLE:.0f} %)"
            )
        return lines

    def _ends_at_limit(self, cycle: int, quantity: str, error: float) -> bool:
        """Return whether the range of a result ends at the limit of its numerical ``error`` [1]."""
        if (cycle, quantity) not in self.ranges.index:
            return False
        row = self.ranges.loc[(cycle, quantity)]
        ends = (row.low, row.best / (1.0 + error)), (row.high, row.best * (1.0 + error))
        return any(math.isclose(end, limit, rel_tol=1e-9) for end, limit in ends)

    def _about_draws(self, cycle: int, quantity: str) -> list[str]:
        """Return a sentence if a result of the joint is at the edge of those with random inputs.

        This is so if more than 85 % of the joints with random inputs lie on one side of it. The
        sentence is a caution if all do.
        """
        drawn = self._drawn(cycle, quantity)
        best = self.ranges.loc[(cycle, quantity), "best"]
        below = (drawn < best).mean() if len(drawn) else 0.5
        share = max(below, 1.0 - below)
        if share <= 1.0 - OUTLYING:
            return []
        line = (
            f"{RANGED_RESULTS[quantity]}, cycle {cycle}: that of the walls as registered, with the "
            f"usual values of all inputs, is {significant(best, 2)}, "
            f"{'smaller' if below < 0.5 else 'larger'} than {100.0 * share:.0f} "
            "% of the results of random inputs"
        )
        if share < 1.0:
            return [line]
        return [
            caution(
                f"{line}. They all change it in one direction: quote the range, which contains "
                "both, and not the single value"
            )
        ]

    def record(self) -> list[dict]:
        """Return the ranges and numerical errors as a record for JSON.

        There is an entry per cycle and quantity, with None in place of NaN.
        """
        rows = self.ranges.astype(object).where(self.ranges.notna(), None)
        errors = limits_of_error(self.numerical)
        return [
            {"cycle": cycle, "quantity": quantity, "text": self.text(cycle, quantity)}
            | row[NUMBERS].to_dict()
            | {"numerical_error": errors.get((cycle, quantity))}
            | {
                "shares": row.drop(NUMBERS).to_dict(),
                "undetermined_shares": self.undetermined_shares(cycle, quantity),
            }
            for (cycle, quantity), row in rows.iterrows()
        ]

    def table(self) -> pd.DataFrame:
        """Return the results with ranges as text: a row for each quantity, a column per cycle.

        Results at the edge of those with random inputs have an asterisk (`AT_EDGE`).
        """

        def marked(cycle: int, quantity: str) -> str:
            mark = " *" if self.at_edge(cycle, quantity) else ""
            return f"{self.text(cycle, quantity)}{mark}"

        return table_of(self.ranges.index.unique("cycle"), marked)

    def notes(self) -> list[str]:
        """Return the lines that explain marks of `table`, none if it has none."""
        return [AT_EDGE] if any(self.at_edge(*place) for place in self.ranges.index) else []

    def at_edge(self, cycle: int, quantity: str) -> bool:
        """Return whether all results of random inputs lie on one side of that of the joint."""
        drawn = self._drawn(cycle, quantity)
        best = self.ranges.loc[(cycle, quantity), "best"]
        aside = (drawn < best).all() or (drawn > best).all()
        return bool(len(drawn) and aside and self.modelled(cycle, quantity))

    def _drawn(self, cycle: int, quantity: str) -> pd.Series:
        """Return the known results of joints with random values of all sources."""
        of_all = self.results.source == ALL
        return self.results.loc[of_all & (self.results.cycle == cycle), quantity].dropna()

    def text(self, cycle: int, quantity: str) -> str:
        """Format a result of the joint and its range with equal decimals: "0.18 (0.13 to 0.24)".

        The text is `NOT_MODELLED` or `UNDETERMINED` for a result that the joint does not have.
        """
        if not self.modelled(cycle, quantity):
            return NOT_MODELLED
        row = self.ranges.loc[cycle, quantity]
        if quantity in FITTED and np.isnan(row.best):
            return UNDETERMINED
        first, low, high = range_texts(row.best, row.low, row.high)
        return f"{first} ({low} to {high})"

    def wider_title(self) -> str:
        """Return the title of `wider_table`, with the choices of the model that were changed."""
        return f"range with other choices of the model ({', '.join(self.choices)})"

    def wider_table(self) -> pd.DataFrame:
        """Return the table of ranges with other choices of the model as text, laid out as `table`.

        A text is empty if the result is not modelled or has no such range.
        """

        def text(cycle: int, quantity: str) -> str:
            """Format the wider range of a result, such as "0.10 to 0.31"."""
            row = self.ranges.loc[cycle, quantity]
            if not self.modelled(cycle, quantity) or np.isnan(row[WIDER].astype(float)).any():
                return ""
            return " to ".join(range_texts(row.best, *row[WIDER])[1:])

        return table_of(self.ranges.index.unique("cycle"), text)

    def modelled(self, cycle: int, quantity: str) -> bool:
        """Return whether the model gives a result of a cycle at all.

        This is so if the result of any variant exceeds the rounding of 0, or, for a residual
        closure, `UNRESOLVED` of the net closure. It is also taken as so if all variants failed.
        """
        rows = self.results[self.results.cycle == cycle].dropna(subset=quantity)
        least = UNRESOLVED * rows[CLOSURE_NET] if quantity == RESIDUAL_NET else ROUNDING
        return rows.empty or bool((rows[quantity].abs() > least).any())

    def about_shares(self) -> str:
        """Return the explanation of shares: what 100 % is, and why they may add to more."""
        others = " and other choices of the model" if self.choices else ""
        wider = (
            "of the range with other choices of the model, and not of the narrower one: "
            if self.choices
            else ""
        )
        return (
            f"{wider}100 % is the variance of the result over joints with random values of all "
            f"sources{others}; an interaction counts for each of its sources, so that shares may "
            "add to more than 100 %"
        )

    def undetermined_shares(self, cycle: int, quantity: str) -> list[str]:
        """Return the names of sources that move a result, but whose share was not found.

        Changed alone, such a source moves the result by more than `MOVES` of the width of its
        range, but its share is below `LEAST_SHARE`.
        """
        row = self.ranges.loc[cycle, quantity]
        shares = row.drop(NUMBERS).dropna().astype(float)
        ends = row[[*ENDS, *WIDER]].astype(float)
        least = MOVES * (ends.max() - ends.min())
        here = self.results[self.results.cycle == cycle]
        moves = (here[quantity] - row.best).abs().groupby(here.source).max()
        return [
            name
            for name, share in shares.items()
            if share < LEAST_SHARE and moves.get(name, 0.0) > max(least, ROUNDING)
        ]

    def share_text(self, cycle: int, quantity: str, name: str) -> str:
        """Format the share of the source ``name`` in a result, as "60 %" or "undetermined"."""
        if name in self.undetermined_shares(cycle, quantity):
            return UNDETERMINED
        return f"{100.0 * self.ranges.loc[(cycle, quantity), name]:.0f} %"

    def _random_joints(self) -> int:
        """Return how many joints with random values of all sources were simulated."""
        return int(self.results[self.results.source == ALL].value.nunique())

    def _shares_text(self, cycle: int, quantity: str) -> str:
        """Return the sources of the range of a result with their shares, as "registration 60 %".

        They are those of at least half a percent, and then those with an undetermined share.
        """
        shares = self.ranges.loc[cycle, quantity].drop(NUMBERS).dropna().astype(float)
        shown = shares[shares >= LEAST_SHARE].sort_values(ascending=False).index
        names = [*shown, *self.undetermined_shares(cycle, quantity)]
        return ", ".join(
            f"{TITLES[name]} {self.share_text(cycle, quantity, name)}" for name in names
        )


class _Answer(NamedTuple):
    """What is read of a simulated variant of a joint.

    ``rows`` are those of `Budget.results`, ``curves`` is its `stress_table`. ``differences`` are
    how far its first loading differs from that of the joint (`differences_of_loading`), and empty
    unless it is the variant with another rule of steps.
    """

    rows: pd.DataFrame
    curves: pd.DataFrame
    differences: dict[str, float]


def uncertainty_budget(
    joint: UncertainJoint,
    closed: xr.Dataset | None = None,
    on_variant: Callable[[float, str], None] = lambda share, variant: None,
    workers: int | None = None,
    at: Sequence[float] = (),
) -> Budget:
    """Simulate a joint and its variants, in threads, and return the uncertainty budget.

    ``closed`` is the history of the joint itself, which is simulated if it is not given, and must
    not have failed. Variants that fail are left out of the ranges. ``on_variant`` is called in the
    calling thread after each variant, with the finished share and the title of its source.
    ``workers`` is the largest number of variants that are simulated at the same time, by default
    the number of processors. ``at`` are stresses [Pa] that curves have besides round ones.
    """
    sources = joint.sources
    variants = [Variant("", "", joint.conditions), *joint.variants]
    closed = (
        simulate_walls(joint.upper, joint.lower, joint.conditions) if closed is None else closed
    )
    levels = history_of(closed).table_levels(at)
    known = stress_table(closed, levels)

    # a joint by the paper's steps is itself compared with resolved breakage
    by_paper = any(variant.source == OTHER_RULE for variant in variants)
    other_rule = OTHER_RULE if by_paper else "breakage"

    def answer_of(variant: Variant, going_on: StepReport) -> _Answer:
        """Simulate a variant and return what is read of it; NaN if it failed or was refused."""
        history = joint.simulated(variant, going_on) if variant.source else closed
        status = -1 if history is None else int(history.status)
        differences: dict[str, float] = {}
        if history is None or failed(history):
            rows = pd.DataFrame({"cycle": known.cycle.unique()})
            rows = rows.assign(**dict.fromkeys(RANGED_RESULTS, np.nan))
            curves = known[["cycle", "branch", "normal_stress_MPa"]]
        else:
            curves = known if history is closed else stress_table(history, levels)
            rows = results_of(history)
            if variant.source == other_rule:
                differences = differences_of_loading(closed, history)
        about = {"source": variant.source, "value": variant.value, "status": status}
        return _Answer(rows.assign(**about), curves.assign(source=variant.source), differences)

    answers = {}
    threads = threads_for(joint.cells, workers)
    for number, answer in in_threads(answer_of, variants, threads):
        answers[number], name = answer, variants[number].source
        on_variant(len(answers) / len(variants), TITLES.get(name, name or "joint"))
    in_order = [answers[number] for number in range(len(variants))]
    results = pd.concat([answer.rows for answer in in_order], ignore_index=True)
    curves = pd.concat([answer.curves for answer in in_order])
    differences: dict[str, float] = next(
        (answer.differences for answer in in_order if answer.differences), {}
    )
    upper, lower = joint.conditions.rock
    of_rock = [name for name in OF_ROCK if name in {*acting(upper), *acting(lower)}]
    omitted = tuple(name for name in ("registration", *of_rock) if name not in sources)
    positions = random_positions(sources, RANDOM_JOINTS, SEED)
    further_positions = random_positions(sources, FURTHER, FURTHER_SEED)
    # no change: joints that are simulated all have the second value of a shared source already,
    # and further joints vary it
    positions[:, [source.kind == SHARED for source in sources.values()]] = 0.5
    numerical = numerical_errors_of(results, largest_jump(closed), differences)
    limits = limits_of_error(numerical)
    varied = results[results.source != OTHER_RULE]
    varied_curves = curves[curves.source != OTHER_RULE]
    ranges = ranges_of(varied, sources, positions, further_positions, limits)
    bands = bands_of(varied_curves, sources, positions, further_positions, limits, ranges)
    return Budget(
        results, ranges, omitted, bands, _choices(sources), numerical, one_rock=upper == lower
    )


def _choices(sources: Mapping[str, Source]) -> tuple[str, ...]:
    """Describe the choices of the model that are changed in the wider range only, with values."""
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


def range_texts(best: float, low: float, high: float, figures: int = 2) -> list[str]:
    """Format a result and the ends of its range with equal decimals, as three texts.

    ``figures`` is the number of significant digits of the result. Values of up to `ROUNDING` count
    as 0.
    """
    values = [0.0 if abs(value) <= ROUNDING else value for value in (best, low, high)]
    return with_equal_decimals(values, figures)

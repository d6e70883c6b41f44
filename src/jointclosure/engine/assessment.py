"""Tables and sentences of an assessment, read from paired differences of its closures."""

import itertools
import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from jointclosure.joint.protocol import FAILURE, FLAGS, LARGEST_UNBREAKABLE_SHARE
from jointclosure.statistics.two_level import FEWEST, Interval, Plan, best_plan, t_interval
from jointclosure.storage.files import read_csv

CLOSURE = "max_closure_seated_net"
"""Closure by which copies of a joint are compared."""
JUDGED = (CLOSURE, "max_closure")
"""Closures to which a request applies: net since seating, and gross from first touch."""
ASSESSED = {
    CLOSURE: "net closure",
    "max_closure": "gross closure",
    "stiffness_net": "net stiffness",
    "mean_aperture_at_max": "aperture",
}
"""Quantities that are compared, and their short titles."""
REFINEMENT = 5.0
"""Tolerance of a resolved setting over that of the next finer one."""
FEATURES = ("unbreakable_share", "largest_jump", "broken_share", "contacts_at_max",
            "stress_over_strength", "spread")  # fmt: skip
"""Quantities by which joints are placed among the hard cases, and the spread of copies [1]."""
HARD_CASES = Path(__file__).with_name("hard_cases.csv")
"""Names and `FEATURES` of the hard cases that the study verification closed."""
_VERDICTS = ("not stable", "hard", "easy")
_EFFECT = "without "


class Assessment(NamedTuple):
    """What accuracy costs on a scene, how hard it is, and which effects it needs.

    Attributes
    ----------
    closures : DataFrame
        One row per variant, joint, copy of its walls and cycle: ``status``, processor ``seconds``,
        `ASSESSED` and `FEATURES` but the spread [SI], ``oracle_ratio``, and the ``error`` of walls
        that could not be closed.
    differences : DataFrame
        One row per variant, quantity of `ASSESSED` and cycle: the mean difference from the
        ``reference`` on the same walls over the mean of the reference, with its 95 % interval
        (``value``, ``low``, ``high`` [1]), and ``seconds`` of a joint. The reference of a setting
        of the numerics is the finest one, that of a scene without effects has all of them.
    hardness : DataFrame
        One row per joint, the worst first: ``verdict``, `FEATURES`, the ``nearest`` hard case and
        the ``distance`` to it, ``oracle_ratio``, and the ``reason`` of the verdict.
    sentences : tuple of str
        What follows for the request.
    within, budget : float
        Request [1], and time [s] or None.
    """

    closures: pd.DataFrame
    differences: pd.DataFrame
    hardness: pd.DataFrame
    sentences: tuple[str, ...]
    within: float
    budget: float | None = None

    @property
    def price(self) -> pd.DataFrame:
        """Seconds and difference from the finest setting (%), one row per setting."""
        return self._table(False, JUDGED)

    @property
    def effects(self) -> pd.DataFrame:
        """Seconds, changes (%), and verdict, one row per group of effects left out."""
        table = self._table(True, tuple(ASSESSED))
        return table.assign(verdict=[self.verdict(name) for name in table.index])

    def _table(self, without: bool, quantities: tuple[str, ...]) -> pd.DataFrame:
        """Format the differences of settings, or of scenes without effects."""
        rows: dict[str, dict[str, str]] = {}
        for row in self.differences.itertuples():
            if row.variant.startswith(_EFFECT) == without and row.quantity in quantities:
                shown = rows.setdefault(row.variant, {"seconds": f"{row.seconds:.2g}"})
                shown[f"{ASSESSED[row.quantity]} {row.cycle} (%)"] = percent_of(row)
        return pd.DataFrame.from_dict(rows, orient="index")

    def verdict(self, variant: str) -> str:
        """Say whether effects can be left out within the request, by `JUDGED` of all cycles."""
        if (self.closures[self.closures.variant == variant].status >= FAILURE).any():
            return "needed: fails"
        rows = self.differences[self.differences.variant == variant]
        inside = [
            interval_of(row).within(self.within)
            for row in rows[rows.quantity.isin(JUDGED)].dropna().itertuples()
        ]
        return (
            "needed" if False in inside else "not decided" if None in inside else "can be left out"
        )

    def __str__(self) -> str:
        effects = self.effects[[c for c in self.effects if not c.startswith(("gross", "aperture"))]]
        tables = [frame.to_string() for frame in (self.price, effects) if len(frame)]
        return "\n\n".join([*tables, "\n".join(f"- {line}" for line in self.sentences)])


def assessed(
    closures: pd.DataFrame, ladder: Sequence[str], stated: str, within: float, budget: float | None
) -> Assessment:
    """Make an assessment of its closures.

    ``ladder`` names the settings of the numerics, from the cheapest to the finest; ``stated`` is
    the variant as the scene is stated.
    """
    lone = len(closures.joint.unique()) == 1
    compared = closures if lone else closures[closures.copy_of_walls == "as it is"]
    differences = paired_differences(compared, ladder, stated)
    limits = limit_lines(compared, ladder, within)
    hardness = hardness_of(closures, ladder, stated, within)
    costs = (
        _of_joint(differences, ladder, within, budget)
        if lone
        else _of_mean(compared, ladder, within, budget)
    )
    worst = hardness.iloc[0]
    words = f"{'this joint' if lone else f'joint {worst.joint}'} is {worst.verdict}: {worst.reason}"
    if lone and worst.spread > within:
        words += f"; no setting answers a request below {100 * worst.spread:.2g} %"
    return Assessment(closures, differences, hardness, (*limits, costs, words), within, budget)


def paired_differences(closures: pd.DataFrame, ladder: Sequence[str], stated: str) -> pd.DataFrame:
    """Return `Assessment.differences`."""
    rows = []
    for variant, own in closures.groupby("variant", sort=False):
        reference = stated if str(variant).startswith(_EFFECT) else ladder[-1]
        about = {"variant": variant, "reference": reference, "seconds": own.seconds.mean()}
        if variant in ladder or reference == stated:
            rows += [
                about
                | {"quantity": name, "cycle": cycle}
                | _apart(closures, variant, reference, cycle, name)._asdict()
                for name in ASSESSED
                for cycle in sorted(closures.cycle.unique())
            ]
    return pd.DataFrame(rows)


def _values(closures: pd.DataFrame, variant: str, cycle: int, quantity: str) -> np.ndarray:
    """Return values (n,) of a variant in a cycle, by joint and copy."""
    rows = closures[(closures.variant == variant) & (closures.cycle == cycle)]
    return rows[quantity].to_numpy(dtype=float)


def _apart(closures: pd.DataFrame, variant, reference, cycle: int, quantity: str) -> Interval:
    """Return the relative difference of the means of two variants."""
    one, two = (_values(closures, name, cycle, quantity) for name in (variant, reference))
    known = np.isfinite(one) & np.isfinite(two)
    if not known.any():
        return Interval(math.nan, -math.inf, math.inf)
    return t_interval((one - two)[known] / two[known].mean())


def hardness_of(
    closures: pd.DataFrame, ladder: Sequence[str], stated: str, within: float
) -> pd.DataFrame:
    """Return `Assessment.hardness`; scenes without an effect do not count."""
    rows = []
    for joint, own in closures[~closures.variant.str.startswith(_EFFECT)].groupby("joint"):
        copies = own[own.variant == stated]
        features = features_of(own, stated, ladder[-1])
        nearest, distance = nearest_hard_case(features)
        share, judged = float(copies.unbreakable_share.max()), float(own.oracle_ratio.max())
        failed = own[~(own.status < FAILURE)]
        by_cycle = [f"{100 * x:.2g} % on cycle {n}" for n, x in spread_of(copies).items()]
        reason = (
            f"copies that must close alike scatter by {', '.join(by_cycle)} (easy: "
            f"{50 * within:.2g} %), {100 * share:.2g} % of its force is on contacts that cannot "
            f"break (easy: {100 * LARGEST_UNBREAKABLE_SHARE:.0f} %), the largest jump is "
            f"{100 * features['largest_jump']:.2g} % of its closure, and the hard case {nearest} "
            f"is nearest ({distance:.2g})"
        )
        hard = not features["spread"] <= 0.5 * within or share > LARGEST_UNBREAKABLE_SHARE
        verdict = "hard" if hard else "easy"
        if len(failed):
            first = failed.iloc[0]
            flags = (n for bit, n in FLAGS.items() if not first.error and int(first.status) & bit)
            reason = f"{first.variant} ({first.copy_of_walls}): {first.error or ', '.join(flags)}"
        elif judged > 1.0:
            reason = f"the independent implementation finds a state {judged:.2g} times beyond a "
            reason += "limit"
        verdict = "not stable" if len(failed) or judged > 1.0 else verdict
        row = {"joint": joint, "verdict": verdict} | features
        row |= {"nearest": nearest, "distance": distance, "oracle_ratio": judged}
        rows.append(row | {"reason": reason})
    return worst_first(pd.DataFrame(rows))


def worst_first(hardness: pd.DataFrame) -> pd.DataFrame:
    """Return joints in the order of their verdicts, and of the spread of their copies."""
    order = np.lexsort((-hardness.spread, hardness.verdict.map(_VERDICTS.index)))
    return hardness.iloc[order].reset_index(drop=True)


def spread_of(copies: pd.DataFrame) -> pd.Series:
    """Return the standard deviation of closure over the copies of a joint [1], by cycle."""
    values = copies.pivot_table(index="cycle", columns="copy_of_walls", values=CLOSURE)
    return values.std(axis=1) / values.mean(axis=1)


def features_of(closures: pd.DataFrame, stated: str, finest: str) -> dict[str, float]:
    """Return `FEATURES` of a joint: of its finest history, and the spread of the stated one."""
    fine = closures[(closures.variant == finest) & (closures.copy_of_walls == "as it is")]
    spread = spread_of(closures[closures.variant == stated]).max()
    return {name: float(fine[name].max()) for name in FEATURES[:-1]} | {"spread": float(spread)}


@cache
def _hard_cases() -> pd.DataFrame:
    return read_csv(HARD_CASES)


def nearest_hard_case(features: Mapping[str, float]) -> tuple[str, float]:
    """Return the hard case with the most similar features, and the distance to it.

    It is the root mean square, over the features, of the difference between the shares of hard
    cases that have less.
    """
    cases, apart = _hard_cases(), []
    for name in FEATURES:
        known = np.sort(cases[name].dropna())
        both = np.append(cases[name], features[name])
        below, upto = np.searchsorted(known, both), np.searchsorted(known, both, "right")
        less = np.where(np.isnan(both), np.nan, 0.5 * (below + upto))
        apart.append((less[:-1] - less[-1]) / known.size)
    comparable = np.isfinite(apart).any(axis=0)
    if not comparable.any():
        return "", math.nan
    distances = np.sqrt(np.nanmean(np.square(apart)[:, comparable], axis=0))
    return str(cases.name[comparable].iloc[distances.argmin()]), float(distances.min())


def limit_lines(closures: pd.DataFrame, ladder: Sequence[str], within: float) -> list[str]:
    """Say for each cycle whether differences shrink with the tolerance of resolved breakage."""
    lines = []
    for cycle in sorted(closures.cycle.unique()) if len(ladder) > 2 else ():
        lasts = {name: _apart(closures, ladder[-2], ladder[-1], cycle, name) for name in JUDGED}
        known = [name for name in JUDGED if math.isfinite(lasts[name].value)]
        judged = max(known, key=lambda name: lasts[name].most) if known else CLOSURE
        coarse, last = _apart(closures, ladder[-3], ladder[-2], cycle, judged), lasts[judged]
        limit = {
            True: "it has a limit within the request",
            False: "no limit was reached",
            None: "these joints do not show whether it has a limit within the request",
        }[last.within(within)]
        if coarse.within(0.0) is False and last.within(0.0) is False:
            order = math.log(abs(coarse.value / last.value)) / math.log(REFINEMENT)
            limit += f" (observed order {order:.2g})"
        change = f"{ASSESSED[judged]} with {ladder[-2]} from that with {ladder[-1]}: "
        change += f"{percent_of(last)} %"
        lines.append(f"cycle {cycle}, {change}: {limit}")
    return lines


def _of_joint(
    differences: pd.DataFrame, ladder: Sequence[str], within: float, budget: float | None
) -> str:
    """Say which setting a lone joint needs, or what the budget buys."""
    rows = differences[differences.variant.isin(ladder[:-1]) & differences.quantity.isin(JUDGED)]
    errors = rows.assign(error=rows[["low", "high"]].abs().max(axis=1))
    errors = errors.groupby("variant")[["seconds", "error"]].max()
    limit, column = (within, "error") if budget is None else (budget, "seconds")
    allowed = errors[errors[column] <= limit]
    finest = float(differences.seconds[differences.variant == ladder[-1]].iloc[0])
    takes = f"{ladder[-1]}, the finest setting, takes {finest:.2g} s of processor time"
    if budget is not None and allowed.empty:
        least = errors.seconds.min() if len(errors) else finest
        return f"budget = {budget:g} s: a joint takes at least {least:.2g} s; {takes}"
    if budget is not None and budget >= finest:
        return f"budget = {budget:g} s: suffices for all settings; {takes}"
    if allowed.empty:
        return f"no cheaper setting is within {100 * within:g} % of the finest; {takes}"
    row = allowed.loc[(allowed.seconds if budget is None else allowed.error).idxmin()]
    return f"{row.name} is within {100 * row.error:.2g} % and takes {row.seconds:.2g} s; {takes}"


def _of_mean(
    closures: pd.DataFrame, ladder: Sequence[str], within: float, budget: float | None
) -> str:
    """Say how many joints a mean takes to be within the request, or what the budget buys."""
    plans: dict[str, Plan] = {}
    seconds = closures.groupby("variant").seconds.mean()
    finest = ladder[-1]
    for name in ladder:
        both = float(seconds[name] + seconds[finest]) if name != finest else 0.0
        plans_of_closures: list[Plan | None] = []
        for cycle, judged in itertools.product(closures.cycle.unique(), JUDGED):
            cheap, best = (_values(closures, v, cycle, judged) for v in (name, finest))
            known = np.isfinite(cheap) & np.isfinite(best)
            cheap, best = cheap[known], best[known]
            if best.size < 2:
                continue
            first, second = (float(np.std(v, ddof=1) / best.mean()) for v in (cheap, best - cheap))
            plan = best_plan((first, second), (float(seconds[name]), both), within, budget)
            plans_of_closures.append(plan)
        possible = [plan for plan in plans_of_closures if plan]
        if possible and None not in plans_of_closures:
            plans[name] = max(possible, key=lambda plan: (plan.seconds, plan.half_width))
    if not plans and budget is None:
        return f"no mean can be planned, as fewer than two joints closed with {finest}"
    if not plans:
        least = FEWEST * float(seconds[finest])
        return f"budget = {budget:g} s: buys no mean, which takes at least {least:.2g} s"
    of = "seconds" if budget is None else "half_width"
    name = min(plans, key=lambda name: getattr(plans[name], of))
    plan = plans[name]
    further = f", {plan.differences} of them with {finest} too" if name != finest else ""
    halves = []
    for cycle in sorted(closures.cycle.unique()):
        of_cycle = (_values(closures, finest, cycle, name) for name in JUDGED)
        means = [t_interval(known) for x in of_cycle if (known := x[np.isfinite(x)]).size]
        half = max(mean.high / mean.value - 1.0 for mean in means)
        halves.append(f"{100 * half:.2g} % on cycle {cycle}")
    known = ", ".join(halves)
    return (
        f"a mean within {100 * plan.half_width:.2g} % of the finest setting takes {plan.joints} "
        f"joints with {name}{further}: {plan.seconds:.3g} s of processor time (deviations of "
        f"{len(closures.joint.unique())} joints; their mean is known to {known})"
    )


def interval_of(row: Any) -> Interval:
    """Return the interval of a row of `Assessment.differences`."""
    return Interval(row.value, row.low, row.high)


def percent_of(row: Any) -> str:
    """Format an interval of relative differences in percent, without the sign of percent."""
    value, low, high = (f"{float(f'{100 * v:.2g}'):+g}" for v in (row.value, row.low, row.high))
    return f"{value} ({low} to {high})" if math.isfinite(row.low) else value

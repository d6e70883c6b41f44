"""Results of an assessment: differences between variants, limits of errors, and verdicts.

All results are read from the differences between variants on the same walls. A lone joint is
compared on its copies, whose scatter is that of the order of breakage; several joints are compared
as they are.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from jointclosure.assessment.assessed_results import (
    ASSESSED,
    CLOSURE,
    JUDGED,
    LIMITED,
    STIFFNESS,
)
from jointclosure.assessment.effect_names import effects_of, lacks_effects
from jointclosure.assessment.finest_error import log_error_of_finest
from jointclosure.assessment.hardness import (
    MEANINGS,
    features_of,
    nearest_hard_case,
    spread_of,
    worst_first,
)
from jointclosure.assessment.numerical_settings import LADDER, REFINEMENT
from jointclosure.assessment.verdicts import (
    CAN_BE_LEFT_OUT,
    GIVEN_UP,
    KEPT_UNTESTED,
    NEEDED_AS_FAILS,
    is_given_up,
    results_beyond,
    verdict_on_effects,
)
from jointclosure.joint.status import (
    FAILURE,
    FLAGS,
    LARGEST_UNBREAKABLE_SHARE,
)
from jointclosure.statistics.number_texts import percent, percent_number, with_equal_decimals
from jointclosure.statistics.two_level import (
    FEWEST_DIFFERENCES,
    Interval,
    Plan,
    best_plan,
    change_interval,
    t_interval,
)
from jointclosure.uncertainty.numerical_error import NOT_STABLE

_LINE_WIDTH = 120
"""Characters of a line of tables in text: wider ones continue below."""
LEAST_ORDER = 0.2
"""Least observed order that is stated. With a smaller one a tolerance of a fifth has an error of
more than 0.7 times as much: the errors do not decrease."""
_IN_WORDS = {
    CAN_BE_LEFT_OUT: "may be left out, each of these groups alone",
    "needed": "must be kept",
    NEEDED_AS_FAILS: "must be kept",
    "not decided": "are not decided",
    GIVEN_UP: f"are kept, as {KEPT_UNTESTED}",
}
"""Verdicts on effects in the words of a sentence."""


@dataclass(frozen=True, eq=False)
class Assessment:
    """What accuracy costs on a scene, how hard it is, and which effects it needs.

    Attributes
    ----------
    closures : DataFrame
        One row per variant, joint, copy of its walls and cycle: ``status``, processor ``seconds``,
        `ASSESSED` and `FEATURES` but the spread [SI], ``oracle_ratio``, and the ``error`` of walls
        that could not be simulated.
    ladder : list of str
        Settings of the numerics, from the cheapest to the finest.
    stated : str
        Variant as the scene is stated.
    within, budget : float
        Request [1], and time [s] or None.
    """

    closures: pd.DataFrame
    ladder: Sequence[str]
    stated: str
    within: float
    budget: float | None = None

    @cached_property
    def differences(self) -> pd.DataFrame:
        """Mean difference of each variant from its ``reference`` on the same walls, over its mean.

        One row for each variant, quantity of `ASSESSED` and cycle: the difference with its 95 %
        interval (``value``, ``low``, ``high`` [1]), and the ``seconds`` of a joint.
        """
        names = ["variant", "reference", "seconds", "quantity", "cycle", *Interval._fields]
        rows = []
        every = itertools.product(self._seconds.items(), ASSESSED, self._cycles)
        for (variant, seconds), quantity, cycle in every:
            reference = self.ladder[-1] if variant in self.ladder else self.stated
            apart = self._apart((variant, reference), cycle, quantity)
            rows.append((variant, reference, seconds, quantity, cycle, *apart))
        return pd.DataFrame(rows, columns=names)

    @cached_property
    def hardness(self) -> pd.DataFrame:
        """Verdict on each joint, the worst first: ``verdict``, ``reason``, and numbers behind it.

        These are `FEATURES`, by the finest setting; only ``unbreakable_share`` is that of the
        stated variant, the largest of all copies. Further columns are the ``nearest`` hard case,
        the ``distance`` to it, and ``oracle_ratio``.
        """
        of_scene = self.closures[~lacks_effects(self.closures.variant)]
        rows = [{"joint": joint} | self._hardness(own) for joint, own in of_scene.groupby("joint")]
        return worst_first(pd.DataFrame(rows))

    @property
    def sentences(self) -> list[str]:
        """Conclusions in words: convergence, limits of errors, and hardness."""
        worst = self.hardness.iloc[0]
        count = self.closures.joint.nunique()
        subject = f"of {count} joints the hardest (number {worst.joint}, from 0)"
        if self._lone:
            subject = "this joint"
        words = f"{subject} is {worst.verdict} ({MEANINGS[worst.verdict]}): {worst.reason}"
        return [*self._convergence(), self._of_joint() if self._lone else self._of_mean(), words]

    @cached_property
    def limits(self) -> pd.DataFrame:
        """Limits of the numerical errors of a lone joint, which about nine in ten joints keep.

        One row for each setting (``variant``), ``quantity`` of `LIMITED` and ``cycle``. The
        ``limit`` [1] is a relative error, by which the result may be multiplied or divided: that of
        the finest setting (`log_error_of_finest`), and for other settings also the largest
        difference of a copy from the mean of the copies by the finest setting. It is NaN where
        copies have no such result. Several joints, and joints without breakage, which have one
        setting, have no limits.
        """
        rows = []
        finest = self.ladder[-1]
        for known in self.known_of_finest.itertuples():
            of_result = known.quantity, known.cycle
            least = log_error_of_finest(known.scatter, known.change, known.jump, *of_result)
            middle = self._logs_of_copies(finest, *of_result).mean()
            for name in self.ladder:
                apart = np.abs(self._logs_of_copies(name, *of_result) - middle).max()
                total = least if name == finest else least + float(apart)
                rows.append((name, *of_result, math.expm1(total)))
        return pd.DataFrame(rows, columns=["variant", "quantity", "cycle", "limit"])

    @property
    def known_of_finest(self) -> pd.DataFrame:
        """What `log_error_of_finest` needs of a lone joint.

        One row for each ``quantity`` of `LIMITED` and ``cycle``: ``scatter``, ``change`` and
        ``jump`` [1]. Empty where there are no `limits`.
        """
        rows = []
        if self._lone and len(self.ladder) > 1:
            *others, finest = self.ladder
            # a stated setting between those of the ladder is too close to the finest one
            coarse = [name for name in others if name != self.stated or name in LADDER][-1]
            jump = float(self.hardness.largest_jump[0])
            for quantity, cycle in itertools.product(LIMITED, self._cycles):
                both = [self._logs_of_copies(name, quantity, cycle) for name in (coarse, finest)]
                change = both[0].mean() - both[1].mean()
                scatter = np.sqrt(np.mean([logs.var(ddof=1) for logs in both]))
                rows.append((quantity, cycle, float(scatter), float(change), jump))
        return pd.DataFrame(rows, columns=["quantity", "cycle", "scatter", "change", "jump"])

    @property
    def price(self) -> pd.DataFrame:
        """Seconds of each setting, differences from the finest one, and limits of errors (%).

        The differences are those of closures and net stiffness, by cycle. The limits, of a lone
        joint, are the largest of net and gross closures, and of net stiffnesses, of all cycles.
        Seconds have the shortest and the longest time of the joints or copies in brackets.
        """
        table = self._table(False, LIMITED)
        if len(self.limits):
            both = (("closures", JUDGED), ("stiffness", (STIFFNESS,)))
            for place, (title, quantities) in enumerate(both, start=1):
                largest = self._largest_limits(quantities)
                texts = [percent_number(100.0 * largest[name]) for name in table.index]
                table.insert(place, f"limit of error, {title} (%)", texts)
        return table

    @property
    def effects(self) -> pd.DataFrame:
        """Seconds, changes (%), and verdict, one row per group of effects left out.

        ``over all effects`` is the time relative to that of the joint with all effects, and
        ``needed by`` names the results that make effects needed, see `needed_by`.
        """
        table = self._table(True, tuple(ASSESSED))
        columns = {"verdict": self.verdict, "needed by": self.needed_by}
        table = table.assign(**{name: list(map(of, table.index)) for name, of in columns.items()})
        time = self._seconds / self._seconds[self.stated]
        table.insert(1, "over all effects", [f"{time[name]:.2g}" for name in table.index])
        return table

    def _table(self, of_effects: bool, quantities: tuple[str, ...]) -> pd.DataFrame:
        """Format the differences of settings, or of scenes without effects."""
        rows: dict[str, dict[str, str]] = {}
        asked = lacks_effects(self.differences.variant) == of_effects
        asked &= self.differences.quantity.isin(quantities)
        for row in self.differences[asked].itertuples():
            shown = rows.setdefault(row.variant, {"seconds": self._seconds_text(row.variant)})
            text = "reference" if row.variant == row.reference else percent_of(row)
            shown[f"{ASSESSED[row.quantity]} {row.cycle} (%)"] = text
        return pd.DataFrame.from_dict(rows, orient="index")

    def verdict(self, variant: str) -> str:
        """Return whether effects can be left out within the request, by `JUDGED` of all cycles."""
        statuses = self.closures[self.closures.variant == variant].status
        if is_given_up(statuses).any():
            return GIVEN_UP
        if (statuses >= FAILURE).any():
            return NEEDED_AS_FAILS
        rows = self.differences[self.differences.variant == variant]
        return verdict_on_effects(rows, self.within)

    def needed_by(self, variant: str) -> str:
        """Return which results leave the request without effects, see `results_beyond`.

        If joints fail without them, it is their status in words. It is "" of effects that are kept
        without a test, whose other joints alone have results.
        """
        verdict = self.verdict(variant)
        if verdict == GIVEN_UP:
            return ""
        if verdict == NEEDED_AS_FAILS:
            statuses = self.closures.status[self.closures.variant == variant].dropna().astype(int)
            return ", ".join(n for bit, n in FLAGS.items() if (statuses & bit).any())
        return results_beyond(self.differences[self.differences.variant == variant], self.within)

    def __str__(self) -> str:
        effects = self.effects.filter(regex="^(?!net st|aperture|needed)")
        columns = [frame.T for frame in (self.price, effects) if len(frame)]
        tables = [frame.to_string(line_width=_LINE_WIDTH) for frame in columns]
        lines = "\n".join(f"- {line}" for line in [*self.sentences, *self._reasons_of_effects])
        return "\n\n".join([self.about_intervals, *tables, lines, self.conclusion])

    @property
    def _reasons_of_effects(self) -> list[str]:
        """Say of each group of effects that is needed which results show it."""
        lines = []
        for name, shown in self.effects["needed by"].items():
            fails = self.verdict(str(name)) == NEEDED_AS_FAILS
            words = "the simulation fails" if fails else "these change by more than the request"
            lines += [f"{name} {words}: {shown}"] if shown else []
        return lines

    def _seconds_text(self, variant: str) -> str:
        """Format the mean time of a joint, and the shortest and the longest."""
        times = self._compared[self._compared.variant == variant].seconds
        low, mean, high = (f"{time:.2g}" for time in (times.min(), times.mean(), times.max()))
        return mean if low == high else f"{mean} ({low} to {high})"

    @property
    def about_intervals(self) -> str:
        """Say what the differences in the tables are from, and what their brackets are."""
        of = "copies of this joint, which should be equal" if self._lone else "the joints"
        words = (
            "Differences are from the finest setting, or from the joint with all effects. Brackets "
            f"have 95 % intervals, from the scatter of {of}."
        )
        words += (
            " Net closure counts from the seating stress, and gross closure from first touch. Net "
            "chord stiffness is the slope of net closure from half of the maximum stress on."
        )
        if self._lone:
            words += (
                " A difference without brackets is equal on all copies, which does not say how "
                "well it is known."
            )
        if len(self.limits):
            words += (
                " About nine in ten joints keep the limits of errors, which contain that of the "
                "finest setting and are the largest of all cycles."
            )
        return words

    @property
    def conclusion(self) -> str:
        """State the cheapest setting that meets the request, and the effects that are needed."""
        asked = f"the request of {100 * self.within:g} %"
        if self.budget is not None:
            asked = f"the budget of {self.budget:g} s"
        if self.hardness.verdict[0] == "not stable":
            setting = f"no setting meets {asked}, because a joint is not stable"
        else:
            setting = self._best_for_joint(asked) if self._lone else self._best_for_mean(asked)
        names = self._seconds.index.to_series()
        groups: dict[str, list[str]] = {}
        for variant in names[lacks_effects(names)]:
            groups.setdefault(_IN_WORDS[self.verdict(variant)], []).append(effects_of(variant))
        verdicts = [f"Effects that {words}: {'; '.join(groups[words])}." for words in groups]
        return " ".join([f"Conclusion: {setting}.", *verdicts])

    def _best_for_joint(self, asked: str) -> str:
        """Name the setting by which a lone joint meets what is asked, with its error and time."""
        seconds = self._seconds
        reached = self._reached
        budget = self.budget
        limited, limit = (reached, self.within) if budget is None else (seconds, budget)
        allowed = [n for n in self.ladder if math.isfinite(reached[n]) and limited[n] <= limit]
        if not allowed and budget is None:
            least = min(reached, key=lambda name: reached[name])
            return (
                f"no setting is shown to meet {asked}; the least limit has {least}: "
                f"{self._error_of(least)}; {self._remedy}"
            )
        if not allowed:
            least_time = float(seconds[list(self.ladder)].min())
            return f"no setting meets {asked}, as a joint takes at least {least_time:.2g} s"
        name = min(allowed, key=lambda n: seconds[n] if budget is None else reached[n])
        best = "cheapest" if budget is None else "most accurate"
        return (
            f"the {best} setting that meets {asked} is {name}; {self._error_of(name)}, and it "
            f"takes {seconds[name]:.2g} s of processor time"
        )

    def _error_of(self, name: str) -> str:
        """Say how large the errors of a lone joint by a setting may be."""
        if not len(self.limits):
            return f"its copies scatter by {percent(self._spread_of_copies[name])}"
        stiffness = self._largest_limits((STIFFNESS,))[name]
        of_stiffness = (
            f"{percent(stiffness)} for net stiffnesses"
            if math.isfinite(stiffness)
            else "none is known for net stiffnesses"
        )
        return (
            f"limits of the error are {percent(self._reached[name])} for net and gross closures, "
            f"and {of_stiffness} (about nine in ten joints keep such limits)"
        )

    @property
    def _remedy(self) -> str:
        """Say what may give a lone joint a smaller limit, or why nothing does."""
        finest = self.ladder[-1]
        if self._spread_of_copies[finest] > self.within:
            return (
                "its copies, which should be equal, scatter more than the request, because the "
                "model does not determine the order of breakage"
            )
        return "a stated tolerance below that of the finest setting may have a smaller limit"

    def _best_for_mean(self, asked: str) -> str:
        """Name the setting by which a mean meets what is asked, with its error and time."""
        if (best := self._best_plan) is None:
            return f"no setting meets {asked}"
        name, plan = best
        kind = "cheapest" if self.budget is None else "most accurate"
        finest = self.ladder[-1]
        error = f"its mean closures differ from those of {finest} by up to"
        if name == finest:
            error = "the half-width of its 95 % intervals is up to"
        return (
            f"the {kind} setting whose mean meets {asked} is {name}; {error} "
            f"{percent(plan.half_width)} with {plan.joints} joints, which take "
            f"{plan.seconds:.3g} s of processor time. The error of {finest} itself is not known"
        )

    @property
    def _lone(self) -> bool:
        return len(self.closures.joint.unique()) == 1

    @cached_property
    def _compared(self) -> pd.DataFrame:
        """Rows of `closures` that are compared: a lone joint with its copies, or several joints."""
        as_they_are = self.closures[self.closures.copy_of_walls == "as it is"]
        return self.closures if self._lone else as_they_are

    @cached_property
    def _seconds(self) -> pd.Series:
        """Mean processor time of a joint [s] by variant: settings first, then left-out effects."""
        means = self._compared.groupby("variant", sort=False).seconds.mean()
        return means[[*self.ladder, *means.index.difference(self.ladder, sort=False)]]

    @property
    def _cycles(self) -> list[int]:
        return sorted(self._compared.cycle.unique())

    def _paired(
        self, variants: Sequence[str], cycle: int, quantity: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return values (n,) of two variants in a cycle, of the walls on which both succeeded."""
        rows = self._compared[self._compared.cycle == cycle]
        one, two = (rows.loc[rows.variant == name, quantity].to_numpy(float) for name in variants)
        known = np.isfinite(one) & np.isfinite(two)
        return one[known], two[known]

    def _apart(self, variants: Sequence[str], cycle: int, quantity: str) -> Interval:
        """Return the relative difference of the means of two variants, with its interval."""
        one, two = self._paired(variants, cycle, quantity)
        if not one.size:
            return Interval(math.nan, -math.inf, math.inf)
        return change_interval((one - two) / two.mean())

    def _hardness(self, own: pd.DataFrame) -> dict[str, Any]:
        """Return a row of `hardness` from the rows of `closures` of a joint."""
        copies = own[own.variant == self.stated]
        features = features_of(own, self.stated, self.ladder[-1])
        scatter = self._scatter_by_cycle(own)
        nearest, distance = nearest_hard_case(features)
        share = float(copies.unbreakable_share.max())
        judged = float(own.oracle_ratio.max())
        failed = own[~(own.status < FAILURE)]
        verdict = "not stable"
        if len(failed):
            first = failed.iloc[0]
            flags = (n for bit, n in FLAGS.items() if not first.error and int(first.status) & bit)
            reason = f"{first.variant} ({first.copy_of_walls}): {first.error or ', '.join(flags)}"
        elif judged > 1.0:
            found = f"a state {judged:.2g} times beyond a limit"
            reason = f"the independent implementation finds {found}"
        elif scatter.max() > NOT_STABLE:
            reason = (
                f"net closures of equal copies scatter by {percent(scatter.max())} (not "
                f"stable: more than {100 * NOT_STABLE:.0f} %)"
            )
        else:
            agrees = scatter.max() <= 0.5 * self.within
            jumps = features["largest_jump"] > self.within
            easy = agrees and not jumps and share <= LARGEST_UNBREAKABLE_SHARE
            verdict = "easy" if easy else "hard"
            spreads = (f"{percent(x)} on cycle {n}" for n, x in scatter.items())
            reason = (
                f"net closures of equal copies scatter by {', '.join(spreads)} (easy: "
                f"{50 * self.within:.2g} %), {percent(share)} of its force is on contacts that "
                f"cannot break (easy: {100 * LARGEST_UNBREAKABLE_SHARE:.0f} %), and the largest "
                f"jump is {percent(features['largest_jump'])} of its closure (easy: "
                f"{100 * self.within:.2g} %)"
            )
        row = {"verdict": verdict} | features | {"unbreakable_share": share, "nearest": nearest}
        return row | {"distance": distance, "oracle_ratio": judged, "reason": reason}

    def _scatter_by_cycle(self, own: pd.DataFrame) -> pd.Series:
        """Return the scatter of copies by cycle [1]: the largest of the stated and finer settings.

        ``own`` are the rows of `closures` of a joint.
        """
        fine = self.ladder[self.ladder.index(self.stated) :]
        by_setting = [spread_of(own[own.variant == name]) for name in fine]
        return pd.concat(by_setting, axis=1).max(axis=1)

    def _convergence(self) -> list[str]:
        """Describe for each cycle whether closures converge for ever finer resolved breakage."""
        lines = []
        ladder = self.ladder
        for cycle in self._cycles if len(ladder) > 2 else ():
            lasts = {name: self._apart(ladder[-2:], cycle, name) for name in JUDGED}
            known = [name for name in JUDGED if math.isfinite(lasts[name].value)]
            judged = max(known, key=lambda name: lasts[name].most) if known else CLOSURE
            coarse = self._apart(ladder[-3:-1], cycle, judged)
            last = lasts[judged]
            converges = last.within(self.within)
            if converges and self._lone and self._reached[ladder[-1]] > self.within:
                converges = None  # copies may agree although their error is larger
            found = {
                True: "it converges within the request",
                False: "it does not converge within the request",
                None: "whether it converges within the request is not shown",
            }[converges]
            if coarse.within(0.0) is False and last.within(0.0) is False:
                order = math.log(abs(coarse.value / last.value)) / math.log(REFINEMENT)
                found += (
                    f" (observed order {order:.2g})"
                    if order >= LEAST_ORDER
                    else f" (from {ladder[-3]} to {ladder[-2]} it changes hardly more, or less)"
                )
            lines.append(
                f"cycle {cycle}: the {ASSESSED[judged]} with {ladder[-2]} differs from that with "
                f"{ladder[-1]} by {percent_of(last)} %: {found}"
            )
        return lines

    def _of_joint(self) -> str:
        """Describe the errors of a lone joint by the finest setting, and what is not possible."""
        finest = self.ladder[-1]
        budget = self.budget
        seconds = self._seconds
        scatter = self._spread_of_copies[finest]
        if not math.isfinite(scatter):
            return f"no error can be stated, because copies failed with {finest}"
        if budget is not None and budget < (least := float(seconds[list(self.ladder)].min())):
            return f"budget = {budget:g} s: a joint takes at least {least:.2g} s"
        takes = f"it takes {seconds[finest]:.2g} s of processor time"
        if len(self.ladder) == 1:
            only = "a joint without breakage has no setting that limits its accuracy"
            return f"{only}: its copies scatter by {percent(scatter)}, and {takes}"
        return (
            f"by {finest}, the finest setting, {self._error_of(finest)}; net and gross closures of "
            f"its copies scatter by up to {percent(scatter)}, and {takes}"
        )

    def _logs_of_copies(self, variant: str, quantity: str, cycle: int) -> np.ndarray:
        """Return logarithms of a result of all copies (n,), NaN where it is not positive."""
        rows = self.closures[(self.closures.variant == variant) & (self.closures.cycle == cycle)]
        values = rows[quantity].to_numpy(float)
        return np.log(values, out=np.full(values.shape, math.nan), where=values > 0.0)

    def _largest_limits(self, quantities: Sequence[str]) -> pd.Series:
        """Return the largest limits of results [1] by setting, infinite if one is not known."""
        rows = self.limits[self.limits.quantity.isin(quantities)].fillna({"limit": math.inf})
        return rows.groupby("variant").limit.max()

    @property
    def _reached(self) -> Mapping[str, float]:
        """Largest limits of the errors of closures of a lone joint [1] by setting.

        Those of a joint without breakage are the scatter of its copies.
        """
        if not len(self.limits):
            return self._spread_of_copies
        return dict(self._largest_limits(JUDGED)[list(self.ladder)])

    @property
    def _spread_of_copies(self) -> dict[str, float]:
        """Largest relative deviation among copies of a lone joint [1], by setting."""
        settings = ((name, self.closures[self.closures.variant == name]) for name in self.ladder)
        return {
            name: max(float(spread_of(rows, judged).max()) for judged in JUDGED)
            for name, rows in settings
        }

    def _of_mean(self) -> str:
        """Describe how many joints a mean within the request takes, or what a budget allows."""
        finest = self.ladder[-1]
        budget = self.budget
        best = self._best_plan
        if best is None and budget is None:
            return f"no mean can be planned, as fewer than two joints succeeded with {finest}"
        if best is None:
            least = FEWEST_DIFFERENCES * float(self._seconds[finest])
            return f"budget = {budget:g} s: buys no mean, which takes at least {least:.2g} s"
        name, plan = best
        halves = []
        further = f", {plan.differences} of them with {finest} too" if name != finest else ""
        for cycle in self._cycles:
            closed = (self._paired((finest, finest), cycle, judged)[0] for judged in JUDGED)
            means = [t_interval(values) for values in closed if values.size]
            half = max(mean.high / mean.value - 1.0 for mean in means)
            halves.append(f"{percent(half)} on cycle {cycle}")
        return (
            f"a mean within {percent(plan.half_width)} of the finest setting takes "
            f"{plan.joints} joints with {name}{further}: {plan.seconds:.3g} s of processor time "
            f"(deviations of {self.closures.joint.nunique()} joints; their mean is known to "
            f"{', '.join(halves)})"
        )

    @property
    def _best_plan(self) -> tuple[str, Plan] | None:
        """Setting with the cheapest plan, or with the most accurate one within a budget."""
        plans = {name: plan for name in self.ladder if (plan := self._plan(name))}
        of = "seconds" if self.budget is None else "half_width"
        return min(plans.items(), key=lambda each: getattr(each[1], of), default=None)

    def _plan(self, name: str) -> Plan | None:
        """Return the plan of a mean with a setting that suffices for all judged closures.

        It is None if there is none for one of them.
        """
        finest = self.ladder[-1]
        plans = list[Plan | None]()
        cost = float(self._seconds[name])
        both = cost + float(self._seconds[finest]) if name != finest else 0.0
        for at in itertools.product(self._cycles, JUDGED):
            cheap, best = self._paired((name, finest), *at)
            if best.size > 1:
                first, second = (
                    float(np.std(v, ddof=1) / best.mean()) for v in (cheap, best - cheap)
                )
                plans.append(best_plan((first, second), (cost, both), self.within, self.budget))
        possible = [plan for plan in plans if plan]
        if len(possible) < max(1, len(plans)):
            return None
        return max(possible, key=lambda plan: (plan.seconds, plan.half_width))


_LEAST_WIDTH = 0.01
"""Width of an interval [%] below which a difference has no interval, as copies are equal."""


def percent_of(row: Any) -> str:
    """Format an interval of relative differences in percent, without the percent sign."""
    if math.isnan(row.value):
        return "no value"
    if not math.isfinite(row.low):
        return f"{float(f'{100 * row.value:.2g}'):+g}"
    percents = [100 * number for number in (row.value, row.low, row.high)]
    if percents[2] - percents[1] < _LEAST_WIDTH:  # copies break in the same order
        return f"{percents[0]:+.2g}" if abs(percents[0]) >= _LEAST_WIDTH else "0.00"
    ends = with_equal_decimals(percents)
    value, low, high = (end if end.startswith("-") or not float(end) else f"+{end}" for end in ends)
    return f"{value} ({low} to {high})"

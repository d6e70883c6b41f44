"""Assessment of a scene: what accuracy costs on it, how hard it is, and which effects it needs.

The same walls are simulated with variants of the scene: with other numerics, without an effect, and
as copies whose results would be equal but for the order of breakage. All results are read from the
differences between variants on the same walls. A lone joint is compared on its copies, whose
scatter is that of the order of breakage; several joints are compared as they are.
"""

import itertools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pandas as pd

from jointclosure.assessment.assessed_results import (
    ASSESSED,
    CLOSURE,
    JUDGED,
    LIMITED,
    STIFFNESS,
)
from jointclosure.assessment.effect_names import effects_of, lacks_effects, without
from jointclosure.assessment.finest_error import log_error_of_finest
from jointclosure.compilation.code_digests import code_digest
from jointclosure.ensembles.simulation import Reading, simulate_row
from jointclosure.execution.workers import Failed, in_processes, number_of_workers
from jointclosure.inputs import InputError, check_below
from jointclosure.joint.checked_conditions import CheckedConditions, on_grid
from jointclosure.joint.conditions import (
    SCAN_DEFAULTS,
    Changes,
    Conditions,
    conditions_from,
    takes_scans,
)
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.joint.status import (
    BREAKAGE_NOT_AT_REST,
    FAILURE,
    FLAGS,
    LARGEST_UNBREAKABLE_SHARE,
)
from jointclosure.joint.wall_checks import checked_walls
from jointclosure.joint.warmup import prepare_kernels
from jointclosure.parameters import RESOLVED, Numerics
from jointclosure.statistics.number_texts import percent, with_equal_decimals
from jointclosure.statistics.two_level import (
    FEWEST_DIFFERENCES,
    Interval,
    Plan,
    best_plan,
    change_interval,
    t_interval,
)
from jointclosure.storage.files import digest, read_csv
from jointclosure.uncertainty.numerical_error import NOT_STABLE
from jointclosure.uncertainty.sources import coarser
from jointclosure.uncertainty.variants import COPIES
from jointclosure.walls import Walls
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.wall_files import registered_walls

REFINEMENT = 5.0  # tolerance of a resolved setting over that of the next finer one
LEAST_ORDER = 0.2
"""Least observed order that is stated. With a smaller one a tolerance of a fifth has an error of
more than 0.7 times as much: the errors do not decrease."""
FEATURES = ("unbreakable_share", "largest_jump", "broken_share", "contacts_at_max",
            "stress_over_strength", "spread")  # fmt: skip
"""Quantities by which a joint is compared with the hard cases, and the spread of its copies [1]."""
HARD_CASES = Path(__file__).with_name("hard_cases.csv")
"""Names, difficulties and `FEATURES` of the hard cases that the study verification simulated."""
_MEANINGS = {
    "not stable": "no closure of it can be stated",
    "hard": "the order of breakage changes its closure, its closure jumps, or contacts that cannot "
    "break carry it",
    "easy": "net closures of its copies agree, its closure hardly jumps and its contacts can break",
}
"""Verdicts on a joint, the worst first, in words."""
NEEDED_AS_FAILS = "needed: fails"
"""Verdict on effects without which a joint fails."""
GIVEN_UP = "not tested: too long"
"""Verdict on effects without which a joint exceeds `MOST_BREAKAGE_STEPS`."""
_IN_WORDS = {
    "can be left out": "may be left out",
    "needed": "must be kept",
    NEEDED_AS_FAILS: "must be kept",
    "not decided": "are not decided",
    GIVEN_UP: "were not tested",
}
"""Verdicts on effects in the words of a sentence."""
MOST_BREAKAGE_STEPS = 2e4
"""Breakage steps, over the number of cells, after which a joint without an effect is given up.

That is half a minute for 100 x 100 cells. Most joints with all effects need 10 to 1000. Without
interaction, joints of weak rock can need 300 000, as their gouge then breaks again and again.
"""
_VERDICTS = tuple(_MEANINGS)
DROPS = (
    ("gouge",),
    ("breakage", "gouge"),
    ("interaction",),
    ("substrate", "interaction"),
    ("soft_peaks",),
)
"""Effects that are left out together."""
READ = (*ASSESSED, *FEATURES[:-1], "status", "timing_simulation", "oracle_ratio")
"""Quantities that are read from every simulation; the last one only from walls as they are."""


def named(numerics: Numerics) -> str:
    """Return the name of resolved breakage as a setting."""
    return f"tolerance {numerics.tolerance:g}"


def ladder_about(middle: Numerics) -> dict[str, Numerics]:
    """Return settings of the numerics, from the cheapest to the finest.

    They are the paper's steps, and five times, once and a fifth of the tolerance of ``middle``.
    """
    resolved = (coarser(middle, REFINEMENT**power) for power in (1, 0, -1))
    return {"the paper's steps": Numerics()} | {named(numerics): numerics for numerics in resolved}


LADDER = ladder_about(RESOLVED)
"""Settings of the numerics that are compared, unless the scene states a finer one."""
FINEST = list(LADDER.values())[-1]


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
        subject = "this joint" if self._lone else f"joint {worst.joint}"
        words = f"{subject} is {worst.verdict} ({_MEANINGS[worst.verdict]}): {worst.reason}"
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

        The differences are those of net closure and net stiffness, by cycle. The limits, of a lone
        joint, are the largest of net and gross closures, and of net stiffnesses, of all cycles.
        """
        table = self._table(False, (CLOSURE, STIFFNESS))
        if len(self.limits):
            for title, quantities in (("closures", JUDGED), ("stiffness", (STIFFNESS,))):
                largest = self._largest_limits(quantities)
                texts = [percent(largest[name]).removesuffix(" %") for name in table.index]
                table[f"limit of error, {title} (%)"] = texts
        return table

    @property
    def effects(self) -> pd.DataFrame:
        """Seconds, changes (%), and verdict, one row per group of effects left out.

        ``needed by`` names the results that make effects needed, see `needed_by`.
        """
        table = self._table(True, tuple(ASSESSED))
        columns = {"verdict": self.verdict, "needed by": self.needed_by}
        return table.assign(**{name: list(map(of, table.index)) for name, of in columns.items()})

    def _table(self, of_effects: bool, quantities: tuple[str, ...]) -> pd.DataFrame:
        """Format the differences of settings, or of scenes without effects."""
        rows: dict[str, dict[str, str]] = {}
        asked = lacks_effects(self.differences.variant) == of_effects
        asked &= self.differences.quantity.isin(quantities)
        for row in self.differences[asked].itertuples():
            shown = rows.setdefault(row.variant, {"seconds": f"{row.seconds:.2g}"})
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

        It is "" of effects that are not tested, whose other joints alone have results.
        """
        if self.verdict(variant) == GIVEN_UP:
            return ""
        return results_beyond(self.differences[self.differences.variant == variant], self.within)

    def __str__(self) -> str:
        effects = self.effects.filter(regex="^(?!net st|aperture)")
        tables = [frame.to_string() for frame in (self.price, effects) if len(frame)]
        lines = "\n".join(f"- {line}" for line in self.sentences)
        return "\n\n".join([self.about_intervals, *tables, lines, self.conclusion])

    @property
    def about_intervals(self) -> str:
        """Say what the differences in the tables are from, and what their brackets are."""
        of = "copies of this joint, which should be equal" if self._lone else "the joints"
        words = (
            "Differences are from the finest setting, or from the joint with all effects. Brackets "
            f"have 95 % intervals, from the scatter of {of}."
        )
        if len(self.limits):
            words += (
                " About nine in ten joints keep the limits of errors, which contain that of the "
                "finest setting."
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
        if not allowed:
            return f"no setting meets {asked}"
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
            f"those of its net stiffnesses at most {percent(stiffness)}"
            if math.isfinite(stiffness)
            else "its net stiffnesses have no known limit"
        )
        return (
            f"the errors of its net and gross closures are at most {percent(self._reached[name])}, "
            f"and {of_stiffness} (about nine in ten joints keep such limits)"
        )

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
        """Mean processor time of a joint [s] by variant."""
        return self._compared.groupby("variant", sort=False).seconds.mean()

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
        elif features["spread"] > NOT_STABLE:
            reason = (
                f"net closures of equal copies scatter by {percent(features['spread'])} (not "
                f"stable: more than {100 * NOT_STABLE:.0f} %)"
            )
        else:
            agrees = features["spread"] <= 0.5 * self.within
            jumps = features["largest_jump"] > self.within
            easy = agrees and not jumps and share <= LARGEST_UNBREAKABLE_SHARE
            verdict = "easy" if easy else "hard"
            spreads = (f"{percent(x)} on cycle {n}" for n, x in spread_of(copies).items())
            reason = (
                f"net closures of equal copies scatter by {', '.join(spreads)} (easy: "
                f"{50 * self.within:.2g} %), {percent(share)} of its force is on contacts that "
                f"cannot break (easy: {100 * LARGEST_UNBREAKABLE_SHARE:.0f} %), and the largest "
                f"jump is {percent(features['largest_jump'])} of its closure (easy: "
                f"{100 * self.within:.2g} %)"
            )
        row = {"verdict": verdict} | features | {"unbreakable_share": share, "nearest": nearest}
        return row | {"distance": distance, "oracle_ratio": judged, "reason": reason}

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
            found = {
                True: "it converges within the request",
                False: "it does not converge within the request",
                None: "these joints do not show whether it converges within the request",
            }[last.within(self.within)]
            if coarse.within(0.0) is False and last.within(0.0) is False:
                order = math.log(abs(coarse.value / last.value)) / math.log(REFINEMENT)
                found += (
                    f" (observed order {order:.2g})"
                    if order >= LEAST_ORDER
                    else f" (the change before, with {ladder[-3]}, was hardly larger or smaller)"
                )
            lines.append(
                f"cycle {cycle}, {ASSESSED[judged]} with {ladder[-2]} from that with {ladder[-1]}: "
                f"{percent_of(last)} %: {found}"
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
        if budget is not None and budget < (least := float(seconds[self.ladder].min())):
            return f"budget = {budget:g} s: a joint takes at least {least:.2g} s"
        takes = f"it takes {seconds[finest]:.2g} s of processor time"
        if len(self.ladder) == 1:
            only = "a joint without breakage has no setting that limits its accuracy"
            return f"{only}: its copies scatter by {percent(scatter)}, and {takes}"
        lines = (
            f"by {finest}, the finest setting, {self._error_of(finest)}; net and gross closures of "
            f"its copies scatter by up to {percent(scatter)}, and {takes}"
        )
        reached = self._reached
        best = min(reached, key=lambda name: reached[name])
        if budget is None and reached[best] > self.within:
            cause = (
                ", as its copies, which should be equal, scatter more than that (the model does "
                "not determine the order of breakage)"
                if scatter > self.within
                else ""
            )
            lines = (
                f"the request of {100 * self.within:g} % cannot be met{cause}: the least limit of "
                f"the errors of net and gross closures is {percent(reached[best])}, by {best}; "
            ) + lines
        return lines

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


@takes_scans
def assess(
    walls: Any,
    *,
    conditions: Conditions | CheckedConditions | None = None,
    within: float = 0.05,
    budget: float | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
    **changes: Unpack[Changes],
) -> Assessment:
    """Assess a joint: what accuracy costs, how reliable its closure is, and which effects it needs.

    The joint is simulated with several numerical settings, without groups of effects, and as copies
    that should give equal results (docs/accuracy.md#your-own-joint).

    Parameters
    ----------
    walls : (upper, lower), or list of such pairs
        Arrays (y, x) of heights towards the other wall [m]; or two scans as for
        `jointclosure.close`.
    within : float
        Requested relative error of closures, and relative change up to which an effect can be left
        out, in (0, 1). Errors of a lone joint contain that of the finest setting; those of means
        are differences from the finest setting.
    budget : float, optional
        Processor time [s] of the joint, or of all joints of a mean for several pairs of walls. If
        given, the most accurate setting within this time is named, in place of the cheapest one
        within the request.
    folder : path, optional
        Existing folder where simulated joints are kept, so that an interrupted assessment can
        continue.
    workers : int, optional
        Number of processes, by default that of the processors available to this process.
    report : callable
        Receives the finished share and the variant that was simulated.
    conditions, **changes
        As for `jointclosure.simulate`. Without ``conditions`` breakage is resolved, unless
        ``numerics`` are given; ``conditions`` keep their numerics, by default the paper's steps.

    Returns
    -------
    Assessment

    Raises
    ------
    InputError
        If an argument is out of its range or a scan cannot be read.
    """
    stated = conditions_from(conditions, changes, "assess", defaults=SCAN_DEFAULTS)
    given = checked_request(stated, within, budget)
    if folder is not None and not Path(folder).is_dir():
        raise InputError(f"folder = {str(folder)!r}: must be an existing folder")
    pairs, spacing = checked_pairs(walls, given)
    return assess_as_checked(
        pairs, on_grid(given, spacing), within, budget, folder, workers, report
    )


def assess_as_checked(
    pairs: Sequence[Walls],
    given: CheckedConditions,
    within: float = 0.05,
    budget: float | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Callable[[float, str], None] = lambda share, variant: None,
) -> Assessment:
    """Assess joints as `assess`, of checked pairs of walls under conditions on their grid.

    The conditions, ``within`` and ``budget`` are those of `checked_request`.
    """
    setting, ladder, variants = assessed_variants(given._replace(flow=False))
    tasks = [
        (name, joint, copy)
        for name, joint in itertools.product(variants, range(len(pairs)))
        for copy in (COPIES if name == setting or len(pairs) == 1 else ["as it is"])
    ]
    closures = closures_of(tasks, setting, variants, pairs, folder, workers, report)
    return Assessment(closures, ladder, setting, within, budget)


def checked_request(
    stated: Conditions, within: float = 0.05, budget: float | None = None
) -> CheckedConditions:
    """Return the checked conditions of an assessment.

    Raise `InputError` if they, the requested error [1] or the budget [s] are not allowed.
    """
    check_below("within", within, 1.0)
    if budget is not None:
        check_below("budget", budget, 1e9)  # thirty years [s]
    return checked_as_stated(stated, varied=True)


def assessed_variants(
    given: CheckedConditions,
) -> tuple[str, list[str], dict[str, CheckedConditions]]:
    """Return the variants of a scene.

    They are the name of the stated setting, the names of all settings (the finest last), and the
    conditions of all variants by name.
    """
    variants = {"as stated": given}
    if given.effects.breakage:
        points = given.numerics.curve_points  # of elastic curves, no part of a setting
        finer = given.numerics.tolerance < FINEST.tolerance
        resolved = given.numerics.breakage == "resolved"
        middle = coarser(given.numerics, REFINEMENT) if resolved and finer else RESOLVED
        settings = {
            name: given._replace(numerics=numerics._replace(curve_points=points))
            for name, numerics in ladder_about(middle).items()
        }
        variants = _with_stated(settings, given)
    stated = next(name for name, variant in variants.items() if variant == given)
    ladder = list(variants)
    for names in DROPS:
        acting = [name for name in names if getattr(given.effects, name)]
        fewer = given.effects._replace(**dict.fromkeys(acting, False))
        # joints that break have no equilibrium without a substrate
        if acting and (fewer.substrate or not fewer.breakage):
            most = min(given.numerics.most_breakage_steps, MOST_BREAKAGE_STEPS)
            numerics = given.numerics._replace(most_breakage_steps=most)
            variants[without(acting)] = given._replace(effects=fewer, numerics=numerics)
    return stated, ladder, variants


def _with_stated(
    settings: dict[str, CheckedConditions], given: CheckedConditions
) -> dict[str, CheckedConditions]:
    """Return settings of the numerics, ordered by their accuracy, among which is the stated one.

    Resolved breakage as stated takes the place of the setting with its tolerance, from which it may
    differ in its first steps.
    """
    if given in settings.values():
        return settings
    if given.numerics.breakage != "resolved":
        return {"as stated": given} | settings
    every = settings | {named(given.numerics): given}
    coarse = [name for name, one in every.items() if one.numerics.breakage != "resolved"]
    resolved = sorted(every.keys() - coarse, key=lambda name: -every[name].numerics.tolerance)
    return {name: every[name] for name in (*coarse, *resolved)}


def checked_pairs(walls: Any, conditions: CheckedConditions) -> tuple[list[Walls], float]:
    """Return checked pairs of walls and their spacing [m]; scans are registered.

    Raise `InputError` if there are no pairs, walls are not allowed, or arrays have no spacing in
    the checked ``conditions``.
    """
    spacing = conditions.spacing
    # scans are tuples too
    one_pair = len(walls) == 2 and (
        isinstance(walls[0], Scan | Cloud) or not isinstance(walls[0], tuple | list)
    )
    pairs: Any = [walls] if one_pair else walls
    if isinstance(walls, np.ndarray) or any(len(pair) != 2 for pair in pairs):
        raise InputError("walls: must be (upper, lower), or a list of such pairs")
    if len(pairs) == 1 and not all(isinstance(wall, np.ndarray) for wall in pairs[0]):
        upper, lower = pairs[0]
        unusual = conditions.unusual_values
        pair = registered_walls(upper, lower, {}, spacing, unusual_values=unusual)
        return [(pair.upper, pair.lower)], pair.spacing
    if spacing is None:
        raise InputError("spacing = None: must be given for walls that are arrays")
    if not len(pairs):
        raise InputError("walls: 0 pairs, must be at least one")
    return [checked_walls(upper, lower, spacing) for upper, lower in pairs], spacing


def closures_of(
    tasks: Sequence[tuple[str, int, str]],
    stated: str,
    variants: Mapping[str, CheckedConditions],
    pairs: Sequence[Walls],
    folder: str | Path | None = None,
    workers: int | None = 1,
    report: Callable[[float, str], None] = lambda share, variant: None,
) -> pd.DataFrame:
    """Return `Assessment.closures` of tasks (variant, joint, copy).

    Those that the folder keeps are not simulated again. Raise `InputError` if the stated variant of
    a pair cannot be simulated.
    """
    processes = number_of_workers(workers)
    kept = dict[str, Any]()
    file = Path(folder) / "closures.jsonl" if folder else None
    for line in file.read_text(encoding="utf-8").splitlines() if file and file.exists() else ():
        if line.endswith("}}"):  # another one was cut off
            entry = json.loads(line)
            kept[entry["key"]] = entry["row"]
    code = code_digest("jointclosure.ensembles.simulation:simulate_row")
    walls = [digest(*(wall.tobytes() for wall in pair)) for pair in pairs]
    keys = {(v, j, copy): digest(code, walls[j], copy, variants[v]) for v, j, copy in tasks}
    missing = [task for task in tasks if keys[task] not in kept]
    asked = [
        (
            tuple(COPIES[copy](wall) for wall in pairs[joint]),
            Reading(variants[name], READ if copy == "as it is" else READ[:-1]),
        )
        for name, joint, copy in missing
    ]
    # before processes need them, and no part of a measured time
    prepare_kernels({variants[name].model for name, *_ in missing}, processes)
    for done, (at, row) in enumerate(in_processes(simulate_row, asked, processes), start=1):
        name = missing[at][0]
        key = keys[missing[at]]
        if isinstance(row, Failed):
            if name == stated and isinstance(row.error, InputError):
                raise row.error  # no scene, and nothing to compare
            row = {"error": str(row.error)}
        kept[key] = {quantity: np.asarray(values).tolist() for quantity, values in row.items()}
        if file:
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps({"key": key, "row": kept[key]}) + "\n")
        report(done / len(missing), name)
    parts = []
    for (name, joint, copy), key in keys.items():
        cycles = np.arange(1, variants[name].cycle_count + 1)
        row = {"variant": name, "joint": joint, "copy_of_walls": copy, "cycle": cycles, "error": ""}
        parts.append(pd.DataFrame(row | dict.fromkeys(READ, math.nan) | kept[key]))
    return pd.concat(parts, ignore_index=True).rename(columns={"timing_simulation": "seconds"})


def worst_first(hardness: pd.DataFrame) -> pd.DataFrame:
    """Return joints in the order of their verdicts, and of the spread of their copies."""
    order = np.lexsort((-hardness.spread, hardness.verdict.map(_VERDICTS.index)))
    return hardness.iloc[order].reset_index(drop=True)


def is_given_up(statuses: pd.Series) -> pd.Series:
    """Return which statuses (n,) of joints without an effect are of joints that were given up."""
    known = statuses.fillna(0.0).astype(int)
    return (known >= FAILURE) & (known & BREAKAGE_NOT_AT_REST > 0)


def verdict_on_effects(differences: pd.DataFrame, within: float) -> str:
    """Return whether effects can be left out within a request, by `JUDGED` of all cycles.

    ``differences`` are rows of `Assessment.differences` of the variant without them. They can be
    left out if all intervals lie inside the request, and are needed if one lies outside.
    """
    ends = differences.loc[differences.quantity.isin(JUDGED), list(Interval._fields)].dropna()
    inside = {Interval(*row).within(within) for row in ends.to_numpy()}
    if False in inside:
        return "needed"
    if None in inside or not inside:
        return "not decided"
    return "can be left out"


def results_beyond(differences: pd.DataFrame, within: float) -> str:
    """Name the judged results of a variant whose intervals lie outside of a request.

    ``differences`` are rows of `Assessment.differences`. The names have their cycles, such as
    "gross closure (cycles 1, 2)"; "" if no interval lies outside.
    """
    words = []
    for quantity in JUDGED:
        rows = differences[differences.quantity == quantity]
        limits = rows[list(Interval._fields)].to_numpy()
        cycles = [
            f"{cycle:.0f}"
            for cycle, row in zip(rows.cycle, limits, strict=True)
            if Interval(*row).within(within) is False
        ]
        if cycles:
            plural = "s" if len(cycles) > 1 else ""
            words.append(f"{ASSESSED[quantity]} (cycle{plural} {', '.join(cycles)})")
    return ", ".join(words)


def spread_of(copies: pd.DataFrame, quantity: str = CLOSURE) -> pd.Series:
    """Return the relative standard deviation of a closure of a joint's copies [1], by cycle."""
    values = copies.pivot_table(index="cycle", columns="copy_of_walls", values=quantity)
    return values.std(axis=1) / values.mean(axis=1)


def features_of(closures: pd.DataFrame, stated: str, finest: str) -> dict[str, float]:
    """Return `FEATURES` of a joint by the finest setting, and the spread of the stated variant."""
    fine = closures[(closures.variant == finest) & (closures.copy_of_walls == "as it is")]
    spread = spread_of(closures[closures.variant == stated]).max()
    return {name: float(fine[name].max()) for name in FEATURES[:-1]} | {"spread": float(spread)}


def nearest_hard_case(features: Mapping[str, float]) -> tuple[str, float]:
    """Return the name of the hard case with the most similar features, and its distance.

    Each feature is replaced by the share of hard cases in which it is less. The distance is the rms
    difference of these shares over the features.
    """
    cases = read_csv(HARD_CASES)
    apart = []
    for name in FEATURES:
        known = np.sort(cases[name].dropna())
        both = np.append(cases[name], features[name])
        below = np.searchsorted(known, both)
        upto = np.searchsorted(known, both, "right")
        less = np.where(np.isnan(both), np.nan, 0.5 * (below + upto))
        apart.append((less[:-1] - less[-1]) / known.size)
    comparable = np.isfinite(apart).any(axis=0)
    if not comparable.any():
        return "", math.nan
    distances = np.sqrt(np.nanmean(np.square(apart)[:, comparable], axis=0))
    return cases[comparable].iloc[distances.argmin()]["name"], float(distances.min())


_LEAST_WIDTH = 0.01
"""Width of an interval [%] below which a difference has no more than two decimals."""


def percent_of(row: Any) -> str:
    """Format an interval of relative differences in percent, without the percent sign."""
    if math.isnan(row.value):
        return "no value"
    if not math.isfinite(row.low):
        return f"{float(f'{100 * row.value:.2g}'):+g}"
    percents = [100 * number for number in (row.value, row.low, row.high)]
    if percents[2] - percents[1] < _LEAST_WIDTH < abs(percents[0]):  # copies are equal
        percents = [round(number, 2) for number in percents]
    ends = with_equal_decimals(percents)
    value, low, high = (end if end.startswith("-") or not float(end) else f"+{end}" for end in ends)
    return f"{value} ({low} to {high})"

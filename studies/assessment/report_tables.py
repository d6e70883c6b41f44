"""Tables of the assessment in the report of a study: errors of settings, effects, hard joints."""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.assessment.assess import DROPS, MOST_BREAKAGE_STEPS
from jointclosure.assessment.assessed_results import CLOSURE, JUDGED, STIFFNESS
from jointclosure.assessment.effect_names import without
from jointclosure.assessment.verdicts import (
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
    OUTSIDE_MODEL_RANGE,
    TARGET_JUMPED,
    unbreakable_share,
)
from jointclosure.parameters import Effects
from jointclosure.statistics.number_texts import percent
from jointclosure.statistics.standard_errors import Estimate, mean_of
from jointclosure.statistics.two_level import Interval, change_interval, t_interval
from studies.assessment.report_plan import RESIDUAL, AssessmentPlan
from studies.frame.joint_tables import changes_of_cases, in_words, succeeded
from studies.frame.settings import BASE
from studies.paper.closure_tables import estimate_columns
from studies.paper.report.verdicts import JUMPS, REFERENCE, VERDICT_OF

ALL_ROCKS = "all rocks"
"""Value of the column ``rock`` in rows of all rocks together; no rock has a name with a space."""
SETTING, EFFECTS = "setting", "effects"
"""Kinds of variants: another setting of the numerics, or fewer effects."""
GROSS = JUDGED[1]
"""Gross closure, by which variants are judged besides the net closure."""
MOST_RANKED = 1000
"""Largest number of joints that are ranked."""
OFF, LEFT_OUT, NEEDED, NOT_TESTED = "off", "left out", "needed", "not tested"
KEPT = "kept"
"""States of an effect: off, left out by `effects.auto`, needed by the joints, not tested, and kept
as joints take longer without it."""


class _Closed(NamedTuple):
    """Results of the joints of a variant; arrays (joint, cycle), NaN for joints that failed."""

    closures: np.ndarray  # net closure since seating [m]
    residuals: np.ndarray  # net closure that remains at seating [m]
    gross: np.ndarray  # gross closure [m]
    compliances: np.ndarray  # [m/Pa], reciprocals of the net chord stiffness
    seconds: np.ndarray  # times (n,) [s] of the joints that did not fail
    given_up: int  # number of failed joints that needed more than `MOST_BREAKAGE_STEPS`


def assessed_table(
    study: xr.Dataset,
    joints: Mapping[str, xr.Dataset],
    plan: AssessmentPlan,
    effects: Mapping[str, Effects],
    within: float,
) -> pd.DataFrame:
    """Tabulate the differences that variants make to the base cases, and the times of their joints.

    Parameters
    ----------
    study : Dataset
        Joints of the study.
    joints : mapping
        Joints of `plan`'s points by rock, along ``joint``.
    plan : AssessmentPlan
        Plan by which the joints were simulated.
    effects : mapping
        Effects that the configuration states for each rock, before `effects.auto` leaves some out.
    within : float
        Relative error that is requested of mean closures [1].

    Returns
    -------
    DataFrame
        A row for each variant and cycle, of each rock and of all rocks together (`ALL_ROCKS`).
        ``kind`` is `SETTING` or `EFFECTS`, ``reference`` the variant to which differences are, and
        ``joints`` the number of joints in the means. ``change_percent`` is the change of the mean
        net closure since seating, ``gross_percent`` that of the mean gross closure,
        ``stiffness_percent`` that of the (harmonic) mean net chord stiffness, and
        ``remains_points`` that of the share of the closure that remains at seating [percentage
        points]. Each has its 95 % interval by Student's t (``_low``, ``_high``; infinite for one
        joint). ``seconds`` is the mean time of a joint that succeeded, and ``time_percent`` its
        change from that of the study's joints. ``change_percent`` and times have standard errors.
        The ``verdict`` on a setting is one of `CHANGE_VERDICTS` by the net and the gross closure of
        the cycle, or `REFERENCE`. The verdict on effects is that of `jointclosure.assess` by net
        and gross closure of all cycles, and ``needed_by`` names the results that make the effects
        needed. ``state`` and ``reason`` are those of effects that were not tested, that the study
        left out, or that its joints need.
    """
    chosen = json.loads(study.attrs.get("effects_chosen", "{}"))
    closed = {rock: _closed(study, rock, part, plan) for rock, part in joints.items()}
    rows = list[dict[str, Any]]()
    groups = {rock: [rock] for rock in closed} | (
        {ALL_ROCKS: list(closed)} if len(closed) > 1 else {}
    )
    for name, rocks in groups.items():
        variants = list(dict.fromkeys(v for rock in rocks for v in closed[rock]))
        for variant in variants:
            of_variant = [closed[rock] for rock in rocks if variant in closed[rock]]
            rows += _rows(name, variant, of_variant, plan, within)
    table = pd.DataFrame(rows)
    states = pd.DataFrame(
        [
            {"rock": rock, "variant": variant, "state": state, "reason": reason}
            for rock, acting in effects.items()
            for variant, state, reason in _states(acting, plan, chosen.get(rock, {}))
        ],
        columns=["rock", "variant", "state", "reason"],
    )
    return _with_states(table, states, list(effects))


def _closed(
    study: xr.Dataset, rock: str, joints: xr.Dataset, plan: AssessmentPlan
) -> dict[str, _Closed]:
    """Return the results of a rock's base case by variant, settings first, by their accuracy.

    The variant with the settings of the study is taken from the dataset ``study`` unless it is
    among ``joints``.
    """
    found = {}
    for variant in dict.fromkeys(joints.variant.values.tolist()):
        found[variant] = _of(joints.isel(joint=(joints.variant == variant).values))
    if plan.stated not in found:
        base = study.isel(case=int(np.flatnonzero(_is_base(study, rock))[0]))
        base = base.rename(realization="joint")
        closed = _of(base.isel(joint=slice(plan.joints)))
        # the time of a job's first joint includes the loading of the kernels
        seconds = _of(base.isel(joint=slice(1, None))).seconds
        found = {plan.stated: closed._replace(seconds=seconds)} | found
    order = [name for name in plan.ladder if name in found]
    return {name: found[name] for name in [*order, *(n for n in found if n not in order)]}


def _is_base(study: xr.Dataset, rock: str) -> np.ndarray:
    return ((study.rock == rock) & (study.parameter == BASE)).values


def _of(joints: xr.Dataset) -> _Closed:
    good = joints.status < FAILURE
    closures, residuals, gross, stiffness = (
        joints[name].where(good).transpose("joint", "cycle").values
        for name in (CLOSURE, RESIDUAL, GROSS, STIFFNESS)
    )
    seconds = joints.timing_simulation.transpose("joint").values
    given_up = int(is_given_up(joints.status.to_series()).sum())
    known = seconds[good.transpose("joint").values]
    return _Closed(closures, residuals, gross, 1.0 / stiffness, known, given_up)


def _rows(
    rock: str,
    variant: str,
    of_rocks: Sequence[dict[str, _Closed]],
    plan: AssessmentPlan,
    within: float,
) -> Iterator[dict]:
    """Generate the rows of a variant, one for each cycle, of one rock or of several together.

    ``rock`` is the name in the rows, ``of_rocks`` has the results of each rock by variant.
    """
    setting = variant in plan.ladder
    reference = plan.ladder[-1] if setting else plan.stated
    pairs = [
        (of[variant], of[reference], of[plan.stated])
        for of in of_rocks
        if {reference, plan.stated} <= of.keys()
    ]
    if not pairs:
        return
    seconds = together([_mean(own.seconds) for own, *_ in pairs])
    times = together([_change(own.seconds, base.seconds) for own, _, base in pairs])
    joints = sum(len(own.closures) for own, *_ in pairs)
    given_up = sum(own.given_up for own, *_ in pairs)
    rows = []
    for place in range(pairs[0][0].closures.shape[1]):
        apart = [_apart(own, best, place) for own, best, _ in pairs]
        samples, remains, gross, stiffness = (
            np.concatenate(parts) for parts in zip(*apart, strict=True)
        )
        interval = _interval(samples, change_interval)
        row: dict[str, Any] = {"rock": rock}
        row |= {"kind": SETTING if setting else EFFECTS, "variant": variant}
        row |= {"reference": reference, "of_study": variant == plan.stated}
        row |= {"cycle": place + 1, "joints": samples.size, "failed": joints - samples.size}
        row["given_up"] = given_up
        row |= estimate_columns("change_percent", _mean(samples), 100.0)
        row |= _limit_columns("change_percent", interval)
        row["gross_percent"] = 100.0 * _mean(gross).value
        row |= _limit_columns("gross_percent", _interval(gross, change_interval))
        row["stiffness_percent"] = 100.0 * _mean(stiffness).value
        row |= _limit_columns("stiffness_percent", _interval(stiffness, change_interval))
        row["verdict"] = judged_setting(row, within)
        row["remains_points"] = 100.0 * _mean(remains).value
        row |= _limit_columns("remains_points", _interval(remains))
        row |= estimate_columns("seconds", seconds)
        rows.append(row | estimate_columns("time_percent", times, 100.0))
    if not setting:
        verdict, needed_by = judged_effects(rows, within)
        rows = [row | {"verdict": verdict, "needed_by": needed_by} for row in rows]
    yield from rows


def judged_setting(row: Mapping, within: float) -> str:
    """Return the verdict on a setting of the numerics by a row, that of one cycle.

    It is by net and gross closure and the request ``within`` [1]; `REFERENCE` for the reference.
    """
    if row["variant"] == row["reference"]:
        return REFERENCE
    verdicts = {
        Interval(*(0.01 * row[f"{name}_percent{end}"] for end in ENDS.values())).within(within)
        for name in JUDGED_COLUMNS.values()
    }
    return VERDICT_OF[next((one for one in (False, None) if one in verdicts), True)]


def judged_effects(rows: Sequence[Mapping], within: float) -> tuple[str, str]:
    """Return the verdict on effects by the rule of `jointclosure.assess`, and what needs them.

    ``rows`` are those of all cycles of the variant without these effects. The second text names the
    results that make them needed; "" if none does, or if joints without them fail.
    """
    if any(row["given_up"] for row in rows):
        return GIVEN_UP, ""
    if any(row["failed"] for row in rows):
        return NEEDED_AS_FAILS, ""
    differences = pd.DataFrame(
        [
            {"quantity": quantity, "cycle": row["cycle"]}
            | {end: 0.01 * row[f"{name}_percent{suffix}"] for end, suffix in ENDS.items()}
            for row in rows
            for quantity, name in JUDGED_COLUMNS.items()
        ]
    )
    return verdict_on_effects(differences, within), results_beyond(differences, within)


ENDS = {"value": "", "low": "_low", "high": "_high"}
"""Suffixes of the columns of a number and of its interval."""
JUDGED_COLUMNS = dict(zip(JUDGED, ("change", "gross"), strict=True))
"""Beginnings of the names of columns with changes, by the closures by which variants are judged."""
SHOWN_COLUMNS = JUDGED_COLUMNS | {STIFFNESS: "stiffness"}
"""Beginnings of the names of columns with changes, by all quantities whose changes are shown."""


def _apart(own: _Closed, best: _Closed, place: int) -> tuple[np.ndarray, ...]:
    """Return differences of a variant from a reference on the same walls: four arrays (joint,).

    They are of the cycle at ``place``, for the joints that succeeded with both. Either variant may
    have only the first joints of the other, where one was given up. Their means are the relative
    change of the mean net closure; the difference of the shares of the mean net closure that remain
    at seating (ratios of means, with scatter by the delta method); the relative change of the mean
    gross closure; and the relative change of the harmonic mean of the net chord stiffness.
    """
    first = min(len(own.closures), len(best.closures))
    of_both = [[part[:first, place] for part in of[:4]] for of in (own, best)]
    known = np.isfinite(of_both).all(axis=(0, 1))
    (one, one_stays, one_gross, one_yields), (two, two_stays, two_gross, two_yields) = (
        [values[known] for values in of] for of in of_both
    )
    if not known.any():
        return one, one, one, one
    shares = [_linear_share(*of) for of in ((one_stays, one), (two_stays, two))]
    gross = (one_gross - two_gross) / two_gross.mean()
    stiffness = (two_yields - one_yields) / one_yields.mean()
    return (one - two) / two.mean(), shares[0] - shares[1], gross, stiffness


def _linear_share(over: np.ndarray, under: np.ndarray) -> np.ndarray:
    """Return values (n,) whose mean is the mean of ``over`` (n,) over the mean of ``under`` (n,).

    Their scatter is that of this ratio to first order (delta method).
    """
    ratio = over.mean() / under.mean()
    return ratio + (over - ratio * under) / under.mean()


def _interval(
    samples: np.ndarray, interval_of: Callable[[np.ndarray], Interval] = t_interval
) -> Interval:
    """Return the mean of samples (n,), NaN without any, with its 95 % interval.

    The interval is infinite for fewer than two samples.
    """
    return interval_of(samples) if samples.size else Interval(math.nan, -math.inf, math.inf)


def _limit_columns(name: str, interval: Interval) -> dict[str, float]:
    """Return the limits of an interval [1] in percent, by the names of their columns."""
    return {f"{name}_low": 100.0 * interval.low, f"{name}_high": 100.0 * interval.high}


def _mean(samples: np.ndarray) -> Estimate:
    """Return the mean of samples (n,) with its standard error; NaN for too few samples.

    The error needs two samples, the mean one.
    """
    if samples.size < 2:
        return Estimate(float(samples[0]) if samples.size else math.nan, math.nan)
    return mean_of(samples)


def _change(over: np.ndarray, under: np.ndarray) -> Estimate:
    """Return the relative change of the mean of ``over`` (n,) from the mean of ``under`` (m,)."""
    return relative_change(_mean(over), _mean(under), over is under)


def relative_change(over: Estimate, under: Estimate, is_same: bool) -> Estimate:
    """Return the relative change from ``under`` to ``over``, two independent estimates.

    It is 0 without error if both are the same estimate.
    """
    if is_same:
        return Estimate(0.0, 0.0)
    ratio = over.value / under.value
    errors = (estimate.standard_error / estimate.value for estimate in (over, under))
    return Estimate(ratio - 1.0, ratio * math.hypot(*errors))


def together(estimates: Sequence[Estimate]) -> Estimate:
    """Return the mean of independent estimates with its standard error."""
    values, errors = np.array(estimates).T
    return Estimate(float(values.mean()), float(np.linalg.norm(errors)) / len(estimates))


def _states(
    acting: Effects, plan: AssessmentPlan, chosen: Mapping[str, dict]
) -> Iterator[tuple[str, str, str]]:
    """Generate (variant, state, reason) for effects of a rock that no joints of the plan test.

    ``acting`` are the stated effects, and ``chosen`` the record of `choose_rock_effects`.
    """
    for name, acts in acting._asdict().items():
        if not acts:
            yield without([name]), OFF, f"off in this study (effects: {name}: false)"
    if acting.substrate and acting.breakage:
        yield without(["substrate"]), NEEDED, "joints that break have no equilibrium without it"
    for variant in plan.omitted:
        if variant not in plan.ladder and variant.startswith(without([""])):
            yield variant, NOT_TESTED, "its joints would take more than the share of the time"
    selected = chosen.get("effects", {})
    reasons = [line for of in chosen.get("cases", {}).values() for line in of["reasons"]]
    for names in DROPS:
        left = [name for name in names if getattr(acting, name) and not selected.get(name, True)]
        for reason in reasons:
            if left and reason.startswith(f"{without(names)} the "):
                words = reason.removeprefix(f"{without(names)} the mean closure ")
                yield without(names), LEFT_OUT, f"effects.auto: {words}"


def _with_states(table: pd.DataFrame, states: pd.DataFrame, rocks: Sequence[str]) -> pd.DataFrame:
    """Return a table with the states and reasons of variants; variants not simulated get rows.

    If there are several ``rocks``, states of all rocks together are added.
    """
    if len(rocks) > 1 and len(states):
        pooled = []
        for (variant, state, reason), part in states.groupby(
            ["variant", "state", "reason"], sort=False
        ):
            words = reason if len(part) == len(rocks) else f"{', '.join(part.rock)}: {reason}"
            pooled.append({"rock": ALL_ROCKS, "variant": variant, "state": state, "reason": words})
        pooled = pd.DataFrame(pooled).groupby(["rock", "variant"], sort=False, as_index=False)
        states = pd.concat([states, pooled.agg({"state": "first", "reason": "; ".join})])
    if table.empty:
        return states.assign(kind=EFFECTS, verdict="", needed_by="")
    table = table.merge(states, on=["rock", "variant"], how="left")
    shown = set(zip(table.rock, table.variant, strict=True))
    groups = set(table.rock)
    further = states[
        [
            rock in groups and (rock, variant) not in shown
            for rock, variant in zip(states.rock, states.variant, strict=True)
        ]
    ]
    table = pd.concat([table, further.assign(kind=EFFECTS)], ignore_index=True)
    return with_failures(table.fillna({"state": "", "reason": "", "verdict": "", "needed_by": ""}))


def with_failures(table: pd.DataFrame) -> pd.DataFrame:
    """Set, in the table itself, the state of effects without which joints fail or are given up.

    Return the table. The state is `KEPT` if a joint was given up, otherwise `NEEDED`; the reason
    counts the joints. Rows that have a state keep it.
    """
    fails = (table.kind == EFFECTS) & (table.failed > 0)
    total = table.joints + table.failed
    for place in table.index[fails & (table.state == "")]:
        state = NEEDED
        counts = f"{table.failed[place]:.0f} of {total[place]:.0f} joints fail without it"
        if table.given_up[place] > 0:
            state = KEPT
            of = f"{table.given_up[place]:.0f} of {total[place]:.0f} joints"
            steps = f"{MOST_BREAKAGE_STEPS:,.0f} breakage steps a cell"
            counts = f"{KEPT_UNTESTED} (given up after {steps}: {of})"
        table.loc[place, ["state", "reason"]] = state, counts
    return table


def cost_table(
    datasets: Sequence[xr.Dataset], joints: Mapping[str, xr.Dataset], plan: AssessmentPlan
) -> pd.DataFrame:
    """Tabulate in one row the number of joints of the assessment, and their time [s].

    ``datasets`` are those of the study's ensembles, whose time [s] is given too.
    """
    whole = float(sum(part.timing_simulation.sum() for part in datasets))
    seconds = float(sum(part.timing_simulation.sum() for part in joints.values()))
    row = {
        "stated": plan.stated,
        "reference": plan.ladder[-1],
        "omitted": ", ".join(plan.omitted),
        "rocks": ", ".join(joints),
        "joints": plan.joints,
        "closed": sum(part.sizes["joint"] for part in joints.values()),
        "seconds": seconds,
        "study_seconds": whole,
        "share_percent": 100.0 * seconds / whole,
        "expected_percent": 100.0 * plan.seconds / plan.study_seconds,
        "allowed_percent": 100.0 * plan.share,
        "within": plan.within,
    }
    return pd.DataFrame([row])


_VERDICTS = (
    "not stable: failed",
    "jumped over the maximum stress",
    "hard: outside of the model's range",
    JUMPS,
    "",
)
"""Verdicts on a joint, the worst first, in the words of `jointclosure.assess` if they mean the
same. The last is that of joints without a remark, of which no copies were simulated."""


def hardness_table(study: xr.Dataset, within: float, jumps: bool) -> pd.DataFrame:
    """Rank the joints of a study by their status, and by the force and jumps that make them hard.

    Limits are those of `jointclosure.assess`: a tenth of the force on contacts that cannot break,
    and a largest closure jump under load control of ``within`` times the closure of its loading.
    Jumps are judged only if ``jumps``, which needs resolved breakage: fixed steps of closure make
    jumps of their own. Copies of the joints and finer numerics, by which `jointclosure.assess`
    judges, are not known.

    Rows are joints, the worst first, at most `MOST_RANKED`. Columns are ``changed`` (what the case
    changes, "" for a base case), ``walls`` (seed of the pair of walls, which cases of common draws
    share), ``verdict``, ``reason``, ``unbreakable_percent`` (share of the force on contacts that
    cannot break, the largest of all cycles), ``jump_percent`` (largest jump), both also over their
    limits (``unbreakable_over_limit``, ``jump_over_limit``), ``residual`` (of equilibrium, the
    largest of all steps), ``effort`` (breakage steps over the median of all joints of the rock),
    ``ranked`` (number of all joints), ``verdict_joints`` (number of joints with the same verdict),
    and ``jump_limit_percent``.
    """
    order = ("case", "realization")
    status = study.status.transpose(*order).values
    changes = list(changes_of_cases(study).values())
    share = unbreakable_share(study).max("cycle").transpose(*order).values
    jump = study.largest_jump.transpose(*order).values
    if not jumps:
        jump = np.full(jump.shape, math.nan)
    residual = study.largest_residual.transpose(*order).values
    steps = study.breakage_steps.transpose(*order).values.astype(float)
    effort = np.full(steps.shape, math.nan)
    for rock in dict.fromkeys(study.rock.values.tolist()):
        of_rock = (study.rock == rock).values
        middle = float(np.nanmedian(steps[of_rock]))
        effort[of_rock] = steps[of_rock] / middle if middle > 0.0 else math.nan
    failed = ~succeeded(study).transpose(*order).values
    over, outside = ((status & bit) > 0 for bit in (TARGET_JUMPED, OUTSIDE_MODEL_RANGE))
    group = np.select([failed, over, outside, jump > within], [0, 1, 2, 3], len(_VERDICTS) - 1)
    limits = {"unbreakable": LARGEST_UNBREAKABLE_SHARE, "jump": within}
    measures = {"unbreakable": share, "jump": jump}
    over_limit = {name: measures[name] / limit for name, limit in limits.items()}
    largest = np.nan_to_num(np.fmax(*over_limit.values()))
    first = np.lexsort((-effort.ravel(), -largest.ravel(), group.ravel()))
    rows = []
    for place in first[:MOST_RANKED]:
        at = np.unravel_index(place, status.shape)
        row: dict[str, Any] = {
            name: study[name].values[at[0]] for name in ("rock", "parameter", "level")
        }
        row["changed"] = changes[at[0]]
        row["walls"] = str(study.seed.values[at])
        row |= {"joint": int(study.realization.values[at[1]]), "status": int(status[at])}
        row["verdict"] = _VERDICTS[group[at]]
        row |= {f"{name}_percent": 100.0 * measure[at] for name, measure in measures.items()}
        row |= {f"{name}_over_limit": ratio[at] for name, ratio in over_limit.items()}
        row |= {"residual": residual[at], "effort": effort[at]}
        rows.append(row | {"reason": _reason(row, int(group[at]), within)})
    counts = {name: int((group == n).sum()) for n, name in enumerate(_VERDICTS)}
    table = pd.DataFrame(rows)
    return table.assign(
        verdict_joints=table.verdict.map(counts),
        ranked=status.size,
        jump_limit_percent=100.0 * within,
    )


def _reason(row: Mapping, group: int, within: float) -> str:
    """Return in words what makes a joint hard; ``group`` is its verdict's place in `_VERDICTS`."""
    if group == 0:
        return ", ".join(in_words(name) for bit, name in FLAGS.items() if row["status"] & bit)
    if group == 1:
        return "breakage made the stress jump over its maximum"
    known = list[str]()
    if row["unbreakable_percent"] > 0.0:
        share = percent(0.01 * row["unbreakable_percent"])
        known.append(
            f"{share} of the force on contacts that cannot break (limit "
            f"{percent(LARGEST_UNBREAKABLE_SHARE)})"
        )
    if row["jump_percent"] > 0.0:
        jump = percent(0.01 * row["jump_percent"])
        known.append(f"largest jump {jump} of the closure (limit {percent(within)})")
    if math.isfinite(row["effort"]):
        known.append(f"{row['effort']:.2g} times the median number of breakage steps")
    return "; ".join(known) or f"residual of equilibrium {row['residual']:.2g}"

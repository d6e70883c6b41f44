"""Judgement of the paper's claims: their truth in the model, and confirmation by a study.

True of the model: margins (`studies.paper.claims`) with confidence intervals, from
surfaces on which all cases are closed (the pool, or the study itself if it has none). A claim
*stands* if all margins are in the range where it is true, in all rocks, and *falls* if one is
outside. For a comparison there is *no difference* if the smallest margin is within the tolerance.
Otherwise the verdict is *undecided*. The intervals of one claim are simultaneous with a
confidence of 95 % (Bonferroni).

Confirmed by a study: the share of repetitions of the study, with n independent draws at every
level, in which the claim is true for all rocks by point estimates, as in the paper.
"""

from collections.abc import Callable, Hashable, Mapping
from typing import NamedTuple, TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.history import loop_between
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.correlations import Quadratic, fit_quadratic
from jointclosure.statistics.drawn_studies import (
    RESAMPLED_POOLS,
    Design,
    DrawnResponse,
    draw_studies,
    pool_error,
    repetitions_of_pool,
    resampled_pools,
)
from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import Estimate
from jointclosure.statistics.verdicts import UNDECIDED, Frequency, Interval, frequency, t_interval
from studies.paper.claims import CLAIMS, EXCESS, LOOP, NET, OURS, TABLE_3, TARGET, Claim, Findings
from studies.paper.responses import RockSample, rock_sample, rocks_of, sensitivities

CONFIDENCE = 0.95
YES, NO = "yes", "no"
COLUMNS = (
    "number", "claim", "section", "paper", "paper_finds", "verdict", "remark",
    "found_here", "found_share", "found_error", "found_low", "found_high",
)  # fmt: skip
OF_PAPER = ("section", "paper", "paper_finds")
"""Columns that are left out in a study of other rocks."""
MARGIN_COLUMNS = (
    "number", "rock", "cycle", "quantity", "value", "standard_error", "low", "high", "decides",
)  # fmt: skip


class Evidence(NamedTuple):
    """Data from which claims are judged.

    ``study``: the real study, which confirms a claim or not. ``pool``: data for what is true, the
    study itself if it has no pool. ``design``: that of repetitions of the study.
    ``resampled_pools``: number of pools for the error of confirmed shares due to the pool.
    """

    study: xr.Dataset
    pool: xr.Dataset
    design: Design
    repetitions: int
    root_seed: int
    resampled_pools: int = RESAMPLED_POOLS


class _Judged(NamedTuple):
    """Rocks of the pool with their margins by claim, and frequencies of confirmation.

    ``study`` and ``paper`` are the real study and the paper's table.
    """

    samples: list[RockSample]
    margins: dict[str, dict[str, dict[tuple[str, int], Estimate]]]
    confirmed: dict[str, Frequency]
    study: Findings
    paper: Findings


def judge_claims(evidence: Evidence, paper: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Judge all claims by both criteria, and return the margins that decide them.

    ``found_share`` is the share of repetitions that confirm a claim, ``found_here`` and
    ``paper_finds`` whether the study and the paper's Table 3 do. In a study of other rocks only,
    `OF_PAPER` and claims that cannot be judged are left out. Intervals of margins are simultaneous
    for a claim; the smallest margin of a rock ``decides``.
    """
    judged = _judged(evidence, paper)
    rows, margins = [], []
    for claim in CLAIMS:
        row: dict = {"number": claim.number, "claim": claim.text, "section": claim.section}
        row |= {"paper": _papers_figures(claim, paper, judged.samples), "remark": claim.remark}
        word, claim_margins = _true(claim, judged)
        row |= {"verdict": word} | _found(claim, judged)
        if claim.shown == TABLE_3 and claim.section != OURS:
            row["paper_finds"] = _yes(claim.found_in(judged.paper))
        rows.append(row)
        margins += claim_margins
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    of_model = pd.DataFrame(margins, columns=list(MARGIN_COLUMNS))
    if not judged.paper.drawn:
        table = table[table.number.isin(of_model.number)].reset_index(drop=True)
        table = table.drop(columns=list(OF_PAPER))
    return table, of_model


def _judged(evidence: Evidence, paper: pd.DataFrame) -> _Judged:
    samples, design = _samples(evidence.pool), evidence.design
    return _Judged(
        samples,
        {sample.rock: _margins(sample, design.critical_change) for sample in samples},
        _frequencies(evidence, samples),
        as_found(_samples(evidence.study), design.significance),
        _paper_as_study(paper, samples),
    )


def _frequencies(evidence: Evidence, samples: list[RockSample]) -> dict[str, Frequency]:
    """Return how often repetitions confirm each claim that can be judged, with the pool's error."""
    pools = sensitivities([sample for sample in samples if sample.levels])
    names = samples[0].names if samples else ()

    def confirmed(drawn) -> dict[str, np.ndarray]:
        by_claim = {claim.number: claim.found_in(Findings(drawn, names)) for claim in CLAIMS}
        return {number: finds for number, finds in by_claim.items() if finds is not None}

    random = generator(seed_of(evidence.root_seed, "claims"))
    once = confirmed(draw_studies(pools, evidence.design, evidence.repetitions, random))
    errors = dict.fromkeys(once, 0.0)
    if evidence.resampled_pools and once:
        random = generator(seed_of(evidence.root_seed, "claims", "pools"))
        times = repetitions_of_pool(evidence.repetitions)
        shares = []
        for resampled in resampled_pools(pools, random, evidence.resampled_pools):
            again = confirmed(draw_studies(resampled, evidence.design, times, random))
            shares.append([finds.mean() for finds in again.values()])
        errors = dict(zip(once, pool_error(shares, times).tolist(), strict=True))
    return {
        number: frequency(int(finds.sum()), finds.size, errors[number])
        for number, finds in once.items()
    }


def _samples(dataset: xr.Dataset) -> list[RockSample]:
    variables = {TARGET: dataset[TARGET], NET: dataset[NET]} | _at_half_stress(dataset)
    samples = [rock_sample(dataset, rock, variables) for rock in rocks_of(dataset)]
    return [sample for sample in samples if sample.values.shape[-1] > 1]


def _at_half_stress(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return `LOOP` and `EXCESS` of each case, at the stored stress next to half the maximum."""
    parts: dict[str, list[xr.DataArray]] = {LOOP: [], EXCESS: []}
    for case in dataset.case.values:
        one = dataset.sel(case=[case])
        most = float(one.max_normal_stress[0])
        half = one.closure.sel(stress=0.5 * most, method="nearest")
        up, down = half.sel(branch="loading"), half.sel(branch="unloading")
        parts[LOOP].append(loop_between(up, down))
        since_start = up.drop_vars("stress") - one.closure.isel(stress=0, drop=True).sel(
            branch="loading"
        )
        parts[EXCESS].append(since_start - float(half.stress) / most * one[TARGET])
    return {
        name: xr.concat(
            [part.drop_vars(["stress", "branch"], errors="ignore") for part in of_cases],
            "case", coords="minimal", compat="override",
        )
        for name, of_cases in parts.items()
    }  # fmt: skip


def _with_squares(sample: RockSample) -> RockSample:
    """Add the squared deviations of a sample's closures, whose means are their variances."""
    n = sample.values.shape[-1]
    cycles = [cycle for variable, cycle in sample.names if variable == TARGET]
    closures = sample.values[[sample.target(TARGET, cycle) for cycle in cycles]]
    squares = (closures - closures.mean(axis=2, keepdims=True)) ** 2 * n / (n - 1)
    return sample._replace(
        names=(*sample.names, *((SQUARE, cycle) for cycle in cycles)),
        values=np.concatenate([sample.values, squares]),
    )


def _margins(sample: RockSample, critical: float) -> dict[str, dict[tuple[str, int], Estimate]]:
    """Return the margins of a rock by claim, and by name and cycle, for properties that vary."""
    asked = {
        claim: cycles
        for claim in CLAIMS
        if (cycles := claim.cycles_among(sample.names))
        and set(claim.judged_by.parameters) <= set(sample.levels)
    }
    whole = _with_squares(sample)

    def numbers(means: np.ndarray) -> dict[tuple, float]:
        model = ClosedModel(whole, means, critical)
        return {
            (claim.number, *name): value
            for claim, cycles in asked.items()
            for name, value in claim.margins(model, cycles).items()
        }

    by_claim: dict[str, dict] = {}
    for (number, *name), estimate in estimated(numbers, whole).items():
        by_claim.setdefault(number, {})[tuple(name)] = estimate
    return by_claim


def _true(claim: Claim, judged: _Judged) -> tuple[str, list[dict]]:
    """Return the verdict on the model, and the margins of all rocks."""
    by_rock = judged.margins.items()
    asked = {rock: claims[claim.number] for rock, claims in by_rock if claim.number in claims}
    if not asked:
        return UNDECIDED, []
    confidence = 1.0 - (1.0 - CONFIDENCE) / sum(len(margins) for margins in asked.values())
    sizes = {sample.rock: sample.values.shape[-1] for sample in judged.samples}
    rows, intervals = [], []
    for rock, estimates in asked.items():
        of_rock = [t_interval(margin, sizes[rock], confidence) for margin in estimates.values()]
        intervals += of_rock
        rows += _margin_rows(claim, rock, estimates, of_rock)
    least = claim.judged_by.least_interval(intervals)
    return claim.verdict(least), rows


def _margin_rows(
    claim: Claim, rock: str, estimates: dict[tuple[str, int], Estimate], intervals: list[Interval]
) -> list[dict]:
    """Return margins of a rock; the smallest, in standard errors, decides."""
    inside = [
        (claim.judged_by.least_interval([Interval(margin.value, margin.value)]).low
         - claim.judged_by.true_above())
        for margin in estimates.values()
    ]  # fmt: skip
    errors = [margin.standard_error for margin in estimates.values()]
    least = np.argmin(
        [
            far / error if error else np.copysign(np.inf, far)
            for far, error in zip(inside, errors, strict=True)
        ]
    )
    return [
        {
            "number": claim.number, "rock": rock, "cycle": cycle, "quantity": quantity,
            "value": estimate.value, "standard_error": estimate.standard_error,
            "low": interval.low, "high": interval.high, "decides": i == least,
        }
        for i, (((quantity, cycle), estimate), interval) in enumerate(
            zip(estimates.items(), intervals, strict=True)
        )
    ]  # fmt: skip


def _found(claim: Claim, judged: _Judged) -> dict:
    """Return how often repetitions confirm the claim, and whether the study does."""
    row: dict = {"found_here": _yes(claim.found_in(judged.study))}
    often = judged.confirmed.get(claim.number)
    if often is not None:
        row |= {"found_share": often.share, "found_error": often.standard_error}
        row |= {"found_low": often.low, "found_high": often.high}
    return row


def _yes(finds: np.ndarray | None) -> str | None:
    return None if finds is None else YES if finds[0] else NO


def as_found(samples: list[RockSample], significance: float) -> Findings:
    """Return a real study as one of many: its means, and lengths as published."""
    drawn = {}
    for sample in samples:
        for parameter, levels in sample.levels.items():
            values = sample.values[:, levels.cases]
            means, deviations = values.mean(axis=2), values.std(axis=2, ddof=1)
            lengths = indifference_lengths(
                levels.values, means, deviations, values.shape[2], significance, levels.base
            )
            drawn[sample.rock, parameter] = DrawnResponse(
                levels.values,
                levels.base,
                means[None],
                deviations[None],
                np.where(np.isnan(lengths), np.inf, lengths)[None],
            )
    return Findings(drawn, samples[0].names if samples else ())


def _paper_as_study(paper: pd.DataFrame, samples: list[RockSample]) -> Findings:
    """Return the paper's Table 3 as a study: lengths without means."""
    cycles = sorted({int(cycle) for cycle in paper.cycle})
    drawn = {}
    for sample in samples:
        for parameter, levels in sample.levels.items():
            part = paper[(paper.rock == sample.rock) & (paper.parameter == parameter)]
            if part.empty:
                continue
            lengths = part.set_index("cycle").paper_length.reindex(cycles).to_numpy(dtype=float)
            lengths = np.where(np.isnan(lengths), np.inf, lengths * PROPERTIES[parameter].size)
            nothing = np.full((1, len(cycles), levels.values.size), np.nan)
            drawn[sample.rock, parameter] = DrawnResponse(
                levels.values, levels.base, nothing, nothing, lengths[None]
            )
    return Findings(drawn, tuple((TARGET, cycle) for cycle in cycles))


def _papers_figures(claim: Claim, paper: pd.DataFrame, samples: list[RockSample]) -> str:
    """Return entries of the paper's Table 3 on a claim, or where else the paper shows it."""
    if claim.shown != TABLE_3:
        return claim.shown
    rocks = {sample.rock for sample in samples}
    part = paper[(paper.parameter == claim.parameter) & paper.rock.isin(rocks)]
    needed = {c for cycle in claim.cycles for c in claim.judged_by.cycles(cycle)}
    part = part[part.cycle.isin(needed)]
    return "; ".join(
        f"cycle {cycle}: " + ", ".join(_entry(row) for row in rows.itertuples())
        for cycle, rows in part.groupby("cycle")
    )


def _entry(row) -> str:
    if pd.isna(row.paper_length):
        return f"{row.rock} –"
    return f"{row.rock} {row.paper_length:g} ({row.paper_percent:g} %)"


SQUARE = "squared deviation"
"""Target whose mean is the variance of the maximum closure, ddof 1 [m2]."""

Means = np.ndarray
"""Means (targets, cases) of a `RockSample`."""
Name = TypeVar("Name", bound=Hashable)


class ClosedModel:
    """Mean closures of all cases of a rock.

    ``critical`` is t sqrt(2/n) of a study's test: the smallest significant change of a mean in
    standard deviations of a closure.
    """

    def __init__(self, sample: RockSample, means: Means, critical: float) -> None:
        self.sample = sample
        self.means = means
        self.critical = critical
        self._fits: dict[tuple[str, int, str], Quadratic] = {}

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> float:
        """Return d ln(closure)/d ln(parameter) at the rock's value, from Eq. (24)."""
        return self._fit(parameter, cycle, variable).elasticity()

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[float]:
        """Return the elasticities between neighbouring levels, about their middle."""
        levels, target = self.sample.levels[parameter], self.sample.target(variable, cycle)
        means = self.means[target, levels.cases]
        return [
            float((after - before) / (after + before) * (upper + lower) / (upper - lower))
            for before, after, lower, upper in zip(
                means, means[1:], levels.values, levels.values[1:], strict=False
            )
        ]

    def change(self, parameter: str, cycle: int, change: float) -> float:
        """Return the relative change of the mean closure with a change of the parameter [SI]."""
        return float(self._fit(parameter, cycle, TARGET).relative_change(change))

    def share(self, variable: str, cycle: int) -> float:
        """Return the mean of a variable over the mean closure of the base case."""
        return float(self._at_base(variable, cycle) / self._at_base(TARGET, cycle))

    def significant(self, cycle: int) -> float:
        """Return the relative change of a mean that is significant with the scatter of the rock."""
        return float(
            self.critical * np.sqrt(self._at_base(SQUARE, cycle)) / self._at_base(TARGET, cycle)
        )

    def _at_base(self, variable: str, cycle: int) -> float:
        return self.means[self.sample.target(variable, cycle), 0]

    def _fit(self, parameter: str, cycle: int, variable: str) -> Quadratic:
        key = parameter, cycle, variable
        if key not in self._fits:
            levels, target = self.sample.levels[parameter], self.sample.target(variable, cycle)
            means = self.means[target, levels.cases]
            self._fits[key] = fit_quadratic(levels.values, means, levels.base)
        return self._fits[key]


def estimated(
    numbers: Callable[[Means], Mapping[Name, float]], sample: RockSample
) -> dict[Name, Estimate]:
    """Return numbers that depend on means, with their standard errors.

    The errors are to first order in the errors of the means, whose covariance is that over
    surfaces: contributions of a surface equal at all levels cancel in differences.
    """
    targets, cases, n = sample.values.shape
    means = sample.values.mean(axis=2)
    covariance = np.atleast_2d(np.cov(sample.values.reshape(targets * cases, n))) / n
    if not sample.paired:
        same_case = np.tile(np.eye(cases, dtype=bool), (targets, targets))
        covariance = np.where(same_case, covariance, 0.0)
    errors = np.sqrt(np.diag(covariance))
    values_by_name = numbers(means)
    gradients = np.zeros((len(values_by_name), errors.size))
    for i in np.flatnonzero(errors):
        step = np.zeros(errors.size)
        step[i] = 0.1 * errors[i]
        up, down = (
            np.array(list(numbers(means + sign * step.reshape(means.shape)).values()))
            for sign in (1.0, -1.0)
        )
        gradients[:, i] = (up - down) / (2.0 * step[i])
    variances = np.einsum("qi,ij,qj->q", gradients, covariance, gradients)
    return {
        name: Estimate(float(value), float(np.sqrt(max(variance, 0.0))))
        for (name, value), variance in zip(values_by_name.items(), variances, strict=True)
    }

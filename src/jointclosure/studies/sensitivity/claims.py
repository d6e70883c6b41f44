"""The paper's claims, each with two answers: is it true of the model, and would a study find it?

True of the model: numbers of the model with confidence intervals, from surfaces on which all
cases are closed (the pool; without one, the study's own). A claim *stands* where the
intervals lie where it is true in all rocks, *falls* where one lies outside, and *cannot be told*
otherwise. The intervals of one claim hold together with a confidence of 95 % (Bonferroni).

Found: the share of repetitions of the study, n independent draws at every level, in which the
claim holds for all rocks when judged as the paper judges, by point estimates.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.properties import PROPERTIES
from jointclosure.randomness import generator, seed_of
from jointclosure.statistics.drawn_studies import Design, DrawnResponse, draw_studies
from jointclosure.statistics.standard_errors import rounded
from jointclosure.statistics.verdicts import (
    CANNOT_BE_TOLD,
    FALLS,
    STANDS,
    frequency,
    t_interval,
    verdict,
    verdict_on_all,
)
from jointclosure.studies.sensitivity.claim_findings import Findings, as_found
from jointclosure.studies.sensitivity.claim_quantities import LOOP, Quantity, estimated
from jointclosure.studies.sensitivity.claim_rules import RULES, Rule
from jointclosure.studies.sensitivity.responses import (
    NET,
    TARGET,
    RockSample,
    rock_sample,
    rocks_of,
    sensitivities,
)

CONFIDENCE = 0.95
YES, NO = "yes", "no"
_TABLE_3 = "table 3"
OURS = "ours"
"""Where a claim is said that is a variant of ours, and not the paper's."""
ELSEWHERE = {
    "7": "a study has one setting of the steps; docs/accuracy.md has what they are worth",
    "8": "the measured curves are not available",
}
"""What no sensitivity study can say, and where it is said."""
_ROUNDING = 1e-12
"""Of a closure: a loop below is none."""


class Evidence(NamedTuple):
    """What claims are judged by.

    ``study``: as made, which finds or does not find; ``pool``: of which it is asked what is
    true, the study itself where there is none; ``design``: of a study's repetitions.
    """

    study: xr.Dataset
    pool: xr.Dataset
    design: Design
    repetitions: int
    root_seed: int


class _Judged(NamedTuple):
    """The pool's rocks, repetitions drawn from them, the study, and the paper's own table."""

    samples: list[RockSample]
    drawn: Findings
    study: Findings
    paper: Findings


def judge_claims(evidence: Evidence, claims: pd.DataFrame, paper: pd.DataFrame) -> pd.DataFrame:
    """All claims with the paper's figures, the model's numbers, and both answers.

    Parameters
    ----------
    evidence : Evidence
    claims : DataFrame
        What the paper says: number, claim, said_in, parameter, cycle, figure, shown.
    paper : DataFrame
        Its Table 3.

    Returns
    -------
    DataFrame
        ``said_in``: where the paper has it, or `OURS`. ``verdict``: whether it is true of the
        model, by the number in ``model`` that decides it, of each rock. ``found_share``: of the
        repetitions, with its binomial error and 95 % interval; ``found_here``: whether the study
        as made finds it; ``paper_finds``: whether the paper's own Table 3 does. In a study of
        other rocks only, the columns of the paper
        are left out, and claims that cannot be judged.
    """
    judged = _judged(evidence, paper)
    rows = []
    for claim in claims.itertuples():
        figure = None if pd.isna(claim.figure) else float(claim.figure)
        row = {"number": claim.number, "claim": _said(claim.claim, figure)}
        row["said_in"] = claim.said_in
        row["paper"] = _papers_figures(claim, paper, judged.samples)
        rule = RULES.get(claim.number)
        if rule is None:
            row |= {"model": ELSEWHERE.get(claim.number, ""), "verdict": CANNOT_BE_TOLD}
        else:
            row |= _true(rule, judged.samples, figure) | _found(rule, judged, figure)
            if claim.shown == _TABLE_3 and claim.said_in != OURS:
                found = _finds(rule, judged.paper, figure)
                row["paper_finds"] = None if found is None else YES if found[0] else NO
        rows.append(row)
    columns = ["number", "claim", "said_in", "paper", "paper_finds", "model", "verdict"]
    columns += ["found_here", "found_share", "found_error", "found_low", "found_high"]
    table = pd.DataFrame(rows, columns=columns)
    if not judged.paper.drawn:
        judgeable = table.number.isin(list(RULES)) & table.model.ne("")
        table = (
            table[judgeable]
            .drop(columns=["said_in", "paper", "paper_finds"])
            .reset_index(drop=True)
        )
    return table


def _judged(evidence: Evidence, paper: pd.DataFrame) -> _Judged:
    samples = _samples(evidence.pool)
    random = generator(seed_of(evidence.root_seed, "claims"))
    varied = [sample for sample in samples if sample.levels]
    drawn = draw_studies(sensitivities(varied), evidence.design, evidence.repetitions, random)
    names = samples[0].names if samples else ()
    return _Judged(
        samples,
        Findings(drawn, names),
        as_found(_samples(evidence.study), evidence.design.significance),
        _papers_own(paper, samples),
    )


def _samples(dataset: xr.Dataset) -> list[RockSample]:
    variables = {TARGET: dataset[TARGET], NET: dataset[NET], LOOP: _loops(dataset)}
    found = [rock_sample(dataset, rock, variables) for rock in rocks_of(dataset)]
    return [sample for sample in found if sample.values.shape[-1] > 1]


def _loops(dataset: xr.Dataset) -> xr.DataArray:
    """Closure of unloading less that of loading at half the maximum stress of each case."""
    parts = []
    for case in dataset.case.values:
        one = dataset.sel(case=[case])
        half = one.closure.sel(stress=0.5 * float(one.max_normal_stress[0]), method="nearest")
        up, down = half.sel(branch="loading"), half.sel(branch="unloading")
        # branches that are one curve, read to and fro, differ by rounding
        loop = (down - up).where(np.abs(down - up) > _ROUNDING * up, 0.0)
        parts.append(loop.drop_vars(["stress", "branch"], errors="ignore"))
    return xr.concat(parts, "case", coords="minimal", compat="override")


def _true(rule: Rule, samples: list[RockSample], figure: float | None) -> dict:
    """Verdict on the model, and the numbers that decide it."""
    asked: dict[str, list[Quantity]] = {}
    for sample in samples:
        quantities = rule.quantities(sample, figure)
        if quantities:
            asked[sample.rock] = quantities
    total = sum(len(quantities) for quantities in asked.values())
    if total == 0:
        return {"model": "", "verdict": CANNOT_BE_TOLD}
    confidence = 1.0 - (1.0 - CONFIDENCE) / total
    verdicts, shown = [], []
    for sample in (each for each in samples if each.rock in asked):
        least, deciding = np.inf, ""
        for quantity in asked[sample.rock]:
            found = estimated(quantity, sample)
            interval = t_interval(found, sample.values.shape[-1], confidence)
            verdicts.append(verdict(interval, quantity.true_between))
            low, high = quantity.true_between
            inside = min(found.value - low, high - found.value)
            margin = (
                inside / found.standard_error
                if found.standard_error
                else (np.inf if inside > 0.0 else -np.inf)
            )
            if not deciding or margin < least:
                least, deciding = margin, f"{quantity.name} {rounded(*found)}"
        shown.append(f"{sample.rock}: {deciding}")
    answer = verdict_on_all(verdicts)
    if rule.negated:
        answer = {STANDS: FALLS, FALLS: STANDS}.get(answer, answer)
    return {"model": "; ".join(shown), "verdict": answer}


def _found(rule: Rule, judged: _Judged, figure: float | None) -> dict:
    """How often repetitions of the study find the claim, and whether the study does."""
    here = _finds(rule, judged.study, figure)
    row: dict = {"found_here": None if here is None else YES if here[0] else NO}
    found = _finds(rule, judged.drawn, figure)
    if found is not None:
        often = frequency(found)
        row |= {"found_share": often.share, "found_error": often.standard_error}
        row |= {"found_low": often.low, "found_high": often.high}
    return row


def _finds(rule: Rule, findings: Findings, figure: float | None) -> np.ndarray | None:
    """Whether studies (R,) find a claim for all rocks; None where no rock can be judged."""
    rocks = list(dict.fromkeys(rock for rock, _ in findings.drawn))
    found = [rule.found(findings, rock, figure) for rock in rocks]
    judged = [each for each in found if each is not None]
    if not judged:
        return None
    every = np.logical_and.reduce(judged)
    return ~every if rule.negated else every


def _papers_own(paper: pd.DataFrame, samples: list[RockSample]) -> Findings:
    """The paper's Table 3 as a study: lengths without means."""
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


def _papers_figures(claim, paper: pd.DataFrame, samples: list[RockSample]) -> str:
    """The entries of the paper's Table 3 that a claim is about, or where else it is shown."""
    if claim.shown != _TABLE_3:
        return claim.shown
    rocks = {sample.rock for sample in samples}
    part = paper[(paper.parameter == claim.parameter) & paper.rock.isin(rocks)]
    if not pd.isna(claim.cycle):
        part = part[part.cycle == int(claim.cycle)]
    return "; ".join(
        f"cycle {cycle}: " + ", ".join(_entry(row) for row in rows.itertuples())
        for cycle, rows in part.groupby("cycle")
    )


def _entry(row) -> str:
    if pd.isna(row.paper_length):
        return f"{row.rock} –"
    return f"{row.rock} {row.paper_length:g} ({row.paper_percent:g} %)"


def _said(claim: str, figure: float | None) -> str:
    return claim if figure is None else f"{claim}: ±{figure:g}"

"""Judgement of the paper's claims: their truth in the model, and their confirmation by studies.

The verdict compares 95 % intervals of the margins of a claim (`studies.paper.claims`) with the
range in which the claim is true of the model. A claim *stands* if the intervals of all margins in
all rocks are in this range, and *falls* if one interval is outside. A comparison shows *no
difference* if the interval of the smallest margin is within the tolerance. Otherwise a claim is
*undecided*. The intervals of the margins of one claim are simultaneous (Bonferroni).

Confirmation by studies is the share of repetitions of a study in which point estimates confirm the
claim in all rocks. A repetition has n independent draws of surfaces at every level.
"""

from collections.abc import Callable, Hashable, Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.cycle_results import loop_between
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics import repetitions as repeated
from jointclosure.statistics.indifference import indifference_lengths
from jointclosure.statistics.quadratics import Quadratic, fit_quadratic, smoothed_by_all_levels
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import CONFIDENCE, Estimate, Limits, confidence_limits
from jointclosure.statistics.verdicts import UNDECIDED, Frequency, frequency
from studies.paper import claims as stated
from studies.paper.claims import (
    CLAIMS,
    EXCESS,
    LOOP,
    NET,
    TARGET,
    Claim,
    Findings,
)
from studies.paper.responses import RockSample, rock_sample, rocks_of, sensitivities

COLUMNS = ["number", "claim", "section", "paper", "paper_finds", "verdict", "remark", "found_here"]
OF_PAPER = ["section", "paper", "paper_finds"]
"""Columns that are left out in a study without rocks of the paper."""
MARGIN_COLUMNS = ["number", "rock", "cycle", "quantity", "value", "standard_error", "low", "high"]
MARGIN_COLUMNS += ["decides"]


class Evidence(NamedTuple):
    """Datasets by which claims are judged, and settings of the repetitions of a study."""

    study: xr.Dataset  # the study, of which the table tells which claims it confirms
    pool: xr.Dataset  # joints that give the verdict, and from which repetitions are drawn
    design: repeated.Design  # of a repetition
    repetitions: int  # number of repetitions
    root_seed: int  # from which their random numbers follow
    resampled_pools: int = repeated.RESAMPLED_POOLS  # number, by which the pool's error is known


def judge_claims(evidence: Evidence, paper: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Judge all claims by both criteria; return a table of claims, and a table of their margins.

    In the second table ``decides`` marks, for each rock, the margin that is smallest in units of
    its standard error. ``paper`` is the paper's Table 3. In a study without rocks of the paper,
    claims without margins are left out, and so are the columns of the paper.
    """
    samples = _samples(evidence.pool)
    design = evidence.design
    margins = {sample.rock: _margins(sample, design.critical_change) for sample in samples}
    often = _frequencies(evidence, samples)
    study = as_found(_samples(evidence.study), design.significance)
    published = _paper_as_study(paper, samples)
    sizes = {sample.rock: sample.values.shape[-1] for sample in samples}
    rows = []
    margin_rows = []
    for claim in CLAIMS:
        asked = {rock: of[claim.number] for rock, of in margins.items() if claim.number in of}
        verdict, of_model = _verdict_on_model(claim, asked, sizes)
        row: dict = {"number": claim.number, "claim": claim.text, "section": claim.section}
        row |= {"paper": _papers_figures(claim, paper, set(sizes)), "remark": claim.remark}
        row |= {"verdict": verdict, "found_here": _yes(claim.found_in(study))}
        if claim.number in often:
            row |= zip(stated.FOUND, often[claim.number], strict=True)
        if claim.shown == stated.TABLE_3 and claim.section != stated.OURS:
            row["paper_finds"] = _yes(claim.found_in(published))
        rows.append(row)
        margin_rows += of_model
    table = pd.DataFrame(rows, columns=[*COLUMNS, *stated.FOUND])
    of_models = pd.DataFrame(margin_rows, columns=MARGIN_COLUMNS)
    if not published.drawn:
        table = table[table.number.isin(of_models.number)].reset_index(drop=True)
        table = table.drop(columns=OF_PAPER)
    return table, of_models


def _frequencies(evidence: Evidence, samples: list[RockSample]) -> dict[str, Frequency]:
    """Return by claim the share of repetitions that confirm it, for claims that can be judged.

    ``samples`` are those of the pool. The error of a share contains the error due to the finite
    pool, which is estimated from resampled pools.
    """
    pools = sensitivities(samples)
    names = samples[0].names if samples else ()

    def confirmed(drawn) -> dict[str, np.ndarray]:
        by_claim = {claim.number: claim.found_in(Findings(drawn, names)) for claim in CLAIMS}
        return {number: finds for number, finds in by_claim.items() if finds is not None}

    random = generator(seed_of(evidence.root_seed, "claims"))
    once = confirmed(repeated.draw_studies(pools, evidence.design, evidence.repetitions, random))
    errors = dict.fromkeys(once, 0.0)
    if evidence.resampled_pools and once:
        random = generator(seed_of(evidence.root_seed, "claims", "pools"))
        times = repeated.repetitions_of_pool(evidence.repetitions)
        shares = []
        for resampled in repeated.resampled_pools(pools, random, evidence.resampled_pools):
            again = confirmed(repeated.draw_studies(resampled, evidence.design, times, random))
            shares.append([finds.mean() for finds in again.values()])
        errors = dict(zip(once, repeated.pool_error(shares, times).tolist(), strict=True))
    return {
        number: frequency(int(finds.sum()), finds.size, errors[number])
        for number, finds in once.items()
    }


def _samples(dataset: xr.Dataset) -> list[RockSample]:
    variables = {TARGET: dataset[TARGET], NET: dataset[NET]} | _at_half_stress(dataset)
    samples = [rock_sample(dataset, rock, variables) for rock in rocks_of(dataset)]
    return [sample for sample in samples if sample.values.shape[-1] > 1]


def _at_half_stress(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return `LOOP` and `EXCESS` [m] of all joints of a dataset, by name.

    They are taken at the stored stress that is next to half of the maximum stress of the case.
    """
    most = dataset.max_normal_stress
    place = dataset.get_index("stress").get_indexer(0.5 * most.values, method="nearest")
    cases = xr.DataArray(np.arange(most.size), dims="case")
    half = dataset.closure.isel(case=cases, stress=xr.DataArray(place, dims="case"))
    stress = half.stress.drop_vars("stress")
    half = half.drop_vars("stress")
    up, down = (half.sel(branch=name, drop=True) for name in ("loading", "unloading"))
    start = dataset.closure.isel(stress=0, drop=True).sel(branch="loading", drop=True)
    excess = up - start - stress / most * dataset[TARGET]
    return {LOOP: loop_between(up, down), EXCESS: excess}


def _with_squares(sample: RockSample) -> RockSample:
    """Return a sample with `SQUARE` for each cycle as further targets.

    The means of these squared deviations are the variances of the maximum closures.
    """
    n = sample.values.shape[-1]
    cycles = [cycle for variable, cycle in sample.names if variable == TARGET]
    closures = sample.values[[sample.target(TARGET, cycle) for cycle in cycles]]
    squares = (closures - closures.mean(axis=2, keepdims=True)) ** 2 * n / (n - 1)
    return sample._replace(
        names=(*sample.names, *((SQUARE, cycle) for cycle in cycles)),
        values=np.concatenate([sample.values, squares]),
    )


def _margins(sample: RockSample, critical: float) -> dict[str, dict[tuple, Estimate]]:
    """Return the margins of a rock with their errors, by number of the claim, and (name, cycle).

    Claims are left out if the rock does not vary all their parameters. ``critical`` is the
    significant change of a mean closure over its standard deviation.
    """
    asked = [
        (claim, cycle)
        for claim in CLAIMS
        if set(claim.statement.parameters) <= set(sample.levels)
        for cycle in claim.cycles_among(sample.names)
    ]
    whole = _with_squares(sample)

    def numbers(means: np.ndarray) -> dict[tuple, Any]:
        model = ClosedModel(whole, means, critical)
        return {
            (claim.number, name, cycle): value
            for claim, cycle in asked
            for name, value in claim.statement.margins(model, cycle, claim.variable).items()
        }

    by_claim: dict[str, dict] = {}
    for (number, *name), estimate in estimated(numbers, whole).items():
        by_claim.setdefault(number, {})[tuple(name)] = estimate
    return by_claim


def _verdict_on_model(
    claim: Claim, asked: dict[str, dict[tuple, Estimate]], sizes: dict[str, int]
) -> tuple[str, list[dict]]:
    """Return the verdict on a claim in the model, and its rows of the table of margins.

    ``asked`` has the margins of the claim by rock, and ``sizes`` the numbers of surfaces by rock.
    Without margins the verdict is undecided.
    """
    if not asked:
        return UNDECIDED, []
    statement = claim.statement
    confidence = 1.0 - (1.0 - CONFIDENCE) / sum(len(margins) for margins in asked.values())
    rows = []
    intervals = []
    for rock, margins in asked.items():
        far = []
        for (quantity, cycle), margin in margins.items():
            intervals.append(interval := confidence_limits(margin, sizes[rock], confidence))
            at = statement.least_limits([Limits(margin.value, margin.value)]).low
            inside = at - statement.true_above()
            error = margin.standard_error
            far.append(inside / error if error else np.copysign(np.inf, inside))
            row = {"number": claim.number, "rock": rock, "cycle": cycle, "quantity": quantity}
            rows.append(row | margin._asdict() | interval._asdict() | {"decides": False})
        rows[int(np.argmin(far)) - len(far)]["decides"] = True
    return claim.verdict(statement.least_limits(intervals)), rows


def _yes(finds: np.ndarray | None) -> str | None:
    return None if finds is None else "yes" if finds[0] else "no"


def as_found(samples: list[RockSample], significance: float) -> Findings:
    """Return the findings of one real study (R = 1): means, and lengths by the unpaired t test.

    ``samples`` are those of its rocks. Lengths are infinite without a root.
    """
    drawn = {}
    for sample in samples:
        for parameter, (levels, cases, base) in sample.levels.items():
            values = sample.values[:, cases]
            means = values.mean(axis=2)
            deviations = values.std(axis=2, ddof=1)
            n = values.shape[2]
            lengths = indifference_lengths(levels, means, deviations, n, significance, base)
            parts = (means, deviations, np.nan_to_num(lengths, nan=np.inf))
            drawn[sample.rock, parameter] = repeated.DrawnResponse(
                levels, base, *(x[None] for x in parts)
            )
    return Findings(drawn, samples[0].names if samples else ())


def _paper_as_study(paper: pd.DataFrame, samples: list[RockSample]) -> Findings:
    """Return the paper's Table 3 as the findings of one study, which has lengths but no means.

    Rocks and parameters are those of ``samples`` that the table has.
    """
    cycles = sorted({int(cycle) for cycle in paper.cycle})
    published = paper.set_index(["rock", "parameter", "cycle"]).paper_length.to_dict()
    drawn = {}
    for sample in samples:
        for parameter, (levels, _, base) in sample.levels.items():
            at = [(sample.rock, parameter, cycle) for cycle in cycles]
            if not published.keys() & at:
                continue
            lengths = PROPERTIES[parameter].size * np.array([published.get(x, np.nan) for x in at])
            none = np.full((1, len(at), levels.size), np.nan)
            drawn[sample.rock, parameter] = repeated.DrawnResponse(
                levels, base, none, none, np.nan_to_num(lengths, nan=np.inf)[None]
            )
    return Findings(drawn, tuple((TARGET, cycle) for cycle in cycles))


def _papers_figures(claim: Claim, paper: pd.DataFrame, rocks: set[str]) -> str:
    """Return as text the entries of the paper's Table 3 on a claim, or where else it is shown.

    ``rocks`` are the rocks whose entries are given.
    """
    if claim.shown != stated.TABLE_3:
        return claim.shown
    statement = claim.statement
    needed = {c for cycle in claim.cycles for c in statement.cycles(cycle)}
    part = paper[(paper.parameter == statement.parameter) & paper.rock.isin(rocks)]
    entries: dict[int, list[str]] = {}
    for row in part[part.cycle.isin(needed)].itertuples():
        known = pd.notna(row.paper_length)
        text = f"{row.paper_length:g} ({row.paper_percent:g} %)" if known else "–"
        entries.setdefault(row.cycle, []).append(f"{row.rock} {text}")
    return "; ".join(f"cycle {cycle}: {', '.join(entries[cycle])}" for cycle in sorted(entries))


SQUARE = "squared deviation"
"""Name of the target whose mean is the variance (ddof 1) of the maximum closure [m2]."""
Name = TypeVar("Name", bound=Hashable)


class ClosedModel(NamedTuple):
    """Model of a rock by its mean closures, from which margins of claims are computed.

    Numbers that its methods return are arrays (...) as the leading dimensions of ``means``.
    """

    sample: RockSample
    means: np.ndarray  # mean closures (..., targets, cases) [m]
    critical: float  # significant change of a mean closure over the standard deviation S

    def elasticity(self, parameter: str, cycle: int, variable: str) -> Any:
        """Return d ln(closure)/d ln(parameter) at the rock's value, from Eq. (24)."""
        return self._fit(parameter, cycle, variable).elasticity()

    def slopes(self, parameter: str, cycle: int, variable: str) -> list:
        """Return the elasticities in the lower and in the upper half of the levels.

        Each is that between the ends of its half, by means smoothed over all levels.
        """
        levels, means = smoothed_by_all_levels(*self._means(parameter, cycle, variable))
        changes = np.diff(means) / (means[..., 1:] + means[..., :-1])
        slopes = changes * (levels[1:] + levels[:-1]) / np.diff(levels)
        return list(np.moveaxis(slopes, -1, 0))

    def change(self, parameter: str, cycle: int, change: float) -> Any:
        """Return the relative change of mean maximum closure with a change [SI] of a parameter."""
        return self._fit(parameter, cycle, TARGET).relative_change(change)

    def share(self, variable: str, cycle: int) -> Any:
        """Return the mean of a variable over the mean maximum closure, both of the base case."""
        return self._at_base(variable, cycle) / self._at_base(TARGET, cycle)

    def significant(self, cycle: int) -> Any:
        """Return the least relative change of mean maximum closure that is significant.

        It follows from the scatter of the base case.
        """
        scatter = self.critical * np.sqrt(self._at_base(SQUARE, cycle))
        return scatter / self._at_base(TARGET, cycle)

    def _at_base(self, variable: str, cycle: int) -> Any:
        return self.means[..., self.sample.target(variable, cycle), 0]

    def _means(self, parameter: str, cycle: int, variable: str) -> tuple:
        """Return the levels (k,) of a parameter, mean closures (..., k) at these, rock's value."""
        levels, cases, base = self.sample.levels[parameter]
        return levels, self.means[..., self.sample.target(variable, cycle), :][..., cases], base

    def _fit(self, parameter: str, cycle: int, variable: str) -> Quadratic:
        return fit_quadratic(*self._means(parameter, cycle, variable))


def estimated(
    numbers: Callable[[np.ndarray], Mapping[Name, Any]], sample: RockSample
) -> dict[Name, Estimate]:
    """Return numbers that are functions of mean closures, by name, with standard errors.

    ``numbers`` is a function that returns values (...) by name from means (..., targets, cases).
    Errors are to first order. If all cases of the sample have the same surfaces, covariances
    between cases count, so that scatter that they have in common cancels.
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
    scattering = np.flatnonzero(errors)
    steps = 0.1 * errors
    moves = np.diag(steps)[scattering].reshape(-1, *means.shape)
    up = numbers(means + moves)
    down = numbers(means - moves)
    for place, name in enumerate(values_by_name):
        gradients[place, scattering] = (up[name] - down[name]) / (2.0 * steps[scattering])
    variances = np.einsum("qi,ij,qj->q", gradients, covariance, gradients)
    return {
        name: Estimate(float(value), float(np.sqrt(max(variance, 0.0))))
        for (name, value), variance in zip(values_by_name.items(), variances, strict=True)
    }

"""Averages over readings: Table 3, and claims, with readings weighted by likelihood.

Compared are the readings of the last round of all rocks that the paper's text allows, on common
surfaces. Weights, probabilities and margins are computed on all surfaces and without each group of
them, so that errors contain those of the weights.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from jointclosure.claims.table import Claim
from jointclosure.experiments.readings.design import Readings
from jointclosure.experiments.readings.likelihood import (
    Question,
    drawn_lengths,
    observed_lengths,
)
from jointclosure.experiments.readings.pools import (
    Closures,
    in_round,
    kept_surfaces,
    samples_of_surfaces,
)
from jointclosure.experiments.readings.summary import (
    ASKED,
    Margins,
    least_margins,
    verdicts_of,
)
from jointclosure.statistics.drawn_studies import jackknife_error
from jointclosure.statistics.model_average import (
    Comparison,
    compare,
    p_averaged,
    p_selected,
    weights,
)
from jointclosure.statistics.standard_errors import Estimate

AVERAGE_TABLES = ("readings_average", "readings_average_tests", "readings_average_claims")
ALL = "all"
CHOSEN = "the same, reading chosen by them"
"""Entries that are seen where each table is judged under its likeliest reading."""


class Averages(NamedTuple):
    """Average over readings from one sample of surfaces.

    ``comparison``: log densities of the published table and of drawn ones; ``weights``: that of
    each reading by the name of the entries that are seen; ``margins``: smallest margins of claims
    in each reading.
    """

    comparison: Comparison
    weights: dict[str, np.ndarray]
    margins: list[Margins]


def average_tables(
    titles: Sequence[str], closures: Sequence[Closures], question: Question
) -> dict[str, pd.DataFrame]:
    """Average Table 3 and claims over readings, weighted by the likelihood of Table 3.

    Parameters
    ----------
    titles : sequence of str
        Titles of the readings.
    closures : sequence of mapping
        Their closures of all rocks, on common surfaces, see `comparable`.
    question : Question

    Returns
    -------
    dict of DataFrame
        ``readings_average``: weight of each reading by the entries of Table 3 that are seen (all,
        those of one cycle, those of all rocks but one), with its error.
        ``readings_average_tests``: p of entries (``tested``) where the weights are from other ones
        (``seen``), or where each drawn table is judged under its likeliest reading, as the
        published one (`CHOSEN`). ``readings_average_claims``: smallest margin of each claim in the
        rock where it is least, averaged over readings, with the share of the reading in its
        variance, the weight of the readings where it is true, and the verdict. All are empty with
        fewer than two readings.
    """
    if len(titles) < 2:
        columns = (["title"], ["tested", "seen"], ["number", "claim"])
        return {
            name: pd.DataFrame(columns=of_table)
            for name, of_table in zip(AVERAGE_TABLES, columns, strict=True)
        }
    entries = entries_of(question)
    whole, *parts = (
        averages([kept_surfaces(one, kept) for one in closures], question, entries)
        for kept in samples_of_surfaces(closures[0], question.groups)
    )
    of_readings: dict[str, Any] = {"title": titles}
    for name, values in whole.weights.items():
        column = "weight" if name == ALL else f"weight by {name}"
        errors = [
            jackknife_error(of) for of in zip(*(one.weights[name] for one in parts), strict=True)
        ]
        of_readings |= {column: values, f"{column}, error": errors}
    tests = pd.DataFrame(list(_tests(whole, parts, entries)))
    claims = _claims(whole, parts, 1.0 - question.design.significance)
    tables = (pd.DataFrame(of_readings), tests, claims)
    return dict(zip(AVERAGE_TABLES, tables, strict=True))


def comparable(
    readings: Readings, ranked: Sequence[pd.DataFrame], joints: pd.DataFrame
) -> tuple[list[str], list[Closures]]:
    """Return the readings of the last round of all rocks, and their closures on common surfaces.

    Readings that were dropped before are behind the best by more than the margin of their round,
    and have no weight. Readings that the paper's text contradicts are left out.

    Parameters
    ----------
    readings : Readings
    ranked : sequence of DataFrame
        Ranking of each round; empty where no reading entered.
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, of all rounds.

    Returns
    -------
    titles : list of str
    closures : list of mapping
    """
    of_all_rocks = (
        number
        for number, one in enumerate(readings.rounds)
        if one.rocks == readings.rocks and not ranked[number].empty
    )
    last = max(of_all_rocks, default=None)
    if last is None:
        return [], []
    names = [name for name in ranked[last].reading if readings.reading(name).allowed]
    closures = [in_round(readings, last, name, joints) for name in names]
    common = {
        rock: set.intersection(*(set(one[rock].realization.values.tolist()) for one in closures))
        for rock in readings.rocks
    }
    return [readings.reading(name).title for name in names], [
        {rock: one[rock].sel(realization=sorted(common[rock])) for rock in readings.rocks}
        for one in closures
    ]


def entries_of(question: Question) -> dict[str, np.ndarray]:
    """Return which entries of Table 3 (entries,) are of a name: all, a cycle, a rock, not it."""
    cycles = sorted({cycle for _, _, cycle in question.published})
    of_rock, of_cycle = np.array(
        [
            (rock, f"cycle {cycle}")
            for rock, parameters in question.parameters.items()
            for _ in parameters
            for cycle in cycles
        ]
    ).T
    named = {ALL: np.ones(len(of_rock), bool)}
    for kind in (of_cycle, of_rock):
        for name in dict.fromkeys(kind.tolist()):
            named |= {name: kind == name, f"all but {name}": kind != name}
    return named


def averages(
    closures: list[Closures], question: Question, entries: Mapping[str, np.ndarray]
) -> Averages:
    """Compute weights and margins from one sample of surfaces."""
    lengths = np.stack([drawn_lengths(question, one) for one in closures])
    comparison = compare(lengths, observed_lengths(question))
    return Averages(
        comparison,
        {name: weights(comparison, of_name) for name, of_name in entries.items()},
        [
            least_margins(one, question.parameters, question.design.critical_change)
            for one in closures
        ],
    )


def _tests(whole: Averages, parts: list[Averages], entries: Mapping[str, np.ndarray]) -> Iterator:
    """Generate rows of p: by other entries, and with the choice of a reading."""
    asked = [(name, f"all but {name}") for name in entries if f"all but {name}" in entries]
    for tested, seen in [(ALL, ALL), (ALL, CHOSEN), *asked]:
        p = p_selected if seen == CHOSEN else p_averaged
        weighted = ALL if seen == CHOSEN else seen
        value, *without = (
            p(one.comparison, entries[tested], one.weights[weighted]) for one in (whole, *parts)
        )
        of_draws = np.sqrt(value * (1.0 - value) / (2 * whole.comparison.drawn.shape[3]))
        error = float(np.hypot(jackknife_error(without), of_draws))
        yield {"tested": tested, "seen": seen, "p": value, "p_error": error}


def _claims(whole: Averages, parts: list[Averages], confidence: float) -> pd.DataFrame:
    """Return a row for each claim: margin, share of the reading in its variance, verdict."""
    margins, shares = {}, {}
    for name in whole.margins[0]:
        value, *without = (_mean(one, name) for one in (whole, *parts))
        between = float(
            whole.weights[ALL] @ (np.array([one[name] for one in whole.margins]) - value) ** 2
        )
        of_surfaces = jackknife_error(without) ** 2
        variance = between + of_surfaces  # 0 for a loop that no joint has
        margins[name] = Estimate(value, float(np.sqrt(variance)))
        shares[name] = between / variance if variance > 0.0 else 0.0
    verdicts = verdicts_of(margins, len(parts), confidence)
    rows = []
    for claim in ASKED:
        of_rocks = {name: value for name, value in margins.items() if name[0] == claim.number}
        if not of_rocks:
            continue
        least = min(of_rocks, key=lambda name: of_rocks[name].value)
        true, *without = (_weight_true(one, claim) for one in (whole, *parts))
        rows.append(
            {
                "number": claim.number,
                "claim": claim.text,
                "rock": least[1],
                "margin": margins[least].value,
                "margin_error": margins[least].standard_error,
                "share_of_reading": shares[least],
                "weight_true": round(true, 12),  # weights sum to 1 but for rounding
                "weight_true_error": round(jackknife_error(without), 12),
                "verdict": verdicts[claim.number],
            }
        )
    return pd.DataFrame(rows)


def _mean(one: Averages, name: tuple[str, str]) -> float:
    """Return the mean of a margin over readings by weight."""
    return float(one.weights[ALL] @ np.array([margins[name] for margins in one.margins]))


def _weight_true(one: Averages, claim: Claim) -> float:
    """Return the weight of the readings in which a claim is true of the mean closures."""
    above = claim.judged_by.true_above()
    true = [
        all(value > above for (number, _), value in margins.items() if number == claim.number)
        != claim.negated
        for margins in one.margins
    ]
    return float(one.weights[ALL] @ np.array(true))

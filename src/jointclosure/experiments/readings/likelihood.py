"""Likelihood of the paper's Table 3 in a reading, and its differences between readings."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.config.properties import PROPERTIES
from jointclosure.experiments.readings.pools import (
    Closures,
    Parameters,
    kept_surfaces,
    samples_of_surfaces,
    sensitivities_of,
    transferred,
)
from jointclosure.inputs import InputError
from jointclosure.statistics.drawn_studies import (
    Design,
    draw_studies,
    jackknife_error,
    lengths_table,
)
from jointclosure.statistics.joint_tests import log_likelihoods, p_of_table
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import Estimate


class Question(NamedTuple):
    """Published table, and the design of the repetitions that are compared with it.

    ``published``: the paper's lengths by (rock, parameter, cycle) [SI], NaN for its dash;
    ``parameters``: levels of all rocks; ``design`` and ``repetitions`` of the study;
    ``groups`` of the jackknife; ``root_seed``: seed of the draws, the same in all readings.
    """

    published: Mapping[tuple[str, str, int], float]
    parameters: Parameters
    design: Design
    repetitions: int
    groups: int
    root_seed: int


class Answer(NamedTuple):
    """Log-likelihood of Table 3 in a reading, and without each group of surfaces (groups,)."""

    log_likelihood: float
    without: np.ndarray

    @property
    def standard_error(self) -> float:
        """Return the error due to the finite numbers of surfaces and of repetitions."""
        return jackknife_error(self.without)


def published_lengths(table: pd.DataFrame, parameters: Parameters) -> dict:
    """Return the paper's lengths by (rock, parameter, cycle) [SI].

    Raises
    ------
    InputError
        If the paper's table lacks a rock or parameter of the study.
    """
    lengths = {
        (row.rock, row.parameter, int(row.cycle)): row.paper_length * PROPERTIES[row.parameter].size
        for row in table.itertuples()
    }
    for rock, of_rock in parameters.items():
        for parameter in of_rock:
            if (rock, parameter, 1) not in lengths:
                raise InputError(
                    f"rocks.{rock}: {parameter} is not in the paper's Table 3, with which readings "
                    "are compared"
                )
    return lengths


def question_of(settings: dict, paper: pd.DataFrame) -> Question:
    """Make a question from plain data and the published table.

    Parameters
    ----------
    settings : dict
        parameters, draws, significance, repetitions, groups, root_seed.
    paper : DataFrame
        The paper's Table 3.
    """
    parameters = {
        rock: {name: (tuple(levels), base) for name, (levels, base) in of_rock.items()}
        for rock, of_rock in settings["parameters"].items()
    }
    return Question(
        published_lengths(paper, parameters),
        parameters,
        Design(settings["draws"], settings["significance"]),
        settings["repetitions"],
        settings["groups"],
        settings["root_seed"],
    )


def answer_of(question: Question, closed: Closures, reference: Closures) -> Answer:
    """Compute the log-likelihood of Table 3 in a reading, and its error.

    Parameters
    ----------
    question : Question
    closed : mapping
        Closures of the rocks closed in the reading; others change as these do (`transferred`).
    reference : mapping
        Closures of all rocks as configured.
    """
    return Answer(
        *_jackknifed(
            question,
            closed,
            reference,
            lambda lengths, observed: log_likelihoods(lengths, observed[None])[0],
        )
    )


def probability_of_table_3(question: Question, closed: Closures, reference: Closures) -> Estimate:
    """Compute the p of `joint_test` for Table 3 in a reading; arguments as for `answer_of`.

    Its standard error combines that of the repetitions and that of the surfaces, by a jackknife
    over groups of them.
    """
    p, without = _jackknifed(question, closed, reference, p_of_table)
    of_repetitions = np.sqrt(p * (1.0 - p) / question.repetitions)
    return Estimate(p, float(np.hypot(jackknife_error(without), of_repetitions)))


def _jackknifed(
    question: Question, closed: Closures, reference: Closures, statistic: Callable
) -> tuple[float, np.ndarray]:
    """Compute a statistic on all surfaces, and without each group of surfaces (groups,).

    ``statistic`` is a function of drawn lengths (repetitions, entries) and observed ones.
    """
    value, *without = (
        float(
            statistic(
                drawn_lengths(question, _all_rocks(closed, reference, question.parameters, kept)),
                observed_lengths(question),
            )
        )
        for kept in samples_of_surfaces(closed, question.groups)
    )
    return value, np.array(without)


def behind(best: Answer, other: Answer) -> Estimate:
    """Compute by how much the log-likelihood of a reading is below the best, with its error.

    If both have as many groups of surfaces, the jackknife is of the difference, in which the
    common effect of the surfaces cancels.
    """
    value = best.log_likelihood - other.log_likelihood
    if best.without.size == other.without.size:
        return Estimate(value, jackknife_error(best.without - other.without))
    return Estimate(value, float(np.hypot(best.standard_error, other.standard_error)))


def ranking(answers: Mapping[str, Answer], margin: float) -> pd.DataFrame:
    """Rank readings by log-likelihood, the best first, and decide which are kept.

    Returns
    -------
    DataFrame
        Columns `COLUMNS`; a reading is kept unless it is behind the best by more than
        ``margin`` standard errors.
    """
    order = sorted(answers, key=lambda name: -answers[name].log_likelihood)
    rows = []
    for name in order:
        apart = behind(answers[order[0]], answers[name])
        rows.append(
            {
                "reading": name,
                "log_likelihood": answers[name].log_likelihood,
                "standard_error": answers[name].standard_error,
                "behind": apart.value,
                "behind_error": apart.standard_error,
                "kept": not apart.value > margin * apart.standard_error,
            }
        )
    return pd.DataFrame(rows, columns=COLUMNS)


COLUMNS = ["reading", "log_likelihood", "standard_error", "behind", "behind_error", "kept"]


class ImpliedScatter(NamedTuple):
    """Factor on all standard deviations of a cycle at which Table 3 is likeliest.

    ``low`` and ``high``: ends of the range in which the log-likelihood is lower by at most 1.92.
    This would be a 95 % interval if the entries were independent, which they are not quite.
    """

    cycle: int
    factor: float
    low: float
    high: float


def implied_scatter(question: Question, closed: Closures, reference: Closures, factors):
    """Find the scatter at which Table 3 is likeliest, given the means of a reading, by cycle.

    Parameters
    ----------
    question, closed, reference
        As for `answer_of`.
    factors : array
        Factors that are tried, ascending.
    """
    whole = _all_rocks(closed, reference, question.parameters, lambda number: number >= 0)
    cycles = next(iter(whole.values())).cycle.values
    observed = observed_lengths(question).reshape(-1, cycles.size)
    likelihoods = []
    for factor in factors:
        scattered = {rock: _scattered(closures, factor) for rock, closures in whole.items()}
        lengths = drawn_lengths(question, scattered)
        lengths = lengths.reshape(question.repetitions, -1, cycles.size)
        likelihoods.append(
            [log_likelihoods(lengths[:, :, i], observed[None, :, i])[0] for i in range(cycles.size)]
        )
    answer = []
    for cycle, values in zip(cycles.tolist(), np.array(likelihoods).T, strict=True):
        likely = factors[values >= values.max() - 1.92]
        best = float(factors[values.argmax()])
        answer.append(ImpliedScatter(cycle, best, float(likely[0]), float(likely[-1])))
    return answer


def _scattered(closures, factor: float):
    """Multiply the deviations of closures from their means by a factor."""
    middle = closures.mean("realization")
    return (middle + (closures - middle) * factor).transpose(*closures.dims)


def _all_rocks(closed: Closures, reference: Closures, parameters: Parameters, kept) -> Closures:
    """Return closures of all rocks on the surfaces whose number a rule keeps."""
    closed, reference = (kept_surfaces(one, kept) for one in (closed, reference))
    if set(parameters) <= set(closed):
        return closed
    return transferred(closed, reference, parameters)


def drawn_lengths(question: Question, closures: Closures) -> np.ndarray:
    """Draw lengths (repetitions, entries) in repetitions of the paper's study.

    If a resampled pool is one surface many times, it has no scatter, and the length is 0, which
    has no logarithm. It is replaced by the shortest other length.
    """
    random = generator(seed_of(question.root_seed, "readings"))
    sensitivities = sensitivities_of(closures, question.parameters)
    drawn = draw_studies(sensitivities, question.design, question.repetitions, random)
    lengths = lengths_table(drawn)
    return np.maximum(lengths, np.where(lengths > 0.0, lengths, np.inf).min(axis=0))


def observed_lengths(question: Question) -> np.ndarray:
    """Return the paper's lengths in the order of `lengths_table`."""
    cycles = sorted({cycle for _, _, cycle in question.published})
    return np.array(
        [
            question.published[rock, parameter, cycle]
            for rock, of_rock in question.parameters.items()
            for parameter in of_rock
            for cycle in cycles
        ]
    )

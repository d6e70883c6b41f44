"""How likely the paper's Table 3 is in a reading, and how far readings are apart."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.config.properties import PROPERTIES
from jointclosure.experiments.readings.pools import (
    Closures,
    Parameters,
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
    """What every reading is asked.

    ``published``: the paper's lengths by (rock, parameter, cycle) [SI], NaN for its dash;
    ``parameters``: levels of all rocks; ``design`` and ``repetitions`` of its study;
    ``groups`` of the jackknife; ``root_seed``: all readings are drawn with the same numbers.
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
        """From the number of surfaces closed, and of repetitions drawn."""
        return jackknife_error(self.without)


def published_lengths(table: pd.DataFrame, parameters: Parameters) -> dict:
    """The paper's lengths by (rock, parameter, cycle) [SI], from its table.

    Raises
    ------
    InputError
        A rock or parameter of the study that the paper's table does not have.
    """
    lengths = {
        (row.rock, row.parameter, int(row.cycle)): row.paper_length * PROPERTIES[row.parameter].size
        for row in table.itertuples()
    }
    for rock, of_rock in parameters.items():
        for parameter in of_rock:
            if (rock, parameter, 1) not in lengths:
                raise InputError(
                    f"rocks.{rock}: {parameter} is not in the paper's Table 3, by which readings "
                    "are judged"
                )
    return lengths


def question_of(settings: dict, paper: pd.DataFrame) -> Question:
    """The question that settings ask, which are plain data: all its fields but the published.

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
    """The log-likelihood of Table 3 in a reading, and its error.

    Parameters
    ----------
    question : Question
    closed : mapping
        The rocks closed in the reading; those that were not change as these do (`transferred`).
    reference : mapping
        All rocks as configured.
    """

    def of(with_surface: Callable) -> float:
        whole = _all_rocks(closed, reference, question.parameters, with_surface)
        lengths = _drawn_lengths(question, whole)
        return float(log_likelihoods(lengths, _observed(question)[None])[0])

    without = [of(kept) for kept in _groups_left_out(question, closed)]
    return Answer(of(lambda number: number >= 0), np.array(without))


def probability_of_table_3(question: Question, closed: Closures, reference: Closures) -> Estimate:
    """Probability of Table 3 in a reading: the p of `joint_test`, arguments as for `answer_of`.

    Its standard error is that of the repetitions, and that of the surfaces by a jackknife over
    groups of them.
    """

    def of(with_surface: Callable) -> float:
        whole = _all_rocks(closed, reference, question.parameters, with_surface)
        return p_of_table(_drawn_lengths(question, whole), _observed(question))

    p = of(lambda number: number >= 0)
    of_surfaces = jackknife_error([of(kept) for kept in _groups_left_out(question, closed)])
    of_repetitions = np.sqrt(p * (1.0 - p) / question.repetitions)
    return Estimate(p, float(np.hypot(of_surfaces, of_repetitions)))


def _groups_left_out(question: Question, closed: Closures) -> list[Callable]:
    """Rules that keep the surfaces of all groups but one, by their numbers."""
    fewest = min(closures.sizes["realization"] for closures in closed.values())
    groups = min(question.groups, fewest)
    return [lambda number, group=group: number % groups != group for group in range(groups)]


def behind(best: Answer, other: Answer) -> Estimate:
    """By how much a reading's log-likelihood is below the best, with its error.

    The same groups of surfaces leave both, where they have as many groups, so that what
    surfaces have in common leaves the error.
    """
    value = best.log_likelihood - other.log_likelihood
    if best.without.size == other.without.size:
        return Estimate(value, jackknife_error(best.without - other.without))
    return Estimate(value, float(np.hypot(best.standard_error, other.standard_error)))


def ranking(answers: Mapping[str, Answer], margin: float) -> pd.DataFrame:
    """Readings by log-likelihood, the best first, and which are kept.

    Returns
    -------
    DataFrame
        Columns reading, log_likelihood, standard_error, behind, behind_error, kept: not behind
        the best by more than ``margin`` standard errors, as far as these are known.
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
    """The factor on all standard deviations of a cycle at which Table 3 is likeliest.

    ``low`` and ``high``: where the log-likelihood is lower by 1.92, which were a 95 %
    interval if the entries were independent; they are not quite.
    """

    cycle: int
    factor: float
    low: float
    high: float


def implied_scatter(question: Question, closed: Closures, reference: Closures, factors):
    """Scatter that Table 3 asks for, given a reading's means, cycle by cycle.

    Parameters
    ----------
    question, closed, reference
        As for `answer_of`.
    factors : array
        Ascending, that are tried.
    """
    whole = _all_rocks(closed, reference, question.parameters, lambda number: number >= 0)
    cycles = next(iter(whole.values())).cycle.values
    observed = _observed(question).reshape(-1, cycles.size)
    found = []
    for factor in factors:
        scattered = {rock: _scattered(each, factor) for rock, each in whole.items()}
        lengths = _drawn_lengths(question, scattered)
        lengths = lengths.reshape(question.repetitions, -1, cycles.size)
        found.append(
            [log_likelihoods(lengths[:, :, i], observed[None, :, i])[0] for i in range(cycles.size)]
        )
    answer = []
    for cycle, values in zip(cycles.tolist(), np.array(found).T, strict=True):
        within = np.flatnonzero(values >= values.max() - 1.92)
        answer.append(
            ImpliedScatter(
                cycle,
                float(factors[int(values.argmax())]),
                float(factors[within[0]]),
                float(factors[within[-1]]),
            )
        )
    return answer


def _scattered(closures, factor: float):
    middle = closures.mean("realization")
    return (middle + (closures - middle) * factor).transpose(*closures.dims)


def _all_rocks(closed: Closures, reference: Closures, parameters: Parameters, kept) -> Closures:
    """Closures of all rocks on the surfaces whose number is kept."""
    closed, reference = (
        {
            rock: each.isel(realization=np.flatnonzero(kept(each.realization.values)))
            for rock, each in closures.items()
        }
        for closures in (closed, reference)
    )
    if set(parameters) <= set(closed):
        return closed
    return transferred(closed, reference, parameters)


def _drawn_lengths(question: Question, closures: Closures) -> np.ndarray:
    """Lengths (repetitions, entries) of repetitions of the paper's study.

    A repetition whose resampled pool is one surface many times has no scatter, and the
    length 0, which has no logarithm: it counts as the shortest other.
    """
    random = generator(seed_of(question.root_seed, "readings"))
    sensitivities = sensitivities_of(closures, question.parameters)
    drawn = draw_studies(sensitivities, question.design, question.repetitions, random)
    lengths = lengths_table(drawn)
    return np.maximum(lengths, np.where(lengths > 0.0, lengths, np.inf).min(axis=0))


def _observed(question: Question) -> np.ndarray:
    """The paper's lengths in the order of `lengths_table`."""
    cycles = sorted({cycle for _, _, cycle in question.published})
    return np.array(
        [
            question.published[rock, parameter, cycle]
            for rock, of_rock in question.parameters.items()
            for parameter in of_rock
            for cycle in cycles
        ]
    )

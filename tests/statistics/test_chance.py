"""Scores by chance: exact where rows share no value."""

from itertools import product

import numpy as np
import pytest
import scipy

from jointclosure.statistics.chance import chance_of_scores

ROWS, QUANTITIES = 3, 5
VALUES = np.broadcast_to(np.arange(ROWS, dtype=float)[:, None, None], (ROWS, QUANTITIES, 1))
INTERVALS = VALUES - 0.1, VALUES + 0.1


def measured_as(rows):
    """Return ranges without width at the values of one row a quantity."""
    values = np.array(rows, dtype=float)[:, None]
    return values, values


def test_a_row_without_choice_scores_as_often_as_the_binomial_distribution_says():
    scores = chance_of_scores(VALUES, INTERVALS, measured_as([0, 0, 0, 1, 2]), np.arange(ROWS), 1)
    assert scores.score.tolist() == [3, 1, 1]
    exact = scipy.stats.binom.sf(2, QUANTITIES, 1.0 / ROWS)
    assert scores.chance[0] == pytest.approx(exact, abs=4.0 * np.sqrt(exact / 10_000))


def test_the_best_of_several_rows_is_chosen_anew_in_every_draw():
    """The best of three rows has 4 or more of 5 readings in 33 of 243 equally likely cases."""
    scores = chance_of_scores(VALUES, INTERVALS, measured_as([0, 0, 0, 0, 2]), np.zeros(ROWS), 1)
    counts = [max(map(case.count, range(ROWS))) for case in product(range(ROWS), repeat=QUANTITIES)]
    exact = np.mean(np.array(counts) >= 4)
    assert exact == pytest.approx(33 / 243)
    assert scores.chance[0] == pytest.approx(exact, abs=4.0 * np.sqrt(exact / 10_000))
    assert (scores.chance[1:] == 1.0).all()  # the best row always has at least one, or none


def test_a_range_counts_as_wide_as_it_was_measured():
    low, high = np.full((QUANTITIES, 1), 0.0), np.full((QUANTITIES, 1), 2.0)
    scores = chance_of_scores(VALUES, INTERVALS, (low, high), np.arange(ROWS), 1)
    assert scores.score.tolist() == [QUANTITIES] * ROWS
    exact = (2.0 / 3.0) ** QUANTITIES  # row 0 is within 1 of rows 0 and 1
    assert scores.chance[0] == pytest.approx(exact, abs=4.0 * np.sqrt(exact / 10_000))

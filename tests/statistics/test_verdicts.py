"""Verdicts on claims by their intervals, and the frequencies that they are based on."""

import numpy as np
import pytest

from jointclosure.inputs import InputError
from jointclosure.statistics import verdicts
from jointclosure.statistics.randomness import generator


@pytest.mark.parametrize(
    ("interval", "above", "alike", "expected"),
    [
        ((0.1, 0.2), 0.0, None, verdicts.STANDS),
        ((0.1, float("inf")), 0.0, None, verdicts.STANDS),
        ((-0.1, 0.2), 0.0, None, verdicts.UNDECIDED),
        ((-0.2, -0.1), 0.0, None, verdicts.FALLS),
        ((0.0, 0.0), 0.0, None, verdicts.FALLS),
        ((float("nan"), 1.0), 0.0, None, verdicts.UNDECIDED),
        ((float("nan"), -1.0), 0.0, None, verdicts.UNDECIDED),
        ((0.11, 0.2), 0.1, 0.1, verdicts.STANDS),
        ((0.05, 0.2), 0.1, 0.1, verdicts.UNDECIDED),
        ((-0.03, -0.01), 0.1, 0.1, verdicts.NO_DIFFERENCE),
        ((-0.1, 0.1), 0.1, 0.1, verdicts.NO_DIFFERENCE),
        ((-0.2, -0.05), 0.1, 0.1, verdicts.UNDECIDED),
        ((-0.2, -0.11), 0.1, 0.1, verdicts.FALLS),
    ],
)
def test_a_claim_stands_or_falls_by_its_interval(interval, above, alike, expected):
    assert verdicts.verdict(interval, above, alike) == expected


@pytest.mark.parametrize(
    ("given", "refused"),
    [
        ((0, 0), "n = 0"),
        ((3, 2), "count = 3"),
        ((-1, 2), "count = -1"),
        ((1.5, 2), "count = 1.5"),
        ((1, 2, np.nan), "pool_error = nan"),
        ((1, 2, -0.1), "pool_error = -0.1"),
    ],
)
def test_a_frequency_that_cannot_be_is_refused(given, refused):
    with pytest.raises(InputError, match=refused):
        verdicts.frequency(*given)


@pytest.mark.parametrize("given", [(np.nan, None), (0.0, -1.0), (0.0, np.nan)])
def test_a_verdict_by_limits_that_cannot_be_is_refused(given):
    with pytest.raises(InputError, match="alike ="):
        verdicts.verdict((0.0, 1.0), *given)


def test_a_frequency_covers_its_truth():
    random = generator(3)
    inside = []
    for _ in range(1000):
        found = verdicts.frequency(int(random.binomial(200, 0.9)), 200)
        inside.append(found.low <= 0.9 <= found.high)
    assert 0.93 <= np.mean(inside) <= 0.97
    assert verdicts.frequency(50, 50).low < 1.0


COUNTS = pytest.mark.parametrize("count", [0, 1, 25, 49, 50])


POOL_ERROR = 0.2


@COUNTS
def test_frequencies_are_shares_with_their_error(count):
    alone = verdicts.frequency(count, 50, 0.0)
    assert 0.0 <= alone.low <= alone.share <= alone.high <= 1.0
    exact = np.sqrt(count / 50 * (1.0 - count / 50) / 50)
    assert alone.standard_error == pytest.approx(exact)


@COUNTS
def test_the_error_of_their_pool_widens_frequencies(count):
    alone, with_pool = (verdicts.frequency(count, 50, error) for error in (0.0, POOL_ERROR))
    assert 0.0 <= with_pool.low <= alone.low <= alone.high <= with_pool.high <= 1.0
    wider = np.hypot(alone.standard_error, POOL_ERROR)
    assert with_pool.standard_error == pytest.approx(wider)


def test_the_error_of_a_pool_limits_frequencies_of_none_or_all():
    assert verdicts.frequency(50, 50, POOL_ERROR).low == pytest.approx(1.0 - 2.0 * POOL_ERROR)
    assert verdicts.frequency(0, 50, POOL_ERROR).high == pytest.approx(2.0 * POOL_ERROR)


def test_an_interval_whose_ends_are_swapped_has_no_verdict():
    with pytest.raises(ValueError, match="low <= high"):
        verdicts.verdict((0.2, 0.1), 0.0)

import numpy as np
import pytest

from jointclosure.statistics.randomness import generator
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.statistics.verdicts import (
    FALLS,
    NO_DIFFERENCE,
    STANDS,
    UNDECIDED,
    frequency,
    t_interval,
    verdict,
)


@pytest.mark.parametrize(
    ("interval", "above", "alike", "expected"),
    [
        ((0.1, 0.2), 0.0, None, STANDS),
        ((0.1, float("inf")), 0.0, None, STANDS),
        ((-0.1, 0.2), 0.0, None, UNDECIDED),
        ((-0.2, -0.1), 0.0, None, FALLS),
        ((0.0, 0.0), 0.0, None, FALLS),
        ((float("nan"), 1.0), 0.0, None, UNDECIDED),
        ((0.11, 0.2), 0.1, 0.1, STANDS),
        ((0.05, 0.2), 0.1, 0.1, UNDECIDED),
        ((-0.03, -0.01), 0.1, 0.1, NO_DIFFERENCE),
        ((-0.1, 0.1), 0.1, 0.1, NO_DIFFERENCE),
        ((-0.2, -0.05), 0.1, 0.1, UNDECIDED),
        ((-0.2, -0.11), 0.1, 0.1, FALLS),
    ],
)
def test_a_claim_stands_above_falls_below_and_a_difference_within_the_tolerance_is_none(
    interval, above, alike, expected
):
    assert verdict(interval, above, alike) == expected


def test_a_wrong_verdict_is_as_rare_as_the_confidence_says():
    random = generator(1)
    wrong = [
        verdict(t_interval(mean_of(random.normal(0.0, 1.0, 20)), 20), 0.0) for _ in range(4000)
    ]
    # the true number is on the threshold: to stand is wrong, in half of the 5 %
    assert wrong.count(STANDS) == pytest.approx(100, abs=30)
    assert wrong.count(FALLS) == pytest.approx(100, abs=30)


def test_a_frequency_covers_its_truth():
    random = generator(3)
    inside = []
    for _ in range(1000):
        found = frequency(int(random.binomial(200, 0.9)), 200)
        inside.append(found.low <= 0.9 <= found.high)
    assert 0.93 <= np.mean(inside) <= 0.97
    assert frequency(50, 50).low < 1.0

"""Intervals of means, and plans of joints at two levels of accuracy."""

import numpy as np
import pytest
import scipy.stats

from jointclosure.statistics.randomness import generator
from jointclosure.statistics.two_level import (
    FEWEST,
    Interval,
    best_plan,
    combined,
    t_interval,
    two_level_mean,
)


@pytest.mark.parametrize(
    ("low", "high", "limit", "expected"),
    [
        (-0.04, 0.03, 0.05, True),
        (-0.05, 0.05, 0.05, True),
        (0.051, 0.2, 0.05, False),
        (-0.2, -0.051, 0.05, False),
        (0.03, 0.06, 0.05, None),
        (-0.06, 0.03, 0.05, None),
        (-1.0, 1.0, 0.05, None),
        (-np.inf, np.inf, 0.05, None),
    ],
)
def test_an_interval_is_within_a_limit_outside_of_it_or_undecided(low, high, limit, expected):
    assert Interval(0.5 * (low + high), low, high).within(limit) is expected


def test_the_interval_of_a_mean_is_that_of_student_and_one_sample_has_none():
    samples = generator(1).normal(size=5)
    found = t_interval(samples)
    exact = scipy.stats.t.interval(0.95, 4, samples.mean(), scipy.stats.sem(samples))
    assert (found.low, found.high) == pytest.approx(exact)
    assert t_interval(samples[:1]) == (samples[0], -np.inf, np.inf)
    assert t_interval(np.ones(3)) == (1.0, 1.0, 1.0)


def test_one_difference_tells_no_error_and_differences_of_all_joints_are_a_plain_mean():
    cheap, fine = generator(2).normal(size=(2, 9))
    assert two_level_mean(cheap, fine[:1] - cheap[:1])[1:] == (-np.inf, np.inf)
    found, plain = two_level_mean(cheap, fine - cheap), t_interval(fine)
    assert found.value == pytest.approx(plain.value)
    assert found.high == pytest.approx(plain.high)
    # joints without a difference add their own error
    some = combined(0.0, [(cheap / 9.0, np.zeros(4))])
    squares = 4 * np.var(cheap[:4] / 9.0, ddof=1), 5 * np.var(cheap / 9.0, ddof=1)
    freedom = sum(squares) ** 2 / (squares[0] ** 2 / 3 + squares[1] ** 2 / 8)
    assert some.high == pytest.approx(scipy.stats.t.ppf(0.975, freedom) * np.sqrt(sum(squares)))
    # groups of joints are independent: their squared errors add
    one = combined(0.0, [(cheap / 9.0, 0.0 * cheap)])
    both = combined(0.0, [(cheap / 9.0, 0.0 * cheap)] * 2)
    wide, freedom = both.high / scipy.stats.t.ppf(0.975, 16), 8
    assert wide == pytest.approx(np.sqrt(2.0) * one.high / scipy.stats.t.ppf(0.975, freedom))


@pytest.mark.parametrize("deviations", [(0.2, 0.05), (0.2, 1e-4), (0.05, 0.2), (0.2, 0.0)])
def test_a_plan_keeps_its_budget_or_its_width_and_has_differences_enough_for_their_scatter(
    deviations,
):
    seconds = 1.0, 11.0
    plan = best_plan(deviations, seconds, 0.05)
    assert plan.half_width <= 0.05
    assert FEWEST == 8 <= plan.differences <= plan.joints
    assert plan.seconds == plan.joints * 1.0 + plan.differences * 11.0
    for budget in (0.7 * plan.seconds, plan.seconds, 3.0 * plan.seconds):
        bought = best_plan(deviations, seconds, 1e-9, budget)
        if bought is None:
            assert budget < FEWEST * sum(seconds)
            continue
        assert bought.seconds <= budget
        assert bought.differences >= FEWEST

"""Means at two levels of accuracy: their intervals, and plans of joints for them."""

import numpy as np
import pytest
import scipy.stats

from jointclosure.statistics.randomness import generator
from jointclosure.statistics.two_level import (
    FEWEST_DIFFERENCES,
    Interval,
    best_plan,
    change_interval,
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


SAMPLES = generator(1).normal(size=5)


def test_the_interval_of_a_mean_is_that_of_student():
    found = t_interval(SAMPLES)
    exact = scipy.stats.t.interval(0.95, 4, SAMPLES.mean(), scipy.stats.sem(SAMPLES))
    assert (found.low, found.high) == pytest.approx(exact)
    assert t_interval(np.ones(3)) == (1.0, 1.0, 1.0)


def test_one_sample_has_no_end_of_its_interval():
    assert t_interval(SAMPLES[:1]) == (SAMPLES[0], -np.inf, np.inf)


def test_an_interval_without_a_width_is_within_its_value():
    assert t_interval(np.ones(3)).within(1.0)


def test_two_level_means_cover_the_truth_as_often_as_they_say():
    random = np.random.default_rng(1)
    truth, covered, runs = 2.0, 0, 2000
    for _ in range(runs):
        cheap = random.normal(truth + 0.5, 1.0, 30)
        # the difference goes with the closure in part
        differences = random.normal(-0.5, 0.3, 8) + 0.3 * (cheap[:8] - truth - 0.5)
        mean = two_level_mean(cheap, differences)
        covered += mean.low <= truth <= mean.high
    assert covered / runs == pytest.approx(0.95, abs=0.015)


CHEAP, FINE = generator(2).normal(size=(2, 9))


def test_one_difference_alone_has_no_error():
    assert two_level_mean(CHEAP, FINE[:1] - CHEAP[:1])[1:] == (-np.inf, np.inf)


def test_differences_of_all_joints_are_a_plain_mean():
    found, plain = two_level_mean(CHEAP, FINE - CHEAP), t_interval(FINE)
    assert found.value == pytest.approx(plain.value)
    assert found.high == pytest.approx(plain.high)


def test_joints_without_a_difference_add_their_own_error():
    some = combined(0.0, [(CHEAP / 9.0, np.zeros(4))])
    squares = 4 * np.var(CHEAP[:4] / 9.0, ddof=1), 5 * np.var(CHEAP / 9.0, ddof=1)
    freedom = sum(squares) ** 2 / (squares[0] ** 2 / 3 + squares[1] ** 2 / 8)
    assert some.high == pytest.approx(scipy.stats.t.ppf(0.975, freedom) * np.sqrt(sum(squares)))


def test_squared_errors_of_independent_groups_of_joints_add():
    one = combined(0.0, [(CHEAP / 9.0, 0.0 * CHEAP)])
    both = combined(0.0, [(CHEAP / 9.0, 0.0 * CHEAP)] * 2)
    wide, freedom = both.high / scipy.stats.t.ppf(0.975, 16), 8
    assert wide == pytest.approx(np.sqrt(2.0) * one.high / scipy.stats.t.ppf(0.975, freedom))


DEVIATIONS, SECONDS = (0.2, 0.05), (1.0, 11.0)
"""Standard deviations of both levels, and what one joint of each takes."""


def test_a_plan_reaches_its_half_width():
    plan = best_plan(DEVIATIONS, SECONDS, 0.05)
    random = np.random.default_rng(2)
    samples = (random.normal(0.0, d, (4000, n)) for d, n in zip(DEVIATIONS, plan[:2], strict=True))
    means = sum(sample.mean(axis=1) for sample in samples)
    assert np.quantile(np.abs(means), 0.95) == pytest.approx(plan.half_width, rel=0.12)
    assert plan.half_width <= 0.05


def test_a_smaller_budget_buys_a_wider_interval():
    plan = best_plan(DEVIATIONS, SECONDS, 0.05)
    assert best_plan(DEVIATIONS, SECONDS, 1.0, 0.7 * plan.seconds).half_width > 0.05


def test_a_budget_below_the_fewest_joints_has_no_plan():
    assert best_plan(DEVIATIONS, SECONDS, 1.0, 50.0) is None


@pytest.mark.parametrize("share", [0.9, 0.7])
def test_no_cheaper_mix_of_both_levels_reaches_the_half_width(share):
    plan = best_plan(DEVIATIONS, SECONDS, 0.05)
    assert best_plan(DEVIATIONS, SECONDS, 0.05, share * plan.seconds).half_width > 0.05


SCATTERS = pytest.mark.parametrize(
    "deviations", [(0.2, 0.05), (0.2, 1e-4), (0.05, 0.2), (0.2, 0.0)]
)


@SCATTERS
def test_a_plan_keeps_its_width(deviations):
    plan = best_plan(deviations, SECONDS, 0.05)
    assert plan.half_width <= 0.05
    assert plan.seconds == plan.joints * 1.0 + plan.differences * 11.0


@SCATTERS
def test_a_plan_has_differences_enough_for_their_scatter(deviations):
    plan = best_plan(deviations, SECONDS, 0.05)
    assert FEWEST_DIFFERENCES == 8 <= plan.differences <= plan.joints


@SCATTERS
def test_a_plan_keeps_its_budget(deviations):
    plan = best_plan(deviations, SECONDS, 0.05)
    for budget in (0.7 * plan.seconds, plan.seconds, 3.0 * plan.seconds):
        bought = best_plan(deviations, SECONDS, 1e-9, budget)
        if bought is None:
            assert budget < FEWEST_DIFFERENCES * sum(SECONDS)
            continue
        assert bought.seconds <= budget
        assert bought.differences >= FEWEST_DIFFERENCES


def test_a_positive_result_decreases_by_no_less_than_all_of_it():
    samples = np.array([-0.5, 0.7])
    assert t_interval(samples).low < -1.0
    interval = change_interval(samples)
    assert (interval.low, interval.high) == (-1.0, t_interval(samples).high)
    assert change_interval(samples[:1]).low == -np.inf  # of one joint nothing is known

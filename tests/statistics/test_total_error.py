"""Total error is bias and sampling; what control variates are worth is split as it was found."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jointclosure.statistics.total_error import (
    REACH,
    Bias,
    Method,
    common_bias,
    front,
    shares,
)


def coverage(
    surfaces: int, sampling: float, spread: float = 1.0, studies: int = 20_000, seed: int = 1
) -> float:
    """Simulate how often the error of a study is below `Bias.total`, with skewed errors."""
    random = np.random.default_rng(seed)
    mean, variance = np.exp(0.5 * spread**2), np.exp(2.0 * spread**2) - np.exp(spread**2)
    drawn = np.exp(spread * random.standard_normal((studies, surfaces)))
    errors = 5.0 + (drawn - mean) / np.sqrt(variance)
    standard = sampling / np.sqrt(surfaces)
    found = 5.0 + standard * random.standard_normal(studies)
    known_to = errors.std(axis=1, ddof=1) / np.sqrt(surfaces)
    biases = map(Bias, errors.mean(axis=1), known_to)
    bounds = [bias.total(REACH * standard) for bias in biases]
    return float(np.mean(np.abs(found) <= bounds))


METHOD = Method(
    bias=Bias(-0.02), scatter=0.1, left=0.02, explained=0.98, cost=0.5, measured_cost=3e-3, least=15
)


def test_total_error_is_bias_and_half_the_interval_of_surfaces_closed_and_measured():
    plain = METHOD._replace(left=1.0, explained=0.0)
    assert plain.total(25) == pytest.approx(0.02 + REACH * 0.1 / 5.0)
    both = np.sqrt(0.02 / 25 + 0.98 / 4000)
    assert METHOD.total(25, 4000) == pytest.approx(0.02 + REACH * 0.1 * both)
    assert METHOD.seconds(25, 4000) == pytest.approx(25 * 0.5 + 12.0)


@given(worth=st.floats(0.5, 200.0), surfaces=st.integers(10, 200), many=st.integers(2, 400))
def test_shares_give_back_the_worth_that_they_were_found_from(worth, surfaces, many):
    measured = surfaces * many
    left, explained = shares(worth, surfaces, measured)
    adjusted = left / surfaces + explained / measured
    assert adjusted * surfaces == pytest.approx(1.0 / worth)
    assert explained == 0.0 if worth <= 1.0 else explained > 0.0
    assert worth <= 1.0 or left + explained == pytest.approx(1.0)  # of the plain variance


@given(within=st.floats(0.021, 0.5))
def test_the_fewest_surfaces_meet_a_bound_and_one_fewer_does_not(within):
    count = METHOD.surfaces_for(within, 100_000)
    if np.isinf(count):
        assert METHOD.total(1e12, 100_000) > within
        return
    assert METHOD.total(count, 100_000) <= within + 1e-12
    assert count == METHOD.least or METHOD.total(count - 1, 100_000) > within


def test_the_bound_holds_for_skewed_biases_that_are_known_from_many_surfaces():
    assert coverage(48, 1.0) > 0.945
    assert 0.85 < coverage(48, 0.0) < 0.93  # one-sided, as the mean of few skewed values is low
    assert coverage(8, 0.0) < 0.85
    assert coverage(300, 0.0, spread=0.1) == pytest.approx(0.975, abs=0.006)


def test_no_number_of_surfaces_takes_a_bias_away():
    assert METHOD.surfaces_for(0.02) == np.inf
    assert METHOD.surfaces_for(0.021, measured=10) == np.inf


def test_the_front_is_what_no_other_beats_in_both():
    seconds = np.array([1.0, 2.0, 2.0, 3.0, 4.0, 0.5])
    errors = np.array([5.0, 4.0, 3.0, 3.0, 1.0, 9.0])
    assert front(seconds, errors).tolist() == [5, 0, 2, 4]


def test_a_bias_in_common_is_the_weighted_mean_unless_the_measured_ones_differ():
    alike = common_bias([Bias(0.02, 0.01), Bias(0.03, 0.02)])
    assert alike.value == pytest.approx((4 * 0.02 + 0.03) / 5)
    assert alike.error == pytest.approx(0.01 * np.sqrt(4 / 5))
    apart = common_bias([Bias(-0.1, 0.001), Bias(0.1, 0.001)])
    assert apart.value == pytest.approx(0.0)
    assert apart.error > 0.1  # it is also the error of a single one
    assert common_bias([Bias(0.02, 0.01)]) == pytest.approx((0.02, 0.01))
    exact = common_bias([Bias(0.0), Bias(0.0)])
    assert exact == pytest.approx((0.0, 0.0), abs=1e-12)

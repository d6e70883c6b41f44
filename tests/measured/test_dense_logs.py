"""Scatter, loadings, spikes and means of dense logs of stress and closure."""

import numpy as np
import pytest

from jointclosure.measured.dense_logs import (
    LEAST_POINTS,
    _group_numbers,
    _is_scattered,
    _line_at_end,
    _number_of_means,
    averaged,
    scatter_of,
    smoothed,
    spikes,
    troughs,
)


def noise(count, size=1.0, seed=1):
    return size * np.random.default_rng(seed).standard_normal(count)


def test_values_in_steps_scatter_by_the_rounding_to_a_step():
    assert scatter_of(np.repeat(np.arange(10.0), 10)) == pytest.approx(1.0 / np.sqrt(12.0))


def test_constant_values_do_not_scatter():
    assert scatter_of(np.ones(100)) == 0.0


def test_scatter_is_known_of_thirty_values():
    assert scatter_of(noise(LEAST_POINTS)) == pytest.approx(1.0, rel=0.5)
    assert scatter_of(noise(LEAST_POINTS - 1)) == 0.0


def test_few_values_that_do_not_exceed_former_ones_are_no_scatter():
    assert not _is_scattered(np.where(np.arange(1000) % 20, np.arange(1000.0), -1.0))  # 5 %
    assert not _is_scattered(np.array([*range(18), 0.0, 1.0]))  # two of twenty
    assert _is_scattered(noise(100))


def test_stresses_are_smoothed_over_no_more_than_a_fiftieth_of_a_log():
    steps = np.arange(1000) >= 500
    wide = np.abs(np.diff(smoothed(steps + noise(1000, 0.5)))).max()
    assert wide > 0.5 / 20  # of a mean over 20 points, and not of one over more
    few = np.arange(100.0) + noise(100, 20.0)
    assert smoothed(few) is few


def test_a_fall_of_more_than_a_quarter_divides_two_loadings_however_much_stresses_scatter():
    turns = np.interp(np.arange(120), [0, 40, 80, 119], [0.0, 10.0, 6.0, 10.0])
    assert len(troughs(turns + noise(120, 0.4))) == 1
    assert troughs(np.linspace(0.0, 10.0, 120) + noise(120, 0.4)) == []


def test_a_value_beside_a_jump_is_no_spike():
    jump = np.linspace(0.0, 1.0, 400) + 5.0 * (np.arange(400) >= 200)
    turn = jump.copy()
    turn[200] = 2.0
    assert spikes(jump).size == spikes(turn).size == 0
    turn = np.linspace(0.0, 1.0, 400)
    turn[200] = 2.0
    assert spikes(turn).tolist() == [200]


def test_there_is_one_mean_or_half_as_many_as_points_at_most():
    assert _number_of_means(100, 0.0, 1.0) == 1.0
    assert _number_of_means(100, 1e6, 1e-6) == 50.0
    assert _number_of_means(100, 1.0, 0.0) == 50.0


def test_points_at_one_held_stress_are_one_group():
    stress = np.concatenate([np.linspace(0.0, 1.0, 100), np.ones(100), np.linspace(1.0, 2.0, 100)])
    group = _group_numbers(stress, np.linspace(0.0, 1.0, 300) + noise(300, 0.02))
    assert len(set(group[99:201])) == 1
    assert len(set(group)) > 5


def test_points_of_one_stress_and_closure_are_one_group():
    assert set(_group_numbers(np.ones(40), np.ones(40))) == {0}


def test_a_log_that_scatters_much_has_several_means():
    rising = np.linspace(0.0, 1.0, 400)
    group = _group_numbers(rising + noise(400, 0.5), rising + noise(400, 0.5, 2))
    assert 3 <= len(set(group)) <= 9


@pytest.mark.parametrize("fast", [slice(0, 20), slice(490, 510), slice(980, 1000)])
def test_no_group_has_few_points_where_the_load_is_fast(fast):
    rate = np.ones(1000)
    rate[fast] = 50.0
    stress = np.cumsum(rate) / rate.sum() + noise(1000, 0.005)
    closure = np.cumsum(rate) / rate.sum() + noise(1000, 0.005, 2)
    sizes = np.bincount(_group_numbers(stress, closure))
    assert sizes.size > 4
    assert sizes.min() >= 6


def test_a_line_ends_within_the_values_through_which_it_is_laid():
    assert _line_at_end(np.array([0.0, 1.0, 2.0]), -1) == pytest.approx(2.0)
    assert _line_at_end(np.array([0.0, 0.0, 0.0, 1.0]), 0) == 0.0
    assert _line_at_end(np.array([0.0, 1.0, 1.0, 1.0]), -1) == 1.0


def test_fewer_points_than_thirty_are_not_averaged():
    rising = np.linspace(0.0, 1.0, 40)
    for count, means in ((40, True), (LEAST_POINTS - 1, False)):
        branch = averaged(rising[:count] + noise(count, 0.2), rising[:count])
        assert branch.averaged == means


@pytest.mark.parametrize("held", [False, True])
def test_an_averaged_branch_ends_at_its_largest_stress(held):
    rising = np.linspace(0.0, 1.0, 600)
    stress = np.minimum(1.25 * rising, 1.0) if held else rising
    branch = averaged(stress + noise(600, 0.01), rising + noise(600, 0.01, 2))
    assert branch.stress[-1] == pytest.approx(1.0, abs=0.012)
    if held:  # the mean of the hold, without a further point for its end
        assert branch.points[-1] > 100


def test_the_error_of_the_end_of_a_line_is_twice_that_of_a_mean_of_its_points():
    rising = np.linspace(0.0, 1.0, 1000)
    ratios = []
    for seed in range(0, 40, 2):
        scattered = (rising + noise(1000, 0.01, seed + i) for i in range(2))
        branch = averaged(*scattered)
        if branch.points[0] == branch.points[1]:  # those of the first mean, which are read twice
            ratios.append(branch.errors[0] / branch.errors[1])
    assert len(ratios) > 10
    assert 1.5 < np.mean(ratios) < 2.5


def test_points_at_one_stress_are_one_mean_with_the_error_of_their_scatter():
    branch = averaged(np.ones(200), 1.0 + noise(200, 0.02))
    assert branch.points.tolist() == [200]
    assert branch.errors == pytest.approx([0.02 / np.sqrt(200)], rel=0.2)

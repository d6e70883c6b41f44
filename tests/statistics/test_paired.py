"""Indifference intervals of paired samples, which have the same surfaces at all levels."""

import numpy as np
import pytest
import scipy.stats

import jointclosure as jc
from jointclosure.statistics.indifference import (
    difference_scatter,
    p_of_difference,
    paired_indifference_interval,
)
from jointclosure.statistics.quadratics import fit_quadratic, paired_lack_of_fit
from jointclosure.statistics.randomness import generator

LEVELS = np.array([70.0, 78.0, 86.0])


def responses(random, levels, n, slope=-0.02, own_slope=0.005, irregular=0.02, between=0.2):
    """Lines with a common slope, one of their own, and an irregular part, on n surfaces."""
    u = levels[:, None] - levels.mean()
    height = 1.0 + between * random.normal(size=n)
    own = own_slope * random.normal(size=n)
    return height + (slope + own) * u + irregular * random.normal(size=(levels.size, n))


def t_value(levels, samples, base, p):
    mean = fit_quadratic(levels, samples.mean(axis=1), base)
    scatter = difference_scatter(levels, samples, base)
    u = (p - base) / mean.half_range
    variance = (scatter.slope * u**2 + 2.0 * scatter.irregular) / samples.shape[1]
    return (mean.at(p) - mean.d) / np.sqrt(variance)


def pairs_with_interval(count, seed):
    """Levels, responses of the same surfaces at each, and their indifference interval."""
    levels = np.linspace(70.0, 86.0, count)
    samples = responses(generator(seed), levels, 20)
    found = paired_indifference_interval(levels, samples)
    assert found.critical_value == pytest.approx(scipy.stats.t.ppf(0.975, 19))
    assert found.length > 0.0
    return levels, samples, found


COUNTS = pytest.mark.parametrize("count", [3, 5, 9])
SEEDS = pytest.mark.parametrize("seed", range(3))


@COUNTS
@SEEDS
def test_at_the_root_the_paired_t_is_critical(count, seed):
    levels, samples, found = pairs_with_interval(count, seed)
    at_root = t_value(levels, samples, 78.0, found.root)
    assert abs(at_root) == pytest.approx(found.critical_value, rel=1e-6)


@COUNTS
@SEEDS
def test_no_critical_paired_t_is_closer_than_the_root(count, seed):
    levels, samples, found = pairs_with_interval(count, seed)
    inside = 78.0 + found.length * np.array([-0.99, -0.5, -0.01, 0.01, 0.5, 0.99])
    assert np.all(np.abs(t_value(levels, samples, 78.0, inside)) < found.critical_value)


@pytest.mark.parametrize("count", [3, 5])
def test_both_parts_of_the_scatter_are_estimated_without_bias(count):
    levels = np.linspace(70.0, 86.0, count)
    random = generator(3)
    found = [difference_scatter(levels, responses(random, levels, 20), 78.0) for _ in range(400)]
    assert np.mean([one.irregular for one in found]) == pytest.approx(0.02**2, rel=0.05)
    assert np.mean([one.slope for one in found]) == pytest.approx((8 * 0.005) ** 2, rel=0.05)


def test_a_change_of_the_length_is_seen_in_about_half_of_the_studies_made_with_it():
    # half the t values pass their expectation
    random = generator(5)
    n, slope, own, sigma = 20, -0.02, 0.005, 0.02
    t = scipy.stats.t.ppf(0.975, n - 1)
    length = t * np.sqrt(2.0 / n) * sigma / np.sqrt(slope**2 - t**2 * own**2 / n)
    found = [
        paired_indifference_interval(LEVELS, responses(random, LEVELS, n)).linear_length
        for _ in range(400)
    ]
    assert np.median(found) == pytest.approx(length, rel=0.05)
    seen = []
    for _ in range(2000):
        before, after = responses(random, np.array([-0.5, 0.5]) * length, n)
        seen.append(p_of_difference(before, after, paired=True) < 0.05)
    assert 0.44 < np.mean(seen) < 0.56


def test_p_of_a_difference_is_that_of_scipys_t_tests():
    first, second = generator(3).normal(size=(2, 5))
    for paired, test in ((True, scipy.stats.ttest_rel), (False, scipy.stats.ttest_ind)):
        expected = test(first, second).pvalue
        assert p_of_difference(first, second, paired) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("count", [5, 9])
def test_paired_lack_of_fit_is_uniform_for_a_quadratic(count):
    levels = np.linspace(70.0, 86.0, count)
    random = generator(9)
    curve = 1e-3 * (levels[:, None] - 78.0) ** 2
    fitted = [paired_lack_of_fit(levels, responses(random, levels, 20) + curve) for _ in range(400)]
    assert scipy.stats.kstest(fitted, "uniform").pvalue > 0.001


@pytest.mark.parametrize("count", [5, 9])
def test_paired_lack_of_fit_is_small_for_a_kink(count):
    levels = np.linspace(70.0, 86.0, count)
    kink = 0.03 * np.abs(levels[:, None] - 78.0)
    assert paired_lack_of_fit(levels, responses(generator(9), levels, 20) + kink) < 1e-3


def test_paired_lack_of_fit_is_unknown_of_three_levels():
    assert np.isnan(paired_lack_of_fit(LEVELS, responses(generator(9), LEVELS, 20)))


def test_surfaces_that_differ_only_in_height_leave_the_length_alone():
    random = generator(4)
    samples = responses(random, LEVELS, 20)
    other = paired_indifference_interval(1e9 * LEVELS, samples + 5.0 * random.normal(size=20))
    found = paired_indifference_interval(LEVELS, samples)
    assert other.length == pytest.approx(1e9 * found.length, rel=1e-9)
    moments = samples.mean(axis=1), samples.std(axis=1, ddof=1)
    assert found.length < 0.5 * jc.indifference_interval(LEVELS, *moments, 20).length


def test_a_paired_length_is_flagged_beyond_the_levels():
    random = generator(12)
    for slope, outside in ((-0.02, False), (-0.0015, True)):
        found = paired_indifference_interval(LEVELS, responses(random, LEVELS, 20, slope, 0.0))
        assert found.extrapolated == outside == (found.length > 8.0)


def test_a_paired_length_has_no_end_without_a_significant_slope():
    samples = responses(generator(12), LEVELS, 20)
    centred = samples - samples.mean(axis=1, keepdims=True)
    assert paired_indifference_interval(LEVELS, centred).linear_length == np.inf


def test_more_surfaces_than_those_of_the_samples_make_a_paired_length_shorter():
    """As 1/sqrt(n)."""
    samples = responses(generator(13), LEVELS, 20, own_slope=0.0)
    few, many = (paired_indifference_interval(LEVELS, samples, surfaces=n) for n in (20, 2000))
    ratio = few.critical_value / many.critical_value * 10.0
    assert few.linear_length / many.linear_length == pytest.approx(ratio, rel=0.05)


@pytest.fixture(scope="module")
def alike():
    """Samples of surfaces that respond alike, and the scatter that is found of them."""
    random, found = generator(14), []
    for _ in range(100):
        samples = responses(random, LEVELS, 5, own_slope=0.0)
        found.append((samples, difference_scatter(LEVELS, samples, 78.0)))
    return found


def test_surfaces_that_respond_alike_have_no_negative_scatter_of_slopes(alike):
    assert all(scatter.slope >= 0.0 for _, scatter in alike)


def test_deviations_without_a_scatter_of_slopes_are_of_the_irregular_part(alike):
    """About a constant of each surface."""
    without = [(samples, scatter) for samples, scatter in alike if scatter.slope == 0.0]
    for samples, scatter in without:
        apart = samples - samples.mean(axis=1, keepdims=True)
        apart -= apart.mean(axis=0)
        assert scatter.irregular == pytest.approx((apart**2).sum() / (4 * 2))
    assert 20 < len(without) < 80


@pytest.mark.parametrize("paired", [True, False])
def test_a_difference_without_scatter_is_certain(paired):
    assert p_of_difference(np.ones(5), np.full(5, 2.0), paired) == 0.0


@pytest.mark.parametrize("paired", [True, False])
def test_no_difference_without_scatter_is_none(paired):
    assert p_of_difference(np.ones(5), np.ones(5), paired) == 1.0

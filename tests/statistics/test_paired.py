import numpy as np
import pytest
import scipy.stats

import jointclosure as jc
from jointclosure.statistics.correlations import fit_quadratic, paired_lack_of_fit
from jointclosure.statistics.indifference import (
    difference_scatter,
    p_of_difference,
    paired_indifference_interval,
)
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


@pytest.mark.parametrize("count", [3, 5, 9])
@pytest.mark.parametrize("seed", range(3))
def test_at_the_root_the_paired_t_is_critical_and_nowhere_closer(count, seed):
    levels = np.linspace(70.0, 86.0, count)
    samples = responses(generator(seed), levels, 20)
    found = paired_indifference_interval(levels, samples)
    assert found.critical_value == pytest.approx(scipy.stats.t.ppf(0.975, 19))
    assert found.length > 0.0
    at_root = t_value(levels, samples, 78.0, found.root)
    assert abs(at_root) == pytest.approx(found.critical_value, rel=1e-6)
    inside = 78.0 + found.length * np.array([-0.99, -0.5, -0.01, 0.01, 0.5, 0.99])
    inner = np.abs(t_value(levels, samples, 78.0, inside))
    assert np.all(inner < found.critical_value)


@pytest.mark.parametrize("count", [3, 5])
def test_the_irregular_part_and_the_scatter_of_slopes_are_estimated_without_bias(count):
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
def test_paired_lack_of_fit_is_uniform_for_a_quadratic_and_small_for_a_kink(count):
    levels = np.linspace(70.0, 86.0, count)
    random = generator(9)
    curve = 1e-3 * (levels[:, None] - 78.0) ** 2
    kink = 0.03 * np.abs(levels[:, None] - 78.0)
    fitted = [paired_lack_of_fit(levels, responses(random, levels, 20) + curve) for _ in range(400)]
    assert scipy.stats.kstest(fitted, "uniform").pvalue > 0.001
    assert paired_lack_of_fit(levels, responses(random, levels, 20) + kink) < 1e-3
    assert np.isnan(paired_lack_of_fit(LEVELS, responses(random, LEVELS, 20)))


def test_surfaces_that_differ_only_in_height_leave_the_length_alone():
    random = generator(4)
    samples = responses(random, LEVELS, 20)
    other = paired_indifference_interval(1e9 * LEVELS, samples + 5.0 * random.normal(size=20))
    found = paired_indifference_interval(LEVELS, samples)
    assert other.length == pytest.approx(1e9 * found.length, rel=1e-9)
    moments = samples.mean(axis=1), samples.std(axis=1, ddof=1)
    assert found.length < 0.5 * jc.indifference_interval(LEVELS, *moments, 20).length


def test_a_paired_length_has_no_end_without_a_significant_slope_and_is_flagged_beyond_the_levels():
    random = generator(12)
    for slope, outside in ((-0.02, False), (-0.0015, True)):
        found = paired_indifference_interval(LEVELS, responses(random, LEVELS, 20, slope, 0.0))
        assert found.extrapolated == outside == (found.length > 8.0)
    samples = responses(random, LEVELS, 20)
    centred = samples - samples.mean(axis=1, keepdims=True)
    assert paired_indifference_interval(LEVELS, centred).linear_length == np.inf
    # more surfaces than those of the samples make it shorter as 1/sqrt(n)
    samples = responses(generator(13), LEVELS, 20, own_slope=0.0)
    few, many = (paired_indifference_interval(LEVELS, samples, surfaces=n) for n in (20, 2000))
    ratio = few.critical_value / many.critical_value * 10.0
    assert few.linear_length / many.linear_length == pytest.approx(ratio, rel=0.05)


def test_surfaces_that_respond_alike_have_no_scatter_of_slopes_and_not_a_negative_one():
    """Their deviations then tell of the irregular part about a constant of each surface."""
    random, alike = generator(14), 0
    for _ in range(100):
        samples = responses(random, LEVELS, 5, own_slope=0.0)
        found = difference_scatter(LEVELS, samples, 78.0)
        assert found.slope >= 0.0
        if found.slope == 0.0:
            alike += 1
            apart = samples - samples.mean(axis=1, keepdims=True)
            apart -= apart.mean(axis=0)
            assert found.irregular == pytest.approx((apart**2).sum() / (4 * 2))
    assert 20 < alike < 80


def test_a_difference_without_scatter_is_certain_and_no_difference_is_none():
    same = np.ones(5)
    for paired in (True, False):
        assert p_of_difference(same, same, paired) == 1.0
        assert p_of_difference(same, 2.0 * same, paired) == 0.0

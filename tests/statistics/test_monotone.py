import numpy as np
import pytest
import scipy.stats

import jointclosure as jc
from jointclosure.statistics.monotone import monotone_interval
from jointclosure.statistics.paired import difference_scatter
from jointclosure.statistics.randomness import generator

LEVELS = np.linspace(-1.0, 1.0, 9)


def with_moments(means, deviations, n=20):
    """Samples (k, n) of exactly these means and standard deviations."""
    shape = scipy.stats.norm.ppf((np.arange(n) + 0.5) / n)
    shape /= shape.std(ddof=1)
    return np.asarray(means)[:, None] + np.asarray(deviations)[:, None] * shape


@pytest.mark.parametrize("slope", [0.2, -0.5])
def test_on_a_line_the_length_is_that_of_the_quadratic(slope):
    samples = with_moments(1.0 + slope * LEVELS, 0.1 + 0.02 * LEVELS)
    found = monotone_interval(LEVELS, samples)
    exact = jc.indifference_interval(LEVELS, samples.mean(axis=1), samples.std(axis=1, ddof=1), 20)
    assert found.length == pytest.approx(exact.length, rel=1e-9)
    assert found.root == pytest.approx(exact.root, rel=1e-9)
    assert (found.fitted[-1] > found.fitted[0]) == (slope > 0)


def test_a_kink_is_followed_where_the_quadratic_smooths_it():
    # flat below the base, steep above: t is critical on the steep side
    means = 1.0 + 0.4 * np.maximum(LEVELS, 0.0)
    samples = with_moments(means, np.full(9, 0.1))
    found = monotone_interval(LEVELS, samples)
    expected = scipy.stats.t.ppf(0.975, 38) * np.sqrt(2 / 20) * 0.1 / 0.4
    assert found.root == pytest.approx(expected, rel=1e-9)
    quadratic = jc.indifference_interval(LEVELS, means, np.full(9, 0.1), 20)
    assert abs(quadratic.length - expected) > 0.2 * expected


def test_a_change_that_is_significant_beyond_the_levels_only_has_no_length():
    samples = with_moments(1.0 + 0.01 * LEVELS, np.full(9, 0.1))
    found = monotone_interval(LEVELS, samples)
    assert np.isnan(found.length)
    assert np.isnan(found.root)


def test_noise_against_the_trend_is_levelled():
    samples = with_moments([1.0, 1.2, 1.1, 1.3, 1.5], np.full(5, 0.1))
    found = monotone_interval(np.arange(5.0), samples)
    np.testing.assert_allclose(found.fitted, [1.0, 1.15, 1.15, 1.3, 1.5])


@pytest.mark.parametrize("paired", [False, True])
def test_at_the_root_the_t_value_is_critical(paired):
    random = generator(1)
    n = 20
    common = random.normal(size=n)
    for _ in range(20):
        effect = 0.1 * np.sign(LEVELS) * np.sqrt(np.abs(LEVELS))
        noise = 0.03 * random.normal(size=(9, n))
        samples = 1.0 + effect[:, None] + 0.1 * common + noise
        found = monotone_interval(LEVELS, samples, paired=paired)
        x = np.interp(found.root, LEVELS, found.fitted) - found.fitted[4]
        s = samples.std(axis=1, ddof=1)
        variance = np.interp(found.root, LEVELS, s) ** 2 + s[4] ** 2
        if paired:
            scatter = difference_scatter(LEVELS, samples, 0.0)
            variance = scatter.slope * found.root**2 + 2.0 * scatter.irregular
        critical = scipy.stats.t.ppf(0.975, n - 1 if paired else 2 * n - 2)
        assert abs(x) / np.sqrt(variance / n) == pytest.approx(critical, rel=1e-6)


def test_the_paired_length_is_the_shorter_where_surfaces_differ_in_height_only():
    random = generator(2)
    samples = 0.3 * LEVELS[:, None] + random.normal(size=20) + 0.02 * random.normal(size=(9, 20))
    paired = monotone_interval(LEVELS, samples, paired=True)
    assert 0.0 < paired.length < 0.3
    assert np.isnan(monotone_interval(LEVELS, samples).length)

import hypothesis.strategies as st
import mpmath
import numpy as np
import pytest
import scipy.stats
from hypothesis import given

import jointclosure as jc
from jointclosure.statistics.correlations import fit_quadratic, lack_of_fit
from jointclosure.statistics.indifference import (
    bootstrap_length,
    indifference_lengths,
    interval_of_lengths,
    paired_indifference_interval,
)
from jointclosure.statistics.randomness import generator

LEVELS = np.array([70.0, 78.0, 85.0])


def t_value(levels, means, deviations, n, at):
    mean, deviation = (fit_quadratic(levels, v, levels[1]) for v in (means, deviations))
    scatter = (deviation.at(at) ** 2 + deviation.d**2) / n
    return (mean.at(at) - mean.d) / np.sqrt(scatter)


@given(
    means=st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3),
    deviations=st.lists(st.floats(0.01, 1.0), min_size=3, max_size=3),
    n=st.integers(2, 100),
)
def test_the_root_is_where_the_t_test_becomes_critical_and_none_is_closer(means, deviations, n):
    found = jc.indifference_interval(LEVELS, means, deviations, n)
    critical = scipy.stats.t.ppf(0.975, 2 * n - 2)
    reach = found.length if np.isfinite(found.length) else 200.0
    inside = np.linspace(78.0 - 0.999 * reach, 78.0 + 0.999 * reach, 401)
    values = np.abs(t_value(LEVELS, means, deviations, n, inside))
    assert np.all(values <= critical * (1 + 1e-6))
    if np.isfinite(found.length):
        at_root = abs(t_value(LEVELS, means, deviations, n, found.root))
        assert at_root == pytest.approx(critical, rel=1e-6)
        assert found.extrapolated == (not 70.0 <= found.root <= 85.0)


def test_no_variation_has_no_root_and_no_scatter_no_length():
    assert np.isnan(jc.indifference_interval(LEVELS, [1.0] * 3, [0.1] * 3, 20).length)
    assert np.isnan(jc.indifference_interval(LEVELS, [1.0] * 3, [0.0] * 3, 20).length)
    assert jc.indifference_interval(LEVELS, [1.1, 1.0, 0.9], [0.0] * 3, 20).length == 0.0


def test_a_scatter_that_outgrows_the_mean_has_no_root_but_none_at_the_base_a_length_of_0():
    levels = np.array([-1.0, 0.0, 1.0])
    found = jc.indifference_interval(levels, [0.1, 0.0, 0.1], [2.0, 1.0, 2.0], 20)
    assert np.isnan(found.length)
    assert not found.extrapolated
    found = jc.indifference_interval(levels, [-0.01, 0.0, 0.01], [1.0, 0.0, 1.0], 20)
    assert found.length == 0.0  # S ~ u^2 against x ~ u: the smallest change is significant


def exact_length(levels, means, deviations, n, critical):
    """The length by all roots of Eq. (29) in 150 digits, NaN without a real one.

    The parameter is counted from p_M, which loses no digits in exact arithmetic. A root is real
    if its imaginary part is below 1e-30.
    """
    with mpmath.workdps(150):
        p, mean, deviation = (
            [mpmath.mpf(float(v)) for v in row] for row in (levels, means, deviations)
        )
        half_range = (p[2] - p[0]) / 2
        powers = mpmath.matrix([[((v - p[1]) / half_range) ** k for k in (2, 1, 0)] for v in p])
        (b, c, d), (bs, cs, ds) = (
            mpmath.lu_solve(powers, mpmath.matrix(v)) for v in (mean, deviation)
        )
        rise, t2 = d - mean[1], mpmath.mpf(critical) ** 2
        quartic = [
            n * b**2 - t2 * bs**2,
            2 * n * b * c - 2 * t2 * bs * cs,
            n * c**2 + 2 * n * b * rise - t2 * cs**2 - 2 * t2 * bs * ds,
            2 * n * c * rise - 2 * t2 * cs * ds,
            n * rise**2 - t2 * (ds**2 + deviation[1] ** 2),
        ]
        largest = max(map(abs, quartic))
        while quartic and abs(quartic[0]) <= largest * mpmath.mpf(10) ** -100:
            del quartic[0]
        if len(quartic) < 2:
            return mpmath.nan
        roots = mpmath.polyroots(quartic[::-1], maxsteps=5000, extraprec=1000, asc=True)
        real = [abs(r.real) for r in roots if abs(r.imag) <= mpmath.mpf(10) ** -30 * (1 + abs(r))]
        return min(real) * half_range if real else mpmath.nan


def assert_exact(found, levels, means, deviations, n, relative):
    """A length equals the exact one for the very same inputs, or both are none."""
    exact = exact_length(levels, means, deviations, n, found.critical_value)
    if mpmath.isnan(exact):
        assert np.isnan(found.length)
    else:
        assert abs(found.length - exact) <= relative * exact


@pytest.mark.parametrize("base", [1e-9, 0.2, 78e9])
@pytest.mark.parametrize("spread", [1e-1, 1e-4, 1e-9, 1e-12])
@pytest.mark.parametrize("n", [2, 20])
def test_the_length_keeps_12_digits_however_small_the_response_beside_its_mean(base, spread, n):
    random = np.random.default_rng([n, int(-np.log10(spread))])
    for _ in range(10):
        levels = base * (1.0 + np.array([-1.0, 0.0, 1.0]) * random.uniform(0.05, 0.2, 3))
        means = 1.0 + spread * random.normal(size=3)
        deviations = spread * random.uniform(0.05, 0.5, 3)
        found = jc.indifference_interval(levels, means, deviations, n)
        assert_exact(found, levels, means, deviations, n, 1e-12)


@pytest.mark.parametrize("base", [1e-9, 0.2, 78e9])
def test_the_length_keeps_13_digits_however_close_the_levels_are(base):
    means, deviations = (0.091, 0.081, 0.074), (0.0081, 0.0078, 0.0083)  # [mm], like dolerite's
    for half in np.logspace(-9, -0.5, 18):
        levels = base * np.array([1.0 - half, 1.0, 1.0 + half])
        found = jc.indifference_interval(levels, means, deviations, 20)
        assert_exact(found, levels, means, deviations, 20, 1e-13)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 78e9])
@pytest.mark.parametrize("means", [[-0.5, 0.0, 0.5], [0.25, 0.0, 0.25], [1.0, 1.5, 2.5]])
@pytest.mark.parametrize(
    "deviations", [[0.25, 0.25, 0.25], [0.5, 0.25, 0.5], [0.25, 0.0, 0.25], [0.0, 0.0, 0.25]]
)
@pytest.mark.parametrize("n", [2, 20])
def test_missing_coefficients_give_the_exact_root(scale, means, deviations, n):
    # b = 0; c = 0; S constant; S quadratic; S_M = 0
    levels = scale * np.array([0.75, 1.0, 1.25])
    found = jc.indifference_interval(levels, means, deviations, n)
    if deviations[1] > 0.0:
        assert_exact(found, levels, means, deviations, n, 1e-13)
    else:  # the double root at the base, where any change is significant
        slope, spread = (fit_quadratic(levels, v, levels[1]) for v in (means, deviations))
        root_n = np.sqrt(n) / found.critical_value
        if slope.c != 0.0:
            assert (found.length == 0.0) == (root_n * abs(slope.c) > abs(spread.c))
        else:
            assert (found.length == 0.0) == (
                spread.c == 0.0 and root_n * abs(slope.b) > abs(spread.b)
            )


@pytest.mark.parametrize("offset", [0.1, 0.3, 3.0, 1e6])
def test_a_straight_line_stays_one_however_its_values_are_rounded(offset):
    # a curvature of rounding alone would win far away, where scatter outgrows the line
    means = offset - 0.02 * (LEVELS - 78.0)
    assert fit_quadratic(LEVELS, means, 78.0).b == 0.0
    for n in (2, 20):
        found = jc.indifference_interval(LEVELS, means, 0.05 + 0.1 * (LEVELS - 70.0), n)
        assert np.isnan(found.length)


@pytest.mark.parametrize("deviation", [0.0, 0.1])
def test_a_response_of_rounding_alone_is_none(deviation):
    means = [0.1 + 0.2, 0.3, 0.3]
    assert means[0] != means[1]
    assert np.isnan(jc.indifference_interval(LEVELS, means, [deviation] * 3, 20).length)


def test_more_than_three_levels_are_fitted_and_tested():
    levels = np.array([4.0, 6.0, 8.0, 10.0, 12.0])
    means = 0.01 * levels**2 + 0.1 * levels
    found = jc.indifference_interval(levels, means, [0.05] * 5, 20)
    quadratic = fit_quadratic(levels, means, 8.0)
    assert quadratic.in_parameter() == pytest.approx((0.01, 0.1, 0.0), abs=1e-12)
    assert found.length < 1.0
    assert lack_of_fit(levels, means, [0.05] * 5, 20, quadratic) == pytest.approx(1.0)
    wavy = means + 0.1 * np.array([1, -1, 1, -1, 1])
    assert lack_of_fit(levels, wavy, [0.05] * 5, 20, fit_quadratic(levels, wavy, 8.0)) < 1e-3


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"levels": [1.0, 3.0, 2.0]}, "ascending"),
        ({"standard_deviations": [1.0, -1.0, 1.0]}, "standard_deviations"),
        ({"samples": 1}, "samples = 1"),
        ({"means": [1.0, float("nan"), 2.0]}, "means"),
    ],
)
def test_bad_input_is_refused_by_name(change, named):
    good = {"levels": [1.0, 2.0, 3.0], "means": [1.0] * 3, "standard_deviations": [1.0] * 3}
    with pytest.raises(jc.InputError, match=named):
        jc.indifference_interval(**(good | {"samples": 20} | change))


def test_an_interval_of_lengths_is_that_of_the_normal_distribution_and_counts_missing_roots():
    lengths = scipy.stats.norm.ppf((np.arange(20_000) + 0.5) / 20_000, 5.0, 0.4)
    found = interval_of_lengths(lengths, 0.95)
    reach = 1.96 * 0.4
    assert found == pytest.approx((5.0 - reach, 5.0 + reach, 0.0, 0.4), rel=1e-3)
    lengths[-4000:] = np.nan
    found = interval_of_lengths(lengths, 0.95)
    assert (found.high, found.share_without_root, found.standard_error) == (np.inf, 0.2, np.inf)


@pytest.mark.parametrize("paired", [False, True])
def test_the_bootstrap_covers_the_length_that_it_resamples(paired):
    random = generator(7)
    samples = random.normal(3.0, 0.05, 20) - 0.02 * (LEVELS - 78.0)[:, None]
    samples = samples + 0.02 * random.normal(size=samples.shape)
    of_one = paired_indifference_interval(LEVELS, samples)
    if not paired:
        moments = samples.mean(axis=1), samples.std(axis=1, ddof=1)
        of_one = jc.indifference_interval(LEVELS, *moments, 20)
    stated = {"base": 78.0, "resamples": 200, "paired": paired}
    interval = bootstrap_length(LEVELS, samples, generator(1), **stated)
    assert 0.3 * of_one.length < interval.low < of_one.length < interval.high
    assert interval.high < 3.0 * of_one.length
    assert bootstrap_length(LEVELS, samples, generator(1), **stated) == interval


LEVELS_OF_STUDIES = [70e9, 78e9, 85e9], [0.15, 0.25, 0.35], [4.0, 6.0, 8.0, 10.0, 12.0]


@pytest.mark.parametrize("levels", LEVELS_OF_STUDIES)
@pytest.mark.parametrize("n", [2, 20])
def test_many_lengths_at_once_are_those_of_one_by_one(levels, n):
    levels, random = np.array(levels), np.random.default_rng(n)
    effect = 10.0 ** random.uniform(-3.0, 0.5, (100, 1))  # from strong ones to none
    means = 1.0 + effect * random.normal(size=(100, levels.size))
    deviations = 0.2 * random.uniform(0.2, 2.0, means.shape)
    many = indifference_lengths(levels, means, deviations, n)
    moments = zip(means, deviations, strict=True)
    single = np.array([jc.indifference_interval(levels, m, s, n).length for m, s in moments])
    assert 0.02 < np.isnan(single).mean() < 0.9  # dashes are among them
    np.testing.assert_allclose(many, single, rtol=1e-9)
    fits = fit_quadratic(levels, means, levels[1])
    for i, row in enumerate(means[:50]):  # bit for bit
        assert (fits.b[i], fits.c[i], fits.d[i]) == fit_quadratic(levels, row, levels[1])[:3]

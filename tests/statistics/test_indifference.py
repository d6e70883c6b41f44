"""Indifference intervals of independent samples: where the t-test becomes critical."""

import hypothesis.strategies as st
import mpmath
import numpy as np
import pytest
import scipy.stats
from hypothesis import given

import jointclosure as jc
from jointclosure.statistics import indifference
from jointclosure.statistics.indifference import (
    _largest_isolated_roots,
    _largest_quartic_roots,
    bootstrap_length,
    indifference_lengths,
    interval_of_lengths,
    largest_real_roots,
    paired_indifference_interval,
    quartic,
)
from jointclosure.statistics.quadratics import Quadratic, fit_quadratic, lack_of_fit
from jointclosure.statistics.randomness import generator

LEVELS = np.array([70.0, 78.0, 85.0])
USUAL = {"levels": LEVELS, "means": [1.0, 1.2, 1.5], "standard_deviations": [0.1, 0.1, 0.2],
         "samples": 20}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "refused"),
    [
        ({"significance": 1e-300}, "significance = 1e-300"),
        ({"significance": 1e-17}, "significance = 1e-17"),
        ({"levels": [-1.7e308, 0.0, 1.7e308]}, "levels: the largest is 1.7e"),
        ({"levels": [0.0, 1e-320, 1e-300]}, "levels: the largest is 1e-300"),
        ({"levels": [1e-200, 1.0 - 1e-15, 1.0]}, None),
        ({"means": [0.0, 1e200, 1.0]}, "means: the largest is 1e"),
        ({"means": [0.0, 1e-310, 1e-300]}, "means: the largest is 1e-300"),
        ({"standard_deviations": [0.0, 1e300, 0.0]}, "standard_deviations: the largest"),
        ({"samples": 10**400}, "samples = .*must be at most"),
        ({"base": np.nan}, "base = nan"),
        ({"base": "78"}, "base = '78'"),
    ],
)
def test_numbers_of_which_no_interval_can_be_computed_are_refused(change, refused):
    if refused is None:
        assert np.isfinite(jc.indifference_interval(**USUAL | change).length)
        return
    with pytest.raises(jc.InputError, match=refused):
        jc.indifference_interval(**USUAL | change)


def test_numbers_of_any_allowed_size_have_an_interval():
    """It grows with the levels, and does not depend on the unit of the means."""
    usual = jc.indifference_interval(**USUAL).length
    for size in (1e-90, 1e90):
        scaled = {name: size * np.array(USUAL[name]) for name in ("means", "standard_deviations")}
        large = jc.indifference_interval(**USUAL | scaled | {"levels": size * LEVELS})
        assert large.length == pytest.approx(size * usual, rel=1e-9)
    assert np.isfinite(jc.indifference_interval(**USUAL | {"significance": 1e-9}).length)


def t_value(levels, means, deviations, n, at):
    mean, deviation = (fit_quadratic(levels, v, levels[1]) for v in (means, deviations))
    scatter = (deviation.at(at) ** 2 + deviation.d**2) / n
    return (mean.at(at) - mean.d) / np.sqrt(scatter)


any_moments = given(
    means=st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3),
    deviations=st.lists(st.floats(0.01, 1.0), min_size=3, max_size=3),
    n=st.integers(2, 100),
)


@any_moments
def test_the_root_is_where_the_t_test_becomes_critical(means, deviations, n):
    found = jc.indifference_interval(LEVELS, means, deviations, n)
    if np.isfinite(found.length):
        at_root = abs(t_value(LEVELS, means, deviations, n, found.root))
        assert at_root == pytest.approx(scipy.stats.t.ppf(0.975, 2 * n - 2), rel=1e-6)
        assert found.extrapolated == (not 70.0 <= found.root <= 85.0)


@any_moments
def test_no_root_is_closer_than_the_length(means, deviations, n):
    found = jc.indifference_interval(LEVELS, means, deviations, n)
    reach = found.length if np.isfinite(found.length) else 200.0
    inside = np.linspace(78.0 - 0.999 * reach, 78.0 + 0.999 * reach, 401)
    values = np.abs(t_value(LEVELS, means, deviations, n, inside))
    assert np.all(values <= scipy.stats.t.ppf(0.975, 2 * n - 2) * (1 + 1e-6))


@pytest.mark.parametrize("deviation", [0.1, 0.0])
def test_no_variation_has_no_root(deviation):
    assert np.isnan(jc.indifference_interval(LEVELS, [1.0] * 3, [deviation] * 3, 20).length)


def test_no_scatter_has_no_length():
    assert jc.indifference_interval(LEVELS, [1.1, 1.0, 0.9], [0.0] * 3, 20).length == 0.0


def test_a_scatter_that_outgrows_the_mean_has_no_root():
    found = jc.indifference_interval([-1.0, 0.0, 1.0], [0.1, 0.0, 0.1], [2.0, 1.0, 2.0], 20)
    assert np.isnan(found.length)
    assert not found.extrapolated


def test_no_scatter_at_the_base_leaves_a_length_of_zero():
    """S ~ u^2 against x ~ u: the smallest change is significant."""
    found = jc.indifference_interval([-1.0, 0.0, 1.0], [-0.01, 0.0, 0.01], [1.0, 0.0, 1.0], 20)
    assert found.length == 0.0


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


FIVE = np.array([4.0, 6.0, 8.0, 10.0, 12.0])
QUADRATIC = 0.01 * FIVE**2 + 0.1 * FIVE


def test_more_than_three_levels_are_fitted():
    found = jc.indifference_interval(FIVE, QUADRATIC, [0.05] * 5, 20)
    quadratic = fit_quadratic(FIVE, QUADRATIC, 8.0)
    assert quadratic.in_parameter() == pytest.approx((0.01, 0.1, 0.0), abs=1e-12)
    assert found.length < 1.0


def test_more_than_three_levels_show_a_lack_of_fit():
    quadratic = fit_quadratic(FIVE, QUADRATIC, 8.0)
    assert lack_of_fit(FIVE, QUADRATIC, [0.05] * 5, 20, quadratic) == pytest.approx(1.0)
    wavy = QUADRATIC + 0.1 * np.array([1, -1, 1, -1, 1])
    assert lack_of_fit(FIVE, wavy, [0.05] * 5, 20, fit_quadratic(FIVE, wavy, 8.0)) < 1e-3


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


NORMAL_LENGTHS = scipy.stats.norm.ppf((np.arange(20_000) + 0.5) / 20_000, 5.0, 0.4)


def test_an_interval_of_normal_lengths_is_that_of_their_distribution():
    found = interval_of_lengths(NORMAL_LENGTHS, 0.95)
    reach = 1.96 * 0.4
    assert found == pytest.approx((5.0 - reach, 5.0 + reach, 0.0, 0.4), rel=1e-3)


def test_an_interval_of_lengths_counts_missing_roots():
    lengths = NORMAL_LENGTHS.copy()
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


def test_lengths_without_scatter_at_the_base_are_found_at_once_as_one_by_one(monkeypatch):
    """As in studies of few surfaces, where the same surface is drawn again and again."""
    levels, random = np.array([-1.0, 0.0, 1.0]), np.random.default_rng(5)
    means, deviations = random.normal(size=(200, 3)), 5.0 * random.uniform(size=(200, 3))
    deviations[:, 1] = 0.0
    means[:20], deviations[:20] = [0.1, 0.0, 0.1], [2.0, 0.0, 2.0]
    single = [
        jc.indifference_interval(levels, m, s, 20).length
        for m, s in zip(means, deviations, strict=True)
    ]
    solved = []

    def counted(polynomials):
        solved.append(len(polynomials))
        return largest_real_roots(polynomials)

    monkeypatch.setattr(indifference, "largest_real_roots", counted)
    many = indifference_lengths(levels, means, deviations, 20)
    np.testing.assert_array_equal(many, single)
    assert len(solved) == 2  # quartics, and what is left of those without scatter
    kinds = np.isnan(many), many == 0.0, many > 0.0
    assert all(kind.sum() > 10 for kind in kinds)


@pytest.mark.parametrize("decades", [0.0, 1.0, 3.0])
def test_outermost_minima_give_the_root_that_isolation_of_all_roots_gives(decades):
    random = generator(8)
    sizes = 10.0 ** random.uniform(-decades, 0.0, (5, 20000))
    b, c, bs, cs, ds = random.normal(size=sizes.shape) * sizes
    mean, deviation = Quadratic(b, c, 0.0, 0.0, 1.0), Quadratic(bs, cs, np.abs(ds), 0.0, 1.0)
    quartics = quartic(mean, deviation, 20, 2.02).T[:, ::-1]
    with np.errstate(all="ignore"):
        roots, certain = _largest_quartic_roots(quartics)
    expected = _largest_isolated_roots(quartics)
    assert certain.mean() > 0.85
    assert 0.0 < np.isnan(expected).mean() < 0.5
    np.testing.assert_allclose(roots[certain], expected[certain], rtol=1e-9)
    np.testing.assert_array_equal(largest_real_roots(quartics[~certain]), expected[~certain])


AROUND = np.array([-1.0, 0.0, 1.0])
CRITICAL = scipy.stats.t.ppf(0.975, 38)


@pytest.mark.parametrize(("slope", "extrapolated"), [(1.0, False), (0.2, True)])
def test_a_root_is_flagged_outside_of_the_levels(slope, extrapolated):
    found = jc.indifference_interval(AROUND, slope * AROUND, np.full(3, 1.0), 20)
    assert found.length == pytest.approx(CRITICAL * np.sqrt(2.0 / 20.0) / slope)
    assert found.extrapolated == extrapolated
    assert not found.negative_deviation


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_root_is_flagged_where_the_fitted_deviation_is_negative(side):
    """Of a line whose deviation falls to one side as 1 - u/2: S(3) = -1/2."""
    falling = 1.0 - 0.5 * AROUND
    needed = CRITICAL * np.sqrt((1.0 + 0.25) / 20.0) / 3.0
    means = np.where(AROUND * side > 0.0, needed * np.abs(AROUND), -needed * np.abs(AROUND))
    found = jc.indifference_interval(AROUND, means, falling[:: int(side)], 20)
    assert abs(found.root) <= 3.0 * (1.0 + 1e-9)
    at_root = 1.0 - 0.5 * found.root * side
    assert found.negative_deviation == (at_root < 0.0)
    assert found.extrapolated == (abs(found.root) > 1.0)


@pytest.mark.parametrize("significance", [0.0, 1.0, -0.1, float("nan"), True])
def test_a_significance_lies_between_0_and_1(significance):
    with pytest.raises(jc.InputError, match="significance"):
        jc.indifference_interval([1.0, 2.0, 3.0], [1.0] * 3, [1.0] * 3, 20, significance)


@pytest.mark.parametrize("count", [3, 5, 8])
def test_a_fit_is_the_least_squares_one(count):
    random, base = generator(count), 2.0
    levels = np.append(base, random.uniform([0.5] * (count - 2) + [3.0], 4.0))
    levels.sort()
    values = random.normal(size=count)
    found = fit_quadratic(levels, values, base)
    exact = np.polyfit(levels, values, 2)
    assert found.in_parameter() == pytest.approx(tuple(exact), rel=1e-9)
    assert found.at(levels) == pytest.approx(np.polyval(exact, levels))
    assert found.elasticity() * found.d == pytest.approx(base * np.polyval(np.polyder(exact), base))
    change = np.polyval(exact, base + 0.3) / np.polyval(exact, base) - 1.0
    assert found.relative_change(0.3) == pytest.approx(change)


def test_lack_of_fit_is_the_f_test_of_the_misfit_against_the_scatter_of_the_samples():
    random, levels = generator(22), np.linspace(-1.0, 1.0, 6)
    samples = levels[:, None] ** 2 + random.normal(size=(6, 3))
    means, deviations = samples.mean(axis=1), samples.std(axis=1, ddof=1)
    misfit = 3 * np.sum((means - np.polyval(np.polyfit(levels, means, 2), levels)) ** 2) / 3
    exact = scipy.stats.f.sf(misfit / np.mean(deviations**2), 3, 6 * 2)
    fit = fit_quadratic(levels, means, levels[2])
    assert lack_of_fit(levels, means, deviations, 3, fit) == pytest.approx(exact)


def test_lack_of_fit_is_uniform_for_a_quadratic():
    random, levels = generator(21), np.linspace(-1.0, 1.0, 5)
    p = []
    for _ in range(2000):
        samples = 1.0 + levels[:, None] ** 2 + random.normal(size=(5, 4))
        moments = samples.mean(axis=1), samples.std(axis=1, ddof=1)
        p.append(lack_of_fit(levels, *moments, 4, fit_quadratic(levels, moments[0], 0.0)))
    assert scipy.stats.kstest(p, "uniform").pvalue > 0.01


@pytest.mark.parametrize(
    ("levels", "deviation"),
    [(np.linspace(-1.0, 1.0, 5), 0.0), (np.linspace(-0.5, 0.5, 3), 1.0)],
    ids=["scatter", "freedom"],
)
def test_lack_of_fit_is_unknown_without_scatter_or_freedom(levels, deviation):
    quadratic = fit_quadratic(levels, levels, 0.0)
    assert np.isnan(lack_of_fit(levels, levels, np.full(levels.size, deviation), 4, quadratic))

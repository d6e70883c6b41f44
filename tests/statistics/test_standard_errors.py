"""Standard errors of statistics of closed joints, and the digits that they leave."""

import numpy as np
import pytest

from jointclosure.statistics.correlations import elasticity, fit_quadratic, quadratic_errors
from jointclosure.statistics.randomness import generator
from jointclosure.statistics.standard_errors import (
    deviation_covariance,
    deviation_of,
    harmonic_mean,
    jackknife_error,
    mean_covariance,
    mean_of,
    number_text,
    percent,
    ratio_of_means,
    rounded,
    variation_of,
    with_equal_decimals,
)

LEVELS = np.array([70.0, 78.0, 85.0])


def studies(count, paired, levels=LEVELS, n=20, seed=1):
    """Many studies (count, k, n) of x = p^-1 with a scatter of 15 %."""
    random = generator(seed)
    scatter = random.normal(size=(count, 1 if paired else levels.size, n))
    own = 0.02 * random.normal(size=(count, levels.size, n))
    return (levels[0] / levels)[:, None] * (1.0 + 0.15 * scatter + own)


@pytest.mark.parametrize("paired", [True, False])
@pytest.mark.parametrize("levels", [LEVELS, np.linspace(70.0, 86.0, 5)])
def test_errors_of_coefficients_are_their_scatter_over_studies(paired, levels):
    base = levels[levels.size // 2]
    fits, stated = [], []
    for samples in studies(2000, paired, levels):
        of_mean = fit_quadratic(levels, samples.mean(axis=1), base)
        of_deviation = fit_quadratic(levels, samples.std(axis=1, ddof=1), base)
        fits.append(
            [*of_mean[:3], *of_mean.in_parameter(), *of_deviation[:3], *of_deviation.in_parameter()]
        )
        row = []
        for covariance in (mean_covariance(samples, paired), deviation_covariance(samples, paired)):
            errors = quadratic_errors(levels, covariance, base)
            row += [*np.sqrt(np.diag(errors.covariance)), *errors.in_parameter]
        stated.append(np.square(row))
    np.testing.assert_allclose(np.sqrt(np.mean(stated, axis=0)), np.std(fits, axis=0), rtol=0.1)


@pytest.fixture(scope="module", params=[True, False], ids=["paired", "independent"])
def elasticities(request):
    """Elasticities of many studies, with their errors."""
    paired = request.param
    return np.array([elasticity(LEVELS, s, 78.0, paired) for s in studies(2000, paired)])


def test_an_elasticity_is_that_of_the_response(elasticities):
    assert elasticities[:, 0].mean() == pytest.approx(-1.0, abs=0.02)


def test_the_error_of_an_elasticity_is_its_scatter(elasticities):
    scatter = elasticities[:, 0].std()
    assert np.sqrt(np.mean(elasticities[:, 1] ** 2)) == pytest.approx(scatter, rel=0.05)


def ratio_to_surfaces(row):
    """Of values that go with those of the surfaces, which are twice as widely scattered."""
    under = 1.0 + 0.2 * (row - 1.0) / 0.3
    return ratio_of_means(1.3 * under + 0.1 * np.roll(row - 1.0, 1) / 0.3, under)


@pytest.mark.parametrize(
    ("estimate", "value"),
    [(mean_of, 1.0), (deviation_of, 0.3), (variation_of, 0.3), (ratio_to_surfaces, 1.3)],
)
def test_errors_of_single_numbers_are_their_scatter_over_studies(estimate, value):
    samples = generator(2).normal(1.0, 0.3, size=(4000, 20))
    found = np.array([estimate(row) for row in samples])
    assert found[:, 0].mean() == pytest.approx(value, rel=0.02)
    assert np.sqrt(np.mean(found[:, 1] ** 2)) == pytest.approx(found[:, 0].std(), rel=0.06)


def test_a_scatter_in_common_leaves_a_ratio_no_error():
    under = np.array([1.0, 2.0, 4.0, 3.0])
    assert ratio_of_means(1.5 * under, under) == pytest.approx((1.5, 0.0))


def test_pairs_that_lack_a_value_are_left_out():
    over, under = np.array([1.0, np.nan, 3.0]), np.array([2.0, 5.0, np.nan])
    ratio, error = ratio_of_means(over, under)
    assert ratio == 0.5
    assert np.isnan(error)
    assert np.isnan(ratio_of_means(over, np.full(3, np.nan)).value)


def test_a_mean_stiffness_is_that_of_the_mean_curve():
    """Compliances add: a joint that is nearly rigid counts as one that hardly closes."""
    stiffness = np.array([1.0, 2.0, 1e9, np.nan])
    mean, error = harmonic_mean(stiffness)
    assert mean == pytest.approx(3.0 / 1.5)
    assert harmonic_mean(10.0 * stiffness) == pytest.approx((10.0 * mean, 10.0 * error))


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.08312, 0.0041, "0.083 ± 0.004"),
        (0.08312, 0.00123, "0.0831 ± 0.0012"),
        (0.08312, 0.00951, "0.083 ± 0.010"),
        (1234.5, 56.0, "1230 ± 60"),
        (-0.0001, 0.04, "0.00 ± 0.04"),
        (78e9, 1.2e9, "78000000000 ± 1200000000"),
        (0.083123, 0.0, "0.08312"),
        (0.083123, float("nan"), "0.08312"),
        (float("nan"), 1.0, "–"),
    ],
)
def test_a_number_ends_where_its_error_does(value, error, text):
    assert rounded(value, error) == text


def test_a_jackknife_of_a_mean_has_its_standard_error():
    samples = generator(5).normal(size=12)
    left_out = [np.delete(samples, i).mean() for i in range(12)]
    assert jackknife_error(left_out) == pytest.approx(mean_of(samples).standard_error)


SAMPLES = generator(6).normal(size=20) * np.array([[1.0], [2.0]])


@pytest.mark.parametrize("covariance", [mean_covariance, deviation_covariance])
def test_only_draws_in_common_have_a_covariance(covariance):
    common, independent = (covariance(SAMPLES, paired) for paired in (True, False))
    np.testing.assert_array_equal(np.diag(common), np.diag(independent))
    scale = np.sqrt(np.prod(np.diag(common)))
    assert common[0, 1] == pytest.approx(scale)  # one is a multiple of the other
    assert independent[0, 1] == 0.0


@pytest.mark.parametrize(
    ("covariance", "estimate"), [(mean_covariance, mean_of), (deviation_covariance, deviation_of)]
)
def test_the_diagonal_of_a_covariance_has_the_squared_standard_errors(covariance, estimate):
    assert np.sqrt(np.diag(covariance(SAMPLES, False))) == pytest.approx(
        [estimate(row).standard_error for row in SAMPLES]
    )


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"), (1234.5678, "1235"), (0.0012344, "0.001234"), (9.99996, "10.00"),
        (9.9e-4, "9.900e-04"), (1e6, "1.000e+06"), (999999.0, "1000000"), (-0.5, "-0.5000"),
        (np.nan, "–"), (np.inf, "∞"), (-np.inf, "−∞"),
    ],
)  # fmt: skip
def test_numbers_have_the_digits_asked_for(value, shown):
    assert number_text(value) == shown


@pytest.mark.parametrize(
    ("share", "shown"), [(0.0123, "1.2 %"), (0.0994, "9.9 %"), (0.0996, "10 %"), (0.5, "50 %")]
)
def test_percentages_have_two_digits_below_ten(share, shown):
    assert percent(share) == shown


@pytest.mark.parametrize(
    ("share", "shown"), [(2.0, "200 %"), (1.63, "163 %"), (1.2e-6, "0.00012 %"), (-0.4, "-40 %")]
)
def test_percentages_have_no_exponent(share, shown):
    assert percent(share) == shown


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ((0.0974, 0.0908, 0.0996), ["0.097", "0.091", "0.100"]),
        ((0.1024, 0.0958, 0.1045), ["0.102", "0.096", "0.104"]),  # not 0.10 (0.10 to 0.10)
        ((195.6, 182.7, 216.9), ["196", "183", "217"]),
        ((3580.0, 3390.0, 3781.0), ["3600", "3400", "3800"]),
        ((144.5, 29.2, 8801.0), ["140", "30", "8800"]),  # an end that is above 0 does not read as 0
        ((0.0085, 0.00085, 0.0589), ["0.0085", "0.0008", "0.0589"]),
        ((-3.1, -9.2, 3.0), ["-3.1", "-9.2", "3.0"]),
        ((3.2, -46.4, 57.1), ["3", "-46", "57"]),
        ((0.0, 0.0, 0.8), ["0.00", "0.00", "0.80"]),
        ((2.4e-8, 1e-9, 3e-7), ["2.4e-08", "1.0e-09", "3.0e-07"]),
        ((np.nan, 0.2, 0.3), ["–", "0.20", "0.30"]),
        ((0.0, 0.0, 0.0), ["0", "0", "0"]),
    ],
)
def test_a_number_and_the_ends_of_its_range_have_equal_decimals(values, shown):
    assert with_equal_decimals(values) == shown

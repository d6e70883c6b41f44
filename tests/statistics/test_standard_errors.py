"""Standard errors of statistics of closed joints are their scatter over repeated studies."""

import numpy as np
import pytest

from jointclosure.statistics.randomness import generator
from jointclosure.statistics.standard_errors import (
    deviation_covariance,
    deviation_of,
    harmonic_mean,
    jackknife_error,
    mean_covariance,
    mean_of,
    ratio_of_means,
    variation_of,
)


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

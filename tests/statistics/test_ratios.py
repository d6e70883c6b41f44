"""Ratios of means over the same surfaces."""

import numpy as np
import pytest

from jointclosure.statistics.standard_errors import harmonic_mean, ratio_of_means


def test_what_both_rows_share_leaves_no_error():
    under = np.array([1.0, 2.0, 4.0, 3.0])
    assert ratio_of_means(1.5 * under, under) == pytest.approx((1.5, 0.0))


def test_the_error_is_the_scatter_of_the_ratio_over_repetitions():
    random = np.random.default_rng(7)
    found, stated = [], []
    for _ in range(2000):
        under = 1.0 + 0.2 * random.standard_normal(30)
        over = 1.3 * under + 0.1 * random.standard_normal(30)
        ratio, error = ratio_of_means(over, under)
        found.append(ratio)
        stated.append(error)
    assert np.mean(found) == pytest.approx(1.3, abs=0.002)
    assert np.mean(stated) == pytest.approx(np.std(found), rel=0.05)


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

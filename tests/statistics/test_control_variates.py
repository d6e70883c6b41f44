import numpy as np
import pytest

import jointclosure as jc
from jointclosure.randomness import generator
from jointclosure.statistics.control_variates import (
    adjusted_deviation,
    adjusted_values,
    worth,
)
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.statistics.verdicts import t_interval

MEANS = np.array([2.0, 5.0])
COVARIANCE = np.array([[1.0, 0.6], [0.6, 1.0]])
SLOPES = np.array([1.0, 0.5])
UNEXPLAINED = 0.4
MEAN = 10.0
EXPLAINED = SLOPES @ COVARIANCE @ SLOPES
DEVIATION = np.sqrt(EXPLAINED + UNEXPLAINED**2)


def surfaces(random, n, curved=0.0):
    covariates = MEANS + random.normal(size=(n, 2)) @ np.linalg.cholesky(COVARIANCE).T
    bend = curved * ((covariates[:, 0] - MEANS[0]) ** 2 - 1.0)
    values = MEAN + (covariates - MEANS) @ SLOPES + bend + UNEXPLAINED * random.normal(size=n)
    return values, covariates


@pytest.mark.parametrize("n", [20, 60])
@pytest.mark.parametrize("curved", [0.0, 0.3])
def test_95_percent_intervals_of_adjusted_means_cover_93_to_97_times_in_100(n, curved):
    random = generator(n)
    inside, gains = [], []
    for _ in range(2000):
        values, covariates = surfaces(random, n, curved)
        adjusted = adjusted_values(values, covariates, MEANS)
        low, high = t_interval(mean_of(adjusted), n)
        inside.append(low <= MEAN <= high)
        gains.append(worth(values, adjusted))
    assert 0.93 <= np.mean(inside) <= 0.97
    assert np.median(gains) > (2.0 if curved else 5.0)


def test_an_adjusted_mean_is_as_much_better_as_it_says():
    random = generator(1)
    plain, adjusted, told = [], [], []
    for _ in range(3000):
        values, covariates = surfaces(random, 20)
        corrected = adjusted_values(values, covariates, MEANS)
        plain.append(values.mean())
        adjusted.append(corrected.mean())
        told.append(mean_of(corrected).standard_error ** 2)
    assert np.mean(adjusted) == pytest.approx(MEAN, abs=0.01)
    assert np.sqrt(np.mean(told)) == pytest.approx(np.std(adjusted), rel=0.05)
    assert np.var(plain) / np.var(adjusted) > 10.0


def test_covariates_that_say_nothing_cost_what_fitting_them_costs_and_no_more():
    random = generator(2)
    adjusted, told = [], []
    for _ in range(3000):
        _, covariates = surfaces(random, 20)
        corrected = adjusted_values(random.normal(size=20), covariates, MEANS)
        adjusted.append(corrected.mean())
        told.append(mean_of(corrected).standard_error ** 2)
    assert np.sqrt(np.mean(told)) == pytest.approx(np.std(adjusted), rel=0.05)
    assert np.var(adjusted) == pytest.approx((1 + 2 / 15) / 20, rel=0.15)


def test_each_adjustment_is_fitted_without_its_own_surface():
    values, covariates = surfaces(generator(3), 12)
    adjusted = adjusted_values(values, covariates, MEANS)
    for i in range(12):
        others = np.arange(12) != i
        design = np.column_stack([np.ones(11), covariates[others]])
        slopes = np.linalg.lstsq(design, values[others])[0][1:]
        expected = values[i] - (covariates[i] - MEANS) @ slopes
        assert adjusted[i] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("n", [60, 200])
def test_adjusted_deviations_are_unbiased_with_honest_errors_and_better_than_plain(n):
    random = generator(4)
    found, plain, inside = [], [], []
    for _ in range(1500):
        values, covariates = surfaces(random, n)
        one = adjusted_deviation(values, covariates, MEANS, np.diag(COVARIANCE))
        low, high = t_interval(one, n)
        inside.append(low <= DEVIATION <= high)
        found.append(one)
        plain.append(values.std(ddof=1))
    found = np.array(found)
    assert found[:, 0].mean() == pytest.approx(DEVIATION, rel=0.01)
    assert np.sqrt(np.mean(found[:, 1] ** 2)) == pytest.approx(found[:, 0].std(), rel=0.12)
    assert 0.92 <= np.mean(inside) <= 0.97
    assert np.var(plain) / np.var(found[:, 0]) > 1.5


def test_an_adjusted_variance_is_unbiased_where_covariates_say_nothing():
    random = generator(6)
    found = []
    for _ in range(4000):
        _, covariates = surfaces(random, 20)
        values = random.normal(size=20)
        found.append(adjusted_deviation(values, covariates[:, :1], MEANS[:1], [1.0]).value ** 2)
    assert np.mean(found) == pytest.approx(1.0, abs=0.025)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"covariates": np.ones((20, 2))}, "constant"),
        ({"covariates": np.outer(np.arange(20.0), [1.0, 2.0])}, "made of others"),
        ({"known_means": [1.0]}, "known_means"),
        ({"values": np.full(20, np.nan)}, "values"),
        ({"values": np.arange(4.0), "covariates": np.ones((4, 2))}, "4 surfaces"),
    ],
)
def test_bad_covariates_are_refused_by_name(change, named):
    values, covariates = surfaces(generator(5), 20)
    good = {"values": values, "covariates": covariates, "known_means": MEANS}
    with pytest.raises(jc.InputError, match=named):
        adjusted_values(**(good | change))

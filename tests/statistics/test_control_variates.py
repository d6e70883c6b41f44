"""Means and deviations that control variates adjust."""

from typing import NamedTuple

import numpy as np
import pytest

from jointclosure.inputs import InputError
from jointclosure.statistics.control_variates import (
    Known,
    adjusted_deviations,
    adjusted_length,
    adjusted_means,
    adjusted_values,
    fewest_surfaces,
)
from jointclosure.statistics.indifference import indifference_interval
from jointclosure.statistics.quadratics import elasticity_of
from jointclosure.statistics.randomness import generator
from jointclosure.statistics.standard_errors import Estimate, confidence_limits, deviation_of

MEANS = np.array([2.0, 5.0])
COVARIANCE = np.array([[1.0, 0.6], [0.6, 1.0]])
SLOPES = np.array([1.0, 0.5])
UNEXPLAINED = 0.4
MEAN = 10.0
EXPLAINED = SLOPES @ COVARIANCE @ SLOPES
DEVIATION = np.sqrt(EXPLAINED + UNEXPLAINED**2)
KNOWN = Known(MEANS, COVARIANCE, np.inf)


def adjusted_deviation(values, covariates, known):
    return Estimate(*map(float, adjusted_deviations(values, covariates, known)))


def surfaces(random, n):
    covariates = MEANS + random.normal(size=(n, 2)) @ np.linalg.cholesky(COVARIANCE).T
    values = MEAN + (covariates - MEANS) @ SLOPES + UNEXPLAINED * random.normal(size=n)
    return values, covariates


def test_each_adjustment_is_fitted_without_its_own_surface():
    values, covariates = surfaces(generator(3), 12)
    adjusted = adjusted_values(values, covariates, MEANS)[0]
    for i in range(12):
        others = np.arange(12) != i
        design = np.column_stack([np.ones(11), covariates[others]])
        slopes = np.linalg.lstsq(design, values[others])[0][1:]
        expected = values[i] - (covariates[i] - MEANS) @ slopes
        assert adjusted[i] == pytest.approx(expected, rel=1e-10)


@pytest.fixture(scope="module", params=[60, 200])
def deviations(request):
    """Of many samples: adjusted deviations with errors, plain ones, whether limits hold the true
    one."""
    n, random = request.param, generator(4)
    found, plain, inside = [], [], []
    for _ in range(1500):
        values, covariates = surfaces(random, n)
        one = adjusted_deviation(values, covariates, KNOWN)
        low, high = confidence_limits(one, n)
        inside.append(low <= DEVIATION <= high)
        found.append(one)
        plain.append(values.std(ddof=1))
    return np.array(found), plain, inside


def test_adjusted_deviations_are_unbiased(deviations):
    found, _, _ = deviations
    assert found[:, 0].mean() == pytest.approx(DEVIATION, rel=0.01)


def test_adjusted_deviations_have_honest_errors(deviations):
    found, _, inside = deviations
    assert np.sqrt(np.mean(found[:, 1] ** 2)) == pytest.approx(found[:, 0].std(), rel=0.12)
    assert 0.92 <= np.mean(inside) <= 0.97


def test_adjusted_deviations_scatter_less_than_plain_ones(deviations):
    found, plain, _ = deviations
    assert np.var(plain) / np.var(found[:, 0]) > 1.5


def test_covariates_that_tell_nothing_of_a_surface_are_refused_by_what_is_wrong():
    values = generator(12).normal(size=10)
    column = generator(13).normal(size=(10, 1))
    single = np.zeros((10, 1))
    single[3] = 1.0
    for covariates, named in (
        (np.ones((10, 1)), "a column is constant"),
        (np.hstack([column, 2.0 * column]), "a combination of others"),
        (single, "constant except on one surface"),
    ):
        with pytest.raises(InputError, match=named):
            adjusted_values(values, covariates, np.zeros(covariates.shape[1]))


FEW = surfaces(generator(14), 20)
SCALES = pytest.mark.parametrize("scale", [1.0, 100.0])
"""Of known covariances: of surfaces far from the known means an adjusted variance may be
negative."""


@SCALES
def test_deviations_are_not_negative(scale):
    deviation, error = adjusted_deviation(*FEW, Known(MEANS, scale * COVARIANCE, np.inf))
    assert deviation > 0.0
    assert error > 0.0


@SCALES
def test_deviations_are_plain_where_adjustment_is_not_asked_for(scale):
    known = Known(MEANS, scale * COVARIANCE, np.inf)
    plain = adjusted_deviations(*FEW, known, tell_scatter=False)
    assert plain == pytest.approx(tuple(deviation_of(FEW[0])))


@pytest.mark.parametrize(("covariates", "fewest"), [(1, 10), (2, 15)])
def test_the_fewest_surfaces_are_five_for_each_coefficient(covariates, fewest):
    assert fewest_surfaces(covariates) == fewest


def test_adjusted_variances_of_few_surfaces_are_unbiased():
    """Without the variance of their own mean, S_a^2/n, those of 16 surfaces are 6 % too small."""
    random = generator(11)
    covariates = random.normal(size=(6000, 16, 1))
    values = random.normal(size=(6000, 16))  # which the covariates do not explain
    known = Known(np.zeros(1), np.eye(1), np.inf)
    squares = adjusted_deviations(values, covariates, known)[0] ** 2
    error = squares.std(ddof=1) / np.sqrt(squares.size)
    assert error < 0.01
    assert squares.mean() == pytest.approx(1.0, abs=3.0 * error)


LEVELS = np.array([70.0, 78.0, 85.0])
STEPS = np.array([-0.3, 0.0, 0.2])
"""What each level adds to the mean."""


def levels_of_surfaces(random, n, shared):
    """Samples (3, n) and covariates (3, n, 2): of the same surfaces at all levels, or of others."""
    rows = [surfaces(random, n)] * 3 if shared else [surfaces(random, n) for _ in range(3)]
    samples = np.stack([values for values, _ in rows]) + STEPS[:, None]
    samples += 0.1 * random.normal(size=samples.shape)  # of each simulation's own
    return samples, np.stack([covariates for _, covariates in rows])


class Responses(NamedTuple):
    """Differences and elasticities of many samples, and whether their limits hold the truth."""

    shared: bool
    differences: list
    plain: list
    inside: list
    covered: list


@pytest.fixture(scope="module", params=[True, False], ids=["common", "independent"])
def drawn_responses(request):
    """Responses to levels, of common surfaces or of others at each level."""
    random, made = generator(7), Responses(request.param, [], [], [], [])
    slope = adjusted_truth()
    for _ in range(1200):
        samples, covariates = levels_of_surfaces(random, 20, made.shared)
        means = adjusted_means(samples, covariates, KNOWN, paired=made.shared)
        change = means.combined([-1.0, 0.0, 1.0])
        low, high = confidence_limits(change, 20)
        made.inside.append(low <= STEPS[2] - STEPS[0] <= high)
        made.differences.append(change.value)
        made.plain.append(samples[2].mean() - samples[0].mean())
        of_slope = elasticity_of(LEVELS, *means, 78.0)
        low, high = confidence_limits(of_slope, 20)
        made.covered.append(low <= slope <= high)
    return made


def test_adjusted_differences_are_unbiased(drawn_responses):
    assert np.mean(drawn_responses.differences) == pytest.approx(0.5, abs=0.02)


def test_adjusted_differences_have_honest_errors(drawn_responses):
    assert 0.93 <= np.mean(drawn_responses.inside) <= 0.975


def test_adjusted_elasticities_have_honest_errors(drawn_responses):
    assert 0.93 <= np.mean(drawn_responses.covered) <= 0.975


def test_adjustment_helps_differences_of_independent_draws(drawn_responses):
    gain = np.var(drawn_responses.plain) / np.var(drawn_responses.differences)
    # of common surfaces the covariates leave the difference by themselves: only fitting costs
    assert 0.75 < gain < 1.0 if drawn_responses.shared else gain > 5.0


def adjusted_truth():
    """Elasticity of the true means at 78."""
    quadratic = np.polyfit(LEVELS - 78.0, MEAN + STEPS, 2)
    return quadratic[1] / quadratic[2] * 78.0


def test_covariates_known_from_few_surfaces_widen_the_errors_by_what_they_are_off():
    """50 surfaces tell the covariates' means; the error has their part, common to all levels."""
    random = generator(8)
    inside, ignored = [], []
    for _ in range(2000):
        samples, covariates = levels_of_surfaces(random, 40, shared=False)
        _, others = surfaces(random, 50)
        known = Known(others.mean(axis=0), np.cov(others.T), 50)
        stated = adjusted_means(samples, covariates, known, paired=False)
        exact = adjusted_means(samples, covariates, known._replace(surfaces=np.inf), False)
        truth = MEAN + STEPS[1]
        for found, one in ((inside, stated), (ignored, exact)):
            low, high = confidence_limits(one.estimate(1), 40)
            found.append(low <= truth <= high)
    assert 0.93 <= np.mean(inside) <= 0.97
    assert np.mean(ignored) < 0.85
    assert stated.covariance[0, 1] > 0.0


@pytest.fixture(scope="module")
def many_lengths():
    """The true length; of many samples adjusted and plain ones, and whether limits hold the true
    one."""
    random = generator(10)
    truth = indifference_interval(LEVELS, MEAN + 5 * STEPS, np.full(3, DEVIATION), 60, base=78.0)
    adjusted, plain, inside = [], [], []
    for i in range(120):
        samples, covariates = levels_of_surfaces(random, 60, shared=False)
        samples += 4 * STEPS[:, None]
        length, scatter = adjusted_length(
            LEVELS, samples, covariates, KNOWN, generator(i), base=78.0
        )
        adjusted.append(length)
        inside.append(scatter.low <= truth.length <= scatter.high)
        moments = samples.mean(axis=1), samples.std(axis=1, ddof=1)
        plain.append(indifference_interval(LEVELS, *moments, 60, base=78.0).length)
    return truth.length, adjusted, plain, inside


def test_an_adjusted_length_estimates_the_true_interval(many_lengths):
    truth, adjusted, _, _ = many_lengths
    assert np.median(adjusted) == pytest.approx(truth, rel=0.05)


def test_an_adjusted_length_scatters_as_stated(many_lengths):
    assert 0.90 <= np.mean(many_lengths[3]) <= 0.98


def test_an_adjusted_length_scatters_less_than_the_plain_one(many_lengths):
    _, adjusted, plain, _ = many_lengths
    spread = [np.diff(np.nanquantile(each, [0.16, 0.84]))[0] for each in (plain, adjusted)]
    assert (spread[0] / spread[1]) ** 2 > 3.0

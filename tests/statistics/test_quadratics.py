"""Errors of the correlations and elasticities are their scatter over repeated studies."""

import numpy as np
import pytest

from jointclosure.statistics.quadratics import (
    elasticity,
    elasticity_of,
    fit_quadratic,
    quadratic_errors,
)
from jointclosure.statistics.randomness import generator
from jointclosure.statistics.standard_errors import (
    deviation_covariance,
    mean_covariance,
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


def test_the_error_of_an_elasticity_is_hardly_more_than_its_scatter(elasticities):
    """Besides the scatter it contains the error of the form, which is small for close levels."""
    scatter = elasticities[:, 0].std()
    assert scatter < np.sqrt(np.mean(elasticities[:, 1] ** 2)) < 1.15 * scatter


@pytest.mark.parametrize("power", [-1.0, 0.6])
def test_the_elasticity_of_a_power_law_does_not_depend_on_its_levels(power):
    levels = np.array([15.0, 22.0, 30.0])
    found = elasticity_of(levels, levels**power, np.zeros((3, 3)), 22.0)
    assert found.value == pytest.approx(power, abs=1e-12)


def test_the_error_of_an_elasticity_contains_that_of_its_form():
    """Of three wide levels it is not known whether closure is quadratic in the parameter."""
    levels = np.array([15.0, 22.0, 30.0])
    in_parameter = fit_quadratic(levels, 1.0 / levels, 22.0).elasticity()
    assert in_parameter == pytest.approx(-1.12, abs=0.01)
    found = elasticity_of(levels, 1.0 / levels, np.zeros((3, 3)), 22.0)
    assert found.standard_error == pytest.approx(abs(in_parameter + 1.0))


def test_an_elasticity_is_that_of_the_quadratic_if_a_level_is_zero():
    levels = np.array([0.0, 0.2, 0.3])
    means = 1.0 - levels**2
    found = elasticity_of(levels, means, 1e-6 * np.eye(3), 0.2)
    assert found.value == pytest.approx(-2.0 * 0.04 / 0.96)
    assert found.standard_error > 0.0


def test_means_that_are_not_positive_have_no_elasticity():
    found = elasticity_of(LEVELS, np.array([1.0, 0.0, -1.0]), np.eye(3), 78.0)
    assert np.isnan(found.value)

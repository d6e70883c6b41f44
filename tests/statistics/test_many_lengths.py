import numpy as np
import pytest

import jointclosure as jc
from jointclosure.statistics.correlations import fit_quadratic
from jointclosure.statistics.indifference import (
    indifference_lengths,
    largest_real_roots,
    real_roots,
)


def random_studies(count, levels, seed):
    """Means and deviations of studies from strong effects to none, some of them dashes."""
    random = np.random.default_rng(seed)
    effect = 10.0 ** random.uniform(-3.0, 0.5, (count, 1))
    means = 1.0 + effect * random.normal(size=(count, levels.size))
    deviations = 0.2 * random.uniform(0.2, 2.0, (count, levels.size))
    return means, deviations


@pytest.mark.parametrize(
    "levels", [[70e9, 78e9, 85e9], [0.15, 0.25, 0.35], [4.0, 6.0, 8.0, 10.0, 12.0]]
)
@pytest.mark.parametrize("n", [2, 20])
def test_many_lengths_at_once_are_those_of_one_by_one(levels, n):
    levels = np.array(levels)
    means, deviations = random_studies(1000, levels, seed=n)
    many = indifference_lengths(levels, means, deviations, n)
    single = np.array(
        [
            jc.indifference_interval(levels, m, s, n).length
            for m, s in zip(means, deviations, strict=True)
        ]
    )
    assert 0.02 < np.isnan(single).mean() < 0.9  # dashes are among them
    np.testing.assert_array_equal(np.isnan(many), np.isnan(single))
    np.testing.assert_allclose(many, single, rtol=1e-9)


def test_many_lengths_keep_the_shape_and_the_special_cases():
    levels = np.array([-1.0, 0.0, 1.0])
    means = np.array([[[1.0, 1.0, 1.0], [1.1, 1.0, 0.9]], [[1.1, 1.0, 0.9], [0.1, 0.0, 0.1]]])
    spreads = np.array([[[0.1, 0.1, 0.1], [0.0, 0.0, 0.0]], [[0.1, 0.1, 0.1], [2.0, 1.0, 2.0]]])
    many = indifference_lengths(levels, means, spreads, 20)
    single = jc.indifference_interval(levels, means[1, 0], spreads[1, 0], 20).length
    np.testing.assert_allclose(many, [[np.nan, 0.0], [single, np.nan]], rtol=1e-12)


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_the_largest_roots_are_those_of_each_polynomial_alone(degree):
    random = np.random.default_rng(degree)
    polynomials = random.normal(size=(2000, degree + 1)) * 10.0 ** random.uniform(
        -6.0, 6.0, (2000, degree + 1)
    )
    found = largest_real_roots(polynomials)
    for polynomial, largest in zip(polynomials, found, strict=True):
        roots = real_roots(polynomial)
        if roots.size:
            assert abs(largest) == pytest.approx(np.abs(roots).max(), rel=1e-9)
        else:
            assert np.isnan(largest)


def test_multiple_roots_at_the_turns_of_all_derivatives_are_found():
    found = largest_real_roots(np.array([np.poly([2.0] * 4), np.poly([1.0, 1.0, 1.0, -3.0])]))
    assert found[0] == pytest.approx(2.0, rel=1e-3)
    assert found[1] == pytest.approx(-3.0, rel=1e-12)


@pytest.mark.parametrize("levels", [[1.0, 2.0, 3.5], [1.0, 2.0, 3.0, 4.0, 5.0]])
def test_quadratics_of_many_studies_are_bit_for_bit_those_of_each(levels):
    levels = np.array(levels)
    values = np.random.default_rng(0).normal(size=(50, levels.size))
    many = fit_quadratic(levels, values, 2.0)
    for i, row in enumerate(values):
        one = fit_quadratic(levels, row, 2.0)
        assert (many.b[i], many.c[i], many.d[i]) == one[:3]

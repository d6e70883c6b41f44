"""Products in one order of sums."""

import numpy as np
import pytest

from jointclosure.solvers.products import inner, symmetric_inverse, symmetric_times

SIZES = [1, 3, 4, 7, 8, 9, 31, 100]


@pytest.mark.parametrize("n", SIZES)
def test_products_are_those_of_linear_algebra(n):
    random = np.random.default_rng(n)
    one, other = random.standard_normal((2, n))
    matrix = random.standard_normal((n, n))
    matrix = matrix @ matrix.T + n * np.eye(n)
    assert inner(one, other) == pytest.approx(one @ other, rel=1e-12, abs=1e-13)
    np.testing.assert_allclose(symmetric_times(matrix, one), matrix @ one, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(symmetric_inverse(matrix) @ matrix, np.eye(n), atol=1e-12)


def test_an_inverse_is_symmetric_to_the_last_bit_and_leaves_its_matrix():
    random = np.random.default_rng(1)
    matrix = random.standard_normal((20, 20))
    matrix = matrix @ matrix.T + np.eye(20)
    before = matrix.copy()
    inverse = symmetric_inverse(matrix)
    np.testing.assert_array_equal(inverse, inverse.T)
    np.testing.assert_array_equal(matrix, before)

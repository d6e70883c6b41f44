"""Products with the influence between cells: in one order of sums, kept or by convolution."""

import numpy as np
import pytest

from jointclosure.solvers import fast, joint
from jointclosure.solvers.interaction_operator import (
    RecentContacts,
    influence_table,
)
from jointclosure.solvers.products import inner, symmetric_inverse, symmetric_times
from tests.joints import SPACING, closed, pair

MODULUS = 4e10


def table_of(*shape):
    return influence_table(*shape, 0.5 * SPACING, MODULUS, SPACING)


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_a_kept_matrix_and_the_convolution_give_the_same_joint(monkeypatch, breakage):
    """Where all is solved exactly; by rough stages another last digit breaks something else."""
    exact = {"breakage": breakage, "force_tolerance": 1e-11, "strength_bound": "none"}
    monkeypatch.setattr(fast, "PROVISIONAL_TOLERANCES", ())
    kept = closed(pair(24, 5), **exact)
    monkeypatch.setattr(joint, "dense_limit", lambda _: 0)
    convolved = closed(pair(24, 5), **exact)
    assert kept.max_closure.values == pytest.approx(convolved.max_closure.values, rel=1e-6)


@pytest.mark.parametrize("n", [1, 3, 4, 7, 8, 9, 31, 100])
def test_products_are_those_of_linear_algebra(n):
    random = np.random.default_rng(n)
    one, other = random.standard_normal((2, n))
    matrix = random.standard_normal((n, n))
    matrix = matrix @ matrix.T + n * np.eye(n)
    assert inner(one, other) == pytest.approx(one @ other, rel=1e-12, abs=1e-13)
    np.testing.assert_allclose(symmetric_times(matrix, one), matrix @ one, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(symmetric_inverse(matrix) @ matrix, np.eye(n), atol=1e-12)


def test_the_matrix_is_that_of_its_cells_whatever_cells_it_had_before():
    table = table_of(17, 23)
    near, random = RecentContacts(table), np.random.default_rng(2)
    begun_anew, largest = 0, 0
    for size in (3, 60, 61, 64, 90, 40, 150, 20, 391):
        wanted = np.sort(random.permutation(table.size)[:size])
        before = near.cells
        slots = near.slots(wanted)
        n = near.cells.size
        np.testing.assert_array_equal(near.cells[slots], wanted)
        y, x = np.divmod(near.cells, 23)
        expected = table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]
        np.testing.assert_array_equal(near.matrix[:n, :n], expected)
        assert n <= 1.25 * size or n == before.size
        begun_anew += not np.array_equal(near.cells[: before.size], before)
        largest = max(largest, n)
    assert begun_anew > 0
    assert largest == table.size

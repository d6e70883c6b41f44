"""Products in one order of sums, influence between cells, preconditioner and Newton direction."""

import numpy as np
import pytest

from jointclosure.solvers import joint
from jointclosure.solvers.conjugate_gradients import coarse_space, newton_direction
from jointclosure.solvers.interaction_operator import (
    Neighbours,
    influence_matrix,
    influence_of,
    influence_table,
)
from jointclosure.solvers.products import inner, symmetric_inverse, symmetric_times
from tests.joints import SPACING, closed, pair

MODULUS = 4e10


def table_of(*shape):
    return influence_table(*shape, 0.5 * SPACING, MODULUS, SPACING)


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_a_kept_matrix_and_the_convolution_give_the_same_joint(monkeypatch, breakage):
    exact = {"breakage": breakage, "force_tolerance": 1e-11, "strength_bound": "none"}
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


@pytest.mark.parametrize("shortfall", [np.nan, 2.0])
def test_direction_solves_newtons_equation(shortfall):
    influence, random = influence_of(table_of(30, 30)), np.random.default_rng(1)
    cells = np.flatnonzero(random.random(900) < 0.5)
    active = random.random(cells.size) > 0.2
    stiffness = active * random.random(cells.size) * SPACING * MODULUS
    secant = np.where(active, 1.0 / np.where(active, stiffness, 1.0), np.inf)
    space = coarse_space(influence, cells, stiffness)
    step = np.where(active, np.sin(np.arange(cells.size)), 0.0)
    forces = np.zeros((30, 30))
    forces.ravel()[cells[~active]] = 1e3  # of contacts at their limit, which do not move
    direction, shift, used = newton_direction(
        influence, np.empty((0, 0)), cells, space, step, secant, shortfall, 1e-12, forces
    )
    interaction = influence_matrix(influence.table, cells)[np.ix_(active, active)]
    left = secant[active] * direction[active] + interaction @ direction[active]
    right = secant[active] * step[active] + shift
    np.testing.assert_allclose(left, right, atol=1e-10 * np.abs(right).max())
    assert np.all(direction[~active] == 0.0)
    assert used < 40
    if np.isnan(shortfall):
        assert shift == 0.0
    else:
        assert direction.sum() == pytest.approx(shortfall, rel=1e-10)


def test_the_matrix_is_that_of_its_cells_however_these_came_and_went():
    table = table_of(17, 23)
    near, random = Neighbours(table), np.random.default_rng(2)
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

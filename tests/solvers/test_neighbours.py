"""The influence between cells that overlapped lately, kept while they change."""

import numpy as np
import pytest

from jointclosure.solvers import joint
from jointclosure.solvers.interaction_operator import Neighbours, influence_table
from tests.joints import SPACING, closed, pair

SHAPE = (17, 23)


def by_distance(table, cells):
    y, x = np.divmod(cells, SHAPE[1])
    return table[np.abs(y[:, None] - y), np.abs(x[:, None] - x)]


def test_the_matrix_is_that_of_its_cells_however_these_came_and_went():
    table = influence_table(*SHAPE, 0.5 * SPACING, 4e10, SPACING)
    near, random = Neighbours(table), np.random.default_rng(2)
    begun_anew, largest = 0, 0
    for size in (3, 60, 61, 64, 90, 40, 150, 20, 391):
        wanted = np.sort(random.permutation(table.size)[:size])
        before = near.cells
        slots = near.slots(wanted)
        n = near.cells.size
        np.testing.assert_array_equal(near.cells[slots], wanted)
        np.testing.assert_array_equal(near.matrix[:n, :n], by_distance(table, near.cells))
        assert n <= 1.25 * size or n == before.size
        begun_anew += not np.array_equal(near.cells[: before.size], before)
        largest = max(largest, n)
    assert begun_anew > 0
    assert largest == table.size


def test_what_is_known_of_the_matrix_is_not_filled_in_again(monkeypatch):
    near = Neighbours(influence_table(*SHAPE, 0.5 * SPACING, 4e10, SPACING))
    near.slots(np.arange(100))
    near.matrix[:100, :100] = -1.0
    near.slots(np.arange(2, 110))
    assert (near.matrix[:100, :100] == -1.0).all()
    assert not np.any(near.matrix[100:110, :110] == -1.0)


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
def test_a_kept_matrix_and_the_convolution_give_the_same_joint(monkeypatch, breakage):
    walls, exact = pair(24, 5), {"breakage": breakage, "force_tolerance": 1e-11}
    kept = closed(walls, **exact)
    monkeypatch.setattr(joint, "dense_limit", lambda _: 0)
    convolved = closed(walls, **exact)
    assert kept.max_closure.values == pytest.approx(convolved.max_closure.values, rel=1e-6)

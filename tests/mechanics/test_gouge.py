"""Gouge of a broken asperity: who loses, and where it is laid."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given

from jointclosure.mechanics.gouge import drops, passed_share, shed, upper_share

TIE = 1e-12  # difference in height [m] up to which a neighbour is not lower
neighbours = st.lists(st.floats(-1e-4, 1e-4), min_size=8, max_size=8).map(np.array)
breakages = {
    "before": neighbours,
    "height": st.floats(-1e-4, 1e-4),
    "loss": st.floats(1e-9, 1e-4),
}


def shed_around(before, height, loss):
    """Heights after a loss is shed, drops to lower neighbours, and the loss; skip if none is."""
    around = before.copy()
    falls = np.empty(8)
    total, least = drops(height, around, TIE, falls)
    assume(total > 0.0)
    lost = shed(around, loss, falls, total, least)
    return around, np.where(height - before > TIE, height - before, 0.0), lost


@given(before=neighbours, height=st.floats(-1e-4, 1e-4))
def test_a_cell_without_a_total_drop_has_no_lower_neighbour(before, height):
    total, _ = drops(height, before, TIE, np.empty(8))
    assert (total == 0.0) == bool(np.all(height - before <= TIE))


@given(**breakages)
def test_gouge_is_conserved(before, height, loss):
    around, _, lost = shed_around(before, height, loss)
    assert 0.0 < lost <= loss
    assert (around - before).sum() == pytest.approx(lost, rel=1e-12)


@given(**breakages)
def test_gouge_is_laid_in_proportion_to_the_drop(before, height, loss):
    around, drop, lost = shed_around(before, height, loss)
    np.testing.assert_allclose(around - before, lost * drop / drop.sum(), atol=1e-18)


@given(**breakages)
def test_gouge_lifts_no_neighbour_above_the_lowered_cell(before, height, loss):
    around, drop, lost = shed_around(before, height, loss)
    highest = around[drop > 0.0].max()
    assert highest <= height - lost + 1e-18
    assert lost == loss or highest == pytest.approx(height - lost, abs=1e-18)  # cut short, level


def test_gouge_does_not_leave_the_grid():
    assert drops(0.0, np.full(8, np.inf), TIE, np.empty(8)) == (0.0, np.inf)


@pytest.mark.parametrize(("drop", "lower"), [(0.9e-12, False), (1.1e-12, True)])
def test_neighbours_lower_by_no_more_than_the_tie_receive_no_gouge(drop, lower):
    total, _ = drops(0.0, np.full(8, -drop), TIE, np.empty(8))
    assert bool(total > 0.0) == lower


def test_the_sharper_asperity_has_the_larger_share():
    assert [upper_share(3.0, 1.0), upper_share(0.0, 2.0)] == [0.75, 0.0]


def test_flat_walls_share_alike_where_neighbours_differ_by_no_more_than_the_tie():
    assert upper_share(0.0, 0.0) == 0.5


def test_a_wall_without_lower_neighbours_passes_its_share_on():
    assert passed_share(0.3, 0.0, 1.0) == 0.0
    assert passed_share(0.3, 1.0, 0.0) == 1.0
    assert passed_share(0.3, 1.0, 1.0) == 0.3

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from jointclosure.mechanics.gouge import drops, passed_share, shed, upper_share

neighbours = st.lists(st.floats(-1e-4, 1e-4), min_size=8, max_size=8).map(np.array)


@given(neighbours, st.floats(-1e-4, 1e-4), st.floats(1e-9, 1e-4))
def test_gouge_is_conserved_and_lifts_none_above_the_lowered_cell(around, height, loss):
    before, falls = around.copy(), np.empty(8)
    total, least = drops(height, around, 1e-12, falls)
    if total == 0.0:
        assert np.all(height - around <= 1e-12)
        return
    lost = shed(around, loss, falls, total, least)
    gained = around - before
    assert 0.0 < lost <= loss
    assert gained.sum() == pytest.approx(lost, rel=1e-12)
    assert np.all(gained >= 0.0)
    lifted = gained > 0.0
    assert np.all(around[lifted] <= height - lost + 1e-18)


@given(neighbours)
def test_gouge_is_laid_in_proportion_to_the_drop(around):
    height, before, falls = 1.1e-4, around.copy(), np.empty(8)
    total, least = drops(height, around, 1e-12, falls)
    lost = shed(around, 1e-9, falls, total, least)
    np.testing.assert_allclose(around - before, lost * (height - before) / total, atol=1e-19)


def test_a_cut_share_ends_level_with_the_closest_neighbour():
    around, falls = np.array([-1e-6] + [-1e-4] * 7), np.empty(8)
    total, least = drops(0.0, around, 1e-12, falls)
    lost = shed(around, 5e-6, falls, total, least)
    assert lost < 5e-6
    assert around[0] == pytest.approx(-lost, rel=1e-12)


def test_nothing_flows_out_of_the_grid():
    around, falls = np.full(8, np.inf), np.empty(8)
    assert drops(0.0, around, 1e-12, falls) == (0.0, np.inf)


def test_the_sharper_asperity_loses_more():
    assert upper_share(3.0, 1.0) == 0.75
    assert upper_share(0.0, 0.0) == 0.5


def test_a_wall_without_lower_neighbours_passes_its_share_on():
    assert passed_share(0.3, 0.0, 1.0) == 0.0
    assert passed_share(0.3, 1.0, 0.0) == 1.0
    assert passed_share(0.3, 1.0, 1.0) == 0.3

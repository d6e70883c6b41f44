"""The comparison with continuum codes: our own parts, and theirs where they are installed."""

import sys
from pathlib import Path

import numpy as np
import pytest

from jointclosure.mechanics.strength import von_mises_on_axis

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import continuum
import limited_pressure
import peers
from yardstick import DOLERITE, joint_walls

STRESSES = continuum.LEVELS * 1e6


@pytest.fixture(scope="module")
def gap():
    summed = np.add(*joint_walls(peers.CELLS, 3))
    return summed.max() - summed


def test_the_lower_hardness_is_the_mean_pressure_at_which_an_asperity_breaks():
    hardness = continuum.hardnesses(DOLERITE)
    largest = max(von_mises_on_axis(z, DOLERITE.poisson_ratio) for z in np.linspace(0.3, 0.6, 301))
    peak = 1.5 * hardness["at breakage"]
    assert peak * largest == pytest.approx(DOLERITE.compressive_strength, rel=1e-3)
    assert hardness["2.8 sigma_c"] == 2.8 * DOLERITE.compressive_strength


@pytest.mark.parametrize("landing", [0.6e6, 0.9e6])
def test_the_stiffness_of_loading_ends_where_the_asperity_model_begins_to_land(landing):
    """All models of a joint are read there; unloading and reloading to the largest stress."""
    at = continuum.stresses_of(1e6, landing)
    assert at.all[at.half] == 0.5e6
    assert at.all[at.end] == landing
    np.testing.assert_array_equal(at.all[at.levels], STRESSES)
    # ten times stiffer from the landing on
    loading = 1e-10 * np.minimum(at.all, landing) + 1e-11 * np.maximum(at.all - landing, 0.0)
    closure = np.array([loading, loading[-1] + 2e-11 * at.all, loading[-1] + 4e-11 * at.all])
    read = continuum.readings(continuum.History(closure, 0.0 * closure, 0.0), at)
    stiffness = {"loading": 10.0, "unloading": 50.0, "reloading": 25.0}
    for name, value in stiffness.items():
        assert read[f"stiffness_{name}_MPa_per_mm"] == pytest.approx(value)
    assert read["loading_read_to_MPa"] == pytest.approx(1e-6 * landing)


@pytest.mark.parametrize("hardness", [165e6, 462e6])
def test_pressures_are_limited_where_walls_overlap_and_nothing_else_does(gap, hardness):
    """The conditions of each cell, at a stress that is met, in the operator's own terms."""
    state = limited_pressure.at_stress(gap, hardness, 20e6, limited_pressure.untouched(gap))
    left = peers.displacement(state.pressure) + gap - state.closure
    assert state.pressure.mean() == pytest.approx(20e6, rel=1e-9)
    none, full = state.pressure == 0.0, state.pressure == hardness
    between = ~none & ~full
    assert min(none.sum(), full.sum(), between.sum()) > 0
    assert (state.pressure[between] > 0.0).all()
    assert (state.pressure[between] < hardness).all()
    assert (left[none] > -1e-12).all()
    assert (left[full] < 1e-12).all()
    assert abs(left[between]).max() < 1e-12


@pytest.mark.parametrize("blocks", [limited_pressure.BLOCKS, 0])
def test_wrong_sets_of_cells_come_right_at_once_or_one_by_one(gap, blocks, monkeypatch):
    right = limited_pressure.at_stress(gap, 462e6, 20e6, limited_pressure.untouched(gap))
    random = np.random.default_rng(1)
    sets = right.sets.copy()
    sets.flat[random.choice(gap.size, 60, replace=False)] = random.integers(-1, 2, 60)
    monkeypatch.setattr(limited_pressure, "BLOCKS", blocks)
    there, _ = limited_pressure.at_closure(gap, 462e6, right.closure, sets)
    np.testing.assert_array_equal(there.sets, right.sets)
    np.testing.assert_allclose(there.pressure, right.pressure, atol=1.0)


def test_what_has_flowed_stays_and_opens_elastically(gap):
    press, left = limited_pressure.own(gap, 165e6)
    closure, pressure = press(20e6)
    assert pressure.max() == 165e6
    unloaded, pressure = press(10e6)
    assert pressure.max() < 165e6
    assert 1e-5 < left() < unloaded < closure
    again, pressure = press(20e6)
    assert again == pytest.approx(closure, rel=1e-9)

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
AT = continuum.stresses_of(1e6, np.inf)
"""The same of a joint that does not land."""
LARGE = continuum.LEVELS * 30e6
"""Of a whole wall: less would be carried by a single cell, which has no equilibrium to iterate."""


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


def test_readings_are_those_of_a_joint_of_known_stiffness():
    closure = np.array([continuum.LEVELS * 1e-4, 1e-4 + 0.0 * STRESSES, 2e-4 * continuum.LEVELS])
    closure[1] -= 2e-5 * (1.0 - continuum.LEVELS)
    contact = np.array([continuum.LEVELS * 0.1] * 3)
    read = continuum.readings(continuum.History(closure, contact, 5e-5), AT)
    expected = {"closure_1_mm": 0.1, "residual_mm": 0.05, "closure_2_mm": 0.15}
    # 0.5 MPa over 50, 10 and 100 micrometres
    stiffness = {"loading": 10.0, "unloading": 50.0, "reloading": 5.0}
    expected |= {f"stiffness_{name}_MPa_per_mm": value for name, value in stiffness.items()}
    expected["contact_1_percent"] = 10.0
    assert {name: read[name] for name in expected} == pytest.approx(expected)


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


def test_the_asperity_model_is_read_on_its_three_branches():
    walls = joint_walls(24, 3)
    history = continuum.asperity_model(walls, continuum.FULL, STRESSES)
    loading, unloading, _ = history.closure
    assert np.isfinite(history.closure).all()
    assert (unloading[:-1] > loading[:-1]).all()
    assert 0.0 < history.residual < unloading[0]
    assert 0.0 < history.contact[0, 0] < history.contact[0, -1] < 1.0


def test_an_elastic_code_has_one_curve_for_all_branches(gap):
    history = continuum.elastic(peers.own, gap, LARGE)
    assert (history.closure == history.closure[0]).all()
    assert (np.diff(history.closure[0]) > 0.0).all()
    assert history.residual == 0.0


def test_a_realisation_without_an_equilibrium_is_named_and_left_out(capsys):
    def fails(walls, stresses):
        raise RuntimeError("no equilibrium at 1e6 Pa")

    def history(scale):
        closure = scale * np.tile(continuum.LEVELS, (3, 1))
        return continuum.History(closure, np.full((3, 6), 0.1), 0.5 * scale)

    none = continuum.closed("other", fails, None, STRESSES)
    assert "other: a realisation is left out (no equilibrium" in capsys.readouterr().out
    ours = [history(s) for s in (1e-4, 2e-4, 9e-4)]
    other = [history(3e-4), history(6e-4), none]
    table = continuum.table_of({"ours": ours, "other": other}, [AT] * 3)
    own = table[table.reading == "closure_1_mm"].set_index("model")
    assert own.realizations.tolist() == [3, 2]
    assert own["mean"].other == pytest.approx(0.45)
    assert own.ratio.other == pytest.approx(3.0)


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

"""The comparison with continuum codes: our own parts, and theirs where they are installed."""

import sys
from pathlib import Path

import numpy as np
import pytest

from jointclosure.mechanics.strength import von_mises_on_axis

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import continuum
from yardstick import DOLERITE

STRESSES = continuum.LEVELS * 1e6


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
    read = continuum.readings(continuum.PressedJoint(closure, 0.0 * closure, 0.0), at)
    stiffness = {"loading": 10.0, "unloading": 50.0, "reloading": 25.0}
    for name, value in stiffness.items():
        assert read[f"stiffness_{name}_MPa_per_mm"] == pytest.approx(value)
    assert read["loading_read_to_MPa"] == pytest.approx(1e-6 * landing)

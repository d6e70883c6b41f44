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


@pytest.fixture(scope="module")
def curves():
    """Curves of two joints in two models, in whose second one nothing remains."""
    at = continuum.stresses_of(1e6, 0.9e6)
    loading = 1e-9 * at.all
    closure = np.array([loading, 0.5 * (loading + loading[-1]), 0.5 * (loading + loading[-1])])
    plastic, elastic = (
        [
            continuum.PressedJoint(factor * one, 0.1 + 0.0 * one, factor * one[1, 0])
            for factor in (1, 3)
        ]
        for one in (closure, np.tile(loading, (3, 1)))
    )
    return continuum.curve_table({"plastic": plastic, "elastic": elastic}, [at, at])


def test_curves_have_means_and_standard_errors_by_stress(curves):
    rows = curves[(curves.model == "elastic") & (curves.branch == "reloading")]
    assert list(rows.normal_stress_MPa) == pytest.approx([0.0, *(1e-6 * STRESSES)])
    np.testing.assert_allclose(rows.closure_mm[1:], 2e-6 * STRESSES)
    np.testing.assert_allclose(rows.closure_mm_error[1:], 1e-6 * STRESSES)
    assert set(rows.contact_percent[1:].round(9)) == {10.0}


def test_branches_of_the_figure_differ_in_line_style_and_models_in_marker(curves):
    figure = continuum.continuum_figure(curves)
    lines = [one.lines[0] for one in figure.axes[0].containers]
    assert len({(one.get_marker(), one.get_linestyle()) for one in lines}) == 6
    texts = {text.get_text() for text in figure.legends[0].get_texts()}
    assert texts == {"plastic", "elastic", *continuum.BRANCHES}

"""Elastic scenes at given stresses: one curve, without steps."""

import numpy as np
import pytest
import scipy.optimize

import jointclosure as jc
from jointclosure.joint.protocol import FLAGS
from jointclosure.solvers import elastic, equilibrium
from tests.joints import balanced, closed, pair

SCENES = {
    "asperities": jc.Effects(False, False, False, False, True),
    "substrate": jc.Effects(True, False, False, False, True),
    "interaction": jc.Effects(True, True, False, False, True),
    "hard peaks": jc.Effects(True, True, False, False, False),
}


def curve_of(walls, scene="interaction", stress=30e6, **stated):
    about = {"effects": SCENES[scene], "seating_stress": 0.0, "cycles": 1}
    return closed(walls, stress, **about | stated)


@pytest.mark.parametrize("scene", SCENES)
def test_each_point_is_an_equilibrium_at_its_closure(small_joint, scene):
    curve = curve_of(small_joint, scene)
    assert int(curve.status) == 0
    assert float(curve.equilibrium_residual.max()) <= 1e-10
    for step in (1, 9, 20):
        at = curve.isel(step=step)
        about = {"effects": SCENES[scene], "force_tolerance": 1e-12}
        found = balanced(small_joint, float(at.closure), **about)
        assert found.normal_stress == pytest.approx(float(at.normal_stress), rel=1e-9)
        bulk = float(at.bulk_indentation)
        assert found.interaction_displacement.mean() == pytest.approx(bulk, rel=1e-9, abs=1e-30)
        contacts = round(float(at.contact_fraction) * found.force.size)
        assert np.count_nonzero(found.force) == contacts


@pytest.mark.parametrize("scene", SCENES)
def test_the_paper_s_steps_end_at_the_same_closure(small_joint, scene):
    slow = {"solver": "reference", "stress_tolerance": 1e-7, "sweep_tolerance": 1e-10}
    stepped, curve = (curve_of(small_joint, scene, 3e6, **more) for more in (slow, {}))
    np.testing.assert_allclose(stepped.max_closure, curve.max_closure, rtol=1e-6)


def test_a_start_that_newton_cannot_use_is_bracketed(small_joint, monkeypatch):
    kernel = equilibrium.interacting_equilibrium

    def half(*given):
        """Newton that never finds the shift, but solves at a given one."""
        *problem, target, tolerance = given
        found = kernel(*problem, np.nan, tolerance)
        return found if np.isnan(target) else found._replace(residual=1.0)

    usual = curve_of(small_joint)
    monkeypatch.setattr(equilibrium, "interacting_equilibrium", half)
    np.testing.assert_allclose(curve_of(small_joint).closure, usual.closure, rtol=1e-9)
    monkeypatch.setattr(scipy.optimize, "brentq", lambda at, low, high, **_: high)
    assert FLAGS[int(curve_of(small_joint).status)] == "not_converged"  # another force


def test_a_cell_outside_of_the_working_set_that_touches_is_added_to_it(monkeypatch):
    """Started from half of the cells, the curve is the same."""
    walls = pair(60, 4)
    curve = curve_of(walls)
    predicted = elastic._predicted

    def halved(*given):
        point = predicted(*given)
        point.force[::2], point.gap[:] = 0.0, np.nan
        return point

    monkeypatch.setattr(elastic, "_predicted", halved)
    from_half = curve_of(walls)
    assert int(from_half.solver_iterations) > int(curve.solver_iterations)
    np.testing.assert_allclose(from_half.closure, curve.closure, rtol=1e-9)

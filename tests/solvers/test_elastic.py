"""Elastic scenes at given stresses: one curve, without steps."""

import numpy as np
import pytest
import scipy.optimize

import jointclosure as jc
from jointclosure.engine import oracle
from jointclosure.joint.protocol import FLAGS
from jointclosure.solvers import elastic
from tests.joints import DOLERITE, SPACING, bump

SCENES = {
    "asperities": jc.Effects(False, False, False, False, True),
    "substrate": jc.Effects(True, False, False, False, True),
    "interaction": jc.Effects(True, True, False, False, True),
    "hard peaks": jc.Effects(True, True, False, False, False),
}


def closed(walls, effects, stress=30e6, **options):
    return jc.simulate(
        *walls,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=stress,
        effects=effects,
        **{"seating_stress": 0.0} | options,
    )


@pytest.mark.parametrize("scene", SCENES)
def test_each_point_is_an_equilibrium_at_its_closure(small_joint, scene):
    curve = closed(small_joint, SCENES[scene], cycles=1)
    assert int(curve.status) == 0
    assert float(curve.equilibrium_residual.max()) <= 1e-10
    for step in (1, 9, 20):
        found = jc.equilibrium(
            *small_joint,
            spacing=SPACING,
            rock=DOLERITE,
            closure=float(curve.closure[step]),
            effects=SCENES[scene],
            numerics=jc.Numerics(force_tolerance=1e-12),
        )
        assert found.normal_stress == pytest.approx(float(curve.normal_stress[step]), rel=1e-9)
        assert found.interaction_displacement.mean() == pytest.approx(
            float(curve.bulk_indentation[step]), rel=1e-9, abs=1e-30
        )
        assert np.count_nonzero(found.force) == round(
            float(curve.contact_fraction[step]) * found.force.size
        )


def test_the_stresses_are_evenly_spaced_and_hold_the_seating_stress(small_joint):
    numerics = jc.Numerics(curve_points=8)
    curve = closed(small_joint, SCENES["interaction"], 8e6, cycles=1, numerics=numerics)
    up = [0, 1, 2, 3, 4, 5, 6, 7, 8]
    np.testing.assert_allclose(curve.normal_stress / 1e6, up + up[-2::-1], rtol=1e-9)
    seated = closed(
        small_joint, SCENES["interaction"], 8e6, cycles=1, numerics=numerics, seating_stress=0.5e6
    )
    assert seated.sizes["step"] == curve.sizes["step"] + 2
    found = jc.equilibrium(
        *small_joint,
        spacing=SPACING,
        rock=DOLERITE,
        closure=float(seated.max_closure[0] - seated.max_closure_seated[0]),
        effects=SCENES["interaction"],
    )
    assert found.normal_stress == pytest.approx(0.5e6, rel=1e-6)


def test_loading_unloading_and_all_cycles_are_one_curve(small_joint):
    curve = closed(small_joint, SCENES["interaction"], cycles=3)
    closure = curve.closure.values.reshape(-1)
    np.testing.assert_array_equal(closure[:41], closure[:41][::-1])
    np.testing.assert_array_equal(closure[40:81], closure[:41])
    np.testing.assert_array_equal(closure[80:], closure[:41])
    np.testing.assert_array_equal(curve.residual_closure, 0.0)


@pytest.mark.parametrize("scene", SCENES)
def test_the_paper_s_steps_end_at_the_same_closure(small_joint, scene):
    stress = 3e6
    slow = jc.Numerics(solver="reference", stress_tolerance=1e-7, sweep_tolerance=1e-10)
    stepped = closed(small_joint, SCENES[scene], stress, cycles=1, numerics=slow)
    curve = closed(small_joint, SCENES[scene], stress, cycles=1)
    np.testing.assert_allclose(stepped.max_closure, curve.max_closure, rtol=1e-6)


def test_a_curve_of_nearly_mated_walls_converges_where_most_cells_touch():
    upper, _ = jc.wall_pair(10.0, (64, 64), SPACING, seed=4, roll_off=None)
    lower = -upper + 1e-7 * np.random.default_rng(4).standard_normal(upper.shape)
    curve = closed((upper, lower), SCENES["interaction"], cycles=1)
    assert int(curve.status) == 0
    assert float(curve.contact_fraction.max()) > 0.7
    assert float(curve.equilibrium_residual.max()) <= 1e-10


def test_flat_contacts_without_substrate_are_rigid_and_said_to_be():
    flat = np.zeros((4, 5))
    curve = closed((flat, flat), SCENES["asperities"], cycles=1)
    assert FLAGS[int(curve.status)] == "rigid_contact"
    assert np.all(np.isnan(curve.max_closure))


def test_a_start_that_newton_cannot_use_is_bracketed(small_joint, monkeypatch):
    from jointclosure.solvers import equilibrium

    monkeypatch.setattr(equilibrium, "interacting_equilibrium", _given_up_on(equilibrium))
    curve = closed(small_joint, SCENES["interaction"], cycles=1)
    monkeypatch.undo()
    usual = closed(small_joint, SCENES["interaction"], cycles=1)
    np.testing.assert_allclose(curve.closure, usual.closure, rtol=1e-9)


def _given_up_on(equilibrium):
    """A Newton that never finds the shift, but solves at a given one."""
    kernel = equilibrium.interacting_equilibrium

    def half(*given):
        *problem, target, tolerance = given
        found = kernel(*problem, np.nan, tolerance)
        return found if np.isnan(target) else found._replace(residual=1.0)

    return half


def test_points_of_the_curve_are_checked(small_joint):
    for bad in (0, 2.5, True):
        with pytest.raises(jc.InputError, match="curve_points"):
            closed(small_joint, SCENES["substrate"], numerics=jc.Numerics(curve_points=bad))


@pytest.mark.parametrize("substrate", [True, False])
@pytest.mark.parametrize("decade", range(-10, 2))
def test_a_curve_of_a_sphere_on_a_flat_is_hertzian_over_12_decades_of_force(decade, substrate):
    upper = bump((9, 9), 2e-3)
    lower = np.zeros(upper.shape)
    radius = 1.0 / oracle.curvature(upper, SPACING)[4, 4]
    area = upper.size * SPACING**2
    force = 10.0**decade  # at most 10 N: the sphere is alone in touch up to 15 um
    effects = jc.Effects(substrate, False, False, False, False)
    curve = closed((upper, lower), effects, force / area, cycles=1, unusual_values=True)
    modulus = DOLERITE.youngs_modulus / (1.0 - DOLERITE.poisson_ratio**2) / 2.0
    forces = curve.normal_stress.values * area
    expected = (9.0 * forces**2 / (16.0 * modulus**2 * radius)) ** (1.0 / 3.0)
    if substrate:
        expected = expected + 0.75 * forces / (0.5 * SPACING * modulus)
    # one cell only: the cap falls by h^2 / 2 R = 15.6 um to the next
    assert expected.max() < SPACING**2 / (2.0 * radius)
    np.testing.assert_allclose(curve.closure, expected, rtol=1e-9)


def test_a_curve_of_two_unequal_distant_contacts_solves_their_two_equations():
    apart, deeper = 16, 4e-7
    shape = (5, apart + 5)
    one = bump(shape, 2e-3, centre=(2, 2))
    two = bump(shape, 3e-3, centre=(2, 2 + apart)) - deeper
    upper, lower = np.maximum(one, two), np.zeros(shape)
    curvature = oracle.curvature(upper, SPACING)[2, [2, 2 + apart]]
    area = upper.size * SPACING**2
    curve = closed((upper, lower), jc.Effects(True, True, False, False, False), 30.0 / area)
    modulus = DOLERITE.youngs_modulus / (1.0 - DOLERITE.poisson_ratio**2) / 2.0
    substrate = 0.75 / (0.5 * SPACING * modulus)
    compliance = (9.0 * curvature / (16.0 * modulus**2)) ** (1.0 / 3.0)
    # two Hertz pressures far apart: F / (pi E* zeta) (1 + (r / zeta)^2 / 10)
    across = (1.0 + (0.5 / apart) ** 2 / 10.0) / (np.pi * modulus * apart * SPACING)

    def closures(first):
        forces = np.array([first, 30.0 - first])
        own = substrate * forces + compliance * forces ** (2.0 / 3.0)
        return own + across * forces[::-1] + [0.0, deeper]

    first = scipy.optimize.brentq(lambda f: np.diff(closures(f))[0], 1.0, 29.0, xtol=1e-12)
    closure = closures(first)[0]
    assert round(float(curve.contact_fraction.max()) * upper.size) == 2
    assert float(curve.max_closure[0]) == pytest.approx(closure, rel=1e-7)


def test_the_curve_is_solved_in_the_cells_that_touch_and_is_that_of_all_that_overlap(monkeypatch):
    """Of the cells that overlap most are pushed apart by those that touch."""
    sizes = []
    solve = elastic.solve_equilibrium

    def counted(influence, contacts, *given):
        sizes.append(contacts.cells.size)
        return solve(influence, contacts, *given)

    monkeypatch.setattr(elastic, "solve_equilibrium", counted)
    walls = jc.wall_pair(8.0, (80, 80), SPACING, seed=4, roll_off=None)
    stated = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 60e6, "cycles": 1}
    stated["effects"] = jc.Effects(breakage=False, gouge=False)
    touching = jc.simulate(*walls, **stated)
    in_touching = sizes[-1]
    monkeypatch.setattr(elastic, "_FEW", np.inf)
    sizes.clear()
    overlapping = jc.simulate(*walls, **stated)
    assert in_touching < 0.6 * sizes[-1]
    assert in_touching >= int(touching.contact_fraction.max() * walls[0].size)
    np.testing.assert_allclose(touching.closure, overlapping.closure, rtol=1e-9)
    np.testing.assert_allclose(touching.contact_fraction, overlapping.contact_fraction, atol=1e-12)


def test_a_cell_outside_of_the_working_set_that_touches_is_added_to_it(monkeypatch):
    """Started from half of the cells, the curve is the same."""
    walls = jc.wall_pair(8.0, (60, 60), SPACING, seed=4, roll_off=None)
    stated = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 30e6, "cycles": 1}
    stated["effects"] = jc.Effects(breakage=False, gouge=False)
    curve = jc.simulate(*walls, **stated)
    predicted = elastic._predicted

    def halved(*given):
        point = predicted(*given)
        point.force[::2], point.gap[:] = 0.0, np.nan
        return point

    monkeypatch.setattr(elastic, "_predicted", halved)
    from_half = jc.simulate(*walls, **stated)
    assert int(from_half.solver_iterations) > int(curve.solver_iterations)
    np.testing.assert_allclose(from_half.closure, curve.closure, rtol=1e-9)

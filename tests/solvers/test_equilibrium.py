"""Elastic scenes: every solver of the registry must pass, judged by the oracle."""

import numpy as np
import pytest
import scipy.optimize

import jointclosure as jc
from jointclosure import oracle
from jointclosure.joint.status import FLAGS
from jointclosure.mechanics.contact_law import contact_law
from jointclosure.parameters import SOLVER_NAMES, Choices, Effects
from jointclosure.solvers import elastic, equilibrium, joint
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.contacts import Contacts, coordinate_sweep, separate_shift
from jointclosure.solvers.contacts import energy as contacts_energy
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import (
    FEW_FORCES,
    add_changes_of_force,
    add_displacements,
    influence_matrix,
    influence_of,
    influence_table,
    interaction_field,
    mean_displacement,
    single_product,
)
from tests.joints import DOLERITE, ELASTIC, SPACING, balanced, closed, pair


def law_of(**choices):
    return contact_law(SPACING, (DOLERITE, DOLERITE), Effects(), Choices(**choices))


def table_of(shape, law):
    return influence_table(*shape, law.base_radius, law.substrate_modulus, law.spacing)


def contacts_at(upper, lower, closure):
    """All contacts of a joint in dolerite, and its influence table."""
    law, offset = law_of(), closure - (upper + lower).max()
    cells, overlap, _, compliance = overlapping_cells(
        upper, lower, offset, peak_map(upper, lower), law
    )
    limit = np.full(cells.size, np.inf)
    return Contacts(cells, overlap, compliance, limit, law.substrate), table_of(upper.shape, law)


@pytest.mark.parametrize("solver", SOLVER_NAMES)
@pytest.mark.parametrize("closure", [5e-6, 4e-5, 3e-4, 1.5e-3])
@pytest.mark.parametrize("soft_peaks", [True, False])
def test_forces_and_gaps_are_complementary(solver, small_joint, closure, soft_peaks):
    effects = ELASTIC._replace(soft_peaks=soft_peaks)
    # the deepest closure takes 8 GPa
    about = {"effects": effects, "unusual_values": True, "solver": solver}
    exact = {"force_tolerance": 1e-10} if solver == "fast" else {"sweep_tolerance": 1e-12}
    found = balanced(small_joint, closure, **about, **exact)
    force = found.force.values
    assert force.min() >= 0.0
    joint = oracle.PristineJoint(*small_joint, SPACING, DOLERITE, effects, Choices())
    state = oracle.State(*small_joint, force, closure, force.sum())
    assert oracle.judge(joint, state).residual < 1e-9  # 1e-4 of the smallest force is more
    assert found.normal_stress == pytest.approx(force.sum() / (force.size * SPACING**2))


@pytest.fixture
def swept(small_joint):
    """Contacts, their influence table, and the forces (sweep, cell) [N] after each sweep."""
    contacts, table = contacts_at(*small_joint, 3e-4)
    force = np.zeros(contacts.cells.size)
    forces = []
    for _ in range(200):
        coordinate_sweep(table, contacts, 0.0, force)
        forces.append(force.copy())
    return contacts, table, forces


def test_a_sweep_never_raises_the_energy(swept):
    contacts, table, forces = swept
    matrix = influence_matrix(table, contacts.cells)

    def energy(force):
        own = contacts.substrate * force**2 / 2 + 0.6 * contacts.compliance * force ** (5 / 3)
        return np.sum(own) + force @ matrix @ force / 2 - contacts.overlap @ force

    energies = [0.0, *map(energy, forces)]
    assert np.all(np.diff(energies) <= 1e-12 * abs(energies[-1]))
    last = contacts_energy(contacts, 0.0, matrix @ forces[-1], forces[-1])
    assert last == pytest.approx(energies[-1])


def test_sweeps_end_at_the_solution(swept):
    contacts, table, forces = swept
    solved = solve_equilibrium(influence_of(table), contacts, 0.0 * forces[0], np.nan, 1e-12)
    np.testing.assert_allclose(forces[-1], solved.force, atol=1e-6 * solved.force.max())


def test_contacts_before_a_rigid_one_are_closed_to_their_force():
    """One of five alone would carry the force where the rigid contact is met already."""
    compliance = np.array([1e-8] * 5 + [0.0])
    overlap = np.array([0.0] * 5 + [-0.5e-8])
    contacts = Contacts(np.arange(6), overlap, compliance, np.full(6, np.inf), 0.0)
    assert separate_shift(contacts, 1.0) == pytest.approx(1e-8 * 0.2 ** (2 / 3), rel=1e-12)


@pytest.mark.parametrize("shape", [(1, 40), (7, 5), (12, 30)])
def test_the_convolution_is_the_sum_over_all_contacts(shape):
    law = law_of()
    force = np.random.default_rng(5).exponential(1.0, shape)
    expected = oracle.interaction(force, SPACING, law.base_radius, law.substrate_modulus)
    table = table_of(shape, law)
    np.testing.assert_allclose(interaction_field(influence_of(table), force), expected, rtol=1e-12)
    mean = np.sum(mean_displacement(table) * force)
    np.testing.assert_allclose(mean, expected.mean(), rtol=1e-12)


@pytest.mark.parametrize("unit", [1.0, 1e-60, 1e60])
def test_products_in_single_precision_have_no_range_of_their_own(unit):
    table = table_of((12, 30), law_of())
    influence, nothing = influence_of(unit * table), np.empty((0, 0))
    cells = np.random.default_rng(7).permutation(table.size)[:40]
    force = np.random.default_rng(8).standard_normal(40) / unit**2
    field = np.zeros(table.shape)
    field.ravel()[cells] = force
    expected = interaction_field(influence, field)
    product, scale = single_product(influence, nothing, cells, force)
    within = 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(product, expected.ravel()[cells], rtol=0.0, atol=within)
    whole = scale * influence.single.field[:, :30].astype(float)
    np.testing.assert_allclose(whole, expected, rtol=0.0, atol=within)


@pytest.mark.parametrize("count", [FEW_FORCES, FEW_FORCES + 1])
def test_displacements_of_a_few_forces_are_added_one_by_one(count):
    table = table_of((12, 30), law_of())
    influence, cells = influence_of(table), np.arange(0, 350, 7)
    force = np.zeros(cells.size)
    force[:count] = np.linspace(-1.0, 2.0, count)
    field = np.zeros(table.shape)
    field.ravel()[cells] = force
    expected, added = interaction_field(influence, field), np.zeros(table.shape)
    by_transform = add_displacements(influence, np.empty((0, 0)), cells, force, added)
    assert by_transform == (count > FEW_FORCES)
    within = (1e-6 if by_transform else 1e-13) * np.abs(expected).max()
    np.testing.assert_allclose(added, expected, rtol=0.0, atol=within)
    of_contacts = np.zeros((1, cells.size))
    add_displacements(influence, influence_matrix(table, cells), cells, force, of_contacts)
    np.testing.assert_allclose(of_contacts[0], expected.ravel()[cells], rtol=0.0, atol=within)


def test_the_interaction_follows_a_change_of_the_forces():
    influence, cells = influence_of(table_of((12, 30), law_of())), np.arange(0, 350, 7)
    force = np.random.default_rng(9).random((12, 30))
    start = np.random.default_rng(10).random(cells.size)
    interaction = interaction_field(influence, force)
    within = 1e-6 * interaction.max()  # of single precision, over what changes
    add_changes_of_force(influence, cells, start, force, interaction)
    changed = np.zeros((12, 30))
    changed.ravel()[cells] = start
    expected = interaction_field(influence, changed)
    np.testing.assert_allclose(interaction, expected, rtol=0.0, atol=within)


@pytest.mark.parametrize("base_radius_in_cells", [0.1, 0.5, 1.0])
def test_substrate_and_interaction_together_are_positive_definite(base_radius_in_cells):
    law = law_of(base_radius_in_cells=base_radius_in_cells)
    matrix = influence_matrix(table_of((16, 16), law), np.arange(256))
    assert np.linalg.eigvalsh(matrix + law.substrate * np.eye(256)).min() > 0.0
    assert np.linalg.eigvalsh(matrix).min() < 0.0  # alone, the interaction is indefinite


# Elastic scenes at given stresses: one curve, without steps


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
    assert float(curve.equilibrium_residual.max()) <= elastic.ELASTIC_TOLERANCE
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
    np.testing.assert_allclose(
        curve_of(small_joint).closure, usual.closure, rtol=elastic.ELASTIC_TOLERANCE
    )
    monkeypatch.setattr(scipy.optimize, "brentq", lambda at, low, high, **_: high)
    assert FLAGS[int(curve_of(small_joint).status)] == "not_converged"  # another force


def test_a_cell_outside_of_the_working_set_that_touches_is_added_to_it(monkeypatch):
    """Started from half of the cells, the curve is the same."""
    walls = pair(60, 4)
    curve = curve_of(walls)
    predicted = elastic._starting_point

    def halved(*given):
        point = predicted(*given)
        point.force[::2], point.gap[:] = 0.0, np.nan
        return point._replace(field=np.empty((0, 0)))

    monkeypatch.setattr(elastic, "_starting_point", halved)
    from_half = curve_of(walls)
    assert int(from_half.solver_iterations) > int(curve.solver_iterations)
    np.testing.assert_allclose(from_half.closure, curve.closure, rtol=elastic.ELASTIC_TOLERANCE)


def test_a_curve_by_transforms_is_that_by_the_matrix(small_joint, monkeypatch):
    """Transforms start from the displacements of the last two points."""
    usual = curve_of(small_joint)
    monkeypatch.setattr(joint, "dense_limit", lambda _: 0)
    monkeypatch.setattr(elastic, "dense_limit", lambda _: 0)
    solve, known = elastic.solve_equilibrium, []

    def solved(*given, field=None, **stated):
        known.append(field is not None and field.size > 0)
        return solve(*given, field=field, **stated)

    monkeypatch.setattr(elastic, "solve_equilibrium", solved)
    curve = curve_of(small_joint)
    assert all(known[-10:])
    np.testing.assert_allclose(curve.closure, usual.closure, rtol=elastic.ELASTIC_TOLERANCE)
    np.testing.assert_array_equal(curve.contact_fraction, usual.contact_fraction)
    assert float(curve.equilibrium_residual.max()) <= elastic.ELASTIC_TOLERANCE


@pytest.mark.parametrize("scene", SCENES)
def test_a_curve_whose_only_candidate_is_the_highest_cell_is_that_of_all_cells(
    scene, small_joint, monkeypatch
):
    curves = []
    for count in (1, 10**6):
        monkeypatch.setattr(elastic, "_FIRST_CANDIDATES", count)
        curves.append(curve_of(small_joint, scene))
    np.testing.assert_allclose(curves[0].closure, curves[1].closure, rtol=elastic.ELASTIC_TOLERANCE)
    np.testing.assert_array_equal(curves[0].contact_fraction, curves[1].contact_fraction)


def test_a_curve_ends_with_the_first_force_that_is_not_solved(small_joint, monkeypatch):
    solve, targets = elastic.solve_equilibrium, []

    def third_fails(influence, start, force, target, *more, **stated):
        targets.append(target)
        found = solve(influence, start, force, target, *more, **stated)
        return found._replace(residual=1.0) if len(set(targets)) == 3 else found

    monkeypatch.setattr(elastic, "solve_equilibrium", third_fails)
    curve = curve_of(small_joint)
    assert FLAGS[int(curve.status)] == "not_converged"
    assert len(set(targets)) == 3
    assert np.isnan(curve.max_closure).all()

"""Elastic scenes: every solver of the registry must pass, judged by the oracle."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engine import oracle
from jointclosure.mechanics.contact_law import contact_law
from jointclosure.parameters import Choices, Effects
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.contacts import Contacts, coordinate_sweep
from jointclosure.solvers.equilibrium import solve_equilibrium
from jointclosure.solvers.interaction_operator import (
    influence_matrix,
    influence_of,
    influence_table,
    interaction_field,
    mean_displacement,
)
from jointclosure.solvers.registry import SOLVERS
from tests.joints import DOLERITE, SPACING, bump

ELASTIC = jc.Effects(breakage=False, gouge=False)


def table_of(shape, law):
    return influence_table(*shape, law.base_radius, law.substrate_modulus, law.spacing)


def contacts_at(upper, lower, closure):
    """All contacts of a joint in dolerite, and its influence table."""
    law = contact_law(SPACING, (DOLERITE, DOLERITE), Effects(), Choices())
    cells, overlap, _, compliance = overlapping_cells(
        upper, lower, closure - (upper + lower).max(), peak_map(upper, lower), law
    )
    limit = np.full(cells.size, np.inf)
    return Contacts(cells, overlap, compliance, limit, law.substrate), table_of(upper.shape, law)


def tight(solver):
    """Numerics that make every solver as exact as the tests ask for."""
    return jc.Numerics(solver=solver, force_tolerance=1e-10, sweep_tolerance=1e-12)


def force_of_contact(overlap, kappa, modulus, r):
    """Of one contact on its substrates [N], of one modulus [Pa]."""
    law = oracle.Law(modulus, modulus, 3 / (4 * r * modulus), r)
    compliance = oracle.asperity_compliances(np.array([kappa]), law)
    return oracle.forces_of_overlaps(np.array([overlap]), compliance, law.substrate)[0]


@pytest.fixture(params=SOLVERS)
def numerics(request):
    return tight(request.param)


@pytest.mark.parametrize("decade", range(-12, 0))
@pytest.mark.parametrize("substrate", [True, False])
def test_a_sphere_on_a_flat_is_hertzian_over_12_decades(numerics, decade, substrate):
    radius, closure = 0.5e-3, 10.0**decade * 1e-4
    upper, flat = bump((3, 3), radius), np.zeros((3, 3))
    effects = jc.Effects(substrate, False, False, False, False)
    found = jc.equilibrium(
        upper,
        flat,
        spacing=SPACING,
        rock=DOLERITE,
        closure=closure,
        effects=effects,
        numerics=numerics,
    )
    kappa = oracle.curvature(upper, SPACING)[1, 1]
    modulus = 78e9 / (1 - 0.2**2) / 2
    if substrate:
        expected = force_of_contact(closure, kappa, modulus, SPACING / 2)
    else:
        expected = 4 / 3 * modulus * np.sqrt(closure**3 / kappa)
    assert found.force.values[1, 1] == pytest.approx(expected, rel=1e-12)
    assert np.count_nonzero(found.force) == 1


def test_two_distant_contacts_push_each_other_as_two_point_forces(numerics):
    shape = (3, 60)
    upper = np.maximum(bump(shape, 0.5e-3, centre=(1, 5)), bump(shape, 0.5e-3, centre=(1, 54)))
    closure = 2e-6
    effects = ELASTIC._replace(soft_peaks=False)
    found = jc.equilibrium(
        upper,
        np.zeros(shape),
        spacing=SPACING,
        rock=DOLERITE,
        closure=closure,
        effects=effects,
        numerics=numerics,
    )
    modulus = 78e9 / (1 - 0.2**2) / 2
    kappa = oracle.curvature(upper, SPACING)[1, 5]
    # symmetric: both carry F, each displaced by the other's F/(pi E* zeta)(1 + (r/zeta)^2/10)
    zeta, r = 49 * SPACING, SPACING / 2
    influence = (1 + (r / zeta) ** 2 / 10) / (np.pi * modulus * zeta)
    force = 0.0
    for _ in range(60):
        force = force_of_contact(closure - influence * force, kappa, modulus, r)
    assert found.force.values[1, 5] == pytest.approx(force, rel=1e-9)
    assert found.force.values[1, 54] == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("closure", [5e-6, 4e-5, 3e-4, 1.5e-3])
@pytest.mark.parametrize("soft_peaks", [True, False])
def test_forces_and_gaps_are_complementary(numerics, small_joint, closure, soft_peaks):
    upper, lower = small_joint
    effects = ELASTIC._replace(soft_peaks=soft_peaks)
    found = jc.equilibrium(
        upper,
        lower,
        spacing=SPACING,
        rock=DOLERITE,
        closure=closure,
        effects=effects,
        numerics=numerics,
        unusual_values=True,  # the deepest closure takes 8 GPa
    )
    force = found.force.values
    assert force.min() >= 0.0
    joint = oracle.Joint(upper, lower, SPACING, DOLERITE, effects, Choices())
    misfit = oracle.residual(joint, oracle.State(upper, lower, force, closure, force.sum()))
    assert misfit < 1e-8 * closure
    assert found.normal_stress == pytest.approx(force.sum() / (upper.size * SPACING**2))


def test_all_solvers_agree_in_elastic_scenes(small_joint):
    upper, lower = small_joint
    forces = [
        jc.equilibrium(
            upper,
            lower,
            spacing=SPACING,
            rock=DOLERITE,
            closure=2e-4,
            effects=ELASTIC,
            numerics=tight(name),
        ).force.values
        for name in SOLVERS
    ]
    for other in forces[1:]:
        np.testing.assert_allclose(other, forces[0], atol=1e-8 * forces[0].max())


@pytest.mark.parametrize("start", [0.0, 1e-9, 1e3, 1e9])
def test_equilibrium_does_not_depend_on_the_start(small_joint, start):
    upper, lower = small_joint
    contacts, table = contacts_at(upper, lower, 3e-4)
    zero = np.zeros(contacts.cells.size)
    influence = influence_of(table)
    usual = solve_equilibrium(influence, contacts, zero, np.nan, 1e-12)
    other = solve_equilibrium(influence, contacts, zero + start, np.nan, 1e-12)
    assert other.residual <= 1e-12
    np.testing.assert_allclose(other.force, usual.force, atol=1e-9 * usual.force.max())


def test_a_sweep_never_raises_the_energy_and_ends_at_the_solution(small_joint):
    upper, lower = small_joint
    contacts, table = contacts_at(upper, lower, 3e-4)
    matrix = influence_matrix(table, contacts.cells)

    def energy(force):
        own = contacts.substrate * force**2 / 2 + 0.6 * contacts.compliance * force ** (5 / 3)
        return np.sum(own) + force @ matrix @ force / 2 - contacts.overlap @ force

    force = np.zeros(contacts.cells.size)
    energies = [0.0]
    for _ in range(200):
        coordinate_sweep(table, contacts, 0.0, force)
        energies.append(energy(force))
    assert np.all(np.diff(energies) <= 1e-12 * abs(energies[-1]))
    solved = solve_equilibrium(influence_of(table), contacts, 0.0 * force, np.nan, 1e-12)
    np.testing.assert_allclose(force, solved.force, atol=1e-6 * solved.force.max())


@pytest.mark.parametrize("shape", [(1, 40), (7, 5), (12, 30)])
def test_the_convolution_is_the_sum_over_all_contacts(shape):
    law = contact_law(SPACING, (DOLERITE, DOLERITE), Effects(), Choices())
    force = np.random.default_rng(5).exponential(1.0, shape)
    expected = oracle.interaction(force, SPACING, law.base_radius, law.substrate_modulus)
    np.testing.assert_allclose(
        interaction_field(influence_of(table_of(shape, law)), force), expected, rtol=1e-12
    )
    np.testing.assert_allclose(
        np.sum(mean_displacement(table_of(shape, law)) * force), expected.mean(), rtol=1e-12
    )


@pytest.mark.parametrize("base_radius_in_cells", [0.1, 0.5, 1.0])
def test_substrate_and_interaction_together_are_positive_definite(base_radius_in_cells):
    law = contact_law(
        SPACING,
        (DOLERITE, DOLERITE),
        Effects(),
        Choices(base_radius_in_cells=base_radius_in_cells),
    )
    table = table_of((16, 16), law)
    matrix = influence_matrix(table, np.arange(256))
    assert np.linalg.eigvalsh(matrix + law.substrate * np.eye(256)).min() > 0.0
    assert np.linalg.eigvalsh(matrix).min() < 0.0  # alone, the interaction is indefinite

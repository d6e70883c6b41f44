"""Elastic scenes: every solver of the registry must pass, judged by the oracle."""

import numpy as np
import pytest
import scipy.optimize

import jointclosure as jc
from jointclosure.engine import oracle
from jointclosure.joint.protocol import FAILURE, FLAGS
from jointclosure.mechanics.contact_law import contact_law
from jointclosure.parameters import Choices, Effects
from jointclosure.solvers import elastic, equilibrium, fast
from jointclosure.solvers.cells import overlapping_cells, peak_map
from jointclosure.solvers.contacts import Contacts, coordinate_sweep, separate_shift
from jointclosure.solvers.contacts import energy as contacts_energy
from jointclosure.solvers.equilibrium import ROUNDING, solve_equilibrium
from jointclosure.solvers.interaction_operator import (
    influence_matrix,
    influence_of,
    influence_table,
    interaction_field,
    mean_displacement,
)
from jointclosure.solvers.registry import SOLVERS
from tests.joints import DOLERITE, ELASTIC, SPACING, balanced, bump, closed, pair

MODULUS = 78e9 / (1 - 0.2**2) / 2
EXACT = {"force_tolerance": 1e-10, "sweep_tolerance": 1e-12}


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


def force_of_contact(overlap, kappa):
    """Of one contact on its substrates [N]."""
    law = oracle.Law(MODULUS, MODULUS, 3 / (2 * SPACING * MODULUS), SPACING / 2)
    compliance = oracle.asperity_compliances(np.array([kappa]), law)
    return oracle.forces_of_overlaps(np.array([overlap]), compliance, law.substrate)[0]


@pytest.fixture(params=SOLVERS)
def solver(request):
    return request.param


@pytest.mark.parametrize("decade", range(-12, 0))
@pytest.mark.parametrize("substrate", [True, False])
def test_a_sphere_on_a_flat_is_hertzian_over_12_decades(solver, decade, substrate):
    upper, closure = bump((3, 3), 0.5e-3), 10.0**decade * 1e-4
    effects = Effects(substrate, False, False, False, False)
    walls = upper, np.zeros((3, 3))
    found = balanced(walls, closure, effects=effects, solver=solver, **EXACT)
    kappa = oracle.curvature(upper, SPACING)[1, 1]
    hertz = 4 / 3 * MODULUS * np.sqrt(closure**3 / kappa)
    expected = force_of_contact(closure, kappa) if substrate else hertz
    assert found.force.values[1, 1] == pytest.approx(expected, rel=1e-12)
    assert np.count_nonzero(found.force) == 1


def test_two_distant_contacts_push_each_other_as_two_point_forces(solver):
    shape, closure = (3, 60), 2e-6
    upper = np.maximum(bump(shape, 0.5e-3, centre=(1, 5)), bump(shape, 0.5e-3, centre=(1, 54)))
    effects = ELASTIC._replace(soft_peaks=False)
    walls = upper, np.zeros(shape)
    found = balanced(walls, closure, effects=effects, solver=solver, **EXACT)
    kappa = oracle.curvature(upper, SPACING)[1, 5]
    # symmetric: both carry F, each displaced by the other's F/(pi E* zeta)(1 + (r/zeta)^2/10)
    zeta, r = 49 * SPACING, SPACING / 2
    influence = (1 + (r / zeta) ** 2 / 10) / (np.pi * MODULUS * zeta)
    force = 0.0
    for _ in range(60):
        force = force_of_contact(closure - influence * force, kappa)
    assert found.force.values[1, [5, 54]] == pytest.approx([force, force], rel=1e-9)


@pytest.mark.parametrize("closure", [5e-6, 4e-5, 3e-4, 1.5e-3])
@pytest.mark.parametrize("soft_peaks", [True, False])
def test_forces_and_gaps_are_complementary(solver, small_joint, closure, soft_peaks):
    effects = ELASTIC._replace(soft_peaks=soft_peaks)
    # the deepest closure takes 8 GPa
    usual = {"effects": effects, "unusual_values": True}
    found = balanced(small_joint, closure, solver=solver, **EXACT, **usual)
    force = found.force.values
    assert force.min() >= 0.0
    joint = oracle.Joint(*small_joint, SPACING, DOLERITE, effects, Choices())
    misfit = oracle.residual(joint, oracle.State(*small_joint, force, closure, force.sum()))
    assert misfit < 1e-8 * closure
    assert found.normal_stress == pytest.approx(force.sum() / (force.size * SPACING**2))


def test_all_solvers_agree_in_elastic_scenes(small_joint):
    forces = [balanced(small_joint, 2e-4, solver=name, **EXACT).force.values for name in SOLVERS]
    for other in forces[1:]:
        np.testing.assert_allclose(other, forces[0], atol=1e-8 * forces[0].max())


def test_a_sweep_never_raises_the_energy_and_ends_at_the_solution(small_joint):
    contacts, table = contacts_at(*small_joint, 3e-4)
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
    assert contacts_energy(contacts, 0.0, matrix @ force, force) == pytest.approx(energies[-1])
    solved = solve_equilibrium(influence_of(table), contacts, 0.0 * force, np.nan, 1e-12)
    np.testing.assert_allclose(force, solved.force, atol=1e-6 * solved.force.max())


def test_contacts_before_a_rigid_one_are_closed_to_their_force_though_a_longer_step_meets_it():
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


def test_a_curve_of_nearly_mated_walls_converges_where_most_cells_touch():
    upper, _ = jc.wall_pair(10.0, (64, 64), SPACING, seed=4, roll_off=None)
    lower = -upper + 1e-7 * np.random.default_rng(4).standard_normal(upper.shape)
    curve = curve_of((upper, lower))
    assert int(curve.status) == 0
    assert float(curve.contact_fraction.max()) > 0.7
    assert float(curve.equilibrium_residual.max()) <= 1e-10


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


@pytest.mark.parametrize("substrate", [True, False])
@pytest.mark.parametrize("decade", range(-10, 2))
def test_a_curve_of_a_sphere_on_a_flat_is_hertzian_over_12_decades_of_force(decade, substrate):
    upper = bump((9, 9), 2e-3)
    lower = np.zeros(upper.shape)
    radius = 1.0 / oracle.curvature(upper, SPACING)[4, 4]
    area = upper.size * SPACING**2
    force = 10.0**decade  # at most 10 N: the sphere is alone in touch up to 15 um
    effects = jc.Effects(substrate, False, False, False, False)
    about = {"effects": effects, "cycles": 1, "unusual_values": True}
    curve = closed((upper, lower), force / area, **about)
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
    curve = curve_of((upper, lower), "hard peaks", 30.0 / area)
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


# What cannot be solved is said to be unsolved: bad starts, tolerances, NaN, steps


pytestmark = pytest.mark.filterwarnings("error")
BREAKAGE = ("fixed_step", "resolved")


@pytest.fixture(scope="module")
def problem():
    """Contacts of a joint, their influence, and their forces in equilibrium."""
    contacts, table = contacts_at(*pair((20, 24)), 3e-4)
    influence = influence_of(table)
    nothing = np.zeros(contacts.cells.size)
    return influence, contacts, solve_equilibrium(influence, contacts, nothing, np.nan, 1e-12)


@pytest.fixture(params=["closure", "force"])
def target(request, problem):
    """The total force, or NaN where the closure is given."""
    return problem[2].force.sum() if request.param == "force" else np.nan


@pytest.fixture(params=[True, False], ids=["interacting", "separate"])
def influence(request, problem):
    return problem[0] if request.param else None


def garbage(n):
    random = np.random.default_rng(1)
    return random.standard_normal(n) * 10.0 ** random.uniform(-300.0, 300.0, n)


STARTS = {
    **{str(value): value for value in (0.0, 1e-9, 1e3, 1e100, 1e300, -1e200, 5e-324)},
    **{"NaN": np.nan, "infinite": np.inf},
    "one NaN": lambda n: np.where(np.arange(n) == 3, np.nan, 1.0),
    "garbage": garbage,
}


@pytest.mark.parametrize("start", STARTS)
def test_any_start_leads_to_the_same_equilibrium(problem, start, target):
    influence, contacts, usual = problem
    n, begin = contacts.cells.size, STARTS[start]
    guess = begin(n) if callable(begin) else np.full(n, begin)
    found = solve_equilibrium(influence, contacts, guess, target, 1e-10)
    assert found.residual <= 1e-10
    assert np.abs(found.force - usual.force).sum() <= 1e-8 * usual.force.sum()


def test_forces_in_equilibrium_at_another_total_are_no_answer(problem):
    influence, contacts, usual = problem
    total = 2.0 * usual.force.sum()
    found = solve_equilibrium(influence, contacts, usual.force, total, 1e-10)
    assert found.residual <= 1e-10
    assert found.force.sum() == pytest.approx(total, rel=1e-9)


def test_rigid_contacts_without_interaction_carry_no_force_that_is_given(problem):
    contacts = problem[1]._replace(compliance=0.0 * problem[1].compliance, substrate=0.0)
    nothing = np.zeros(contacts.cells.size)
    found = solve_equilibrium(None, contacts, nothing, 1.0, 1e-10)
    assert found.residual == np.inf


def test_a_tolerance_below_rounding_is_not_said_to_be_met(problem, influence, target):
    start = np.zeros(problem[1].cells.size)
    found = solve_equilibrium(influence, problem[1], start, target, 1e-18)
    assert ROUNDING <= found.residual < 1e-13
    assert np.isfinite(found.force).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("field", ["overlap", "compliance"])
def test_contacts_that_are_no_numbers_have_no_equilibrium(problem, field, value, target, influence):
    values = getattr(problem[1], field).copy()
    values[2] = value
    bad = problem[1]._replace(**{field: values})
    found = solve_equilibrium(influence, bad, np.zeros(values.size), target, 1e-10)
    assert np.isnan(found.residual)
    assert np.isnan(found.force).all()


@pytest.mark.parametrize("total", [0.0, -1.0, np.inf])
def test_a_force_that_no_closure_carries_is_not_found(problem, total, influence):
    start = np.zeros(problem[1].cells.size)
    assert np.isnan(solve_equilibrium(influence, problem[1], start, total, 1e-10).residual)


def test_forces_that_nothing_answers_are_no_equilibrium(small_joint, monkeypatch):
    """A solver that believes in a wrong answer is overruled by the recomputed residual."""

    def believer(*arguments, **more):
        found = solve_equilibrium(*arguments, **more)
        return found._replace(force=2.0 * found.force)

    monkeypatch.setattr(fast, "solve_equilibrium", believer)
    joint = closed(small_joint, 1e6)
    assert FLAGS[int(joint.status)] == "not_converged"
    assert np.isnan(joint.max_closure).all()


@pytest.mark.parametrize("breakage", BREAKAGE)
@pytest.mark.parametrize("tolerance", [1e-14, 0.01, 0.1, 0.9])
def test_success_means_that_every_step_is_within_the_tolerance(tolerance, breakage):
    """Also a coarse one, at which forces and what answers them differ in sum."""
    for seed in range(3):
        joint = closed(pair(24, seed), breakage=breakage, force_tolerance=tolerance)
        assert int(joint.status) < FAILURE
        assert float(joint.equilibrium_residual.max()) <= tolerance


@pytest.mark.parametrize("breakage", BREAKAGE)
@pytest.mark.parametrize(("step", "stress"), [(1e-3, 1.0), (1.0, 1e5), (12.5e-6, 1e-5)])
def test_a_step_far_longer_than_all_of_the_closure_still_lands(small_joint, step, stress, breakage):
    steps = jc.Numerics(step, 0.4 * step, step, 0.4 * step, breakage=breakage)
    rock = DOLERITE._replace(compressive_strength=1e12)
    about = {"rock": rock, "numerics": steps, "seating_stress": 0.0, "unusual_values": True}
    joint = closed(small_joint, stress, **about)
    assert int(joint.status) == 0
    assert joint.normal_stress.max() == pytest.approx(stress, rel=1e-3)
    assert np.all(joint.max_closure > 0.0)


def test_a_target_below_what_rounding_resolves_is_a_failure_that_says_so():
    # heights of 1 km beside a pit: the overlap is known to 1e-13 m, which carries far more
    upper, lower = pair(9, 1)
    upper[:8] += 1e3
    lower[:8] += 1e3
    joint = closed((upper, lower), 1e-9, seating_stress=0.0, cycles=1, unusual_values=True)
    assert FLAGS[int(joint.status)] == "stress_not_reached"
    assert np.isnan(joint.max_closure).all()


@pytest.mark.parametrize("breakage", BREAKAGE)
@pytest.mark.parametrize("effects", [jc.Effects(substrate=False, interaction=False), jc.Effects()])
def test_a_strength_that_nothing_reaches_leaves_walls_and_elastic_closures(
    small_joint, effects, breakage
):
    rock = DOLERITE._replace(compressive_strength=float("inf"))
    joint = closed(small_joint, 1e6, rock=rock, effects=effects, breakage=breakage)
    elastic = effects._replace(breakage=False, gouge=False)
    smooth = closed(small_joint, 1e6, rock=rock, effects=elastic)
    assert float(joint.equilibrium_residual.max()) <= jc.Numerics().force_tolerance
    np.testing.assert_allclose(joint.max_closure, smooth.max_closure, rtol=1e-3)
    np.testing.assert_array_equal(joint.upper_final, small_joint[0])
    assert int(joint.breakage_steps) == 0

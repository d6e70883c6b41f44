"""What cannot be solved is said to be unsolved: bad starts, tolerances, NaN, steps."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint.protocol import FAILURE, FLAGS
from jointclosure.solvers.equilibrium import ROUNDING, solve_equilibrium
from jointclosure.solvers.interaction_operator import influence_of
from tests.joints import DOLERITE, SPACING
from tests.solvers.test_equilibrium import contacts_at

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def problem():
    """Contacts of a joint, their influence, and their forces in equilibrium."""
    upper, lower = jc.wall_pair(8.0, (20, 24), SPACING, seed=3, roll_off=None)
    contacts, table = contacts_at(upper, lower, 3e-4)
    influence = influence_of(table)
    nothing = np.zeros(contacts.cells.size)
    return influence, contacts, solve_equilibrium(influence, contacts, nothing, np.nan, 1e-12)


def garbage(n):
    random = np.random.default_rng(1)
    return random.standard_normal(n) * 10.0 ** random.uniform(-300.0, 300.0, n)


STARTS = {
    "zero": np.zeros,
    "NaN": lambda n: np.full(n, np.nan),
    "one NaN": lambda n: np.where(np.arange(n) == 3, np.nan, 1.0),
    "infinite": lambda n: np.full(n, np.inf),
    "huge": lambda n: np.full(n, 1e300),
    "1e100 N": lambda n: np.full(n, 1e100),
    "negative": lambda n: np.full(n, -1e200),
    "denormal": lambda n: np.full(n, 5e-324),
    "garbage": garbage,
}


@pytest.mark.parametrize("given", ["closure", "force"])
@pytest.mark.parametrize("start", STARTS)
def test_any_start_leads_to_the_same_equilibrium(problem, start, given):
    influence, contacts, usual = problem
    target = usual.force.sum() if given == "force" else np.nan
    guess = STARTS[start](contacts.cells.size)
    found = solve_equilibrium(influence, contacts, guess, target, 1e-10)
    assert found.residual <= 1e-10
    assert np.abs(found.force - usual.force).sum() <= 1e-8 * usual.force.sum()


@pytest.mark.parametrize("given", ["closure", "force"])
@pytest.mark.parametrize("interacting", [True, False])
def test_a_tolerance_below_rounding_is_not_said_to_be_met(problem, interacting, given):
    influence, contacts, usual = problem
    start = np.zeros(contacts.cells.size)
    target = usual.force.sum() if given == "force" else np.nan
    found = solve_equilibrium(influence if interacting else None, contacts, start, target, 1e-18)
    assert ROUNDING <= found.residual < 1e-13
    assert np.isfinite(found.force).all()


@pytest.mark.parametrize("name", ["stress_tolerance", "force_tolerance", "sweep_tolerance"])
def test_a_tolerance_below_rounding_is_refused_by_name(small_joint, name):
    with pytest.raises(jc.InputError, match=f"{name} = 1e-18"):
        jc.simulate(
            *small_joint,
            spacing=SPACING,
            rock=DOLERITE,
            max_normal_stress=1e6,
            numerics=jc.Numerics(**{name: 1e-18}),
        )


@pytest.mark.parametrize("interacting", [True, False])
@pytest.mark.parametrize("given", ["closure", "force"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("field", ["overlap", "compliance"])
def test_contacts_that_are_no_numbers_have_no_equilibrium(
    problem, field, value, given, interacting
):
    influence, contacts, usual = problem
    values = getattr(contacts, field).copy()
    values[2] = value
    target = usual.force.sum() if given == "force" else np.nan
    found = solve_equilibrium(
        influence if interacting else None,
        contacts._replace(**{field: values}),
        np.zeros(values.size),
        target,
        1e-10,
    )
    assert np.isnan(found.residual)
    assert not found.residual <= 1e-10
    assert np.isnan(found.force).all()


@pytest.mark.parametrize("interacting", [True, False])
@pytest.mark.parametrize("target", [0.0, -1.0, np.inf])
def test_a_force_that_no_closure_carries_is_not_found(problem, target, interacting):
    influence, contacts, _ = problem
    start = np.zeros(contacts.cells.size)
    found = solve_equilibrium(influence if interacting else None, contacts, start, target, 1e-10)
    assert np.isnan(found.residual)


def test_forces_that_nothing_answers_are_no_equilibrium(small_joint, monkeypatch):
    """A solver that believes in a wrong answer is overruled by the recomputed residual."""
    from jointclosure.solvers import fast

    def believer(*arguments, **more):
        found = solve_equilibrium(*arguments, **more)
        return found._replace(force=2.0 * found.force)

    monkeypatch.setattr(fast, "solve_equilibrium", believer)
    closed = jc.simulate(*small_joint, spacing=SPACING, rock=DOLERITE, max_normal_stress=1e6)
    assert FLAGS[int(closed.status)] == "not_converged"
    assert np.isnan(closed.max_closure).all()


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
@pytest.mark.parametrize("tolerance", [1e-14, 0.01, 0.03, 0.1, 0.3, 0.9])
def test_success_means_that_every_step_is_within_the_tolerance(tolerance, breakage):
    """Also a coarse one, at which forces and what answers them differ in sum."""
    for seed in range(3):
        closed = jc.simulate(
            *jc.wall_pair(8.0, (24, 24), SPACING, seed=seed, roll_off=None),
            spacing=SPACING,
            rock=DOLERITE,
            max_normal_stress=4e6,
            numerics=jc.Numerics(breakage=breakage, force_tolerance=tolerance),
        )
        assert int(closed.status) < FAILURE
        assert float(closed.equilibrium_residual.max()) <= tolerance


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
@pytest.mark.parametrize(("step", "stress"), [(1e-3, 1.0), (1.0, 1e5), (12.5e-6, 1e-5)])
def test_a_step_far_longer_than_all_of_the_closure_still_lands(small_joint, step, stress, breakage):
    closed = jc.simulate(
        *small_joint,
        spacing=SPACING,
        rock=DOLERITE._replace(compressive_strength=1e12),
        max_normal_stress=stress,
        seating_stress=0.0,
        numerics=jc.Numerics(
            displacement_step=step,
            breakage_step=0.4 * step,
            later_displacement_step=step,
            later_breakage_step=0.4 * step,
            breakage=breakage,
        ),
        unusual_values=True,
    )
    assert int(closed.status) == 0
    assert closed.normal_stress.max() == pytest.approx(stress, rel=1e-3)
    assert np.all(closed.max_closure > 0.0)


def test_a_target_below_what_rounding_resolves_is_a_failure_that_says_so():
    # heights of 1 km beside a pit: the overlap is known to 1e-13 m, which carries far more
    upper, lower = jc.wall_pair(8.0, (9, 9), SPACING, seed=1, roll_off=None)
    upper[:8] += 1e3
    lower[:8] += 1e3
    closed = jc.simulate(
        upper,
        lower,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=1e-9,
        seating_stress=0.0,
        cycles=1,
        unusual_values=True,
    )
    assert FLAGS[int(closed.status)] == "stress_not_reached"
    assert np.isnan(closed.max_closure).all()


@pytest.mark.parametrize("effects", [jc.Effects(substrate=False, interaction=False), jc.Effects()])
def test_infinite_strength_holds_where_breakage_is_resolved(small_joint, effects):
    rock = DOLERITE._replace(compressive_strength=float("inf"))
    closed = jc.simulate(
        *small_joint,
        spacing=SPACING,
        rock=rock,
        max_normal_stress=1e6,
        effects=effects,
        numerics=jc.Numerics(breakage="resolved"),
    )
    elastic = jc.simulate(
        *small_joint,
        spacing=SPACING,
        rock=rock,
        max_normal_stress=1e6,
        effects=effects._replace(breakage=False, gouge=False),
    )
    assert float(closed.equilibrium_residual.max()) <= jc.Numerics().force_tolerance
    np.testing.assert_allclose(closed.max_closure, elastic.max_closure, rtol=1e-3)

"""What cannot be solved is said to be unsolved: bad starts, tolerances, NaN, steps."""

import numpy as np
import pytest

from jointclosure.joint.status import FAILURE, FLAGS
from jointclosure.solvers import fast
from jointclosure.solvers.equilibrium import ROUNDING, solve_equilibrium
from jointclosure.solvers.interaction_operator import influence_of
from tests.joints import closed, pair
from tests.solvers.test_equilibrium import contacts_at

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
    for seed in range(2):
        joint = closed(pair(24, seed), breakage=breakage, force_tolerance=tolerance)
        assert int(joint.status) < FAILURE
        assert float(joint.equilibrium_residual.max()) <= tolerance


def test_a_target_below_what_rounding_resolves_is_a_failure_that_says_so():
    # heights of 1 km beside a pit: the overlap is known to 1e-13 m, which carries far more
    upper, lower = pair(9, 1)
    upper[:8] += 1e3
    lower[:8] += 1e3
    joint = closed((upper, lower), 1e-9, seating_stress=0.0, cycles=1, unusual_values=True)
    assert FLAGS[int(joint.status)] == "stress_not_reached"
    assert np.isnan(joint.max_closure).all()

"""The limit of the numerical error of one joint: its terms, and where nothing is known."""

import math

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint.cycle_results import net_responses
from jointclosure.uncertainty.numerical_error import (
    WEIGHTS,
    differences_of_loading,
    log_change,
    log_scatter,
    numerical_error,
)
from jointclosure.uncertainty.ranged_results import CLOSURE_NET, STIFFNESS

RESULTS = [(quantity, cycle) for quantity in (CLOSURE_NET, STIFFNESS) for cycle in (1, 2)]


def stated(change=0.0, curve=0.0, jump=0.0, quantity=CLOSURE_NET, cycle=1):
    return numerical_error(change, curve, jump, quantity, cycle)


@pytest.mark.parametrize(("quantity", "cycle"), RESULTS)
def test_results_that_agree_without_a_jump_leave_the_least_error(quantity, cycle):
    weights = WEIGHTS[quantity, cycle == 1]
    found = stated(quantity=quantity, cycle=cycle)
    assert found == pytest.approx(math.expm1(weights.limit * weights.least))


@pytest.mark.parametrize(("quantity", "cycle"), RESULTS)
def test_terms_add_up_as_squares(quantity, cycle):
    weights = WEIGHTS[quantity, cycle == 1]
    expected = math.sqrt(
        weights.least**2
        + (0.06 * weights.of_change) ** 2
        + (0.05 * weights.of_curve) ** 2
        + (0.04 * weights.of_jump) ** 2
    )
    found = stated(0.06, 0.05, 0.04, quantity, cycle)
    assert found == pytest.approx(math.expm1(weights.limit * expected))


def test_a_change_counts_in_both_directions():
    assert stated(log_change(1.0, 1.1)) == pytest.approx(stated(log_change(1.0, 1.0 / 1.1)))


def test_the_unit_of_a_result_does_not_matter():
    assert stated(log_change(1e-6, 1.1e-6)) == pytest.approx(stated(log_change(1.0, 1.1)))


@pytest.mark.parametrize("other", [math.nan, 0.0, -1.0])
def test_nothing_is_stated_where_other_steps_give_no_result(other):
    assert math.isnan(stated(log_change(1.0, other)))
    assert math.isnan(stated(log_change(other, 1.0)))


def test_nothing_is_stated_where_the_other_rule_of_steps_gives_no_curve():
    assert math.isnan(stated(0.1, math.nan))


@pytest.mark.parametrize("values", [[1.0], [1.0, math.nan], [1.0, 1.1, 0.0], [-1.0, 1.0, 1.0]])
def test_nothing_scatters_where_nothing_is_known(values):
    assert math.isnan(log_scatter(values))


def test_a_copy_that_failed_does_not_count():
    assert log_scatter([1.0, math.nan, 1.1]) == log_scatter([1.0, 1.1])


def test_the_scatter_is_that_of_factors():
    assert log_scatter([1.0, 4.0]) == pytest.approx(math.log(4.0) / math.sqrt(2.0))


@pytest.fixture(scope="module")
def joint():
    walls = jc.wall_pair(8, (24, 24), 0.5e-3, 3)
    load = {"spacing": 0.5e-3, "rock": "granite", "max_normal_stress": 5e6, "cycles": 2}
    return jc.simulate(*walls, **load, numerics=jc.Numerics(breakage="resolved"))


def test_equal_loadings_do_not_differ(joint):
    assert differences_of_loading(joint, joint) == {CLOSURE_NET: 0.0, STIFFNESS: 0.0}


def test_a_loading_that_is_shifted_differs_by_the_shift(joint):
    """Over the closure since seating, and over the closure from half of the maximum."""
    shift = 2e-6
    closures = net_responses(joint)
    chord = 2.5e6 / closures["stiffness_net"][0]
    found = differences_of_loading(joint, joint.assign(closure=joint.closure + shift))
    assert found[CLOSURE_NET] == pytest.approx(shift / closures["max_closure_seated_net"][0])
    assert found[STIFFNESS] == pytest.approx(shift / chord, rel=0.02)


def test_a_loading_without_closure_has_no_difference(joint):
    still = joint.assign(closure=joint.bulk_indentation)
    assert all(math.isnan(value) for value in differences_of_loading(still, joint).values())


def test_only_the_first_loading_is_compared(joint):
    later = joint.load_cycle > 1
    other = joint.assign(closure=joint.closure.where(~later, 2.0 * joint.closure))
    assert differences_of_loading(joint, other)[CLOSURE_NET] == pytest.approx(0.0, abs=1e-12)


def test_differences_of_both_signs_do_not_cancel(joint):
    below = joint.normal_stress < 3.7e6
    signs = np.where(below, -1.0, 1.0) * 2e-6
    shifted = differences_of_loading(joint, joint.assign(closure=joint.closure + 2e-6))
    found = differences_of_loading(joint, joint.assign(closure=joint.closure + signs))
    assert found[CLOSURE_NET] == pytest.approx(shifted[CLOSURE_NET], rel=0.1)

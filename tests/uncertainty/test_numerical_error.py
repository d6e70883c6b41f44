"""The limit of the numerical error of one joint: its terms, and where nothing is known."""

import math

import numpy as np
import pytest

from jointclosure.uncertainty.numerical_error import (
    LEAST,
    LIMIT,
    OF_JUMP,
    OF_SCATTER,
    log_scatter,
    numerical_error,
)
from jointclosure.uncertainty.ranged_results import CLOSURE_NET, STIFFNESS


def stated(values=(1.0, 1.0, 1.0), jump=0.0, quantity=CLOSURE_NET, cycle=1):
    return numerical_error(log_scatter(values), jump, quantity, cycle)


def test_results_that_agree_without_a_jump_leave_the_least_error():
    assert stated() == pytest.approx(math.expm1(LIMIT[CLOSURE_NET, True] * LEAST))


@pytest.mark.parametrize("quantity", [CLOSURE_NET, STIFFNESS])
@pytest.mark.parametrize("cycle", [1, 2])
def test_terms_add_up_as_squares(quantity, cycle):
    values = [1.0, 1.1, 0.95]
    scatter = np.std(np.log(values), ddof=1)
    first = cycle == 1
    expected = math.hypot(LEAST, OF_JUMP[first] * 0.04, OF_SCATTER * scatter)
    assert stated(values, 0.04, quantity, cycle) == pytest.approx(
        math.expm1(LIMIT[quantity, first] * expected)
    )


def test_a_change_counts_in_both_directions():
    assert stated([1.0, 1.1]) == pytest.approx(stated([1.0, 1.0 / 1.1]))


def test_the_unit_of_a_result_does_not_matter():
    values = np.array([1.0, 1.1, 1.05])
    assert stated(1e-6 * values) == pytest.approx(stated(values))


@pytest.mark.parametrize("values", [[1.0], [1.0, math.nan], [1.0, 1.1, 0.0], [-1.0, 1.0, 1.0]])
def test_nothing_is_stated_where_nothing_is_known(values):
    assert math.isnan(stated(values))


def test_a_copy_that_failed_does_not_count():
    assert stated([1.0, math.nan, 1.1]) == stated([1.0, 1.1])


def test_the_scatter_is_that_of_factors():
    assert log_scatter([1.0, 4.0]) == pytest.approx(math.log(4.0) / math.sqrt(2.0))

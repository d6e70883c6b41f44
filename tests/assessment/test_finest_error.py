"""Limit of the error of the finest setting of an assessment, from what is known of a joint."""

import math

import pytest

from jointclosure.assessment.assessed_results import LIMITED
from jointclosure.assessment.finest_error import WEIGHTS, log_error_of_finest

TERMS = {"scatter": "of_scatter", "change": "of_change", "jump": "of_jump"}


@pytest.mark.parametrize("quantity", LIMITED)
@pytest.mark.parametrize("cycle", [1, 2, 3])
@pytest.mark.parametrize("term", TERMS)
def test_each_term_adds_its_square(quantity, cycle, term):
    weights = WEIGHTS[quantity, cycle == 1]
    known = dict.fromkeys(TERMS, 0.0) | {term: 0.2}
    found = log_error_of_finest(**known, quantity=quantity, cycle=cycle) / weights.limit
    expected = math.hypot(weights.least, getattr(weights, TERMS[term]) * 0.2)
    assert found == pytest.approx(expected)
    assert found > weights.least > 0.0


def test_an_unknown_scatter_gives_no_limit():
    assert math.isnan(log_error_of_finest(math.nan, 0.1, 0.0, LIMITED[0], 1))

"""The stated numerical error of a joint grows with all that is known to make it uncertain."""

import math

import numpy as np
import pytest

from jointclosure.uncertainty.numerical_error import (
    EXPECTED_FIRST,
    EXPECTED_LATER,
    FACTOR,
    PRIOR_WEIGHT,
    numerical_error,
    scatter_of,
)

ALIKE = {"value": 1.0, "changed": [1.0] * 3, "copies": [1.0] * 4, "contacts": 256.0, "cycle": 1}


def stated(**changes):
    return numerical_error(**ALIKE | changes)


def test_copies_that_agree_leave_the_scatter_that_is_expected_of_so_few_contacts():
    share = PRIOR_WEIGHT / (PRIOR_WEIGHT + 3)
    assert stated() == pytest.approx(FACTOR * EXPECTED_FIRST * math.sqrt(share / 256))
    assert stated(contacts=16.0) == pytest.approx(4.0 * stated())
    assert stated(cycle=2) == pytest.approx(FACTOR * EXPECTED_LATER * math.sqrt(share))
    assert math.isfinite(stated(contacts=0.0))


def test_a_change_with_the_tolerance_counts_in_both_directions():
    up, down = (stated(changed=[value] * 3) for value in (1.1, 1.0 / 1.1))
    assert up == pytest.approx(down)
    assert up > FACTOR * math.log(1.1) / math.sqrt(2.0)


def test_of_many_copies_the_scatter_is_theirs():
    copies = [1.0, 1.2] * 50
    scatter = np.std(np.log(copies), ddof=1)
    assert stated(copies=copies) == pytest.approx(FACTOR * scatter, rel=0.02)
    assert stated(copies=[1.0, 1.2]) > stated()


def test_the_unit_of_a_result_does_not_matter():
    values = {"value": 1.0, "changed": [1.1, 1.05], "copies": [1.0, 1.1, 1.05]}
    scaled = {"value": 1e-6, "changed": [1.1e-6, 1.05e-6], "copies": [1e-6, 1.1e-6, 1.05e-6]}
    assert stated(**values) == pytest.approx(stated(**scaled))


@pytest.mark.parametrize(
    "changes", [{"changed": []}, {"changed": [math.nan]}, {"value": math.nan}, {"value": 0.0}]
)
def test_nothing_is_stated_where_nothing_is_known(changes):
    assert math.isnan(stated(**changes))


def test_a_copy_that_failed_does_not_count():
    assert stated(copies=[1.0, math.nan, 1.1]) == stated(copies=[1.0, 1.1])
    assert scatter_of([1.0, math.nan, 1.1]) == scatter_of([1.0, 1.1])
    assert scatter_of([1.0]) == 0.0


def test_scatter_is_relative_to_the_mean():
    assert scatter_of([9.0, 11.0]) == pytest.approx(math.sqrt(2.0) / 10.0)

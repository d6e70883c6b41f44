"""Numbers as text have the digits that their errors allow."""

import numpy as np
import pytest

from jointclosure.statistics.number_texts import number_text, percent, rounded


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.08312, 0.0041, "0.083 ± 0.004"),
        (0.08312, 0.00123, "0.0831 ± 0.0012"),
        (0.08312, 0.00951, "0.083 ± 0.010"),
        (1234.5, 56.0, "1230 ± 60"),
        (-0.0001, 0.04, "0.00 ± 0.04"),
        (78e9, 1.2e9, "78000000000 ± 1200000000"),
        (0.083123, 0.0, "0.08312"),
        (0.083123, float("nan"), "0.08312"),
        (float("nan"), 1.0, "–"),
    ],
)
def test_a_number_ends_where_its_error_does(value, error, text):
    assert rounded(value, error) == text


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"), (1234.5678, "1235"), (0.0012344, "0.001234"), (9.99996, "10.00"),
        (9.9e-4, "9.900e-04"), (1e6, "1.000e+06"), (999999.0, "1000000"), (-0.5, "-0.5000"),
        (np.nan, "–"), (np.inf, "∞"), (-np.inf, "−∞"),
    ],
)  # fmt: skip
def test_numbers_have_the_digits_asked_for(value, shown):
    assert number_text(value) == shown


@pytest.mark.parametrize(
    ("share", "shown"), [(0.0123, "1.2 %"), (0.0994, "9.9 %"), (0.0996, "10 %"), (0.5, "50 %")]
)
def test_percentages_have_two_digits_below_ten(share, shown):
    assert percent(share) == shown

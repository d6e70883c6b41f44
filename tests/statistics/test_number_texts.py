"""Numbers as text have the digits that their errors allow."""

import numpy as np
import pytest

from jointclosure.statistics.number_texts import (
    number_text,
    percent,
    rounded,
    with_equal_decimals,
)


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


@pytest.mark.parametrize(
    ("share", "shown"), [(2.0, "200 %"), (1.63, "163 %"), (1.2e-6, "0.00012 %"), (-0.4, "-40 %")]
)
def test_percentages_have_no_exponent(share, shown):
    assert percent(share) == shown


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ((0.0974, 0.0908, 0.0996), ["0.097", "0.091", "0.100"]),
        ((0.1024, 0.0958, 0.1045), ["0.102", "0.096", "0.104"]),  # not 0.10 (0.10 to 0.10)
        ((195.6, 182.7, 216.9), ["196", "183", "217"]),
        ((3580.0, 3390.0, 3781.0), ["3600", "3400", "3800"]),
        ((144.5, 29.2, 8801.0), ["140", "30", "8800"]),  # an end that is above 0 does not read as 0
        ((0.0085, 0.00085, 0.0589), ["0.0085", "0.0008", "0.0589"]),
        ((-3.1, -9.2, 3.0), ["-3.1", "-9.2", "3.0"]),
        ((3.2, -46.4, 57.1), ["3", "-46", "57"]),
        ((0.0, 0.0, 0.8), ["0.00", "0.00", "0.80"]),
        ((2.4e-8, 1e-9, 3e-7), ["2.4e-08", "1.0e-09", "3.0e-07"]),
        ((np.nan, 0.2, 0.3), ["–", "0.20", "0.30"]),
        ((2.7e-8, 2.2e-18, 5.9e-2), ["2.7e-08", "2.2e-18", "0.059"]),
        ((0.0, 0.0, 0.0), ["0", "0", "0"]),
    ],
)
def test_a_number_and_the_ends_of_its_range_have_equal_decimals(values, shown):
    assert with_equal_decimals(values) == shown

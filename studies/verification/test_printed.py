"""What the paper's printed formulas lose, and that ours do not."""

import mpmath
import numpy as np
import pytest

from studies.verification import printed


def errors(frame):
    return frame.pivot(index="at", columns="series", values="error")


def test_the_cubic_as_printed_is_never_right_and_its_best_root_loses_what_ours_keeps():
    found = errors(printed.cubic_errors(np.logspace(-12, 12, 25)))
    assert found["Eq. (13) as printed"].min() > 0.1
    assert found["sign corrected, principal root"].min() > 0.1
    best = found["sign corrected, best root"]
    assert best.iloc[0] > 1e-6  # cancels as 1e-16/g
    assert best[best.index > 1.0].max() < 1e-13  # the derivation, with the sign corrected
    assert found["jointclosure"].max() < 1e-14


def test_the_exact_deformation_solves_eq_10_to_50_digits():
    for overlap, gamma in ((1e-300, 0.0), (1e-6, 1e-9), (1e-6, 1e15), (1e3, 1e12)):
        with mpmath.workdps(80):
            x = mpmath.sqrt(printed.exact_deformation(overlap, gamma))
            left = mpmath.mpf(gamma) * x**3 + x**2
            assert abs(left / mpmath.mpf(overlap) - 1) < mpmath.mpf(10) ** -50


def test_the_far_field_as_printed_loses_every_digit_and_ours_none():
    found = errors(printed.far_field_errors(np.logspace(0, 9, 40)))
    as_printed = found["Eq. (17) as printed"]
    assert as_printed[as_printed.index < 2.0].max() < 1e-14
    assert as_printed[as_printed.index > 3e8].max() > 0.1
    assert found["jointclosure"].max() < 1e-13


@pytest.mark.parametrize("base", [1e-9, 0.2, 78e9])
def test_the_quartic_as_printed_loses_every_digit_and_ours_none(base):
    found = errors(printed.quartic_errors(np.logspace(-9, -0.5, 18), base))
    as_printed = found[f"Eq. (29) as printed, p = {base:g}"]
    assert as_printed.iloc[-1] < 1e-12
    assert as_printed.iloc[0] > 1.0
    assert found[f"jointclosure, p = {base:g}"].max() < 1e-13


def test_a_missing_root_is_none_in_all_forms():
    levels, flat = [1.0, 2.0, 3.0], [1.0, 1.0, 1.0]
    assert mpmath.isnan(printed.exact_length(levels, flat, flat, 20, 2.0))
    assert np.isnan(printed.length_as_printed(levels, flat, flat, 20, 2.0))
    assert printed.relative_error(np.nan, mpmath.mpf(1)) == np.inf

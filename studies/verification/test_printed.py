"""What the paper's printed formulas lose, and that ours do not."""

import mpmath
import numpy as np
import pandas as pd
import pytest

from studies.verification import printed
from studies.verification.printed import FORMULAS, formula_rows


def by_series(frame):
    return frame.pivot_table("error", "at", "series")


def test_the_cubic_as_printed_is_never_right_and_its_best_root_loses_what_ours_keeps():
    found = by_series(printed.cubic_errors(np.logspace(-12, 12, 25)))
    assert found["Eq. (13) as printed"].min() > 0.1
    assert found["sign corrected, principal root"].min() > 0.1
    best = found["sign corrected, best root"]
    assert best.iloc[0] > 1e-6  # cancels as 1e-16/g
    assert best[best.index > 1.0].max() < 1e-13  # the derivation, with the sign corrected
    assert found["jointclosure"].max() < 1e-14


def test_the_far_field_as_printed_loses_every_digit_and_ours_none():
    found = by_series(printed.far_field_errors(np.logspace(0, 9, 40)))
    as_printed = found["Eq. (17) as printed"]
    assert as_printed[as_printed.index < 2.0].max() < 1e-14
    assert as_printed[as_printed.index > 3e8].max() > 0.1
    assert found["jointclosure"].max() < 1e-13


@pytest.mark.parametrize("base", [1e-9, 0.2, 78e9])
def test_the_quartic_as_printed_loses_every_digit_and_ours_none(base):
    found = by_series(printed.quartic_errors(np.logspace(-9, -0.5, 18), base))
    as_printed = found[f"Eq. (29) as printed, p = {base:g}"]
    assert as_printed.iloc[-1] < 1e-12
    assert as_printed.iloc[0] > 1.0
    assert found[f"jointclosure, p = {base:g}"].max() < 1e-13


LOADS = pd.DataFrame(
    {
        "joint": ["paper's grid"] * 2 + ["polished"],
        "spectral_radius": [0.9, 1.2, 3.0],
        "fast_residual": [1e-12, 2e-11, 3e-12],
    }
)


@pytest.fixture(scope="module")
def measured():
    return pd.concat(
        [
            printed.cubic_errors(np.logspace(-12, 12, 5)),
            printed.far_field_errors(np.logspace(0, 9, 5)),
            printed.quartic_errors(np.logspace(-9, -0.5, 4), 78e9),
        ]
    )


def test_every_formula_and_every_joint_is_a_row_that_holds(measured):
    rows = pd.DataFrame(formula_rows(measured, LOADS)).set_index("name")
    joints = ["interaction_paper_grid", "interaction_polished"]
    assert rows.index.tolist() == [*(name.replace(" ", "_") for name in FORMULAS), *joints]
    assert rows.holds.all()
    assert rows.loc["interaction_paper_grid", "largest_error"] == 2e-11
    assert "2 loads, on 1 of which" in rows.loc["interaction_paper_grid", "hard"]


def test_the_exact_deformation_solves_eq_10_to_50_digits():
    for overlap, gamma in ((1e-300, 0.0), (1e-6, 1e-9), (1e-6, 1e15), (1e3, 1e12)):
        with mpmath.workdps(80):
            x = mpmath.sqrt(printed.exact_deformation(overlap, gamma))
            left = mpmath.mpf(gamma) * x**3 + x**2
            assert abs(left / mpmath.mpf(overlap) - 1) < mpmath.mpf(10) ** -50

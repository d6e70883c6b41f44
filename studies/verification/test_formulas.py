"""Formulas as hard cases: rows that hold, and that fail where a number is wrong."""

import numpy as np
import pandas as pd
import pytest

from studies.verification import printed
from studies.verification.formulas import FORMULAS, formula_rows

LOADS = pd.DataFrame(
    {
        "joint": ["paper's grid"] * 2 + ["polished"],
        "spectral_radius": [0.9, 1.2, 3.0],
        "fast_residual": [1e-12, 2e-11, 3e-12],
    }
)


@pytest.fixture(scope="module")
def errors():
    return pd.concat(
        [
            printed.cubic_errors(np.logspace(-12, 12, 5)),
            printed.far_field_errors(np.logspace(0, 9, 5)),
            printed.quartic_errors(np.logspace(-9, -0.5, 4), 78e9),
        ]
    )


def test_every_formula_and_every_joint_is_a_row_that_holds(errors):
    rows = pd.DataFrame(formula_rows(errors, LOADS)).set_index("name")
    assert rows.index.tolist() == [
        *(name.replace(" ", "_") for name in FORMULAS),
        "interaction_paper_grid",
        "interaction_polished",
    ]
    assert rows.holds.all()
    assert rows.loc["interaction_paper_grid", "largest_error"] == 2e-11
    assert "2 loads, on 1 of which" in rows.loc["interaction_paper_grid", "hard"]


@pytest.mark.parametrize("subject", FORMULAS)
def test_a_formula_that_loses_digits_or_is_not_measured_does_not_hold(errors, subject):
    ours = errors.series.str.startswith("jointclosure") & (errors.subject == subject)
    worse = errors.assign(error=errors.error.where(~ours, 1e-9))
    for spoilt in (worse, errors[~ours]):
        rows = pd.DataFrame(formula_rows(spoilt, LOADS)).set_index("name")
        assert rows.index[~rows.holds].tolist() == [subject.replace(" ", "_")]
        assert rows.loc[subject.replace(" ", "_"), "failed"]


def test_a_load_that_is_not_solved_does_not_hold(errors):
    rows = pd.DataFrame(formula_rows(errors, LOADS.assign(fast_residual=[1e-9, 0.0, np.nan])))
    assert rows.set_index("name").holds.tolist() == [True, True, True, False, False]

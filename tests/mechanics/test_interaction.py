"""Displacement of neighbours by a loaded asperity, to the last digits."""

import mpmath
import numpy as np
import pytest

from jointclosure.mechanics.interaction import far_field_factor, interaction_displacement


def exact_factor(ratio):
    """Eqs. (17) to (20) in 60 digits, over the displacement by a point force."""
    with mpmath.workdps(60):
        r = mpmath.mpf(ratio)
        bracket = (2 * r**2 - 1) * mpmath.asin(r) + r * mpmath.sqrt(1 - r**2)
        return 3 * bracket / (4 * r**3)


@pytest.mark.parametrize(
    "ratios",
    [
        pytest.param(1.0 / np.logspace(0, 9, 400), id="far"),
        pytest.param(np.linspace(0.89, 0.91, 401), id="switch"),
        pytest.param(0.9 + np.arange(-8, 9) * np.spacing(0.9), id="next to the switch"),
        pytest.param(1.0 - np.logspace(-16, -1, 400), id="rim"),
        pytest.param(np.array([5e-324, 1e-300, 1e-160]), id="out of range"),
    ],
)
def test_factor_keeps_14_digits_from_the_rim_to_a_billion_radii(ratios):
    # next to the rim 1 - (r/zeta)^2 cost three digits; far away the series has one term
    for ratio in ratios:
        with mpmath.workdps(60):
            exact = exact_factor(ratio) if ratio > 1e-10 else mpmath.mpf(1)
            assert abs(mpmath.mpf(float(far_field_factor(ratio))) / exact - 1) < 1e-14, ratio


def test_displacement_is_continuous_with_the_substrate_at_the_rim():
    # at the rim a Hertz pressure moves the surface by 3 F / (8 E* r)
    at_rim = interaction_displacement(1.0, 1.0, 1.0)
    assert at_rim == pytest.approx(3.0 / 8.0, rel=1e-14)

"""One Hertz contact: its force and slope by the overlap, to the last digits."""

import math

import hypothesis.strategies as st
import mpmath
import numpy as np
import pytest
from hypothesis import given

from jointclosure.mechanics.contact import (
    asperity_compliance,
    cube_root,
    equivalent_modulus,
    force_of_overlap,
    overlap_of_force,
    plane_strain_modulus,
    substrate_compliance,
)

E_STAR = 40e9
magnitudes = st.floats(-12.0, 0.0).map(lambda power: 10.0**power)


def exact_force(overlap, substrate, asperity):
    """Force and slope in 50 digits: the root t of A t^3 + B t^2 = delta_S, from the right."""
    with mpmath.workdps(50):
        a, b, d = (mpmath.mpf(float(v)) for v in (substrate, asperity, overlap))
        t = min(mpmath.cbrt(d / a) if a else mpmath.inf, mpmath.sqrt(d / b) if b else mpmath.inf)
        while (a * t + b) * t * t / d - 1 > mpmath.mpf(10) ** -40:
            t -= ((a * t + b) * t * t - d) / ((3 * a * t + 2 * b) * t)
        return t**3, 3 * t / (3 * a * t + 2 * b)


@pytest.mark.parametrize("g", [0.0, *np.logspace(-18, 12, 31)])
def test_force_and_slope_keep_14_digits_at_any_stiffness_ratio(g):
    # g = A sqrt(delta_S)/B^(3/2) is all that the cubic's shape depends on; with
    # F = 1 N for g = 0 the force itself never leaves the range of doubles
    for overlap in np.logspace(-300, 3, 102):
        found = force_of_overlap(overlap, g * overlap, overlap)
        exact = exact_force(overlap, g * overlap, overlap)
        for value, wanted in zip(found, exact, strict=True):
            assert abs(mpmath.mpf(float(value)) / wanted - 1) < 1e-14


@pytest.mark.parametrize("overlap", [5e-324, 1e-300, 1e-250, 1e-205, 1e-200, 1e3])
@pytest.mark.parametrize("curvature", [0.0, 1e-20, 1.0, 1e12])
def test_a_force_below_the_range_of_doubles_is_only_rounded(overlap, curvature):
    law = substrate_compliance(0.125e-3, E_STAR), asperity_compliance(curvature, E_STAR)
    force, slope = force_of_overlap(overlap, *law)
    exact, _ = exact_force(overlap, *law)
    assert abs(force - exact) <= 1e-14 * exact + mpmath.mpf(5e-324)
    assert 0.0 < slope < np.inf


@given(
    curvature=st.floats(-20.0, 12.0).map(lambda p: 10.0**p),
    modulus=st.floats(6.0, 12.0).map(lambda p: 10.0**p),
)
def test_compliances_keep_15_digits(curvature, modulus):
    with mpmath.workdps(50):
        kappa, e, r = (mpmath.mpf(v) for v in (curvature, modulus, 0.125e-3))
        exact = mpmath.cbrt(9 * kappa / (16 * e**2))
        assert abs(asperity_compliance(curvature, modulus) / exact - 1) < 1e-15
        assert abs(substrate_compliance(0.125e-3, modulus) / (3 / (4 * r * e)) - 1) < 1e-15


@given(overlap=magnitudes, curvature=st.floats(1.0, 1e5))
def test_overlap_of_force_inverts_force_of_overlap(overlap, curvature):
    law = substrate_compliance(0.1e-3, E_STAR), asperity_compliance(curvature, E_STAR)
    force, _ = force_of_overlap(overlap, *law)
    assert overlap_of_force(force, *law) == pytest.approx(overlap, rel=1e-13)


@pytest.mark.parametrize("overlap", [0.0, -0.0, -1e-6, float("nan")])
def test_walls_apart_carry_nothing(overlap):
    assert force_of_overlap(overlap, 1e-9, 1e-9) == (0.0, 0.0)


def test_moduli_of_equal_walls_halve():
    modulus = plane_strain_modulus(78e9, 0.2)
    assert modulus == pytest.approx(81.25e9)
    assert equivalent_modulus(modulus, modulus) == pytest.approx(modulus / 2)


@given(st.floats(1e-200, 1e200), st.integers(-100, 100))
def test_cube_roots_scale_exactly_by_powers_of_eight(x, power):
    assert cube_root(x * 8.0**power) == cube_root(x) * 2.0**power


@pytest.mark.parametrize("x", [0.0, math.inf])
def test_the_cube_root_of_a_number_without_a_mantissa_is_this_number(x):
    assert cube_root(x) == x


@pytest.mark.parametrize("x", [5e-324, 3.7e-320, 2.2250738585072009e-308])
def test_cube_roots_of_subnormal_numbers_keep_15_digits(x):
    assert cube_root(x) == pytest.approx(float(mpmath.cbrt(x)), rel=1e-15, abs=0.0)


def test_the_cube_root_of_no_number_is_none():
    assert math.isnan(cube_root(math.nan))


@given(st.floats(1e-200, 1e200))
def test_cube_roots_keep_15_digits(x):
    assert cube_root(x) == pytest.approx(float(mpmath.cbrt(x)), rel=1e-15, abs=0.0)

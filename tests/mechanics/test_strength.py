"""Strength of one pair: the yield of a Hertz contact, and its bound."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given
from scipy.optimize import minimize_scalar

from jointclosure.mechanics.contact import asperity_compliance, overlap_of_force
from jointclosure.mechanics.strength import (
    critical_indentation,
    is_overstressed,
    strength_factor,
    von_mises_on_axis,
)


@given(st.floats(0.0, 0.5))
def test_eq_23_is_the_maximum_of_eq_21_within_1_5e_4(ratio):
    found = minimize_scalar(
        lambda z: -von_mises_on_axis(z, ratio), bounds=(0.2, 0.8), method="bounded"
    )
    assert strength_factor(ratio) == pytest.approx(-found.fun, abs=1.5e-4)


@given(
    deformation=st.floats(1e-9, 1e-4),
    curvature=st.floats(1.0, 1e5),
    modulus=st.floats(1e9, 1e11),
    substrate=st.sampled_from([0.0, 1e-10, 1e-8]),
    base=st.sampled_from([0.0, 1e-5, 1e-3]),
)
def test_overstress_by_overlap_agrees_with_eq_22(deformation, curvature, modulus, substrate, base):
    """With a bound also with the mean pressure over a base of this radius [m], 0 for none."""
    limit = 2e8
    critical = critical_indentation(limit, modulus)
    force = 4.0 / 3.0 * modulus * np.sqrt(deformation**3 / curvature)
    overlap = overlap_of_force(force, substrate, asperity_compliance(curvature, modulus))
    pressure = 2.0 / np.pi * modulus * np.sqrt(deformation * curvature)  # Eq. (22)
    mean = force / (np.pi * base**2) if base else 0.0
    assume(min(abs(pressure / limit - 1.0), abs(1.5 * mean / limit - 1.0)) > 1e-9)
    filling = np.sqrt(critical) / base if base else 0.0
    breaking_force = 4.0 / 3.0 * modulus * critical * np.sqrt(critical)
    broken = is_overstressed(overlap, curvature, critical, breaking_force, substrate, filling)
    assert broken == (pressure > limit or mean > 2.0 / 3.0 * limit)


def test_a_flat_contact_breaks_only_where_strength_is_bounded():
    assert not is_overstressed(1.0, 0.0, 1e-12, 1e-3, 1e-9, 0.0)
    assert is_overstressed(1.0, 0.0, 1e-12, 1e-3, 1e-9, 1.0)


def test_the_largest_stress_moves_from_a_depth_of_0_38_to_0_55_radii():
    depths = np.linspace(0.0, 1.0, 10001)
    for ratio, where in ((0.0, 0.382), (0.5, 0.548)):
        stresses = [von_mises_on_axis(z, ratio) for z in depths]
        assert depths[np.argmax(stresses)] == pytest.approx(where, abs=1e-3)

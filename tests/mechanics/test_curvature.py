"""Curvature of an asperity: Menger's, of both profiles."""

import hypothesis.strategies as st
import mpmath
import numpy as np
import pytest
from hypothesis import given

from jointclosure.mechanics.curvature import gaussian_curvature

heights = st.floats(-1e-3, 1e-3)


def profile_curvature(before, here, after, spacing):
    """That of a cell with this profile both ways."""
    return gaussian_curvature(before, after, before, after, here, 1.0, spacing)


cells = st.lists(heights, min_size=5, max_size=5)


@given(cells)
def test_gaussian_curvature_is_the_geometric_mean_of_both_profiles(z):
    west, east, south, north, here = z
    h = 0.25e-3
    product = profile_curvature(west, here, east, h) * profile_curvature(south, here, north, h)
    found = gaussian_curvature(*z, 1.0, h)
    assert found == pytest.approx(np.sqrt(product), rel=1e-12, abs=1e-9)


@given(cells)
def test_a_valley_has_the_curvature_of_the_mirrored_peak(z):
    h = 0.25e-3
    assert gaussian_curvature(*z, 1.0, h) == gaussian_curvature(*[-v for v in z], 1.0, h)


@given(cells)
def test_only_caps_have_curvature_if_valleys_are_flat(z):
    west, east, south, north, here = z
    h = 0.25e-3
    cap = (west - here) + (east - here) < 0.0 and (south - here) + (north - here) < 0.0
    assert gaussian_curvature(*z, 0.0, h) == (gaussian_curvature(*z, 1.0, h) if cap else 0.0)


def exact_profile(before, here, after, spacing):
    """Menger's curvature in 50 digits, and its change by half an ulp in every difference."""
    with mpmath.workdps(50):
        z1, z2, z3, h = (mpmath.mpf(float(v)) for v in (before, here, after, spacing))
        sides = (
            mpmath.sqrt(h**2 + (z2 - z1) ** 2)
            * mpmath.sqrt(h**2 + (z3 - z2) ** 2)
            * mpmath.sqrt(4 * h**2 + (z3 - z1) ** 2)
        )
        per_difference = 2 * h / sides
        rounding = mpmath.mpf(np.finfo(float).eps) / 2 * (abs(z1 - z2) + abs(z3 - z2))
        return abs(z1 - 2 * z2 + z3) * per_difference, rounding * per_difference


@given(
    slope=st.floats(-2.0, 2.0),
    sag=st.floats(-20.0, 0.0).map(lambda p: 10.0**p),
    offset=st.sampled_from([0.0, 1e-12, 1e-3, 10.0]),
    spacing=st.sampled_from([1e-6, 0.25e-3, 10.0]),
)
def test_nearly_collinear_points_keep_every_digit_that_their_differences_have(
    slope, sag, offset, spacing
):
    z = offset + spacing * np.array([-slope, sag, slope])
    exact, rounding = exact_profile(*z, spacing)
    found = profile_curvature(*z, spacing)
    with mpmath.workdps(50):
        assert abs(found - exact) <= 1e-14 * exact + rounding

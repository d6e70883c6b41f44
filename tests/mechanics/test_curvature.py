import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from jointclosure.mechanics.curvature import gaussian_curvature, profile_curvature

heights = st.floats(-1e-3, 1e-3)


@given(radius=st.floats(1e-3, 10.0), start=st.floats(-0.5, 0.5))
def test_points_on_a_circle_have_its_curvature(radius, start):
    h = 1e-2 * radius
    x = start * radius + np.array([-h, 0.0, h])
    z = np.sqrt(radius**2 - x**2)
    assert profile_curvature(*z, h) == pytest.approx(1.0 / radius, rel=1e-9)


@given(here=heights, slope=st.floats(-2.0, 2.0))
def test_collinear_points_have_no_curvature(here, slope):
    h = 0.25e-3
    curvature = profile_curvature(here - slope * h, here, here + slope * h, h)
    assert curvature * h < 1e-9


@given(st.lists(heights, min_size=5, max_size=5))
def test_gaussian_curvature_is_the_geometric_mean_of_the_profiles(z):
    west, east, south, north, here = z
    h = 0.25e-3
    product = profile_curvature(west, here, east, h) * profile_curvature(south, here, north, h)
    assert gaussian_curvature(west, east, south, north, here, h) == pytest.approx(
        np.sqrt(product), rel=1e-12, abs=1e-9
    )


@given(st.lists(heights, min_size=5, max_size=5))
def test_a_valley_counts_as_the_peak_that_mirrors_it(z):
    h = 0.25e-3
    assert gaussian_curvature(*z, h) == gaussian_curvature(*[-v for v in z], h)


@given(st.lists(heights, min_size=5, max_size=5))
def test_curvature_scales_exactly_with_powers_of_64(z):
    h = 0.25e-3
    assert gaussian_curvature(*[64.0 * v for v in z], 64.0 * h) == (
        gaussian_curvature(*z, h) / 64.0
    )


def test_a_ridge_has_no_gaussian_curvature():
    assert gaussian_curvature(0.0, 0.0, -1e-4, -1e-4, 0.0, 0.25e-3) == 0.0

import hypothesis.strategies as st
import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from scipy.optimize import minimize_scalar

from jointclosure.mechanics.contact import (
    asperity_compliance,
    cube_root,
    equivalent_modulus,
    force_of_overlap,
    overlap_of_force,
    plane_strain_modulus,
    substrate_compliance,
)
from jointclosure.mechanics.curvature import gaussian_curvature
from jointclosure.mechanics.gouge import drops, passed_share, shed, upper_share
from jointclosure.mechanics.interaction import far_field_factor, interaction_displacement
from jointclosure.mechanics.strength import (
    critical_indentation,
    is_overstressed,
    strength_factor,
    von_mises_on_axis,
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
def test_force_and_slope_keep_14_digits_at_any_stiffness_ratio_and_overlap(g):
    # g = A sqrt(delta_S)/B^(3/2) is all that the cubic's shape depends on; with
    # F = 1 N for g = 0 the force itself never leaves the range of doubles
    for overlap in np.logspace(-300, 3, 102):
        substrate, asperity = g * overlap, overlap
        found = force_of_overlap(overlap, substrate, asperity)
        exact = exact_force(overlap, substrate, asperity)
        for value, wanted in zip(found, exact, strict=True):
            assert abs(mpmath.mpf(float(value)) / wanted - 1) < 1e-14


@pytest.mark.parametrize("overlap", [5e-324, 1e-300, 1e-250, 1e-205, 1e-200, 1e3])
@pytest.mark.parametrize("curvature", [0.0, 1e-20, 1.0, 1e12])
def test_a_force_below_the_range_of_doubles_is_rounded_and_not_lost(overlap, curvature):
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
    assert cube_root(x) == pytest.approx(float(mpmath.cbrt(x)), rel=1e-15, abs=0.0)


heights = st.floats(-1e-3, 1e-3)


def profile_curvature(before, here, after, spacing):
    """That of a cell with this profile both ways."""
    return gaussian_curvature(before, after, before, after, here, 1.0, spacing)


@given(st.lists(heights, min_size=5, max_size=5))
def test_gaussian_curvature_is_the_mean_of_the_profiles_and_of_caps_alone_if_valleys_are_flat(z):
    west, east, south, north, here = z
    h = 0.25e-3
    product = profile_curvature(west, here, east, h) * profile_curvature(south, here, north, h)
    found = gaussian_curvature(*z, 1.0, h)
    assert found == pytest.approx(np.sqrt(product), rel=1e-12, abs=1e-9)
    assert found == gaussian_curvature(*[-v for v in z], 1.0, h)
    cap = (west - here) + (east - here) < 0.0 and (south - here) + (north - here) < 0.0
    assert gaussian_curvature(*z, 0.0, h) == (found if cap else 0.0)


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


neighbours = st.lists(st.floats(-1e-4, 1e-4), min_size=8, max_size=8).map(np.array)


@given(neighbours, st.floats(-1e-4, 1e-4), st.floats(1e-9, 1e-4))
def test_gouge_is_conserved_laid_by_the_drop_and_lifts_none_above_the_lowered_cell(
    around, height, loss
):
    before, falls = around.copy(), np.empty(8)
    total, least = drops(height, around, 1e-12, falls)
    if total == 0.0:
        assert np.all(height - around <= 1e-12)
        return
    lost = shed(around, loss, falls, total, least)
    gained = around - before
    assert 0.0 < lost <= loss
    assert gained.sum() == pytest.approx(lost, rel=1e-12)
    drop = np.where(height - before > 1e-12, height - before, 0.0)
    np.testing.assert_allclose(gained, lost * drop / total, atol=1e-18)
    highest = around[drop > 0.0].max()
    assert highest <= height - lost + 1e-18
    assert lost == loss or highest == pytest.approx(height - lost, abs=1e-18)  # cut short, level


def test_nothing_flows_out_of_the_grid():
    around, falls = np.full(8, np.inf), np.empty(8)
    assert drops(0.0, around, 1e-12, falls) == (0.0, np.inf)


def test_the_sharper_asperity_loses_more_and_one_without_lower_neighbours_passes_its_share_on():
    assert upper_share(3.0, 1.0) == 0.75
    assert upper_share(0.0, 0.0) == 0.5
    assert passed_share(0.3, 0.0, 1.0) == 0.0
    assert passed_share(0.3, 1.0, 0.0) == 1.0
    assert passed_share(0.3, 1.0, 1.0) == 0.3


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
    """And, with a bound, with the mean pressure over a base of this radius [m], 0 for none."""
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


def test_displacement_is_continuous_with_the_substrate_at_the_rim():
    # at the rim a Hertz pressure moves the surface by 3 F / (8 E* r)
    at_rim = interaction_displacement(1.0, 1.0, 1.0)
    assert at_rim == pytest.approx(3.0 / 8.0, rel=1e-14)


def test_the_maximum_moves_from_0_38_to_0_55():
    depths = np.linspace(0.0, 1.0, 10001)
    for ratio, where in ((0.0, 0.382), (0.5, 0.548)):
        stresses = [von_mises_on_axis(z, ratio) for z in depths]
        assert depths[np.argmax(stresses)] == pytest.approx(where, abs=1e-3)


def test_neighbours_lower_by_no_more_than_the_tie_receive_nothing_and_flat_walls_share_alike():
    falls = np.empty(8)
    for drop, lower in ((0.9e-12, False), (1.1e-12, True)):
        total, _ = drops(0.0, np.full(8, -drop), 1e-12, falls)
        assert bool(total > 0.0) == lower
    assert upper_share(0.0, 0.0) == 0.5
    assert [upper_share(0.0, 2.0), upper_share(3.0, 1.0)] == [0.0, 0.75]
    assert [passed_share(0.3, *totals) for totals in ((0.0, 1.0), (1.0, 0.0), (1.0, 1.0))] == [
        0.0, 1.0, 0.3
    ]  # fmt: skip

"""Synthetic walls have the roughness, the spectrum and the mates that they are made with."""

from types import SimpleNamespace

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls.jrc import RELATIONS, jrc_of_z2, rms_slope, z2_of_jrc
from jointclosure.walls.planes import detrended
from jointclosure.walls.synthesis import Spectrum, gaussian_field, power
from tests.joints import SPACING

SHAPES = pytest.mark.parametrize("shape", [(40, 40), (17, 33), (1, 50), (50, 1)])


@SHAPES
def test_every_wall_has_exactly_the_slope_of_its_jrc(shape):
    for wall in jc.wall_pair(8.0, shape, SPACING, seed=1):
        assert wall.shape == shape
        assert rms_slope(wall, SPACING) == pytest.approx((8.0 + 4.51) / 60.32, rel=1e-12)


@SHAPES
def test_no_wall_has_a_plane(shape):
    for wall in jc.wall_pair(8.0, shape, SPACING, seed=1):
        np.testing.assert_allclose(wall, detrended(wall), atol=1e-15)


def test_walls_are_independent_unless_a_correlation_is_given():
    def correlation(**settings):
        values = []
        for seed in range(60):
            upper, lower = jc.wall_pair(8.0, (24, 24), SPACING, seed=seed, **settings)
            values.append(np.corrcoef(upper.ravel(), lower.ravel())[0, 1])
        return np.mean(values)

    assert abs(correlation()) < 0.15
    assert correlation(correlation=1.0) == pytest.approx(-1.0)
    assert correlation(correlation=0.8) == pytest.approx(-0.8, abs=0.1)


@pytest.mark.parametrize("mated", [{"correlation": 1.0}, {"mismatch_wavelength": 4 * SPACING}])
def test_a_shift_moves_what_mates(mated):
    def likeness(upper, lower):
        return np.corrcoef(upper.ravel(), -lower.ravel())[0, 1]

    options = mated | {"roll_off": None}
    still, moved = (
        jc.wall_pair(8.0, (64, 64), SPACING, 3, shift_in_cells=shift, **options) for shift in (0, 5)
    )
    assert likeness(*still) > 0.95
    assert likeness(moved[0][:, :-5], moved[1][:, 5:]) > 0.95
    assert np.std(np.add(*moved)) > max(1.5 * np.std(np.add(*still)), 0.1 * np.std(moved[0]))


def waves(spectrum, shape=(32, 48)):
    """Fourier coefficients of a periodic field, and the wavelengths [cells]."""
    field = gaussian_field(shape, spectrum, np.random.default_rng(5), oversize=1)
    frequencies = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1]))
    with np.errstate(divide="ignore"):
        return np.fft.rfft2(field), 1.0 / frequencies


RULES = pytest.mark.parametrize("rule", ["self_affine", "walk"])


@RULES
def test_the_power_is_flat_beyond_the_roll_off(rule):
    plain, length = waves(Spectrum(0.7, rule))
    rolled, _ = waves(Spectrum(0.7, rule, roll_off=8.0))
    noise, _ = waves(Spectrum(-1.0))  # k^0: all waves alike
    gain = np.abs(rolled / np.where(noise == 0.0, 1.0, noise))
    beyond = (length > 8.1) & np.isfinite(length)
    np.testing.assert_allclose(gain[beyond], 8.0 ** (1.7 if rule == "self_affine" else 1.0), 2e-2)
    assert np.all(np.abs(rolled[beyond]) < np.abs(plain[beyond]))
    assert rolled[0, 0] == pytest.approx(0.0, abs=1e-9)


@RULES
def test_the_power_is_unchanged_below_the_roll_off(rule):
    plain, length = waves(Spectrum(0.7, rule))
    rolled, _ = waves(Spectrum(0.7, rule, roll_off=8.0))
    below = length < 6.0
    np.testing.assert_allclose(rolled[below], plain[below], 1e-9)


def test_a_walk_has_the_law_of_independent_slopes_projected_on_the_nearest_heights():
    shape = (4, 6)
    cells = np.arange(24).reshape(shape)
    # the difference to the next cell along each axis, periodic
    steps = np.concatenate(
        [np.eye(24)[np.roll(cells, -1, axis).ravel()] - np.eye(24) for axis in (0, 1)]
    )
    nearest = np.linalg.pinv(steps)  # heights from all slopes, by least squares
    # of noise that is 1 in one cell, a field is a column of its filter
    noises = np.eye(24).reshape(24, *shape)
    generators = [SimpleNamespace(standard_normal=lambda _, noise=noise: noise) for noise in noises]
    fields = [gaussian_field(shape, Spectrum(0.8, "walk"), one, 1) for one in generators]
    filtered = np.reshape(fields, (24, 24))
    found, expected = filtered.T @ filtered, nearest @ nearest.T
    np.testing.assert_allclose(found / found[0, 0], expected / expected[0, 0], atol=1e-12)


@pytest.mark.parametrize("relation", RELATIONS)
def test_relations_invert(relation):
    for jrc in (0.5, 8.0, 20.0):
        z2 = z2_of_jrc(jrc, 0.4e-3, 0.7, relation)
        assert jrc_of_z2(z2, 0.4e-3, 0.7, relation) == pytest.approx(jrc, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"jrc": 21.0}, "jrc = 21.0"),
        ({"correlation": 2.0}, "correlation = 2.0"),
        ({"shift_in_cells": -1}, "shift_in_cells = -1"),
        ({"roll_off": 0.03}, "roll_off = 0.03 m: must be at most the longer side of the walls"),
        ({"roll_off": 3}, r"roll_off = 3 m: not usual .* is 3 mm meant, 0.003 m\?"),
        ({"roll_off": 4e-4}, "roll_off = 0.0004 m with spacing = 0.00025 m: must be at least two"),
        ({"spacing": 0.25}, r"spacing = 0.25 m: not usual .* is 0.25 mm meant, 0.00025 m\?"),
        ({"mismatch_wavelength": -1e-3}, "mismatch_wavelength = -0.001 m: must be finite, 0"),
        ({"mismatch_wavelength": 1e-3, "correlation": 0.5}, "correlation = 0.5: must be 0"),
    ],
)
def test_bad_input_is_refused_by_name(change, named):
    good = {"jrc": 8.0, "shape": (9, 9), "spacing": SPACING, "seed": 1}
    with pytest.raises(jc.InputError, match=named):
        jc.wall_pair(**(good | change))


def test_the_default_roll_off_is_allowed_on_every_grid():
    coarse = {"jrc": 8.0, "shape": (9, 9), "spacing": 2e-3, "seed": 1}
    for wall, stated in zip(
        jc.wall_pair(**coarse), jc.wall_pair(**coarse, roll_off=4e-3), strict=True
    ):
        np.testing.assert_array_equal(wall, stated)


@pytest.mark.parametrize("wavelength", [0.0, 1e-3, 4e-3])
def test_each_wall_keeps_its_spectrum_whatever_the_mismatch(wavelength):
    def powers(**mismatch):
        """Power over wave number, of walls along an axis, in units of independent walls'."""
        found = np.zeros((2, 4))
        for seed in range(40):
            pair = jc.wall_pair(8.0, (48, 48), SPACING, seed, **mismatch)
            for side, wall in enumerate(pair):
                waves = np.abs(np.fft.rfft2(wall * np.outer(np.hanning(48), np.hanning(48)))) ** 2
                found[side] += [waves[1, 1], waves[3, 4], waves[6, 8], waves[12, 16]]
        return found

    ratio = powers(mismatch_wavelength=wavelength) / powers()
    # the upper wall differs by its scale only, the lower one is another draw of the same spectrum
    np.testing.assert_allclose(ratio[0], 1.0, atol=0.03)
    np.testing.assert_allclose(ratio[1], 1.0, atol=0.65)


@pytest.mark.parametrize("wavelength", [None, 2e-3])
def test_walls_may_have_the_slope_of_their_jrc_in_the_mean_alone(wavelength):
    about = {"mismatch_wavelength": wavelength, "normalise": "expectation"}
    slopes = []
    for seed in range(30):
        pair = jc.wall_pair(8.0, (32, 32), SPACING, seed, **about)
        slopes.append(np.mean([rms_slope(wall, SPACING) ** 2 for wall in pair]))
    assert np.std(slopes) > 0.01 * np.mean(slopes)  # and not in every pair
    expected = z2_of_jrc(8.0, SPACING, 0.8)
    assert np.sqrt(np.mean(slopes)) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("exponent", [-0.9, -0.65, -2.0, 0.3])
def test_a_power_is_numpys_to_its_last_digits(exponent):
    base = np.logspace(-12, 12, 20_001)
    np.testing.assert_allclose(power(base, exponent), base**exponent, rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "taken", "refused"),
    [
        ("hurst", (1e-3, 1.0), (0.0, 1.001, np.nan)),
        ("shape", ((1, 3), (3, 1), (3, 3)), ((2, 2), (0, 9), (9,), (9.0, 9.0))),
        ("seed", (0, 2**100), (-1, 0.5)),
        ("correlation", (0.0, 1.0), (-1e-9, 1.001)),
        ("mismatch_wavelength", (0.0, 1e-3, None), (-1e-3, np.inf, np.nan)),
        ("roll_off", (2.0 * SPACING, 3e-3, None), (1.99 * SPACING, np.inf)),
        ("jrc", (0.0, 20.0), (-0.01, 20.01)),
        ("shift_in_cells", (0, 3), (-1, 0.5)),
    ],
)
def test_arguments_of_walls_are_taken_no_further_than_their_limits(name, taken, refused):
    usual = {"jrc": 8.0, "shape": (6, 9), "spacing": SPACING, "seed": 1, "unusual_values": True}
    for value in taken:
        for wall in jc.wall_pair(**usual | {name: value}):
            assert np.isfinite(wall).all()
    for value in refused:
        with pytest.raises(jc.InputError, match=name):
            jc.wall_pair(**usual | {name: value})

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.surface.mating import mating, mismatch_wavelength
from jointclosure.surface.roughness import (
    RELATIONS,
    detrended,
    jrc_of_z2,
    rms_slope,
    z2_of_jrc,
)
from jointclosure.surface.synthesis import power
from tests.conftest import SPACING
from tests.same_bits import PROCESSORS, printed


@pytest.mark.parametrize("shape", [(40, 40), (17, 33), (1, 50), (50, 1)])
def test_every_wall_has_exactly_the_slope_of_its_jrc(shape):
    for wall in jc.wall_pair(8.0, shape, SPACING, seed=1):
        assert wall.shape == shape
        assert rms_slope(wall, SPACING) == pytest.approx((8.0 + 4.51) / 60.32, rel=1e-12)


def test_walls_are_detrended():
    for wall in jc.wall_pair(12.0, (30, 40), SPACING, seed=1):
        np.testing.assert_allclose(wall, detrended(wall), atol=1e-15)


def test_expectation_normalises_the_mean_and_not_each_wall():
    slopes = [
        rms_slope(jc.wall_pair(8.0, (32, 32), SPACING, seed=s, normalise="expectation")[0], SPACING)
        for s in range(100)
    ]
    assert np.std(slopes) > 0.0
    # detrending takes a little away
    mean = np.sqrt(np.mean(np.square(slopes)))
    assert mean == pytest.approx(z2_of_jrc(8.0, SPACING, 0.8), rel=0.03)


def test_a_seed_is_a_surface():
    one, same, other = (jc.wall_pair(8.0, (9, 9), SPACING, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one[0] - other[0]).max() > 0.0


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


def test_a_shift_moves_the_mated_part():
    upper, lower = jc.wall_pair(8.0, (20, 60), SPACING, 4, correlation=1.0, shift_in_cells=6)
    here = np.corrcoef(upper.ravel(), lower.ravel())[0, 1]
    shifted = np.corrcoef(upper[:, :-6].ravel(), lower[:, 6:].ravel())[0, 1]
    assert shifted < -0.85
    assert shifted < here - 0.1


@pytest.mark.parametrize("hurst", [0.6, 0.8])
def test_the_slope_scales_with_the_hurst_exponent(hurst):
    slopes = {1: [], 4: []}
    for seed in range(30):
        wall = jc.wall_pair(8.0, (128, 128), SPACING, seed=seed, hurst=hurst)[0]
        for step, values in slopes.items():
            values.append(rms_slope(wall[::step, ::step], step * SPACING) ** 2)
    found = 0.5 * np.log(np.mean(slopes[4]) / np.mean(slopes[1])) / np.log(4.0)
    assert found == pytest.approx(hurst - 1.0, abs=0.12)


@pytest.mark.parametrize("relation", RELATIONS)
def test_relations_invert(relation):
    for jrc in (0.5, 8.0, 20.0):
        z2 = z2_of_jrc(jrc, 0.4e-3, 0.7, relation)
        assert jrc_of_z2(z2, 0.4e-3, 0.7, relation) == pytest.approx(jrc, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"jrc": 21.0}, "jrc = 21.0"),
        ({"hurst": 0.0}, "hurst = 0.0"),
        ({"spacing": -1.0}, "spacing = -1.0"),
        ({"shape": (2, 2)}, "shape"),
        ({"correlation": 2.0}, "correlation = 2.0"),
        ({"shift_in_cells": -1}, "shift_in_cells = -1"),
        ({"jrc_relation": "none"}, "jrc_relation = 'none'"),
        ({"normalise": "no"}, "normalise = 'no'"),
    ],
)
def test_bad_input_is_refused_by_name(change, named):
    good = {"jrc": 8.0, "shape": (9, 9), "spacing": SPACING, "seed": 1}
    with pytest.raises(jc.InputError, match=named):
        jc.wall_pair(**(good | change))


def test_waves_longer_than_the_mismatch_wavelength_mate_and_shorter_ones_are_independent():
    wavelength = 16 * SPACING
    scores = []
    for seed in range(6):
        upper, lower = jc.wall_pair(8.0, (160, 160), SPACING, seed, mismatch_wavelength=wavelength)
        found = mating(upper, lower, SPACING)
        # a window blurs the edge by half an octave
        long = found.wavelengths > 1.5 * wavelength
        short = found.wavelengths < wavelength / 1.5
        assert found.correlation[long].min() > 0.9
        scores.append((found.correlation * np.sqrt(found.modes))[short])
        assert mismatch_wavelength(found) == pytest.approx(wavelength, rel=0.3)
    assert abs(np.mean(scores)) < 0.4
    assert np.std(scores) < 1.5


def test_walls_range_from_mates_to_independent_ones_with_the_mismatch_wavelength():
    def pair(wavelength):
        return jc.wall_pair(8.0, (48, 56), SPACING, 3, mismatch_wavelength=wavelength)

    upper, lower = pair(0.5 * SPACING)
    np.testing.assert_allclose(upper, -lower, atol=1e-18)
    apart = [np.std(np.add(*pair(cells * SPACING))) for cells in (2, 8, 32, 1000)]
    assert apart == sorted(apart)
    own, other = pair(1000 * SPACING)
    free = jc.wall_pair(8.0, (48, 56), SPACING, 3)
    for wall, independent in zip((own, other), free, strict=True):
        assert np.corrcoef(wall.ravel(), independent.ravel())[0, 1] == pytest.approx(1.0)


@pytest.mark.parametrize("normalise", ["wall", "expectation"])
def test_partly_mated_walls_have_the_slope_of_their_jrc(normalise):
    slopes = []
    for seed in range(30):
        pair = jc.wall_pair(
            8.0, (32, 32), SPACING, seed, mismatch_wavelength=2e-3, normalise=normalise
        )
        slopes.append(np.mean([rms_slope(wall, SPACING) ** 2 for wall in pair]))
    expected = z2_of_jrc(8.0, SPACING, 0.8)
    rel = 1e-12 if normalise == "wall" else 0.05
    assert np.sqrt(np.mean(slopes)) == pytest.approx(expected, rel=rel)


def test_a_shift_moves_what_mates():
    wavelength = 4 * SPACING
    still, moved = (
        jc.wall_pair(
            8.0, (64, 64), SPACING, 3, mismatch_wavelength=wavelength, shift_in_cells=shift
        )
        for shift in (0, 5)
    )
    assert np.corrcoef(still[0].ravel(), -still[1].ravel())[0, 1] > 0.95
    back = [wall[:, part] for wall, part in zip(moved, (np.s_[:-5], np.s_[5:]), strict=True)]
    assert np.corrcoef(back[0].ravel(), -back[1].ravel())[0, 1] > 0.95
    assert np.std(np.add(*moved)) > 1.5 * np.std(np.add(*still))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"mismatch_wavelength": 0.0}, "mismatch_wavelength = 0.0 m: must be positive"),
        ({"mismatch_wavelength": "a"}, "mismatch_wavelength"),
        ({"mismatch_wavelength": 1e-3, "correlation": 0.5}, "correlation = 0.5: must be 0"),
        ({"mismatch_wavelength": 1e-3, "normalise": "both"}, "normalise = 'both'"),
    ],
)
def test_a_wrong_mismatch_wavelength_is_named(given, said):
    with pytest.raises(jc.InputError) as error:
        jc.wall_pair(8.0, (32, 32), SPACING, 3, **given)
    assert said in str(error.value)


@pytest.mark.parametrize("exponent", [-0.9, -0.65, -2.0, 0.3])
def test_a_power_is_numpys_to_its_last_digits(exponent):
    base = np.logspace(-12, 12, 20_001)
    np.testing.assert_allclose(power(base, exponent), base**exponent, rtol=1e-14)


WALLS = """
import hashlib, jointclosure as jc
for normalise in ("wall", "expectation"):
    pair = jc.wall_pair(8.0, (40, 50), 0.25e-3, seed=3, normalise=normalise)
    print(*(hashlib.sha256(wall.tobytes()).hexdigest() for wall in pair))
"""


def test_a_seed_is_the_same_surface_on_any_processor():
    here = printed(WALLS)
    for name, environment in PROCESSORS.items():
        assert printed(WALLS, **environment) == here, name

import numpy as np
import pytest

import jointclosure as jc
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

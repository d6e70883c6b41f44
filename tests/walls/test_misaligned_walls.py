"""Walls out of alignment are the same walls, moved."""

import numpy as np
import pytest

from jointclosure.inputs import InputError
from jointclosure.walls.roughness import DEFAULT_RELATION, detrended, rms_slope, z2_of_jrc
from jointclosure.walls.synthesis import rotated_pair, spectrum_of, tilted, wall_pair

SPACING, SHAPE, ROLL_OFF = 0.25e-3, (40, 40), 3e-3
Z2 = z2_of_jrc(8.0, SPACING, 0.8, DEFAULT_RELATION)
SPECTRUM = spectrum_of(0.8, "self_affine", ROLL_OFF, SPACING)


def pair(seed, rotation=0.0, wavelength=1.03e-3):
    return rotated_pair(Z2, SHAPE, SPACING, SPECTRUM, seed, wavelength, rotation)


def test_walls_that_are_not_rotated_are_those_of_every_other_study():
    own = pair(3)
    stated = wall_pair(8.0, SHAPE, SPACING, 3, mismatch_wavelength=1.03e-3, roll_off=ROLL_OFF)
    for mine, other in zip(own, stated, strict=True):
        np.testing.assert_allclose(mine, other, atol=1e-11 * other.std())


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_puts_cells_on_cells(quarters):
    (_, before), (_, after) = pair(5), pair(5, 90.0 * quarters)
    turned = np.rot90(before, -quarters)  # rows are y, which points down in rot90's picture
    np.testing.assert_allclose(after / after.std(), turned / turned.std(), atol=1e-10)


def test_a_rotation_damps_no_wave():
    """Slopes and second differences stay; a cubic spline takes 5 and 10 % of them."""
    ratios = []
    for seed in range(24):
        upper, lower = pair(seed, 45.0, np.inf)
        bend = [np.mean(np.diff(wall, 2, axis=1) ** 2) for wall in (upper, lower)]
        ratios.append((rms_slope(lower, SPACING) / rms_slope(upper, SPACING), bend[1] / bend[0]))
    slope, bend = np.mean(ratios, axis=0)
    assert slope == pytest.approx(1.0, abs=0.02)
    assert np.sqrt(bend) == pytest.approx(1.0, abs=0.04)


def test_a_rotation_takes_walls_apart_the_further_it_goes():
    left = []
    for angle in (0.0, 2.0, 10.0, 45.0):
        both = [pair(seed, angle, 0.6e-3) for seed in range(6)]
        left.append(np.mean([np.std(upper + lower) for upper, lower in both]))
    assert left == sorted(left)
    assert left[-1] > 2.0 * left[0]


def test_a_tilt_is_a_plane_of_its_angle_about_the_middle():
    wall = detrended(np.random.default_rng(1).standard_normal((5, 8)))
    leaning = tilted(wall, SPACING, 0.5)
    np.testing.assert_allclose(np.diff(leaning - wall, axis=1), SPACING * np.tan(np.pi / 360.0))
    assert leaning.mean() == pytest.approx(wall.mean(), abs=1e-15)
    np.testing.assert_allclose(detrended(leaning), wall, atol=1e-12)


def test_a_wall_that_is_not_square_is_not_rotated():
    with pytest.raises(InputError, match=r"shape = \(40, 30\): a wall is rotated on a square"):
        rotated_pair(Z2, (40, 30), SPACING, SPECTRUM, 1)

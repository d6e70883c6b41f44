"""Errors of registered walls: displaced within the errors of the fit, and without noise."""

import numpy as np
import pytest
import scipy

import jointclosure as jc
from jointclosure.walls.gridding import Scan
from jointclosure.walls.registration import registered
from jointclosure.walls.roughness import detrended, rms_slope
from jointclosure.walls.scan_errors import ScanErrors, noise_of

SPACING = 0.25e-3
SHAPE = (96, 96)


def errors(noise=0.0, offset=(0.0, 0.0, 0.0), shape=SHAPE):
    middle = 0.5 * (np.array(shape[::-1]) - 1.0)
    holes = np.zeros(shape, bool)
    return ScanErrors(np.array(offset), np.zeros((3, 3)), middle, (noise, noise), holes)


@pytest.fixture(scope="module")
def walls():
    """Walls of which every second cell is scanned, so that shorter waves appear as longer ones."""
    fine = jc.wall_pair(
        8.0, (192, 192), SPACING / 2, 1, roll_off=None, mismatch_wavelength=1e-3,
        unusual_values=True,
    )  # fmt: skip
    return tuple(detrended(wall[::2, ::2]) for wall in fine)


def noisy(walls, noise):
    random = np.random.default_rng(0)
    return tuple(wall + noise * random.standard_normal(wall.shape) for wall in walls)


def test_walls_are_displaced_as_a_motion_moves_points():
    y, x = np.indices(SHAPE, float)

    def wave(x, y):
        return detrended(np.sin(0.13 * x + 0.05 * y) + np.cos(0.11 * y))

    turn, along_x, along_y = 0.01, 0.4, -0.2
    moved = errors(offset=(turn, along_x, along_y)).displaced(wave(x, y), 1)
    from_x, from_y = x - along_x - 47.5, y - along_y - 47.5  # turned back about the middle
    expected = wave(from_x + turn * from_y + 47.5, from_y - turn * from_x + 47.5)
    np.testing.assert_allclose(moved[4:-4, 4:-4], expected[4:-4, 4:-4], atol=5e-3)


@pytest.mark.parametrize("noise", [5e-6, 15e-6])
def test_other_noise_changes_walls_by_its_size_and_takes_at_most_its_own_power(walls, noise):
    known = float(np.sqrt(2.0) * noise)
    scanned = noisy(walls, noise)
    draws = [errors(known).with_other_noise(*scanned, n) for n in (1, 2)]
    for true, rough, *drawn in zip(walls, scanned, *draws, strict=True):
        for wall in drawn:
            slopes = [rms_slope(one, SPACING) for one in (true, wall, rough)]
            assert 0.98 * slopes[0] < slopes[1] < 1.02 * slopes[2]
            assert 0.5 * noise < np.std(wall - rough) < 1.2 * noise
    assert 0.7 * noise < np.std(draws[0][0] - draws[1][0]) < 1.7 * noise


def test_the_noise_may_be_all_that_keeps_mated_walls_apart():
    wall = jc.wall_pair(8.0, SHAPE, SPACING, 1, roll_off=None, unusual_values=True)[0]
    scanned = noisy((wall, -wall), 10e-6)
    low, high = noise_of(*scanned)
    assert low <= np.std(sum(scanned)) * 1.1
    assert high == pytest.approx(np.std(sum(scanned)), rel=0.1)
    apart = [np.std(sum(errors(high).with_other_noise(*scanned, n))) for n in range(1, 25)]
    assert min(apart) < 0.5 * high < 0.8 * high < max(apart)


def test_short_waves_that_interpolation_took_from_a_wall_are_restored(walls):
    scanned = scipy.ndimage.gaussian_filter(walls[0], 0.6, mode="mirror"), walls[1]
    drawn = errors(5e-6).with_other_noise(*scanned, 1)
    short = np.hypot(*np.ogrid[0.0:1.0:96j, 0.0:1.0:96j]) > 0.5
    lost, restored, true = (
        sum((scipy.fft.dctn(wall, norm="ortho")[short] ** 2).mean() for wall in pair)
        for pair in (scanned, drawn, walls)
    )
    assert lost < 0.7 * true
    assert restored == pytest.approx(true, rel=0.15)


def test_walls_without_noise_are_themselves(walls):
    for wall, drawn in zip(walls, errors().with_other_noise(*walls, 1), strict=True):
        np.testing.assert_allclose(drawn, wall, atol=1e-12)
    flat = np.zeros(SHAPE)
    upper, lower = errors(1e-5).with_other_noise(flat, walls[1], 1)
    assert not upper.any()
    assert 0.0 < np.std(lower - walls[1]) < 3e-5


@pytest.mark.parametrize("noise", [0.0, 5e-6, 15e-6])
def test_the_noise_is_found_beside_the_waves_that_are_shorter_than_the_grid(walls, noise):
    low, high = noise_of(*noisy(walls, noise))
    assert np.sqrt(2.0) * noise * 0.8 <= low <= high < np.sqrt(2.0) * noise + 12e-6


def test_errors_of_a_pair_are_those_of_its_fit():
    upper, lower = jc.wall_pair(8.0, SHAPE, SPACING, 1, roll_off=None, mismatch_wavelength=1e-3,
                                unusual_values=True)  # fmt: skip
    upper, lower = noisy((upper, lower), 3e-6)
    scans = [Scan(z, (SPACING, SPACING), (0.0, 0.0)) for z in (-upper + 2e-3, lower)]
    pair = registered(*scans)
    assert pair.errors.covariance[1, 1] == pytest.approx(pair.motion.covariance[1, 1] / SPACING**2)
    np.testing.assert_allclose(pair.errors.middle, 47.5, atol=0.5)
    nodes = pair.errors.offset  # the walls were laid on nodes, off the best fit
    np.testing.assert_allclose(nodes[1:], (pair.mated.place - pair.motion.place)[:2] / SPACING,
                               atol=1e-3)  # fmt: skip
    left = registered(*scans, shift="scanned")
    assert not left.errors.covariance.any()
    assert not left.errors.offset.any()

"""The mismatch wavelength of two walls is found with an interval that covers it."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls.mating import measured_mismatch
from tests.joints import SPACING

PAIRS = 20


def found_in(cells, shape=(80, 96), **how):
    """Estimates (pairs, wavelength and ends) [m] of pairs with a mismatch of so many cells."""
    wavelength = None if cells is None else cells * SPACING
    return np.array(
        [
            measured_mismatch(
                *jc.wall_pair(8.0, shape, SPACING, seed, mismatch_wavelength=wavelength, **how),
                SPACING,
            )
            for seed in range(PAIRS)
        ]
    )


@pytest.mark.parametrize(
    ("cells", "how"), [(5, {}), (9, {"hurst": 0.5}), (9, {"roll_off": 3e-3}), (16, {})]
)
def test_the_interval_of_a_mismatch_wavelength_covers_it(cells, how):
    wavelength, low, high = found_in(cells, **how).T / (cells * SPACING)
    assert np.median(wavelength) == pytest.approx(1.0, abs=0.08)
    assert np.mean((low <= 1.0) & (high >= 1.0)) >= 0.9
    # it says something: within a third of it, where walls are so many wavelengths long
    assert np.median(high / low) < 1.6


def test_it_is_where_the_correlation_is_a_half_though_long_waves_do_not_mate_fully():
    """Correlations of 0.65 beyond 14 cells, 0.39 from 6 to 14 cells, and 0 below."""
    wavelength, found = 14 * SPACING, []
    for seed in range(PAIRS):
        about = {"jrc": 8.0, "shape": (80, 96), "spacing": SPACING, "normalise": "expectation"}
        upper, far = jc.wall_pair(**about, seed=seed, mismatch_wavelength=wavelength)
        _, near = jc.wall_pair(**about, seed=seed, mismatch_wavelength=6 * SPACING)
        other, _ = jc.wall_pair(**about, seed=1000 + seed)
        lower = 0.7 * (0.6 * far + 0.4 * near + other)
        found.append(measured_mismatch(upper, lower, SPACING))
    value, low, high = np.array(found).T / wavelength
    assert np.median(value) == pytest.approx(1.0, abs=0.15)
    assert np.mean((low <= 1.0) & (high >= 1.0)) >= 0.8


def test_mates_have_none_and_independent_walls_may_have_an_infinite_one():
    assert np.all(found_in(0) == 0.0)
    wavelength, low, high = found_in(None).T
    # the few longest waves correlate by chance
    assert np.median(wavelength) == np.inf
    assert np.all(high == np.inf)
    assert np.all(low > 4 * SPACING)


def test_a_scale_of_heights_changes_no_mismatch_wavelength():
    upper, lower = jc.wall_pair(8.0, (48, 48), SPACING, 3, mismatch_wavelength=8 * SPACING)
    one, other = (measured_mismatch(k * upper, k * lower, SPACING) for k in (1.0, 64.0))
    assert one == other


def test_a_shift_of_mates_reads_as_a_mismatch_of_its_length():
    upper, lower = jc.wall_pair(
        8.0, (80, 96), SPACING, 3, mismatch_wavelength=0.0, shift_in_cells=2
    )
    found = measured_mismatch(upper, lower, SPACING)
    # waves shorter than about six shifts are out of step along x
    assert 4 * SPACING < found.wavelength < 24 * SPACING


def test_level_walls_tell_nothing():
    level = np.zeros((16, 16))
    assert measured_mismatch(level, level, SPACING).high == np.inf

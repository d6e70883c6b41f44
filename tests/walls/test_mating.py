"""Fit of two walls: by shift, by wavelength, and the wavelength beyond which they are mated."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls.mating import (
    Mismatch,
    mating,
    measured_mismatch,
    slope_correlations,
)
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


def test_mates_have_none_and_independent_walls_may_have_an_infinite_one():
    assert np.all(found_in(0) == 0.0)
    wavelength, low, high = found_in(None).T
    # the few longest waves correlate by chance
    assert np.median(wavelength) == np.inf
    assert np.all(high == np.inf)
    assert np.all(low > 4 * SPACING)


def test_mates_correlate_at_all_wavelengths_and_independent_walls_at_none():
    upper, lower = jc.wall_pair(9.0, (128, 128), SPACING, seed=4, correlation=1.0, roll_off=None)
    mates = mating(upper, lower, SPACING)
    np.testing.assert_allclose(mates.correlation, 1.0, atol=1e-12)
    assert measured_mismatch(upper, lower, SPACING) == Mismatch(0.0, 0.0, 0.0)
    scores = []
    for seed in range(20):
        found = mating(*jc.wall_pair(9.0, (128, 128), SPACING, seed, roll_off=None), SPACING)
        scores.append(found.correlation * np.sqrt(found.modes))
    # standard errors are as stated: the scores have a spread of one
    assert 0.8 < np.std(scores) < 1.25
    assert abs(np.mean(scores)) < 0.3


def test_a_band_of_half_an_octave_is_named_by_its_middle():
    n, wavelength = 128, 8 * SPACING
    x = np.arange(n) * SPACING
    rng = np.random.default_rng(1)
    noise = 1e-6 * rng.normal(size=(2, n, n))
    wave = 1e-4 * np.cos(2.0 * np.pi * x / wavelength)
    found = mating(noise[0] + wave, noise[1] - wave, SPACING)
    band = int(np.argmin(np.abs(np.log(found.wavelengths / wavelength))))
    assert found.correlation[band] > 0.99
    assert np.abs(np.delete(found.correlation, [band - 1, band, band + 1])).max() < 0.5


def test_correlations_over_shifts_are_those_of_the_definition():
    rng = np.random.default_rng(3)
    fixed, moved = rng.normal(size=(7, 8)), rng.normal(size=(6, 7))
    fixed[2, 3] = moved[4, 1] = np.nan
    found = slope_correlations(fixed, moved.shape, 0.5)(moved)
    slopes = [
        np.diff(field, axis=1)[:-1] + 1j * np.diff(field, axis=0)[:, :-1]
        for field in (fixed, moved)
    ]
    least = 0.5 * min(np.isfinite(field).sum() for field in slopes)
    one, other = slopes
    for down in range(-3, 4):
        for right in range(-3, 4):
            pairs = np.array([
                (one[y, x], other[y - down, x - right])
                for y in range(one.shape[0]) for x in range(one.shape[1])
                if 0 <= y - down < other.shape[0] and 0 <= x - right < other.shape[1]
            ])  # fmt: skip
            a, b = pairs[np.isfinite(pairs).all(axis=1)].T
            if len(a) >= least:
                expected = (a @ b.conj()).real / np.sqrt((a @ a.conj() * (b @ b.conj())).real)
                assert found[down, right] == pytest.approx(expected, abs=1e-12)
            else:
                assert np.isnan(found[down, right])


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

"""Mating of two walls: correlation by wavelength, and the mismatch wavelength."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.walls import mating as mating_module
from jointclosure.walls.mating import mating, measured_mismatch, slope_correlations
from tests.joints import SPACING


def test_the_interval_of_a_mismatch_wavelength_ends_where_the_likelihood_ratio_is_significant(
    monkeypatch,
):
    """Of a wavelength whose logarithm has a normal likelihood: 1.96 standard deviations off."""
    monkeypatch.setattr(mating_module, "_power_ratios", lambda *walls: ())
    monkeypatch.setattr(
        mating_module, "_profile_likelihood", lambda tried: -0.5 * (np.log(tried / 4e-3) / 0.2) ** 2
    )
    flat = np.zeros((4000, 4000))  # long beside the wavelength, which it resolves
    ends = np.sort(measured_mismatch(flat, flat, SPACING))
    np.testing.assert_allclose(np.log(ends / 4e-3), [-0.392, 0.0, 0.392], atol=0.02)


PAIRS = 10


def found_in(cells, **how):
    """Estimates (wavelength and ends, pairs) [m] of pairs with a mismatch of so many cells."""
    how["mismatch_wavelength"] = None if cells is None else cells * SPACING
    pairs = (jc.wall_pair(8.0, (80, 96), SPACING, seed, **how) for seed in range(PAIRS))
    return np.transpose([measured_mismatch(*pair, SPACING) for pair in pairs])


@pytest.mark.parametrize(
    ("cells", "how"), [(5, {}), (9, {"hurst": 0.5}), (9, {"roll_off": 3e-3}), (16, {})]
)
def test_the_interval_of_a_mismatch_wavelength_covers_it(cells, how):
    wavelength, low, high = found_in(cells, **how) / (cells * SPACING)
    assert np.median(wavelength) == pytest.approx(1.0, abs=0.08)
    assert np.mean((low <= 1.0) & (high >= 1.0)) >= 0.9
    # it says something: within a third of it, where walls are so many wavelengths long
    assert np.median(high / low) < 1.6


def test_mates_have_no_mismatch_wavelength():
    assert np.all(found_in(0) == 0.0)


def test_independent_walls_may_have_an_infinite_mismatch_wavelength():
    wavelength, low, high = found_in(None)
    # the few longest waves correlate by chance
    assert np.median(wavelength) == np.inf
    assert np.all(high == np.inf)
    assert np.all(low > 4 * SPACING)


def test_mates_correlate_at_all_wavelengths():
    upper, lower = jc.wall_pair(9.0, (64, 64), SPACING, seed=4, correlation=1.0, roll_off=None)
    mates = mating(upper, lower, SPACING)
    np.testing.assert_allclose(mates.correlation, 1.0, atol=1e-12)


def test_independent_walls_correlate_at_no_wavelength():
    scores = []
    for seed in range(20):
        found = mating(*jc.wall_pair(9.0, (64, 64), SPACING, seed, roll_off=None), SPACING)
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
                assert found[down, right] == pytest.approx(expected, abs=2e-6)  # single precision
            else:
                assert np.isnan(found[down, right])

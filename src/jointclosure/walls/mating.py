"""Mating of two walls: their correlation by wavelength and by shift, and the mismatch wavelength.

The mismatch wavelength is that at which walls correlate by 1/2: longer waves mate, shorter ones do
not. In the model of Brown (1995) the correlation changes abruptly there, in that of Glover et al.
(1998) gradually.
"""

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.walls.planes import detrended

_WAVES_FOR_ONE = 4.5
"""Fourier coefficients that count as one independent wave: each has a mirror image (2), and the
Hann window correlates neighbours (1.5 along each axis): 2 * 1.5^2."""
_RESOLUTION = 0.75
"""Error of a mismatch wavelength by the finite length of walls, in wave numbers of this length;
chosen: with it 99 % of the intervals of 24 pairs contained the true value."""
_STEEPNESS = np.geomspace(1.0, 64.0, 25)
"""Values tried for the steepness with which the correlation falls with the logarithm of wave
number."""
_FLOORS = np.array([3e-4, 1e-3, 4e-3, 1.6e-2, 6e-2, 0.2])
"""Values tried for the share of a wall's power that never correlates (noise, leakage)."""
_TRIED = 600  # number of mismatch wavelengths at which the likelihood is computed


class Mating(NamedTuple):
    """Correlation of two walls by wavelength, in bands of half an octave; arrays (bands,).

    The standard error of a correlation c is (1 - c^2) / sqrt(modes).
    """

    wavelengths: np.ndarray  # middles of the bands [m], the longest first
    correlation: np.ndarray  # of the walls in each band; 1 where they are mated
    modes: np.ndarray  # number of independent waves in each band


class Mismatch(NamedTuple):
    """Mismatch wavelength [m] of two walls, at which they correlate by 1/2, and its limits.

    ``low`` and ``high`` limit its 95 % interval. It is 0 if the walls are mated at all wavelengths
    of the grid, and infinite if they are mated at none.
    """

    wavelength: float
    low: float
    high: float


def mating(upper: np.ndarray, lower: np.ndarray, spacing: float) -> Mating:
    """Return the correlation of walls (y, x) [m] by wavelength; it is 1 where they are mated.

    Heights count towards the other wall. With the Fourier coefficients U and L of both walls, each
    less its plane and in a Hann window, the correlation of a band is -Re(sum U L*) / sqrt(sum |U|^2
    sum |L|^2), summed over the waves of the band. Bands of fewer than four independent waves are
    left out.
    """
    one = _windowed_waves(upper)
    other = _windowed_waves(lower)
    wave = _wave_numbers(upper.shape, spacing)
    longest = 0.5 * min(upper.shape) * spacing
    # number of the half octave below the longest wave
    bands = np.floor(2.0 * np.log2(np.maximum(wave, 1e-300) * longest) + 0.5).astype(int)
    kept = (bands >= 0) & (wave <= 0.5 / spacing)
    count = bands[kept].max() + 1
    products = -(one * other.conj()).real, np.abs(one) ** 2, np.abs(other) ** 2
    cross, power, other_power, waves = (
        np.bincount(bands[kept], values[kept], minlength=count)
        for values in (*products, np.ones_like(wave))
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = np.clip(cross / np.sqrt(power * other_power), -1.0, 1.0)  # but for rounding
    modes = waves / _WAVES_FOR_ONE
    enough = modes >= 4.0
    middles = longest * 2.0 ** (-0.5 * np.arange(count))
    return Mating(middles[enough], correlation[enough], modes[enough])


def _windowed_waves(wall: np.ndarray) -> Any:
    """Return the Fourier coefficients (y, x) of a wall (y, x) less its plane, in a Hann window."""
    ny, nx = wall.shape
    window = np.outer(np.hanning(ny + 2)[1:-1], np.hanning(nx + 2)[1:-1])
    return scipy.fft.fft2(window * detrended(wall))


def _wave_numbers(shape: tuple[int, ...], spacing: float) -> np.ndarray:
    """Return the wave number [1/m] of each coefficient (y, x) of `_windowed_waves`."""
    wave_y, wave_x = (scipy.fft.fftfreq(n, spacing) for n in shape)
    return np.hypot(wave_y[:, None], wave_x[None, :])


def measured_mismatch(upper: np.ndarray, lower: np.ndarray, spacing: float) -> Mismatch:
    """Estimate the mismatch wavelength of walls (y, x) [m], which are in the position of best fit.

    Let waves of both walls have equal power and the correlation c. The power of the walls' sum over
    that of their difference, in a ring of n waves of about one wave number, is then (1 - c)/(1 + c)
    times a variable with the F(2n, 2n) distribution. At the wavelength W the correlation is c = (1
    - 2 e) Phi(s log(W/w) + q), with q such that c is 1/2 at the mismatch wavelength w. The
    likelihood of each w is that at the best steepness s and floor e (noise, leakage of the window).
    """
    length = min(upper.shape) * spacing
    shortest = 2.0 * spacing
    longest = 0.5 * length
    tried = np.geomspace(0.5 * shortest, 4.0 * longest, _TRIED)
    fit = _profile_likelihood(*_power_ratios(upper, lower, spacing), tried)
    best = int(fit.argmax())
    within = tried[fit > fit[best] - 0.5 * scipy.stats.chi2.ppf(CONFIDENCE, 1)]
    wave = 1.0 / tried[best]
    most = 1.0 / within[0]
    least = 1.0 / within[-1]
    most = wave + np.hypot(most - wave, _RESOLUTION / length)
    least = wave - np.hypot(wave - least, _RESOLUTION / length)
    limited = [  # to the wavelengths of the grid
        np.inf if k * longest <= 1.0 else 0.0 if k * shortest >= 1.0 else float(1.0 / k)
        for k in (wave, most, least)
    ]
    return Mismatch(*limited)


def _power_ratios(
    upper: np.ndarray, lower: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ratios of power from which `measured_mismatch` finds the wavelength.

    For each ring of wave numbers, (rings,): its mean wave number [1/m], the power of the sum of
    both walls over that of their difference, and the number of independent waves.
    """
    apart, along = (np.abs(_windowed_waves(wall)) ** 2 for wall in (upper + lower, upper - lower))
    wave = _wave_numbers(upper.shape, spacing)
    ring = np.round(wave * min(upper.shape) * spacing).astype(int)
    kept = (ring >= 2) & (wave <= 0.5 / spacing)
    fields = np.ones_like(wave), wave, apart, along
    sums = [np.bincount(ring[kept], field[kept]) for field in fields]
    count, waves, above, below = np.array(sums)[:, (sums[0] > 0) & (sums[3] > 0.0)]
    return waves / count, above / below, count / _WAVES_FOR_ONE


def _profile_likelihood(
    waves: np.ndarray, ratio: np.ndarray, n: np.ndarray, tried: np.ndarray
) -> np.ndarray:
    """Return the log likelihoods (tried,) of mismatch wavelengths ``tried`` [m].

    Each is the largest over steepness and floor. ``waves`` (rings,) [1/m], ``ratio`` and ``n`` are
    those of `_power_ratios`.
    """
    octaves = -np.log(tried[:, None] * waves[None, :])
    best = np.full(tried.size, -np.inf)
    for steepness, floor in itertools.product(_STEEPNESS, _FLOORS):
        most = 1.0 - 2.0 * floor
        half = scipy.special.ndtri(0.5 / most)
        correlation = most * scipy.special.ndtr(steepness * octaves + half)
        expected = (1.0 - correlation) / (1.0 + correlation)
        fit = (n * (np.log(expected) - 2.0 * np.log(expected + ratio))).sum(axis=1)
        best = np.maximum(best, fit)
    return best


def slope_correlations(
    fixed: np.ndarray, shape: tuple[int, int], least_overlap: float
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function that correlates the slopes of a moved field with those of the fixed field.

    Fields are heights (y, x), NaN where missing. The function takes a field of the given ``shape``,
    and returns the correlation (y, x) of slopes at each shift of this field in cells: index 0 is no
    shift, and negative shifts are at the end. Means are not subtracted. The correlation is NaN at
    shifts where the known slopes of both fields that meet are fewer than ``least_overlap`` times
    the known slopes of the field that has fewer. All shifts are computed at once by Fourier
    transforms; slopes along x and y are the parts of complex numbers. Single precision suffices, as
    the best shift is only the start of a finer fit.
    """
    size = [scipy.fft.next_fast_len(n - 2, True) for n in np.add(fixed.shape, shape).tolist()]

    def waves(field: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Return the transforms of slopes, of their squares and of their mask, and their number."""
        slopes = np.diff(field, axis=1)[:-1] + 1j * np.diff(field, axis=0)[:, :-1]
        known = np.isfinite(slopes)
        slopes = np.where(known, slopes, 0.0).astype(np.complex64)
        real = (np.abs(slopes) ** 2, known.astype(np.float32))
        return scipy.fft.fft2(slopes, size), *(scipy.fft.rfft2(r, size) for r in real), known.sum()

    slopes, squares, ones, count = waves(fixed)

    def correlation_by_shift(moved: np.ndarray) -> np.ndarray:
        others, other_squares, other_ones, other_count = waves(moved)
        both, power, other_power = (
            scipy.fft.irfft2(one * other.conj(), size)
            for one, other in ((ones, other_ones), (squares, other_ones), (ones, other_squares))
        )
        cross = scipy.fft.ifft2(slopes * others.conj()).real
        allowed = np.round(both) >= max(least_overlap * min(count, other_count), 4.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation = np.where(allowed, cross / np.sqrt(power * other_power), np.nan)
        return np.where(np.isfinite(correlation), correlation, np.nan)

    return correlation_by_shift

"""Mismatch wavelength of two walls: longer waves are common, shorter ones independent.

Brown (1995) uses one sharp length, Glover et al. (1998) a correlation that decreases gradually with
the wavelength. Here the length is the wavelength at which the correlation is 1/2, however gradual
the decrease.
"""

import itertools
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.walls.mating import WAVES_FOR_ONE, wave_numbers, windowed_waves

CONFIDENCE = 0.95
"""Confidence of the interval of a mismatch wavelength."""
_RESOLUTION = 0.75
"""Resolution of the mismatch wave number, in wave numbers of the walls' length: three quarters of
the distance of two waves. Of 24 pairs each with 48, 96 and 192 cells a side, H 0.5 and 0.8, and
true wavelengths of 5 to 24 cells, 99 % of the intervals with it contained the true value; the worst
share was 87 %, for a wavelength of a third of the side."""
_STEEPNESS = np.geomspace(1.0, 64.0, 25)
_FLOORS = np.array([3e-4, 1e-3, 4e-3, 1.6e-2, 6e-2, 0.2])
_TRIED = 600


class Mismatch(NamedTuple):
    """Wavelength [m] at which the correlation of two walls is 1/2, with a 95 % interval.

    ``wavelength`` is 0 if the walls are mated at all wavelengths of the grid, and infinite if at
    none. ``low`` is 0, or ``high`` infinite, if the walls do not bound it.
    """

    wavelength: float
    low: float
    high: float


def measured_mismatch(upper: np.ndarray, lower: np.ndarray, spacing: float) -> Mismatch:
    """Estimate the mismatch wavelength of two walls.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights [m] towards the other wall, without missing cells, in the position of best fit,
        because a shift also causes mismatch.
    spacing : float
        Grid spacing [m].

    Notes
    -----
    If the waves of both walls have equal power and correlation c, the powers of the sum and of
    the difference of both walls are independent, with a ratio of (1 - c) to (1 + c). The ratio of
    their sums over a ring of n wave numbers is this ratio times a variable distributed as
    F(2n, 2n), for any spectrum. The likelihood is profiled over the wavelength w at which c is a
    half. At a wavelength W the model is c = (1 - 2 e) Phi(s log(W/w) + q), where q makes c a half
    at w, and the steepness s and the floor e (noise of the scans, leakage of the window) are
    free. The interval is widened by `_RESOLUTION`.
    """
    length = min(upper.shape) * spacing
    shortest, longest = 2.0 * spacing, 0.5 * length
    tried = np.geomspace(0.5 * shortest, 4.0 * longest, _TRIED)
    fit = _profile(*_rings(upper, lower, spacing), tried)
    best = int(fit.argmax())
    within = tried[fit > fit[best] - 0.5 * scipy.stats.chi2.ppf(CONFIDENCE, 1)]
    wave, most, least = 1.0 / tried[best], 1.0 / within[0], 1.0 / within[-1]
    most = wave + np.hypot(most - wave, _RESOLUTION / length)
    least = wave - np.hypot(wave - least, _RESOLUTION / length)

    def limited(wave: float) -> float:
        """Return the wavelength of a wave number, limited to those of the grid."""
        if wave * longest <= 1.0:
            return float("inf")
        return 0.0 if wave * shortest >= 1.0 else float(1.0 / wave)

    return Mismatch(limited(wave), limited(most), limited(least))


def _rings(
    upper: np.ndarray, lower: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mean wave number [1/m], ratio of powers, and number of waves of rings."""
    apart, along = (np.abs(windowed_waves(wall)) ** 2 for wall in (upper + lower, upper - lower))
    wave = wave_numbers(upper.shape, spacing)
    ring = np.round(wave * min(upper.shape) * spacing).astype(int)
    kept = (ring >= 2) & (wave <= 0.5 / spacing)

    def over_rings(values: np.ndarray) -> np.ndarray:
        return np.bincount(ring[kept], values[kept])

    count, below = over_rings(np.ones(wave.shape)), over_rings(along)
    known = (count > 0) & (below > 0.0)
    mean, ratio = (
        over_rings(part)[known] / whole[known] for part, whole in ((wave, count), (apart, below))
    )
    return mean, ratio, count[known] / WAVES_FOR_ONE


def _profile(
    wave: np.ndarray, ratio: np.ndarray, count: np.ndarray, tried: np.ndarray
) -> np.ndarray:
    """Return the log likelihood of each wavelength tried [m] at the best steepness and floor."""
    octaves = -np.log(tried[:, None] * wave[None, :])
    best = np.full(tried.size, -np.inf)
    for steepness, floor in itertools.product(_STEEPNESS, _FLOORS):
        most = 1.0 - 2.0 * floor
        half = scipy.special.ndtri(0.5 / most)
        correlation = most * scipy.special.ndtr(steepness * octaves + half)
        expected = (1.0 - correlation) / (1.0 + correlation)
        fit = (count * (np.log(expected) - 2.0 * np.log(expected + ratio))).sum(axis=1)
        best = np.maximum(best, fit)
    return best

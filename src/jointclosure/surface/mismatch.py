"""The mismatch wavelength of two walls: longer waves mate, shorter ones do not.

Brown (1995) has one sharp length, Glover et al. (1998) a correlation that falls gradually with
the wavelength. Here the length is where the correlation falls to 1/2, however gradually it does.
"""

import itertools
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.surface.mating import WAVES_FOR_ONE, wave_numbers, windowed_waves

CONFIDENCE = 0.95
"""Of the interval of a mismatch wavelength."""
_RESOLUTION = 0.75
"""Of a wave number, in those of the walls' length: an edge is placed no better than to three
quarters of the distance of two waves. Of 24 pairs each of 48, 96 and 192 cells a side, H 0.5 and
0.8, and true wavelengths of 5 to 24 cells, intervals with it held the truth 99 % of the time; at
worst 87 %, where the wavelength was a third of the side."""
_STEEPNESS = np.geomspace(1.0, 64.0, 25)
_FLOORS = np.array([3e-4, 1e-3, 4e-3, 1.6e-2, 6e-2, 0.2])
_TRIED = 600


class Mismatch(NamedTuple):
    """The wavelength [m] at which two walls' correlation falls to 1/2, with a 95 % interval.

    ``wavelength`` is 0 where the walls mate at all wavelengths of the grid, infinite where at
    none; ``low`` is 0, or ``high`` infinite, where the walls do not tell.
    """

    wavelength: float
    low: float
    high: float


def measured_mismatch(upper: np.ndarray, lower: np.ndarray, spacing: float) -> Mismatch:
    """The mismatch wavelength of two walls.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights [m] towards the other wall, none missing, where they mate best: a shift of them
        is a mismatch too.
    spacing : float
        Grid spacing [m].

    Returns
    -------
    Mismatch

    Notes
    -----
    Where both walls' waves are of equal power and correlate by c, the powers of the sum and of
    the difference of both walls are independent and as (1 - c) to (1 + c). So the ratio of their
    sums over a ring of n wave numbers is that times a variable of F(2n, 2n), whatever the
    spectrum. Its likelihood is profiled over the wavelength w at which c is a half, where
    c = (1 - 2 e) Phi(s log(W/w) + q) at a wavelength W, and q makes it a half at w; the steepness
    s and the floor e (noise of the scans, leakage of the window) are free. The interval is
    widened by `_RESOLUTION`.
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

    def told(wave: float) -> float:
        """The wavelength of a wave number, where the grid has it."""
        if wave * longest <= 1.0:
            return float("inf")
        return 0.0 if wave * shortest >= 1.0 else float(1.0 / wave)

    return Mismatch(told(wave), told(most), told(least))


def _rings(
    upper: np.ndarray, lower: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Over rings of wave numbers: their mean [1/m], the powers' ratio, and how many waves."""
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
    """Log likelihood of each wavelength tried [m], at the steepness and floor that suit it best."""
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

"""Scans whose spectrum ends at a circle of wave numbers, near that of the shortest waves of a grid.

An instrument's blur, or a filter that is equal in all directions, leaves no waves in the corners of
the square of wave numbers that a grid has. The heights of such a scan grow with distance as those
of a rough wall without noise, so that fits of the growth understate noise. The corners show it.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.walls.gridding import Scan
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.planes import detrended

CLEAR = 6.0
"""Difference of log likelihoods from which a spectrum ends at a circle. The largest of undamaged
walls is in benchmarks/results/scan_defects/warnings.csv, with the scans that are recognised."""
_RADII = np.linspace(0.7, 1.1, 9)
"""Radii of the circles that are compared, over the largest wave number along an axis."""
_LONGEST = 0.3  # wave number from which spectra are compared, in the same unit
_WIDTH = 0.025  # of the rings of wave numbers, in the same unit
_LEAST = 24  # cells along the shorter side, below which a scan has too few of these waves
_DIAGONAL = math.tan(math.radians(25.0))
"""Least ratio of the wave numbers along both axes of the waves that are compared: those along the
axes do not reach the corners, and walls may differ between directions."""
_EXPONENTS = np.linspace(0.3, 1.0, 15)  # Hurst exponents of the walls that are compared
_REWEIGHTED = 4  # weighted least squares fits, which come close to the likeliest powers


class SpectrumEnd(NamedTuple):
    """Circle at which the spectrum of a scan ends, and the white noise beyond it."""

    wave: float  # wavelength [m] of the circle
    noise: float  # standard deviation [m] of white noise that has the power beyond the circle
    waves_beyond: int  # number of waves beyond the circle
    clarity: float  # log likelihood of this spectrum, over that of one without an end

    @property
    def clear(self) -> bool:
        """Whether the spectrum ends at the circle more likely than it goes on."""
        return self.clarity > CLEAR

    @property
    def noise_interval(self) -> tuple[float, float]:
        """The 95 % interval of the noise [m], from the number of waves beyond the circle."""
        low, high = scipy.stats.chi2.ppf([0.025, 0.975], self.waves_beyond)
        scales = (self.waves_beyond / high, self.waves_beyond / low)
        return self.noise * math.sqrt(scales[0]), self.noise * math.sqrt(scales[1])


class _Rings(NamedTuple):
    """Means of wave numbers and powers [m^2] of rings of waves near the diagonals, and numbers."""

    wave: np.ndarray
    power: np.ndarray
    number: np.ndarray


def spectrum_end(scan: Scan) -> SpectrumEnd | None:
    """Return the circle at which the spectrum of a scanned grid ends most likely.

    Powers of its waves are compared with two spectra, by Whittle's likelihood. One is that of a
    self-affine wall, to the corners of the square of wave numbers, with white noise. The other ends
    at a circle, with white noise beyond it too. None without enough waves on a square grid.
    """
    dy, dx = scan.spacing
    if min(scan.heights.shape) < _LEAST or not math.isclose(dy, dx, rel_tol=0.01):
        return None
    rings = _rings(scan.heights)
    if rings is None:
        return None
    whole, _ = _likeliest(rings, math.inf)
    fits = [(*_likeliest(rings, radius), radius) for radius in _RADII.tolist()]
    value, noise, radius = max(fits)
    beyond = int(rings.number[rings.wave > radius].sum())
    return SpectrumEnd(2.0 * dx / radius, math.sqrt(noise), beyond, value - whole)


def _rings(heights: np.ndarray) -> _Rings | None:
    """Return the powers of heights (y, x) [m] in rings; None if the heights are flat."""
    known = np.isfinite(heights)
    if known.mean() < 0.5:
        return None
    whole = heights if known.all() else fill_missing(heights, "linear", 1.0)
    powers = scipy.fft.dctn(detrended(whole), norm="ortho") ** 2
    wave, ring = _ring_of_waves(heights.shape)
    kept = ring >= 0
    count = np.bincount(ring[kept])
    some = count > 0
    sums = [np.bincount(ring[kept], values[kept])[some] for values in (wave, powers)]
    means = [total / count[some] for total in sums]
    if not (means[1] > 0.0).all():
        return None
    return _Rings(means[0], means[1], count[some])


@lru_cache(maxsize=4)
def _ring_of_waves(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return wave number and ring (y, x) of each cosine; ring -1 for those left out."""
    y, x = np.ogrid[tuple(slice(0.0, 1.0 - 1.0 / n, 1j * n) for n in shape)]
    wave = np.hypot(y, x)
    kept = (np.minimum(y, x) > _DIAGONAL * np.maximum(y, x)) & (wave > _LONGEST)
    return wave, np.where(kept, np.floor(wave / _WIDTH).astype(int), -1)


def _likeliest(rings: _Rings, radius: float) -> tuple[float, float]:
    """Return the largest log likelihood of a spectrum that ends at a radius, and its noise [m^2].

    The spectrum is A k^(-2H - 2) at wave numbers k within the radius, and white noise everywhere.
    """
    fits = []
    scale = float(rings.power[-1])  # keeps columns of one size
    for exponent in _EXPONENTS:
        law = np.where(rings.wave < radius, rings.wave ** (-2.0 * exponent - 2.0), 0.0)
        columns = scale * np.stack([law, np.ones_like(law)])
        model = rings.power
        parts = np.zeros(2)
        for _ in range(_REWEIGHTED):
            weight = np.sqrt(rings.number) / model
            parts, _ = scipy.optimize.nnls((columns * weight).T, rings.power * weight)
            model = np.maximum(parts @ columns, 1e-9 * rings.power)
        value = -0.5 * float((rings.number * (np.log(model) + rings.power / model)).sum())
        fits.append((value, scale * float(parts[1])))
    return max(fits)

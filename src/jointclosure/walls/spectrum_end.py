"""Circular end of the spectrum of a scan, near the shortest waves of its grid, and noise beyond it.

The wave numbers of a grid fill a square. An instrument's blur, or a filter that is equal in all
directions, leaves no waves of the wall in the corners of the square, outside of a circle. Height
differences of such a scan grow with distance as those of a rough wall without noise do, so that a
fit of this growth understates the noise. The power in the corners shows it.
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
"""Difference of log likelihoods above which a spectrum counts as ending at a circle. The largest
difference of undamaged walls, and those of scans that are recognised, are in
benchmarks/results/scan_defects/warnings.csv."""

# Wave numbers of this module are over the largest wave number of the grid along an axis.
_RADII = np.linspace(0.7, 1.1, 9)  # radii (wave numbers) of the circles that are compared
_LONGEST = 0.3  # least wave number of the waves by which spectra are compared
_WIDTH = 0.025  # width of the rings of wave numbers over which powers are averaged
_LEAST = 24  # fewest cells along the shorter side of a scan that is judged
_DIAGONAL = math.tan(math.radians(25.0))
"""Least ratio of the smaller wave number of a wave, along x or y, to the larger one. Waves nearer
to an axis are left out: they do not reach the corners, and walls may differ between directions."""
_EXPONENTS = np.linspace(0.3, 1.0, 15)  # Hurst exponents of the walls that are compared
_REWEIGHTED = 4  # rounds of weighted least squares, which come close to the likeliest powers


class SpectrumEnd(NamedTuple):
    """Circle at which the spectrum of a scan ends, and the white noise beyond it."""

    wave: float  # wavelength [m] of the circle
    noise: float  # standard deviation [m] of white noise that has the power beyond the circle
    waves_beyond: int  # number of waves beyond the circle
    clarity: float  # log likelihood of this spectrum less that of a spectrum without an end

    @property
    def clear(self) -> bool:
        """Whether it is clear that the spectrum ends at the circle (`CLEAR`)."""
        return self.clarity > CLEAR

    @property
    def noise_interval(self) -> tuple[float, float]:
        """The 95 % interval (low, high) of the noise [m], from the number of waves beyond."""
        low, high = scipy.stats.chi2.ppf([0.025, 0.975], self.waves_beyond)
        scales = (self.waves_beyond / high, self.waves_beyond / low)
        return self.noise * math.sqrt(scales[0]), self.noise * math.sqrt(scales[1])


class _Rings(NamedTuple):
    """Rings of waves near the diagonals of a scan's square of wave numbers: arrays (rings,)."""

    wave: np.ndarray  # mean wave number
    power: np.ndarray  # mean power [m^2]
    number: np.ndarray  # of waves


def spectrum_end(scan: Scan) -> SpectrumEnd | None:
    """Return the circle at which the spectrum of a scanned grid ends most likely.

    The powers of its waves are compared with two spectra, by Whittle's likelihood. The first is
    that of a self-affine wall with white noise, up to the corners of the square of wave numbers. In
    the second the wall ends at a circle, and only the noise continues. `SpectrumEnd.clear` tells
    whether the second is clearly the better one. None if the cells are not square, the grid is too
    small, or more than half of the heights are missing.
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
    """Return the powers of heights (y, x) [m] in rings; None if a ring has no power.

    Missing heights are interpolated; None too if more than half of them are missing.
    """
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
    """Return the wave number (y, x) of each cosine of a grid, and the number (y, x) of its ring.

    Cosines that are not compared, as they are too long or too near to an axis, have the ring -1.
    """
    y, x = np.ogrid[tuple(slice(0.0, 1.0 - 1.0 / n, 1j * n) for n in shape)]
    wave = np.hypot(y, x)
    kept = (np.minimum(y, x) > _DIAGONAL * np.maximum(y, x)) & (wave > _LONGEST)
    return wave, np.where(kept, np.floor(wave / _WIDTH).astype(int), -1)


def _likeliest(rings: _Rings, radius: float) -> tuple[float, float]:
    """Return the largest log likelihood of a spectrum that ends at a ``radius``, and its noise.

    The spectrum is A k^(-2H - 2) at wave numbers k within the radius, plus white noise at all wave
    numbers, whose power [m^2] is returned. A, H and the noise are fitted.
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

"""Errors of two registered walls: of their registration, and of their heights.

Walls are drawn as other scans could show them: displaced by the errors of the fit, and with another
noise. Of waves with a power P and noise of a power N, a part sqrt(1 - N/P) is kept and random waves
of a power N are added, so that waves have the power of the scanned ones: heights that are
interpolated on the grid lose about as many short waves as noise adds. Sum and difference of the
walls are drawn apart, because mated waves have no sum but noise.
"""

import math
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.roughness import detrended

_EXPONENTS = np.linspace(0.3, 1.0, 36)
"""Hurst exponents of walls without noise that are compared."""
_LONGEST = 4
"""First ring whose waves are compared; longer ones are few."""


class ScanErrors(NamedTuple):
    """Errors of registered walls, in cells.

    ``offset`` (rotation [rad], x, y) of the fit from the position of the upper wall about a
    ``middle`` (x, y), and its ``covariance``, 0 if the walls stayed as scanned. ``noise`` is the
    standard deviation [m] of that of the sum of both walls; ``holes`` (y, x) have no scanned
    height.
    """

    offset: np.ndarray
    covariance: np.ndarray
    middle: np.ndarray
    noise: float
    holes: np.ndarray

    def displaced(self, upper: np.ndarray, number: int) -> np.ndarray:
        """Return the upper wall (y, x) [m] at a random place within the errors of the fit."""
        random = generator(seed_of(1, "registration", number))
        turn, x, y = random.multivariate_normal(self.offset, self.covariance, method="eigh")
        place_y, place_x = np.indices(upper.shape, float)
        from_x = place_x - x + turn * (place_y - self.middle[1])
        from_y = place_y - y - turn * (place_x - self.middle[0])
        moved = scipy.ndimage.map_coordinates(upper, [from_y, from_x], mode="mirror")
        return detrended(np.where(self.holes, upper, moved))

    def with_other_noise(
        self, upper: np.ndarray, lower: np.ndarray, number: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draw walls (y, x) [m] with another noise."""
        random = generator(seed_of(1, "noise", number))
        drawn = []
        for field in (upper + lower, upper - lower):
            waves, ring = scipy.fft.dctn(field, norm="ortho"), _ring_numbers(field.shape)
            whole = _ring_means(waves**2)
            noise = np.minimum(self.noise**2, whole)
            kept = np.sqrt(1.0 - noise / np.where(whole > 0.0, whole, 1.0))[ring]
            scatter = np.sqrt(noise)[ring] * random.standard_normal(field.shape)
            drawn.append(scipy.fft.idctn(kept * waves + scatter, norm="ortho"))
        walls = (0.5 * (drawn[0] + drawn[1]), 0.5 * (drawn[0] - drawn[1]))
        if not (upper.any() and lower.any()):  # a flat wall has no noise
            walls = (drawn[0] * upper.any(), drawn[0] * lower.any())
        one, other = (
            detrended(np.where(self.holes, scanned, wall))
            for scanned, wall in zip((upper, lower), walls, strict=True)
        )
        return one, other


def _ring_numbers(shape: tuple[int, ...]) -> np.ndarray:
    """Return the wave number (y, x) of each cosine, in waves over twice the shorter side."""
    waves = np.hypot(*np.ogrid[tuple(slice(0.0, 1.0 - 1.0 / n, 1j * n) for n in shape)])
    return np.rint(waves * min(shape)).astype(int)


def _ring_means(values: np.ndarray) -> np.ndarray:
    """Return means of values (y, x) over the cosines of each wave number."""
    ring = _ring_numbers(values.shape).ravel()
    return np.bincount(ring, values.ravel()) / np.maximum(np.bincount(ring), 1)


def noise_of(upper: np.ndarray, lower: np.ndarray) -> float:
    """Estimate the standard deviation of the noise of the sum of walls (y, x) [m].

    Noise is the nugget N beside a power A k^(-2H - 2) at wave number k, fitted by Whittle's
    likelihood. It has no more power than the sum of mated waves. Waves shorter than twice the
    spacing, which appear as longer ones, are part of it, as heights between cells miss them.
    """
    powers = [scipy.fft.dctn(wall, norm="ortho") ** 2 for wall in (upper, lower, upper + lower)]
    side, count = min(upper.shape), np.bincount(_ring_numbers(upper.shape).flat)
    kept = np.arange(_LONGEST, side)
    power, count = _ring_means(powers[0] + powers[1])[kept], count[kept]
    if not (power > 0.0).all():
        return 0.0
    octaves = np.log2(kept / _LONGEST).astype(int)
    apart = np.bincount(octaves, _ring_means(powers[2])[kept] * count)
    weight, fits = np.sqrt(count), []
    for exponent in _EXPONENTS:
        columns = power[-1] * np.stack([(kept / side) ** (-2.0 * exponent - 2.0), 0.0 * kept + 1.0])
        parts, _ = scipy.optimize.nnls((columns * (weight / power)).T, weight)
        model = parts @ columns
        fits.append(((count * (np.log(model) + power / model)).sum(), power[-1] * parts[1]))
    return math.sqrt(min(min(fits)[1], (apart / np.bincount(octaves, count)).min()))

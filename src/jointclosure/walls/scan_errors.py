"""Errors of two registered walls: of their registration, and noise of their scans.

Walls without these errors are drawn at random: displaced by the errors of the fit, and without
noise. Of waves with a power P and noise of a power N, those without noise have the mean 1 - N/P of
the scanned ones and the variance N (1 - N/P), as for a Wiener filter. Sum and difference of the
walls are drawn apart, because mated waves have no sum but noise.
"""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.roughness import detrended

EXPONENTS = np.linspace(0.3, 1.0, 36)
"""Hurst exponents of walls without noise that are compared."""
_FOLDS = 2
"""Waves up to so many times shorter than twice the spacing are counted where they appear."""
_LONGEST = 4
"""First ring whose waves are compared; longer ones are few."""


class ScanErrors(NamedTuple):
    """Errors of registered walls, in cells.

    ``offset`` (rotation [rad], x, y) of the fit from the position of the upper wall about a
    ``middle`` (x, y), and its ``covariance``, 0 if the walls stayed as scanned. ``noise`` are the
    smallest and largest standard deviation of the noise of the sum of both walls [m]; ``holes`` (y,
    x) have no scanned height.
    """

    offset: np.ndarray
    covariance: np.ndarray
    middle: np.ndarray
    noise: tuple[float, float]
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

    def without_noise(
        self, upper: np.ndarray, lower: np.ndarray, number: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draw walls (y, x) [m] that with noise are as those that were scanned."""
        random = generator(seed_of(1, "noise", number))
        power = random.uniform(*self.noise) ** 2
        drawn = []
        for field in (upper + lower, upper - lower):
            waves, ring = scipy.fft.dctn(field, norm="ortho"), _ring_numbers(field.shape)
            kept = np.maximum(1.0 - power / np.maximum(_ring_means(waves**2), power), 0.0)[ring]
            scatter = np.sqrt(power * kept) * random.standard_normal(field.shape)
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


def noise_between(upper: np.ndarray, lower: np.ndarray) -> tuple[float, float]:
    """Estimate the smallest and largest deviation of the noise of the sum of walls (y, x) [m].

    Noise is the nugget beside a power k^(-2H - 2) at wave number k. Waves that are shorter than
    twice the spacing appear as longer ones unless the scanner averages over a cell, and look like
    noise: both are assumed in turn. Noise has no more power than the sum of mated waves.
    """
    powers = [scipy.fft.dctn(wall, norm="ortho") ** 2 for wall in (upper, lower)]
    side = min(upper.shape)
    rings, count = _ring_means(powers[0] + powers[1]), np.bincount(_ring_numbers(upper.shape).flat)
    kept = np.arange(_LONGEST, side)
    if not (rings[kept] > 0.0).all():
        return 0.0, 0.0
    found = [_nugget(kept / side, rings[kept], count[kept], folds) for folds in (_FOLDS, 0)]
    apart = _ring_means(scipy.fft.dctn(upper + lower, norm="ortho") ** 2)[kept]
    octaves = np.log2(kept / _LONGEST).astype(int)
    bands = np.bincount(octaves, apart * count[kept]) / np.bincount(octaves, count[kept])
    low, high = np.sqrt(np.minimum(np.sort(found), bands.min()))
    return float(low), float(high)


def _nugget(wave: np.ndarray, power: np.ndarray, count: np.ndarray, folds: int) -> float:
    """Fit A k^(-2H - 2) + N to the power of rings of so many waves each, and return N.

    ``wave`` is relative to the shortest one of the grid; waves beyond it are folded back.
    """
    angle, whole = np.linspace(0.0, 0.25 * np.pi, 9), 2 * np.arange(-folds, folds + 1)
    x, y = (np.multiply.outer(wave, part(angle))[..., None] + whole for part in (np.cos, np.sin))
    length = np.hypot(x[..., :, None], y[..., None, :])
    weight, fits = np.sqrt(count), []
    for exponent in EXPONENTS:
        shape = (length ** (-2.0 * exponent - 2.0)).sum(axis=(2, 3)).mean(axis=1)
        scale = power[-1] / np.array([shape[-1], 1.0])
        columns = scale * np.stack([shape, np.ones(len(wave))], axis=1)
        parts, _ = scipy.optimize.nnls(columns * (weight / power)[:, None], weight)
        model = columns @ parts
        fits.append(((count * (np.log(model) + power / model)).sum(), scale[1] * parts[1]))
    return float(min(fits)[1])

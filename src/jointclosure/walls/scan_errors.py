"""Errors of two registered walls: of their registration, and of their heights.

Walls are drawn at random as other scans of them could show them: displaced by the errors of the
fit, and with other noise. Interpolation on the grid takes a power L of short waves from both walls
together, and noise adds a power N. The sum of walls of coherence c has therefore lost (1 - c) L,
and their difference (1 + c) L. How much of the estimated N is noise is not known: true waves
shorter than twice the spacing, unless both walls have them, add the same power as noise.

Waves that a filter took from a scan are drawn by a self-affine law, fitted to the waves that the
scan still holds.

In this module a ring is the set of cosines of a field with the same rounded wave number.
"""

import math
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls import Walls
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.planes import detrended

_EXPONENTS = np.linspace(0.3, 1.0, 36)  # Hurst exponents of walls without noise
_LONGEST = 4  # first ring that is used to estimate power; rings of longer waves have few waves
_ROCK_EXPONENTS = 0.5, 1.0  # least and largest Hurst exponent with which lost waves are drawn
_HELD = 1.3, 4.0
"""Shortest and longest wavelength from which lost waves are extrapolated, over the wavelength at
which half of the power is lost. At the shortest a Gaussian filter takes a third of the power."""
_AMPLIFIED = 5.0  # largest factor by which what a filter left of a wave is amplified
_SCALE_WAVES = 8.0  # shortest waves [cells] by which the scales of heights are compared
_MATED = 0.8  # least correlation of these waves from which the ratio of both scales is known
_LEAST_SCALE = 0.02  # least logarithm of the ratio of both scales that is believed; chosen
_CLEAR_SCALE = 5.0  # least ratio of this logarithm to its standard error; chosen


class ScanErrors(NamedTuple):
    """Errors of the position and of the heights of registered walls.

    Lengths without a unit are in cells of the finest grid that the scans give.
    """

    offset: np.ndarray  # (rotation [rad], x, y) of the best fit from the upper wall as registered
    covariance: np.ndarray  # (3, 3) of the offset
    middle: np.ndarray  # place (x, y) about which the upper wall rotates
    noise: tuple[float, float]  # low and high deviation [m] of the noise of the sum of both walls
    holes: np.ndarray  # cells (y, x) without a scanned height
    step: int = 1  # spacing of the joint, in cells of this grid
    waves: tuple[float, float] = (0.0, 0.0)  # wavelengths at which each scan lost half its power
    scale: float = 1.0  # scale of the upper wall's heights over that of the lower wall's
    lost_square: float = 0.0
    """Mean square difference [m^2] of neighbouring heights that interpolation took, summed over
    both walls."""

    @property
    def cells(self) -> int:
        """Number of cells of the grid to which the errors refer."""
        return int(self.holes.size)

    def displaced(self, upper: np.ndarray, number: int) -> np.ndarray:
        """Return the upper wall (y, x) [m], less its plane, at a random place within its errors.

        Cells of holes keep their height. Here and below ``number`` is that of the draw, from which
        its random numbers follow.
        """
        random = generator(seed_of(1, "registration", number))
        turn, x, y = random.multivariate_normal(self.offset, self.covariance, method="eigh")
        place_y, place_x = np.indices(upper.shape, float)
        from_x = place_x - x + turn * (place_y - self.middle[1])
        from_y = place_y - y - turn * (place_x - self.middle[0])
        moved = scipy.ndimage.map_coordinates(upper, [from_y, from_x], mode="mirror")
        return detrended(np.where(self.holes, upper, moved))

    def with_other_noise(self, upper: np.ndarray, lower: np.ndarray, number: int) -> Walls:
        """Return registered walls (y, x) [m] with other, random noise, each less its plane.

        The size of the noise is drawn between both estimates (``noise``). Cells of holes keep their
        heights, and a flat wall stays flat.
        """
        random = generator(seed_of(1, "noise", number))
        variance = random.uniform(*self.noise) ** 2
        part = random.random()
        drawn = []
        ring = _ring_numbers(upper.shape)
        scanned = [_waves(field) for field in (upper + lower, upper - lower)]
        powers = [_ring_means(waves**2) for waves in scanned]
        coherence = _coherence(powers[0], powers[1], variance)
        lost = _lost_power(self.lost_square, upper.shape)
        for waves, power, sign in zip(scanned, powers, (-1.0, 1.0), strict=True):
            divisor = np.where(power > 0.0, power, 1.0)
            noise = np.minimum(variance, power)
            true = np.maximum(power + (1.0 + sign * coherence) * lost - part * noise, 0.0)
            # of true waves with this power that depart from the scanned ones by the noise
            kept = np.clip(0.5 * (true + power - noise) / divisor, 0.0, np.sqrt(true / divisor))
            scatter = np.sqrt(np.maximum(true - kept**2 * power, 0.0))
            other = kept[ring] * waves + scatter[ring] * random.standard_normal(ring.shape)
            drawn.append(scipy.fft.idctn(other, norm="ortho"))
        walls = (0.5 * (drawn[0] + drawn[1]), 0.5 * (drawn[0] - drawn[1]))
        if not (upper.any() and lower.any()):  # a flat wall has no noise
            walls = (drawn[0] * upper.any(), drawn[0] * lower.any())
        one = detrended(np.where(self.holes, upper, walls[0]))
        return one, detrended(np.where(self.holes, lower, walls[1]))

    def with_lost_waves(self, upper: np.ndarray, lower: np.ndarray, number: int) -> Walls:
        """Return walls (y, x) [m] with the short waves that filters took from their scans.

        The power of these waves is that of a self-affine wall with the longer waves of the scan. A
        random part of it comes from what the filter left of each wave, which is amplified. The rest
        are random waves, with the coherence that both walls have at this wavelength. Each wall is
        returned less its plane; cells of holes keep their heights.
        """
        random = generator(seed_of(1, "resolution", number))
        exponent = random.uniform(*_ROCK_EXPONENTS)
        part = random.random()
        ring = _ring_numbers(upper.shape)
        scanned = [_waves(upper), _waves(lower)]
        powers = [_ring_means(waves**2) for waves in scanned]
        both = np.sqrt(powers[0] * powers[1])
        cross = _ring_means(scanned[0] * scanned[1])
        coherence = np.clip(cross / np.where(both > 0.0, both, 1.0), -1.0, 1.0)
        first, second = random.standard_normal((2, *ring.shape))
        second = coherence[ring] * first + np.sqrt(1.0 - coherence[ring] ** 2) * second
        drawn = []
        for waves, power, length, other in zip(
            scanned, powers, self.waves, (first, second), strict=True
        ):
            true = _extrapolated_power(power, length, exponent, upper.shape)
            ratio = np.sqrt(true / np.where(power > 0.0, power, np.inf))
            kept = 1.0 + part * (np.minimum(np.maximum(ratio, 1.0), _AMPLIFIED) - 1.0)
            scatter = np.sqrt(np.maximum(true - kept**2 * power, 0.0))
            drawn.append(scipy.fft.idctn(kept[ring] * waves + scatter[ring] * other, norm="ortho"))
        one = detrended(np.where(self.holes, upper, drawn[0]))
        return one, detrended(np.where(self.holes, lower, drawn[1]))

    def with_filled_holes(self, upper: np.ndarray, lower: np.ndarray, number: int) -> Walls:
        """Return walls (y, x) [m] with random heights in holes, where they cannot touch otherwise.

        The sum of both walls is interpolated over the holes. To this is added the departure of a
        random field, with the spectrum of the sum, from its own interpolation over the holes
        (conditional simulation, Journel & Huijbregts 1978). The change is made in the upper wall,
        or in the lower one if the upper one is flat.
        """
        random = generator(seed_of(1, "holes", number))
        together = upper + lower
        smooth = fill_missing(np.where(self.holes, np.nan, together), "linear", 1.0)
        power = _ring_means(_waves(smooth) ** 2)[_ring_numbers(upper.shape)]
        drawn = scipy.fft.idctn(np.sqrt(power) * random.standard_normal(power.shape), norm="ortho")
        departure = drawn - fill_missing(np.where(self.holes, np.nan, drawn), "linear", 1.0)
        change = np.where(self.holes, smooth + departure - together, 0.0)
        return upper + change * upper.any(), lower + change * (not upper.any())

    def with_one_scale(self, upper: np.ndarray, lower: np.ndarray, number: int) -> Walls:
        """Return walls (y, x) [m] with the same scale of heights, random between both scans'."""
        part = generator(seed_of(1, "scale", number)).random()
        return upper * self.scale**-part, lower * self.scale ** (1.0 - part)


def _waves(field: np.ndarray) -> np.ndarray:
    """Return the amplitudes (y, x) of the cosines of a field (y, x), in the field's units."""
    return scipy.fft.dctn(field, norm="ortho")


def _ring_numbers(shape: tuple[int, ...]) -> np.ndarray:
    """Return the ring (y, x) of each cosine: its waves over twice the shorter side, rounded."""
    waves = np.hypot(*np.ogrid[tuple(slice(0.0, 1.0 - 1.0 / n, 1j * n) for n in shape)])
    return np.rint(waves * min(shape)).astype(int)


def _ring_means(values: np.ndarray) -> np.ndarray:
    """Return the means (rings,) of values (y, x) over the cosines of each ring; 0 without any."""
    ring = _ring_numbers(values.shape).ravel()
    return np.bincount(ring, values.ravel()) / np.maximum(np.bincount(ring), 1)


def _coherence(of_sum: np.ndarray, of_difference: np.ndarray, noise: float = 0.0) -> np.ndarray:
    """Return the coherence (rings,) of walls less their noise, from powers (rings,) of two fields.

    The fields are the sum and the difference of the walls, and ``noise`` is the power of noise in
    each. Heights count towards the other wall, so that the sum of walls of coherence 1 has no
    power. A negative coherence is returned as 0.
    """
    whole = np.maximum(of_sum + of_difference - 2.0 * noise, np.abs(of_difference - of_sum))
    return np.maximum(of_difference - of_sum, 0.0) / np.where(whole > 0.0, whole, 1.0)


def _lost_power(square: float, shape: tuple[int, ...]) -> np.ndarray:
    """Return the power of each ring of wave numbers that interpolation took from walls (y, x).

    It is even over the waves of the shortest octave, and 0 at longer ones. Its waves have the mean
    ``square`` [m^2] of differences of neighbouring heights. A cosine of wave number k [rad/cell]
    along an axis has (2 sin(k/2))^2 times its mean square as that of its differences.
    """
    short = _ring_numbers(shape) >= min(shape) // 2
    along = [4.0 * np.sin(0.5 * np.pi * np.arange(n) / n) ** 2 for n in shape]
    differences = 0.5 * (along[0][:, None] + along[1][None, :])  # mean of both axes
    return (_ring_means(short) > 0.0) * square / float((short * differences).mean())


def noise_of(upper: np.ndarray, lower: np.ndarray) -> tuple[float, float]:
    """Estimate the standard deviation [m] of the noise in the sum of walls (y, x): low and high.

    Both are roots of powers of the noise. The low power is that of white noise besides a power A
    k^(-2H - 2) at wave number k, fitted to the walls by Whittle's likelihood, or the least power of
    the sum in any octave, if that is less. The high power is nearer to this least power, the more
    coherent the walls are in its octave: how much of the least power is a true difference of shape
    cannot be known. Both are 0 if a ring of waves has no power.
    """
    fields = (upper, lower, upper + lower, upper - lower)
    powers = [_waves(field) ** 2 for field in fields]
    side = min(upper.shape)
    count = np.bincount(_ring_numbers(upper.shape).flat)
    kept = np.arange(_LONGEST, side)
    power = _ring_means(powers[0] + powers[1])[kept]
    count = count[kept]
    if not (power > 0.0).all():
        return 0.0, 0.0
    octaves = np.log2(kept / _LONGEST).astype(int)
    apart, together = (
        np.bincount(octaves, _ring_means(field)[kept] * count) / np.bincount(octaves, count)
        for field in powers[2:]
    )
    weight = np.sqrt(count)
    fits = []
    for exponent in _EXPONENTS:
        columns = power[-1] * np.stack([(kept / side) ** (-2.0 * exponent - 2.0), 0.0 * kept + 1.0])
        parts, _ = scipy.optimize.nnls((columns * (weight / power)).T, weight)
        model = parts @ columns
        fits.append(((count * (np.log(model) + power / model)).sum(), power[-1] * parts[1]))
    octave = apart.argmin()
    low = min(min(fits)[1], apart[octave])
    high = low + (apart[octave] - low) * _coherence(apart, together)[octave]
    return math.sqrt(low), math.sqrt(high)


def _extrapolated_power(
    power: np.ndarray, length: float, exponent: float, shape: tuple[int, ...]
) -> np.ndarray:
    """Return the power (rings,) [m2] that a wall had before a filter took its short waves.

    ``power`` (rings,) is what is left, ``length`` [cells] the wavelength at which half was lost; 0
    means that none was. The power of short waves is A k^(-2H - 2) at wave number k, with A from the
    longer waves and the Hurst exponent H, but at least what is left. ``shape`` is that of the wall.
    """
    rings = np.arange(len(power))
    if not length > 0.0 or not power.any():
        return power
    lost = 2.0 * min(shape) / length  # ring of this wavelength
    shortest = lost / _HELD[0]
    held = (rings >= max(_LONGEST, shortest / _HELD[1])) & (rings <= shortest)
    if not held.any():
        held = rings == max(int(shortest), 1)
    count = np.bincount(_ring_numbers(shape).ravel())[held]
    law = np.maximum(rings, 1.0) ** (-2.0 * exponent - 2.0)
    size = float(np.average(power[held] / law[held], weights=count))
    return np.where(rings > shortest, np.maximum(size * law, power), power)


def scale_of(upper: np.ndarray, lower: np.ndarray) -> tuple[float, float]:
    """Return the scale of the upper wall's heights over the lower wall's, and its relative error.

    It is found from the long waves of both walls (y, x) [m]. The powers P and P' of n waves with
    coherence c give log(P/P') / 2 with a variance of (1 - c^2)/n; these are averaged over rings. If
    the walls do not mate, the ratio is returned as 1 with an infinite error.
    """
    one = _waves(upper)
    other = _waves(lower)
    powers = [_ring_means(product) for product in (one * one, other * other, one * other)]
    count = np.bincount(_ring_numbers(upper.shape).ravel())
    rings = np.arange(len(count))
    kept = (rings >= 2) & (rings <= 2.0 * min(upper.shape) / _SCALE_WAVES) & (powers[0] > 0.0)
    kept &= powers[1] > 0.0
    if not kept.any():
        return 1.0, math.inf
    first, second, cross = (power[kept] for power in powers)
    sums = [float((count[kept] * power).sum()) for power in (first, second, cross)]
    if -sums[2] < _MATED * math.sqrt(sums[0] * sums[1]):
        return 1.0, math.inf
    variance = np.maximum(1.0 - cross**2 / (first * second), 1e-9) / count[kept]
    weight = np.where(cross < 0.0, 1.0 / variance, 0.0)  # heights count towards the other wall
    if not weight.any():
        return 1.0, math.inf
    scale = float((weight * np.log(first / second)).sum() / weight.sum())
    return math.exp(0.5 * scale), math.sqrt(1.0 / float(weight.sum()))


def scales_differ(scale: float, error: float) -> bool:
    """Return whether a ratio ``scale`` of heights, with its relative error, is clearly not 1."""
    return abs(math.log(scale)) > max(_LEAST_SCALE, _CLEAR_SCALE * error)

"""Fit of two walls: correlation of slopes over shifts, and of heights over wavelengths."""

from typing import Any, NamedTuple

import numpy as np
import scipy.fft

from jointclosure.walls.roughness import detrended

WAVES_FOR_ONE = 4.5
"""Number of coefficients of `windowed_waves` that contain as much information as one independent
one: each occurs with its mirror image, and the window correlates neighbours (factor 1.5 along each
axis)."""


class Mating(NamedTuple):
    """Correlation of two walls over wavelengths, from `mating`.

    ``wavelengths`` [m] are the middles of bands of half an octave, longest first. ``modes`` are the
    numbers of independent waves of the bands; the standard error is (1 - correlation^2) /
    sqrt(modes).
    """

    wavelengths: np.ndarray
    correlation: np.ndarray
    modes: np.ndarray


def mating(upper: np.ndarray, lower: np.ndarray, spacing: float) -> Mating:
    """Compute the correlation of walls by wavelength: 1 if they are mated, 0 if independent.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights [m] towards the other wall, without missing cells.
    spacing : float
        Grid spacing [m].

    Returns
    -------
    Mating
        -Re(sum U L*) / sqrt(sum |U|^2 sum |L|^2) over the waves of a band, where U and L are the
        Fourier transforms of the walls with a Hann window. Bands with fewer than four waves are
        left out.
    """
    ny, nx = upper.shape
    one, other = (windowed_waves(wall) for wall in (upper, lower))
    wave = wave_numbers(upper.shape, spacing)
    longest, shortest = 0.5 * min(ny, nx) * spacing, 2.0 * spacing
    bands = np.floor(2.0 * np.log2(np.maximum(wave, 1e-300) * longest) + 0.5).astype(int)
    kept = (bands >= 0) & (wave <= 1.0 / shortest)
    count = bands[kept].max() + 1

    def over_bands(values: np.ndarray) -> np.ndarray:
        return np.bincount(bands[kept], values[kept], minlength=count)

    cross = -over_bands((one * other.conj()).real)
    power = over_bands(np.abs(one) ** 2) * over_bands(np.abs(other) ** 2)
    modes = over_bands(np.ones(wave.shape)) / WAVES_FOR_ONE
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = np.clip(cross / np.sqrt(power), -1.0, 1.0)  # exceeded only by rounding
    enough = modes >= 4.0
    middles = longest * 2.0 ** (-0.5 * np.arange(count))
    return Mating(middles[enough], correlation[enough], modes[enough])


def windowed_waves(wall: np.ndarray) -> Any:
    """Compute the Fourier transform (y, x) of a wall less its plane, with a Hann window."""
    ny, nx = wall.shape
    window = np.outer(np.hanning(ny + 2)[1:-1], np.hanning(nx + 2)[1:-1])
    return scipy.fft.fft2(window * detrended(wall))


def wave_numbers(shape: tuple[int, ...], spacing: float) -> np.ndarray:
    """Return the wave number [1/m] of each coefficient (y, x) of `windowed_waves`."""
    wave_y, wave_x = (scipy.fft.fftfreq(n, spacing) for n in shape)
    return np.hypot(wave_y[:, None], wave_x[None, :])


def slope_correlation_over_shifts(
    fixed: np.ndarray, moved: np.ndarray, least_overlap: float
) -> np.ndarray:
    """Compute the correlation of the slopes of two fields for every shift of one of them.

    Slopes are used instead of heights, because the few longest waves of heights correlate by
    chance.

    Parameters
    ----------
    fixed, moved : array (y, x)
        Heights on grids of equal spacing, NaN where missing.
    least_overlap : float
        Smallest share of the smaller field's slopes that must overlap the other field.

    Returns
    -------
    array
        Correlation over shifts of ``moved`` in cells, (y, x), with negative shifts counted from
        the end as in a discrete Fourier transform; NaN where fields overlap too little. Computed
        by masked normalised cross-correlation (Padfield 2012).
    """
    cross = fixed_power = moved_power = 0.0
    for one, other in zip(_slopes(fixed), _slopes(moved), strict=True):
        parts = _masked_moments(one, other, least_overlap)
        cross, fixed_power, moved_power = (
            sums + part for sums, part in zip((cross, fixed_power, moved_power), parts, strict=True)
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = cross / np.sqrt(fixed_power * moved_power)
    return np.where(np.isfinite(correlation), correlation, np.nan)


def best_shift(correlation: np.ndarray) -> tuple[tuple[int, int], float]:
    """Return the shift (y, x) in cells with the largest value of an array, and this value.

    The value is NaN if no shift is allowed.
    """
    if not np.isfinite(correlation).any():
        return (0, 0), float("nan")
    place = np.unravel_index(int(np.nanargmax(correlation)), correlation.shape)
    y, x = (int(i - n if i > n // 2 else i) for i, n in zip(place, correlation.shape, strict=True))
    return (y, x), float(correlation[place])


def _slopes(field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.diff(field, axis=1)[:-1], np.diff(field, axis=0)[:, :-1]


def _masked_moments(fixed: np.ndarray, moved: np.ndarray, least_overlap: float) -> Any:
    """Return sums of products and of squares, less their means, where both fields are known."""
    size = [
        scipy.fft.next_fast_len(a + b - 1, True)
        for a, b in zip(fixed.shape, moved.shape, strict=True)
    ]
    known = [np.isfinite(field).astype(float) for field in (fixed, moved)]
    fields = [
        np.where(mask > 0.0, field, 0.0) for mask, field in zip(known, (fixed, moved), strict=True)
    ]
    ones, ones_moved = (scipy.fft.rfft2(mask, size) for mask in known)
    first, first_moved = (scipy.fft.rfft2(field, size) for field in fields)
    square, square_moved = (scipy.fft.rfft2(field**2, size) for field in fields)

    def met(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return scipy.fft.irfft2(one * other.conj(), size)

    count = np.round(met(ones, ones_moved))
    allowed = count >= max(least_overlap * min(mask.sum() for mask in known), 4.0)
    count = np.where(allowed, count, np.nan)
    sums, sums_moved = met(first, ones_moved), met(ones, first_moved)
    return (
        met(first, first_moved) - sums * sums_moved / count,
        met(square, ones_moved) - sums**2 / count,
        met(ones, square_moved) - sums_moved**2 / count,
    )

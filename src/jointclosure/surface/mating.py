"""How two walls fit each other: correlation of slopes over shifts, of heights over wavelengths."""

from typing import Any, NamedTuple

import numpy as np
import scipy.fft

from jointclosure.surface.roughness import detrended

WAVES_FOR_ONE = 4.5
"""Coefficients of `windowed_waves` that tell as much as one: each is there with its mirror image,
and the window makes neighbours of four alike (1.5 along each axis)."""


class Mating(NamedTuple):
    """Correlation of two walls over wavelengths, as of `mating`.

    ``wavelengths`` [m] are the middles of bands of half an octave, longest first; ``modes`` their
    numbers of independent waves, by which the standard error is (1 - correlation^2) / sqrt(modes).
    """

    wavelengths: np.ndarray
    correlation: np.ndarray
    modes: np.ndarray


def mating(upper: np.ndarray, lower: np.ndarray, spacing: float) -> Mating:
    """Correlation of walls by wavelength: 1 where they mate, 0 where they are independent.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights [m] towards the other wall, none missing.
    spacing : float
        Grid spacing [m].

    Returns
    -------
    Mating
        -Re(sum U L*) / sqrt(sum |U|^2 sum |L|^2) over the waves of a band, of the walls' Fourier
        transforms U and L under a Hann window. Bands with fewer than four waves are left out.
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
        correlation = np.clip(cross / np.sqrt(power), -1.0, 1.0)  # beyond by rounding
    enough = modes >= 4.0
    middles = longest * 2.0 ** (-0.5 * np.arange(count))
    return Mating(middles[enough], correlation[enough], modes[enough])


def windowed_waves(wall: np.ndarray) -> Any:
    """Fourier transform (y, x) of a wall less its plane, under a Hann window."""
    ny, nx = wall.shape
    window = np.outer(np.hanning(ny + 2)[1:-1], np.hanning(nx + 2)[1:-1])
    return scipy.fft.fft2(window * detrended(wall))


def wave_numbers(shape: tuple[int, ...], spacing: float) -> np.ndarray:
    """Of each coefficient (y, x) of `windowed_waves` [1/m]."""
    wave_y, wave_x = (scipy.fft.fftfreq(n, spacing) for n in shape)
    return np.hypot(wave_y[:, None], wave_x[None, :])


def slope_correlation_over_shifts(
    fixed: np.ndarray, moved: np.ndarray, least_overlap: float
) -> np.ndarray:
    """Correlation of the slopes of two fields for every shift of one of them.

    Slopes, and not heights, since the longest waves correlate by chance: there are few of them.

    Parameters
    ----------
    fixed, moved : array (y, x)
        Heights on grids of one spacing, NaN where missing.
    least_overlap : float
        Share of the smaller field's slopes that must meet others.

    Returns
    -------
    array
        Over shifts of ``moved`` in cells, (y, x), negative ones counted from the end as in a
        discrete Fourier transform; NaN where fields overlap too little. By masked normalised
        cross-correlation (Padfield 2012).
    """
    cross = fixed_power = moved_power = 0.0
    for one, other in zip(_slopes(fixed), _slopes(moved), strict=True):
        parts = _masked_moments(one, other, least_overlap)
        cross, fixed_power, moved_power = (
            sums + part for sums, part in zip((cross, fixed_power, moved_power), parts, strict=True)
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        found = cross / np.sqrt(fixed_power * moved_power)
    return np.where(np.isfinite(found), found, np.nan)


def best_shift(correlation: np.ndarray) -> tuple[tuple[int, int], float]:
    """Shift (y, x) in cells at which an array of all shifts is largest, and its value there.

    The value is NaN where no shift is allowed.
    """
    if not np.isfinite(correlation).any():
        return (0, 0), float("nan")
    place = np.unravel_index(int(np.nanargmax(correlation)), correlation.shape)
    y, x = (int(i - n if i > n // 2 else i) for i, n in zip(place, correlation.shape, strict=True))
    return (y, x), float(correlation[place])


def _slopes(field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.diff(field, axis=1)[:-1], np.diff(field, axis=0)[:, :-1]


def _masked_moments(fixed: np.ndarray, moved: np.ndarray, least_overlap: float) -> Any:
    """Sums of the product and of the squares, less their means, where both are known."""
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

"""Misaligned walls: one tilted against the other, or rotated about the normal of the joint.

A synthetic wall is a sum of waves, which can be evaluated at any point and not only at the cells. A
rotated wall is this sum at the rotated points, so that no interpolation damps any wave.
"""

import numpy as np
import scipy.fft

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.roughness import detrended, rms_slope
from jointclosure.walls.synthesis import Spectrum, gaussian_field


def tilted(wall: np.ndarray, spacing: float, degrees: float) -> np.ndarray:
    """Tilt a wall (y, x) [m] about the middle axis along y in its mean plane.

    Heights increase by x tan(degrees). The displacement of cells by the cosine is neglected (4e-5
    at 0.5 degrees).
    """
    nx = wall.shape[1]
    x = spacing * (np.arange(nx) - 0.5 * (nx - 1))
    return wall + np.tan(np.deg2rad(degrees)) * x


def rotated_pair(
    z2: float,
    shape: tuple[int, int],
    spacing: float,
    spectrum: Spectrum,
    seed: int,
    mismatch_wavelength: float = np.inf,
    rotation: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Make the two walls of a joint whose lower wall is rotated about the normal.

    Parameters
    ----------
    z2 : float
        RMS slope of both walls pooled, after the rotation.
    shape : (n, n)
        Cells.
    spacing : float
        Grid spacing [m].
    seed : int
        Not negative. Waves are those of `jointclosure.wall_pair` with the same seed.
    mismatch_wavelength : float
        Longer waves [m] are common to both walls before the rotation; infinite for independent
        walls.
    rotation : float
        Degrees, about the middle of the wall, anticlockwise.

    Returns
    -------
    upper, lower : array (n, n)
        Heights towards the other wall [m], each plane-detrended.

    Raises
    ------
    InputError
        If the grid is not square: a rotated wall would need the waves of another grid.

    Notes
    -----
    At multiples of 90 degrees cells map to cells. At other angles the waves in the corners of
    the square of wave numbers are shorter than two spacings along x or y after the rotation, and
    are aliased to longer waves. Heights at other angles may differ in their last digits between
    processors, because the waves are summed by the matrix product of the installed BLAS.
    """
    n = shape[0]
    if shape[1] != n:
        raise InputError(f"shape = {tuple(shape)!r}: a wall is rotated on a square grid only")
    size = (2 * n, 2 * n)
    upper, other = (
        scipy.fft.rfft2(
            gaussian_field(size, spectrum, generator(seed_of(seed, side)), oversize=1), workers=1
        )
        for side in ("upper", "lower")
    )
    waves = np.hypot(*_wave_numbers(2 * n))
    lower = np.where(waves < spacing / mismatch_wavelength, -upper, other)
    pair = [
        detrended(field)
        for field in (
            scipy.fft.irfft2(upper, s=size, workers=1)[:n, :n],
            _at_rotated_points(lower, n, rotation),
        )
    ]
    slope = np.sqrt(np.mean([rms_slope(wall, spacing) ** 2 for wall in pair]))
    return pair[0] * (z2 / slope), pair[1] * (z2 / slope)


def _wave_numbers(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return wave numbers in cycles per cell along y (n, 1) and x (1, n // 2 + 1)."""
    return scipy.fft.fftfreq(n)[:, None], scipy.fft.rfftfreq(n)[None, :]


def _at_rotated_points(waves: np.ndarray, n: int, degrees: float) -> np.ndarray:
    """Sum waves of `scipy.fft.rfft2` on twice as many cells at n by n rotated points."""
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    middle = 0.5 * (n - 1)
    about = np.arange(n) - middle
    wave_y, wave_x = _wave_numbers(2 * n)
    # waves of a real field with negative wave numbers along x are mirror images and not stored
    twice = np.where((wave_x > 0.0) & (wave_x < 0.5), 2.0, 1.0)
    weighted = (waves * twice).T / (2 * n) ** 2
    # rotated point: (middle + cosine x + sine y, middle - sine x + cosine y)
    of_x = _phases(cosine * about, wave_x), _phases(-sine * about, wave_y.T)
    of_y = _phases(middle + sine * about, wave_x), _phases(middle + cosine * about, wave_y.T)
    rows = []
    for along_x, along_y in zip(*of_y, strict=True):
        summed = of_x[0] @ (along_x[:, None] * weighted)
        rows.append(np.sum(summed * of_x[1] * along_y, axis=1).real)
    return np.stack(rows)


def _phases(places: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """Return exp(2 pi i f x) for places x [cells] (n,) and wave numbers f (1, waves)."""
    return np.exp(2j * np.pi * places[:, None] * waves)

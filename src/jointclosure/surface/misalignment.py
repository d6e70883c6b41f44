"""Walls out of alignment: one tilted against the other, or rotated about the joint's normal.

A synthetic wall is a sum of waves, which is known everywhere and not at the cells alone. So a
rotated wall is that sum at the rotated points: nothing is interpolated, and no wave is damped.
"""

import numpy as np
import scipy.fft

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.surface.roughness import detrended, rms_slope
from jointclosure.surface.synthesis import Spectrum, gaussian_field


def tilted(wall: np.ndarray, spacing: float, degrees: float) -> np.ndarray:
    """A wall (y, x) [m] tilted about the axis in its mean plane along y, through its middle.

    Heights gain x tan(degrees); that cells move by its cosine is left out (4e-5 at 0.5 degrees).
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
    """Upper and lower wall of a joint whose lower wall is rotated about the normal.

    Parameters
    ----------
    z2 : float
        RMS slope of both walls pooled, rotated as they are.
    shape : (n, n)
        Cells.
    spacing : float
        Grid spacing [m].
    spectrum : Spectrum
    seed : int
        Not negative. Waves are those of `jointclosure.wall_pair` of the same seed.
    mismatch_wavelength : float
        Waves longer than this [m] mate before the rotation; infinite: independent walls.
    rotation : float
        Degrees, about the middle of the wall, anticlockwise.

    Returns
    -------
    upper, lower : array (n, n)
        Heights towards the other wall [m], each plane-detrended.

    Raises
    ------
    InputError
        A grid that is not square: a rotated wall would need waves of another grid.

    Notes
    -----
    By multiples of 90 degrees cells fall on cells. At other angles the waves of the corners of
    the grid's square of wave numbers, shorter than two spacings along x or y after the rotation,
    are sampled as longer ones.
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
    own = np.sqrt(np.mean([rms_slope(wall, spacing) ** 2 for wall in pair]))
    return pair[0] * (z2 / own), pair[1] * (z2 / own)


def _wave_numbers(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Cycles per cell along y (n, 1) and x (1, n // 2 + 1)."""
    return scipy.fft.fftfreq(n)[:, None], scipy.fft.rfftfreq(n)[None, :]


def _at_rotated_points(waves: np.ndarray, n: int, degrees: float) -> np.ndarray:
    """Sum of waves, as of `scipy.fft.rfft2` on twice as many cells, at n by n rotated points."""
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    middle = 0.5 * (n - 1)
    about = np.arange(n) - middle
    wave_y, wave_x = _wave_numbers(2 * n)
    # of a real field the waves of negative wave numbers along x are left out, but for their mirror
    twice = np.where((wave_x > 0.0) & (wave_x < 0.5), 2.0, 1.0)
    weighted = (waves * twice).T / (2 * n) ** 2
    # a point is at (middle + cosine x + sine y, middle - sine x + cosine y)
    of_x = _phases(cosine * about, wave_x), _phases(-sine * about, wave_y.T)
    of_y = _phases(middle + sine * about, wave_x), _phases(middle + cosine * about, wave_y.T)
    rows = []
    for along_x, along_y in zip(*of_y, strict=True):
        summed = of_x[0] @ (along_x[:, None] * weighted)
        rows.append(np.sum(summed * of_x[1] * along_y, axis=1).real)
    return np.stack(rows)


def _phases(places: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """exp(2 pi i f x) of places x [cells] (n,) and wave numbers f (1, waves)."""
    return np.exp(2j * np.pi * places[:, None] * waves)

"""Random walls of given JRC: a declared reconstruction.

The compound algorithm of Rezaei Niya & Selvadurai (2019) is not described in
the paper. Ours is a self-affine Gaussian field, scaled to the RMS slope that
a published relation gives for the JRC: docs/decisions/0007-surfaces.md.
"""

import math
from functools import lru_cache

import numpy as np
import scipy.fft

from jointclosure.inputs import InputError, check_number
from jointclosure.randomness import generator, seed_of
from jointclosure.surface.roughness import DEFAULT_RELATION, detrended, rms_slope, z2_of_jrc


def self_affine_field(
    shape: tuple[int, int],
    hurst: float,
    random: np.random.Generator,
    oversize: int = 2,
) -> np.ndarray:
    """Self-affine Gaussian heights (y, x) of arbitrary scale.

    Spectral synthesis (power spectrum ~ k^(-2 (H + 1))) on a periodic grid
    ``oversize`` times as long, of which a corner is cropped, so that opposite
    edges are not neighbours.
    """
    ny, nx = (oversize * max(n, 2) for n in shape)
    noise = scipy.fft.rfft2(random.standard_normal((ny, nx)), workers=1)
    field = scipy.fft.irfft2(noise * _amplitudes(ny, nx, hurst), s=(ny, nx), workers=1)
    return field[: shape[0], : shape[1]]


@lru_cache(maxsize=8)
def _amplitudes(ny: int, nx: int, hurst: float) -> np.ndarray:
    """k^-(H + 1) of the waves (ny, nx // 2 + 1) of a real transform, 0 for the mean."""
    wave_y = scipy.fft.fftfreq(ny)[:, None]
    wave_x = scipy.fft.rfftfreq(nx)[None, :]
    square = wave_y * wave_y + wave_x * wave_x
    square[0, 0] = 1.0
    amplitudes = power(square, -0.5 * (hurst + 1.0))
    amplitudes[0, 0] = 0.0
    amplitudes.flags.writeable = False
    return amplitudes


def power(base: np.ndarray, exponent: float) -> np.ndarray:
    """A positive array to a power, to the same bits on any processor.

    `numpy.power` is another function on processors with other vector units, which differ
    in the last digit; breakage makes another history of that digit. This one has
    additions, multiplications and divisions only: log by the series of 2 atanh((m - 1)/(m + 1)),
    exp by Taylor's; right to some 5e-15.
    """
    mantissa, two = np.frexp(base)
    small = mantissa < np.sqrt(0.5)
    mantissa = np.where(small, 2.0 * mantissa, mantissa)
    two = two - small
    s = (mantissa - 1.0) / (mantissa + 1.0)
    logarithm = np.zeros_like(s)
    for odd in range(25, 0, -2):
        logarithm = logarithm * (s * s) + 2.0 / odd
    # base^exponent = 2^whole times e^rest
    twos = exponent * (two + logarithm * s / _LN2)
    whole = np.rint(twos)
    rest = (twos - whole) * _LN2
    answer = np.ones_like(rest)
    for order in range(18, 0, -1):
        answer = 1.0 + answer * rest / order
    return np.ldexp(answer, whole.astype(int))


_LN2 = 0.6931471805599453


def synthetic_wall(
    z2: float,
    shape: tuple[int, int],
    spacing: float,
    hurst: float,
    random: np.random.Generator,
    normalise: str = "wall",
) -> np.ndarray:
    """One wall (y, x) of given RMS slope, plane-detrended [m].

    Parameters
    ----------
    z2 : float
        RMS slope at the grid spacing.
    shape : (ny, nx)
        Cells.
    spacing : float
        Grid spacing [m].
    hurst : float
        Hurst exponent in (0, 1].
    random : Generator
        Drawn from once.
    normalise : {"wall", "expectation"}
        Whether every wall has exactly this Z2, or walls have it on average:
        then all are scaled by the RMS slope that the spectrum has itself.
    """
    field = detrended(self_affine_field(shape, hurst, random))
    if normalise == "wall":
        return field * (z2 / rms_slope(field, spacing))
    if normalise == "expectation":
        return field * (z2 / _expected_rms_slope(shape, hurst, spacing))
    raise InputError(f"normalise = {normalise!r}: must be one of wall, expectation")


def wall_pair(
    jrc: float,
    shape: tuple[int, int],
    spacing: float,
    seed: int,
    hurst: float = 0.8,
    *,
    jrc_relation: str = DEFAULT_RELATION,
    normalise: str = "wall",
    correlation: float = 0.0,
    shift_in_cells: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Upper and lower wall of a joint, heights towards the other wall.

    Parameters
    ----------
    jrc : float
        Joint roughness coefficient of both walls.
    shape : (ny, nx)
        Cells.
    spacing : float
        Grid spacing h [m].
    seed : int
        Not negative; the same seed gives the same walls.
    hurst : float
        Hurst exponent H in (0, 1].
    jrc_relation : str
        Key of `jointclosure.surface.roughness.RELATIONS`.
    normalise : {"wall", "expectation"}
        See `synthetic_wall`.
    correlation : float
        Of the lower wall with the negative of the upper one, in [0, 1]: 0 are
        independent walls (the paper's), 1 mated ones.
    shift_in_cells : int
        Shift of the mated part along x, at least 0.

    Returns
    -------
    upper, lower : array (ny, nx)
        Heights [m], each plane-detrended.

    Raises
    ------
    InputError
        An argument out of its range.
    """
    for name, value in (
        ("jrc", jrc),
        ("spacing", spacing),
        ("hurst", hurst),
        ("correlation", correlation),
    ):
        check_number(name, value)
    check_number("seed", seed, whole=True)
    check_number("shift_in_cells", shift_in_cells, whole=True)
    _check(shape, spacing, hurst, correlation, shift_in_cells)
    jrc, spacing, hurst, correlation = (float(v) for v in (jrc, spacing, hurst, correlation))
    z2 = z2_of_jrc(jrc, spacing, hurst, jrc_relation)
    ny, nx = shape
    wide = (ny, nx + shift_in_cells)
    upper = synthetic_wall(z2, wide, spacing, hurst, generator(seed_of(seed, "upper")), normalise)
    lower = synthetic_wall(z2, wide, spacing, hurst, generator(seed_of(seed, "lower")), normalise)
    mated = -correlation * np.roll(upper, shift_in_cells, axis=1)
    lower = mated + np.sqrt(1.0 - correlation**2) * lower
    pair = []
    for wall in (upper, lower):
        cropped = detrended(wall[:, shift_in_cells:]) if shift_in_cells else wall
        if normalise == "wall" and (shift_in_cells or correlation):
            cropped = cropped * (z2 / rms_slope(cropped, spacing))
        pair.append(np.ascontiguousarray(cropped))
    return pair[0], pair[1]


def _check(shape, spacing, hurst, correlation, shift_in_cells) -> None:
    if not isinstance(shape, tuple | list) or len(shape) != 2:
        raise InputError(f"shape = {shape!r}: must be (cells along y, cells along x)")
    for size in shape:
        check_number("shape", size, whole=True)
    if min(shape) < 1 or max(shape) < 3:
        raise InputError(f"shape = {tuple(shape)!r}: needs two sizes, the longer at least 3 cells")
    if not 0.0 < spacing < np.inf:
        raise InputError(f"spacing = {spacing!r} m: must be positive and finite")
    if not 0.0 < hurst <= 1.0:
        raise InputError(f"hurst = {hurst!r}: must lie in (0, 1]")
    if not 0.0 <= correlation <= 1.0:
        raise InputError(f"correlation = {correlation!r}: must lie in [0, 1]")
    if shift_in_cells < 0:
        raise InputError(f"shift_in_cells = {shift_in_cells!r}: must be a whole number from 0 on")


def _expected_rms_slope(shape: tuple[int, int], hurst: float, spacing: float) -> float:
    """RMS slope of `self_affine_field` over all its draws, from its spectrum."""
    ny, nx = (2 * max(n, 2) for n in shape)
    wave_y = scipy.fft.fftfreq(ny)[:, None]
    wave_x = scipy.fft.fftfreq(nx)[None, :]
    square = wave_y * wave_y + wave_x * wave_x
    square[0, 0] = 1.0
    spectrum = power(square, -(hurst + 1.0)) / (ny * nx)
    spectrum[0, 0] = 0.0
    directions = [
        4.0 * np.vectorize(math.sin)(np.pi * frequency) ** 2
        for frequency, cells in ((wave_y, shape[0]), (wave_x, shape[1]))
        if cells > 1
    ]
    weights = [(n0 - 1) * n1 for n0, n1 in (shape, shape[::-1]) if n0 > 1]
    mean_squares = [float(np.sum(spectrum * factor)) for factor in directions]
    return float(np.sqrt(np.average(mean_squares, weights=weights))) / spacing

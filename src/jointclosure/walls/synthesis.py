"""Random walls of given JRC: self-affine Gaussian fields scaled to its RMS slope."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft

from jointclosure.inputs import InputError, check_count, check_length, check_number, check_one_of
from jointclosure.parameters import AS_IT_IS, check_usual
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls import Walls
from jointclosure.walls.jrc import DEFAULT_RELATION, rms_slope, z2_of_jrc
from jointclosure.walls.planes import detrended

RULES = ("self_affine", "walk")  # relations between the long and the short waves of a wall
NORMALISATIONS = ("wall", "expectation")  # the slope is that of every wall, or of the average
ROLL_OFF = 3e-3  # wavelength [m] beyond which spectra are flat (docs/decisions.md#0013-readings)
_LN2 = 0.6931471805599453  # natural logarithm of 2


class Spectrum(NamedTuple):
    """Power spectrum of heights: k^(-2 (H + 1)), or a "walk"; flat beyond ``roll_off`` [cells]."""

    hurst: float
    rule: str = "self_affine"
    roll_off: float | None = None

    @property
    def exponent(self) -> float:
        """Exponent of the squared wave number in the power."""
        return -1.0 if self.rule == "walk" else -(self.hurst + 1.0)

    def squares(self, ny: int, wave_x: np.ndarray) -> np.ndarray:
        """Return squared wave numbers (ny, waves along x) [1/cell^2], bounded by the roll-off.

        That of the mean is set to 1. For a walk they are those of differences, |d|^2 =
        4 sin^2(pi f), over (2 pi)^2: the heights that minimise sum (d_x z - g_x)^2 + (d_y z -
        g_y)^2 for white slopes g have the power 1/(|d_x|^2 + |d_y|^2).
        """
        wave_y = scipy.fft.fftfreq(ny)[:, None]
        wave_x = wave_x[None, :]
        if self.rule == "walk":
            wave_y, wave_x = (_sines(wave) / np.pi for wave in (wave_y, wave_x))
        square = wave_y * wave_y + wave_x * wave_x
        square[0, 0] = 1.0
        if self.roll_off is not None:
            square = np.maximum(square, 1.0 / (self.roll_off * self.roll_off))
        return square


def gaussian_field(
    shape: tuple[int, int], spectrum: Spectrum, random: np.random.Generator, oversize: int = 2
) -> np.ndarray:
    """Return Gaussian heights (y, x) of a spectrum.

    They are the corner of a periodic grid with sides ``oversize`` times as long.
    """
    ny, nx = (oversize * max(n, 2) for n in shape)
    waves = _random_waves((ny, nx), spectrum, random)
    return scipy.fft.irfft2(waves, s=(ny, nx), workers=1)[: shape[0], : shape[1]]


def _random_waves(
    size: tuple[int, int], spectrum: Spectrum, random: np.random.Generator
) -> np.ndarray:
    """Return Fourier coefficients of Gaussian heights on a periodic grid, as `scipy.fft.rfft2`."""
    noise = scipy.fft.rfft2(random.standard_normal(size), workers=1)
    return noise * _amplitudes(*size, spectrum)


@lru_cache(maxsize=8)
def _amplitudes(ny: int, nx: int, spectrum: Spectrum) -> np.ndarray:
    """Return amplitudes of the waves (ny, nx // 2 + 1) of a real transform, 0 for the mean."""
    squares = spectrum.squares(ny, scipy.fft.rfftfreq(nx))
    amplitudes = power(squares, 0.5 * spectrum.exponent)
    amplitudes[0, 0] = 0.0
    amplitudes.flags.writeable = False
    return amplitudes


def wave_numbers(ny: int, nx: int) -> tuple[np.ndarray, np.ndarray]:
    """Return wave numbers of `scipy.fft.rfft2` [1/cell], along y (ny, 1) and along x (1, waves)."""
    return scipy.fft.fftfreq(ny)[:, None], scipy.fft.rfftfreq(nx)[None, :]


def _sines(wave: np.ndarray) -> np.ndarray:
    """Return sin(pi f) of wave numbers f, with the same bits on any processor, as `power`."""
    return np.vectorize(math.sin)(np.pi * wave)


def power(base: np.ndarray, exponent: float) -> np.ndarray:
    """Raise a positive array to a power with the same bits on any processor, unlike `numpy.power`.

    Log is the series of 2 atanh((m - 1)/(m + 1)), exp that of Taylor: relative error 5e-15.
    """
    mantissa, two = np.frexp(base)
    small = mantissa < np.sqrt(0.5)
    mantissa = np.where(small, 2.0 * mantissa, mantissa)
    two = two - small
    s = (mantissa - 1.0) / (mantissa + 1.0)
    logarithm = np.zeros_like(s)
    for odd in range(25, 0, -2):
        logarithm = logarithm * (s * s) + 2.0 / odd
    # base^exponent = 2^whole * e^rest
    twos = exponent * (two + logarithm * s / _LN2)
    whole = np.rint(twos)
    rest = (twos - whole) * _LN2
    answer = np.ones_like(rest)
    for order in range(18, 0, -1):
        answer = 1.0 + answer * rest / order
    return np.ldexp(answer, whole.astype(int))


def synthetic_wall(
    z2: float,
    shape: tuple[int, int],
    spacing: float,
    spectrum: Spectrum,
    random: np.random.Generator,
    normalise: str = "wall",
) -> np.ndarray:
    """Generate one wall (y, x) [m] of RMS slope ``z2``, detrended; ``normalise`` as `wall_pair`."""
    field = detrended(gaussian_field(shape, spectrum, random))
    if normalise == "wall":
        return field * (z2 / rms_slope(field, spacing))
    return field * (z2 / _expected_rms_slope(shape, spectrum, spacing))


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
    mismatch_wavelength: float | None = None,
    rule: str = "self_affine",
    roll_off: float | None = ROLL_OFF,
    unusual_values: bool = False,
) -> Walls:
    """Generate random upper and lower walls of a joint for a JRC.

    The heights of each wall are positive towards the other wall.

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
        Key of `jointclosure.walls.jrc.RELATIONS`.
    normalise : {"wall", "expectation"}
        Whether every wall has exactly the Z2 of its JRC, or walls have it on average.
    correlation : float
        Correlation of the lower wall with the negative of the upper one, in [0, 1]: 0 for
        independent walls (as in the paper), 1 for mated walls.
    shift_in_cells : int
        Shift of the common part along x, at least 0.
    mismatch_wavelength : float, optional
        Wavelength [m] from which waves are common to both walls, while shorter ones are independent
        (Brown 1995); 0 for mated walls. It is the sharp limit of Glover et al. (1998), and needs a
        ``correlation`` of 0. Each wall has the spectrum of independent walls; with ``normalise``
        "wall" one factor scales both, so that their pooled slopes have the Z2 of the JRC.
    rule : {"self_affine", "walk"}
        "self_affine": profiles have the Hurst exponent. "walk": independent slopes, projected on
        the nearest heights (`Spectrum`); ``hurst`` then only carries Z2 to the spacing.
    roll_off : float, optional
        Wavelength [m] beyond which the spectrum is flat; None for no limit. The default is for
        the paper's study (docs/decisions.md#0013-readings): 3 mm, or two spacings if these are
        longer. Natural walls have waves of all lengths. Use None for them, as `jointclosure.fit`
        does.
    unusual_values : bool
        Whether wavelengths that are unusual for rock are accepted, see `jointclosure.Conditions`.

    Returns
    -------
    upper, lower : array (ny, nx)
        Heights [m], each plane-detrended.

    Raises
    ------
    InputError
        If an argument is out of its range.
    """
    check_number("jrc", jrc)
    check_length("spacing", spacing)
    check_count("seed", seed, 0)
    check_one_of("normalise", normalise, NORMALISATIONS)
    _check_wall_arguments(shape, hurst, correlation, shift_in_cells)
    check_mismatch(mismatch_wavelength, correlation)
    if not unusual_values:
        lengths = {"roll_off": roll_off, "mismatch_wavelength": mismatch_wavelength}
        check_usual((), spacing=spacing, **lengths)
        check_roll_off(roll_off, max(shape) * spacing)
    jrc, spacing, hurst, correlation = (float(v) for v in (jrc, spacing, hurst, correlation))
    z2 = z2_of_jrc(jrc, spacing, hurst, jrc_relation)
    wide = (shape[0], shape[1] + shift_in_cells)
    roll_off = max(roll_off, 2.0 * spacing) if roll_off == ROLL_OFF else roll_off
    spectrum = spectrum_of(hurst, rule, roll_off, spacing)
    if mismatch_wavelength is not None:
        longest = float(mismatch_wavelength) / spacing
        pair = _partly_mated(wide, spectrum, longest, seed, shift_in_cells)
        expected = None if normalise == "wall" else _expected_rms_slope(wide, spectrum, spacing)
        return scaled_together(*pair, z2, spacing, expected)
    upper, lower = (
        synthetic_wall(z2, wide, spacing, spectrum, random, normalise)
        for random in generators(seed)
    )
    mated = -correlation * np.roll(upper, shift_in_cells, axis=1)
    lower = mated + np.sqrt(1.0 - correlation**2) * lower
    walls = []
    for wall in (upper, lower):
        cropped = detrended(wall[:, shift_in_cells:]) if shift_in_cells else wall
        if normalise == "wall" and (shift_in_cells or correlation):
            cropped = cropped * (z2 / rms_slope(cropped, spacing))
        walls.append(np.ascontiguousarray(cropped))
    return walls[0], walls[1]


def generators(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Return the random generators of the upper and of the lower wall."""
    return generator(seed_of(seed, "upper")), generator(seed_of(seed, "lower"))


def scaled_together(
    upper: np.ndarray, lower: np.ndarray, z2: float, spacing: float, slope: float | None = None
) -> Walls:
    """Return two walls (y, x) [m] scaled by one factor to an RMS slope ``z2``.

    ``slope`` is the RMS slope that they count as having before, by default that of both walls
    together. It may be the slope that is expected of such walls, which then have ``z2`` only in the
    mean. ``spacing`` is that of the grid [m].
    """
    if slope is None:
        slope = np.sqrt(np.mean([rms_slope(wall, spacing) ** 2 for wall in (upper, lower)]))
    return upper * (z2 / slope), lower * (z2 / slope)


def _partly_mated(
    wide: tuple[int, int], spectrum: Spectrum, wavelength: float, seed: int, shift: int
) -> Walls:
    """Generate walls (y, x) [cells] whose waves beyond a wavelength [cells] are common, others not.

    The upper wall is shifted along x by some cells.
    """
    size = (2 * max(wide[0], 2), 2 * max(wide[1], 2))
    upper, other = (_random_waves(size, spectrum, random) for random in generators(seed))
    lower = np.where(np.hypot(*wave_numbers(*size)) * wavelength < 1.0, -upper, other)
    upper, lower = (scipy.fft.irfft2(waves, s=size, workers=1) for waves in (upper, lower))
    rows = slice(wide[0])
    cells = wide[1] - shift
    return detrended(upper[rows, shift : shift + cells]), detrended(lower[rows, :cells])


def check_roll_off(roll_off: float | None, length: float) -> None:
    """Raise `InputError` if a roll-off, other than the usual one, exceeds the walls [m]."""
    if roll_off is not None and roll_off > max(length, ROLL_OFF):
        raise InputError(
            f"roll_off = {roll_off!r} m: must be at most the longer side of the walls, "
            f"{length:.3g} m (is it in m?), or None for waves of all lengths; {AS_IT_IS}"
        )


def check_mismatch(wavelength: float | None, correlation: float) -> None:
    """Raise `InputError` for an invalid mismatch wavelength [m], or one with a correlation."""
    if wavelength is None:
        return
    check_number("mismatch_wavelength", wavelength)
    if not 0.0 <= wavelength < np.inf:
        raise InputError(f"mismatch_wavelength = {wavelength!r} m: must be finite, 0 or above")
    if correlation != 0.0:
        must = "must be 0 if mismatch_wavelength is given"
        raise InputError(f"correlation = {correlation!r}: {must}")


def _check_wall_arguments(
    shape: tuple[int, int], hurst: float, correlation: float, shift_in_cells: int
) -> None:
    """Raise `InputError` if an argument of `wall_pair` is out of its range."""
    check_number("hurst", hurst)
    check_number("correlation", correlation)
    check_count("shift_in_cells", shift_in_cells, 0)
    if not isinstance(shape, tuple | list) or len(shape) != 2:
        raise InputError(f"shape = {shape!r}: must be (cells along y, cells along x)")
    for size in shape:
        check_number("shape", size, whole=True)
    if min(shape) < 1 or max(shape) < 3:
        raise InputError(f"shape = {tuple(shape)!r}: needs two sizes, the longer at least 3 cells")
    if not 0.0 < hurst <= 1.0:
        raise InputError(f"hurst = {hurst!r}: must lie in (0, 1]")
    if not 0.0 <= correlation <= 1.0:
        raise InputError(f"correlation = {correlation!r}: must lie in [0, 1]")


def spectrum_of(hurst: float, rule: str, roll_off: float | None, spacing: float) -> Spectrum:
    """Return the spectrum of a wall's settings; raise `InputError` if one is not allowed."""
    check_one_of("rule", rule, RULES)
    if roll_off is None:
        return Spectrum(hurst, rule)
    check_length("roll_off", roll_off)
    if roll_off < 2.0 * spacing:
        raise InputError(
            f"roll_off = {roll_off!r} m with spacing = {spacing!r} m: must be at least two "
            "spacings, the shortest wavelength of the grid (or None: no roll-off)"
        )
    return Spectrum(hurst, rule, float(roll_off) / spacing)


def _expected_rms_slope(shape: tuple[int, int], spectrum: Spectrum, spacing: float) -> float:
    """Return the expected RMS slope of `gaussian_field`, from its spectrum."""
    ny, nx = (2 * max(n, 2) for n in shape)
    wave_y = scipy.fft.fftfreq(ny)[:, None]
    wave_x = scipy.fft.fftfreq(nx)[None, :]
    powers = power(spectrum.squares(ny, wave_x[0]), spectrum.exponent) / (ny * nx)
    powers[0, 0] = 0.0
    slopes = [
        (float(np.sum(powers * (4.0 * _sines(wave) ** 2))), (n - 1) * across)
        for wave, n, across in ((wave_y, *shape), (wave_x, *shape[::-1]))
        if n > 1
    ]
    mean_squares, weights = np.transpose(slopes)
    return float(np.sqrt(np.average(mean_squares, weights=weights))) / spacing

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

RULES = ("self_affine", "walk")  # spectra of walls, see `wall_pair`
NORMALISATIONS = ("wall", "expectation")  # whether each wall has the RMS slope, or walls on average
ROLL_OFF = 3e-3  # wavelength [m] beyond which spectra are flat (docs/decisions.md#0013-readings)
_LN2 = 0.6931471805599453  # natural logarithm of 2


class Spectrum(NamedTuple):
    """Power spectrum of the heights of synthetic walls, of any scale.

    With the ``rule`` "self_affine" the power at wave number k [1/cell] is k^(-2 (H + 1)), with the
    exponent H ``hurst``. With the rule "walk" it is that of heights fitted to independent random
    slopes (see `squares`), and ``hurst`` is not used. It is constant at wavelengths beyond
    ``roll_off`` [cells], unless that is None. Nothing is checked.
    """

    hurst: float
    rule: str = "self_affine"
    roll_off: float | None = None

    @property
    def exponent(self) -> float:
        """Exponent of the squared wave number in the power."""
        return -1.0 if self.rule == "walk" else -(self.hurst + 1.0)

    def squares(self, ny: int, wave_x: np.ndarray) -> np.ndarray:
        """Return the squared wave numbers (ny, nx) [1/cell^2] of the waves of a periodic grid.

        ``wave_x`` (nx,) are the wave numbers [1/cell] along x. Squares are not below that of the
        roll-off. The square of the mean, which has no wave number, is set to 1. For a walk squares
        are replaced by the squared factors |d|^2 = 4 sin^2(pi f) of height differences, over (2
        pi)^2: the heights z that minimise sum (d_x z - g_x)^2 + (d_y z - g_y)^2 for white slopes g
        have the power 1/(|d_x|^2 + |d_y|^2).
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
    """Return random Gaussian heights (y, x) with a spectrum, on an arbitrary scale.

    They are cut from a corner of a periodic grid, whose sides are ``oversize`` times as long.
    """
    ny, nx = (oversize * max(n, 2) for n in shape)
    waves = _random_waves((ny, nx), spectrum, random)
    return scipy.fft.irfft2(waves, s=(ny, nx), workers=1)[: shape[0], : shape[1]]


def _random_waves(
    size: tuple[int, int], spectrum: Spectrum, random: np.random.Generator
) -> np.ndarray:
    """Return random Fourier coefficients of Gaussian heights on a periodic grid of ``size`` (y, x).

    They are arranged as by `scipy.fft.rfft2`.
    """
    noise = scipy.fft.rfft2(random.standard_normal(size), workers=1)
    return noise * _amplitudes(*size, spectrum)


@lru_cache(maxsize=8)
def _amplitudes(ny: int, nx: int, spectrum: Spectrum) -> np.ndarray:
    """Return the amplitudes (ny, nx // 2 + 1) of the waves of a spectrum; that of the mean is 0.

    They are arranged as by `scipy.fft.rfft2`, and cannot be written to, as they are kept.
    """
    squares = spectrum.squares(ny, scipy.fft.rfftfreq(nx))
    amplitudes = power(squares, 0.5 * spectrum.exponent)
    amplitudes[0, 0] = 0.0
    amplitudes.flags.writeable = False
    return amplitudes


def wave_numbers(ny: int, nx: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the wave numbers [1/cell] of a grid along y (ny, 1) and along x (1, nx // 2 + 1).

    They are those of the coefficients of `scipy.fft.rfft2`.
    """
    return scipy.fft.fftfreq(ny)[:, None], scipy.fft.rfftfreq(nx)[None, :]


def _sines(wave: np.ndarray) -> np.ndarray:
    """Return sin(pi f) of wave numbers f [1/cell], with the same bits on any processor."""
    return np.vectorize(math.sin)(np.pi * wave)


def power(base: np.ndarray, exponent: float) -> np.ndarray:
    """Raise the numbers of a positive array to a power, with the same bits on any processor.

    `numpy.power` does not have the same bits. The logarithm is the series of 2 atanh((m - 1)/(m +
    1)) with the mantissa m, the exponential is the Taylor series; the relative error is 5e-15.
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
    """Return a random wall (y, x) [m] less its plane, with the RMS slope ``z2`` at a spacing [m].

    By ``normalise`` "wall" it has this slope exactly, by "expectation" such walls have it on
    average.
    """
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
    """Return the random generators of the upper and of the lower wall of a seed."""
    return generator(seed_of(seed, "upper")), generator(seed_of(seed, "lower"))


def scaled_together(
    upper: np.ndarray, lower: np.ndarray, z2: float, spacing: float, slope: float | None = None
) -> Walls:
    """Return two walls (y, x) [m] multiplied by the same factor, ``z2`` over ``slope``.

    By default ``slope`` is the RMS slope of both walls together at the ``spacing`` [m], so that
    they then have the RMS slope ``z2``. If it is the expected slope of such walls, they have ``z2``
    on average only.
    """
    if slope is None:
        slope = np.sqrt(np.mean([rms_slope(wall, spacing) ** 2 for wall in (upper, lower)]))
    return upper * (z2 / slope), lower * (z2 / slope)


def _partly_mated(
    wide: tuple[int, int], spectrum: Spectrum, wavelength: float, seed: int, shift: int
) -> Walls:
    """Return walls, each less its plane, that have their waves beyond a ``wavelength`` in common.

    Shorter waves are independent. ``wide`` (y, x) are the cells of the walls before they are cut:
    the upper wall is shifted along x by ``shift`` cells, which both walls lose. The wavelength is
    in cells, and the scale of heights is arbitrary.
    """
    size = (2 * max(wide[0], 2), 2 * max(wide[1], 2))
    upper, other = (_random_waves(size, spectrum, random) for random in generators(seed))
    lower = np.where(np.hypot(*wave_numbers(*size)) * wavelength < 1.0, -upper, other)
    upper, lower = (scipy.fft.irfft2(waves, s=size, workers=1) for waves in (upper, lower))
    rows = slice(wide[0])
    cells = wide[1] - shift
    return detrended(upper[rows, shift : shift + cells]), detrended(lower[rows, :cells])


def check_roll_off(roll_off: float | None, length: float) -> None:
    """Raise `InputError` if a roll-off [m] exceeds both the walls' length [m] and `ROLL_OFF`."""
    if roll_off is not None and roll_off > max(length, ROLL_OFF):
        raise InputError(
            f"roll_off = {roll_off!r} m: must be at most the longer side of the walls, "
            f"{length:.3g} m (is it in m?), or None for waves of all lengths; {AS_IT_IS}"
        )


def check_mismatch(wavelength: float | None, correlation: float) -> None:
    """Raise `InputError` for an invalid mismatch wavelength [m], or one beside a correlation.

    None, for no mismatch wavelength, is allowed.
    """
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
    """Return the spectrum of synthetic walls with a Hurst exponent, a rule and a roll-off [m].

    Raise `InputError` for an unknown rule, or a roll-off below two spacings [m].
    """
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
    """Return the expected RMS slope, at a spacing [m], of `gaussian_field` taken as metres."""
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

"""Quality of a scan: rounding, short waves that it lacks, and noise, measured once and remarked on.

`quality_of` measures a scan, and `quality_remarks` says what of the quality matters on a grid.
"""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.inputs.remarks import Caution, caution
from jointclosure.walls.gridding import Cloud, Scan, point_distance
from jointclosure.walls.jrc import DEFAULT_RELATION, RELATIONS
from jointclosure.walls.rounding import Rounding, rounding_of, step_of
from jointclosure.walls.scan_noise import noise_of_grid, noise_of_points
from jointclosure.walls.short_waves import shortest_wave
from jointclosure.walls.spectrum_end import SpectrumEnd, spectrum_end

MOVED = 0.02  # relative change of the rms slope from which an error of heights is a warning


class ScanQuality(NamedTuple):
    """What limits the heights of one scan, measured before the scan is turned or interpolated."""

    scattered: bool  # whether the scan is a `Cloud`
    point_distance: float  # [m] between neighbouring points
    rounding: Rounding  # steps [m] of heights and places
    shortest_wave: float  # [m] at which half of the power is lost; 0 if none is, or without a grid
    spectrum_end: SpectrumEnd | None  # of a `Scan` that lost no waves, if it has one
    noise: tuple[float, float]
    """Ends [m] of the 95 % interval of the standard deviation of white noise. NaN if not known: of
    a filtered or small grid, and of a `Cloud` whose close points show no noise."""


def quality_of(scan: Scan | Cloud, level: Scan | Cloud | None = None) -> ScanQuality:
    """Measure the quality of a scan.

    Parameters
    ----------
    scan : Scan or Cloud
        In metres, before levelling: levelling interpolates the heights of a grid, and so takes
        noise and short waves.
    level : Scan or Cloud, optional
        The same scan once it is level (`jointclosure.walls.levelling.levelled`). Short waves of a
        `Cloud` are judged by the grid on which its points lie once they are level; without such a
        grid no lost waves are found. Ignored if the ``scan`` is a grid itself.

    Raises
    ------
    InputError
        If the points of a `Cloud` lie on one line.
    """
    rounding = rounding_of(scan)
    distance = point_distance(scan)
    if isinstance(scan, Cloud):
        of_level = step_of(level.heights.ravel()) if isinstance(level, Scan) else 0.0
        wave = shortest_wave(level, of_level) if isinstance(level, Scan) else 0.0
        most = noise_of_points(scan, distance)
        noise = (0.0, most) if most > 0.0 else (math.nan, math.nan)
        return ScanQuality(True, distance, rounding, wave, None, noise)
    wave = shortest_wave(scan, rounding.heights)
    if wave > 0.0:
        return ScanQuality(False, distance, rounding, wave, None, (math.nan, math.nan))
    end = spectrum_end(scan)
    noise = noise_of_grid(scan, rounding.heights, end)
    return ScanQuality(False, distance, rounding, 0.0, end, noise)


def quality_remarks(quality: ScanQuality, wall: np.ndarray, spacing: float) -> list[Caution]:
    """Return cautions about short waves that a wall (y, x) [m] lacks, and its rounding and noise.

    The wall has heights of the scan on a grid of a spacing [m], NaN where missing. Rounding and
    noise of heights are stated if they raise the squared slope of the wall by about 4 % (2 `MOVED`)
    or more, with the rms slope and the JRC that result. Noise is stated for a `Cloud` only: the
    range of a joint has the noise of grids. Rounding of x and y is stated if it is more than a
    tenth of the point distance.
    """
    remarks = []
    if quality.shortest_wave > 2.0 * spacing:
        remarks.append(_lost_waves(quality.shortest_wave, spacing))
    elif quality.spectrum_end is not None and quality.spectrum_end.clear:
        remarks.append(_ended_spectrum(quality.spectrum_end))
    steps = [np.diff(wall, axis=axis) for axis in (0, 1)]
    square = float(np.nanmean(np.concatenate([part.ravel() ** 2 for part in steps])))
    rounding = quality.rounding
    # what is wrong, and the squared difference of neighbours [m^2] that comes from it
    errors = [
        (f"heights are multiples of {1e6 * rounding.heights:.4g} um", rounding.heights**2 / 6.0)
    ]
    if quality.scattered:
        noise = quality.noise[1]
        about = (
            f"heights of points close to each other scatter by up to {1e6 * noise:.2g} um rms, by "
            "noise, by passes of the scanner that lie apart, or by steep slopes"
        )
        errors.append((about, 2.0 * noise**2))
        if rounding.places > 0.1 * quality.point_distance:
            remarks.append(
                caution(
                    f"x and y are multiples of {1e3 * rounding.places:.4g} mm, at points "
                    f"{1e3 * quality.point_distance:.4g} mm apart: heights lie at wrong places, "
                    "which changes slopes; export more digits of x and y"
                )
            )
    for about, excess in errors:
        if excess > 2.0 * MOVED * square:
            remarks.append(_error_caution(about, square, excess, spacing))
    return remarks


def _lost_waves(wave: float, spacing: float) -> Caution:
    """Return the caution about a scan that lacks waves shorter than a length ``wave`` [m].

    The caution states the shortest waves of a grid of the ``spacing`` [m].
    """
    return caution(
        f"the scan holds nothing below a wavelength of about {1e3 * wave:.3g} mm, as it was "
        "filtered or interpolated: its third differences grow faster with distance than those of "
        f"any rough wall. A grid of {1e3 * spacing:.4g} mm shows waves from "
        f"{2e3 * spacing:.4g} mm on: slopes, JRC and closures are too small; export the heights "
        "without a filter"
    )


def _ended_spectrum(end: SpectrumEnd) -> Caution:
    """Return the caution about a scan whose spectrum ends at a circle of wave numbers."""
    low, high = (f"{1e6 * size:.2g}" for size in end.noise_interval)
    return caution(
        f"the spectrum of the heights ends at a wavelength of {1e3 * end.wave:.2g} mm, equal in "
        "all directions, as after the blur of an instrument, a filter, or a turn of the grid by "
        f"interpolation. Beyond it there is white noise of {low} to {high} um (95 % interval). "
        "Noise that was smoothed with the heights is not in this, so that the noise of the "
        "scanner is understated, and ranges of the joint may be too narrow; export the heights "
        "as they were measured"
    )


def _error_caution(about: str, square: float, excess: float, spacing: float) -> Caution:
    """Return the caution about an error that raises the rms slope and the JRC, with their values.

    ``square`` are mean squared differences of neighbours [m^2], ``excess`` the part by the error.
    """
    relation = RELATIONS[DEFAULT_RELATION]
    if excess >= square:
        return caution(
            f"{about}: as much as neighbours at {1e3 * spacing:.4g} mm differ by roughness and "
            "noise together, so that noise and slopes cannot be separated here; the range uses "
            "this estimate only if the spectra of both walls show no noise"
        )
    slopes = [math.sqrt(part) / spacing for part in (square, square - excess)]
    jrcs = [relation.jrc(slope) for slope in slopes]
    return caution(
        f"{about}: this raises the rms slope at {1e3 * spacing:.4g} mm from {slopes[1]:.3g} to "
        f"{slopes[0]:.3g}, and the JRC by {jrcs[0] - jrcs[1]:.2g}"
    )

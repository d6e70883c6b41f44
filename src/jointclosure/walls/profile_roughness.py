"""Roughness of a profile: heights along one line, as profile combs, photographs and logs give."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from jointclosure.inputs import InputError, naming, size_of
from jointclosure.inputs.remarks import caution
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.jrc import RELATIONS
from jointclosure.walls.planes import detrended
from jointclosure.walls.scans.contents import (
    SAME_SPACING,
    axis_name,
    missing_values,
    settled,
    split_name,
)
from jointclosure.walls.scans.text import read_table, unit_of_column
from jointclosure.walls.wall_roughness import (
    SCATTER_SAMPLES,
    Measure,
    height_differences,
    hurst_of_squares,
    jrc_of_relation,
    lags_of,
    lags_of_relations,
    measure_of,
    scattered,
    slope_over_interval,
)

FEWEST_POINTS = 24  # fewest points of a profile: the longest distance, a quarter, is six steps
LEVEL = 5.0  # largest inclination [degrees] of a profile whose mean line is just subtracted
EVEN = 0.1  # largest difference of a step from the mean step, over it, in evenly spaced points
LONGEST_GAP = 3.0  # largest step, over the median step, within which heights are interpolated
_PLACES = ("x", "distance", "length", "position")
"""Names of the column of places, the more likely ones first."""
_HEIGHTS = ("z", "y")
"""Names of the column of heights, the more likely one first."""
_SEED = 1  # of the random profiles, which are the same for all measured ones


class Profile(NamedTuple):
    """Heights (n,) [m] at increasing places (n,) [m] along a line, and remarks on the file."""

    places: np.ndarray
    heights: np.ndarray
    remarks: tuple[str, ...] = ()


def read_profile(
    path: str | Path, *, units: str | None = None, variable: str | None = None
) -> Profile:
    """Read a profile from a text file of places and heights.

    Parameters
    ----------
    path : path
        Lines of a place and a height; a file with further columns names those two x and z, or
        ``variable`` chooses them.
    units : {"m", "mm", "um", "nm", "inch"}, optional
        Units of places and heights, if the file does not state them.
    variable : str, optional
        Names or numbers of the two columns, such as "1,3".

    Returns
    -------
    Profile

    Raises
    ------
    InputError
        If the file is missing or no table, units are not stated or contradict those of the file,
        or places do not all increase or all decrease.
    """
    with naming(str(path)):
        if not Path(path).is_file():
            raise InputError("file not found")
        table = read_table(Path(path), [{x, z} for x in _PLACES for z in _HEIGHTS])
        columns = _columns(table.names, table.values.shape[1], variable)
        of_places, of_heights = (unit_of_column(table, column) for column in columns)
        header = table.header
        known = table.values[:, columns]
        places = size_of(settled("distances", of_places or header.length_units, units))
        heights = size_of(settled("heights", of_heights or header.height_units, units))
        missing = missing_values(known[:, 1])[0] | ~np.isfinite(known).all(axis=1)
        remarks = list(table.remarks)
        if missing.any():
            remarks.append(caution(f"{missing.sum()} points without a height were left out"))
        along, across = (known[~missing] * [places, heights]).T
        steps = np.diff(along)
        if (steps < 0.0).all():
            along = along[::-1]
            across = across[::-1]
            steps = -steps[::-1]
        if not (steps > 0.0).all():
            row = int(np.flatnonzero(steps <= 0.0)[0]) + 2
            raise InputError(
                f"point {row} is not beyond the one before it: places must all increase or all "
                "decrease, as a profile has one height at each place"
            )
        return Profile(along, across, tuple(remarks))


def _columns(names: list[str], width: int, variable: str | None) -> list[int]:
    """Return the numbers, from 0, of the columns of places and heights of a profile.

    ``variable`` states their names, or their numbers from 1. Otherwise they are known by their
    names, or are the only two. Raise `InputError` if they are not found.
    """
    axes = [axis_name(name) for name in names]
    if variable is not None:
        words = [word.strip() for word in variable.split(",")]
        known = {str(place + 1): place for place in range(width)}
        known |= {split_name(name)[0]: place for place, name in enumerate(names)}
        known |= {name: place for place, name in enumerate(names)}
        columns = [known[word] for word in words if word in known]
        if len(words) == len(set(columns)) == 2:
            return columns
        listed = ", ".join(names) or f"numbers from 1 to {width}"
        must = "must be two columns for places and heights, as in 1,2"
        raise InputError(f"variable = {variable!r}: {must}; there are {listed}")
    place = next((name for name in _PLACES if name in axes), None)
    height = next((name for name in _HEIGHTS if name in axes), None)
    if place and height and not (width > 2 and {*_HEIGHTS} <= set(axes)):
        return [axes.index(place), axes.index(height)]
    if width == 2:
        return [0, 1]
    must = "must be two, or named x and z, or variable (--variable) must state them, such as 1,3"
    raise InputError(f"{width} columns ({', '.join(names) or 'without names'}): {must}")


def levelled_profile(profile: Profile) -> tuple[np.ndarray, float, float]:
    """Return the heights of a profile above its mean line, at even places.

    The line of a profile that is inclined by up to `LEVEL` degrees is subtracted. A steeper profile
    is turned until its line is level, because heights are normal to it. Heights between uneven
    points are interpolated by a monotone cubic (PCHIP). This loses 4 % of the RMS slope at the
    spacing of a self-affine profile with a Hurst exponent of 0.8, and 9 % with 0.5.

    Returns
    -------
    heights : ndarray (n,) [m]
        At places a ``spacing`` apart, NaN in gaps.
    spacing : float [m]
        Mean distance of even points, median of others.
    inclination : float [degrees]
        That of the mean line as read.

    Raises
    ------
    InputError
        If there are fewer than `FEWEST_POINTS`, or points overhang once the profile is level.
    """
    if profile.places.size < FEWEST_POINTS:
        raise InputError(f"{profile.places.size} points: must be at least {FEWEST_POINTS}")
    x = profile.places - profile.places.mean()
    z = profile.heights - profile.heights.mean()
    slope = float(np.sum(x * z) / np.sum(x * x))
    angle = np.arctan(slope)
    inclination = float(np.degrees(angle))
    if abs(inclination) <= LEVEL:
        along = x
        across = z - slope * x
    else:
        cosine = np.cos(angle)
        sine = np.sin(angle)
        along = x * cosine + z * sine
        across = z * cosine - x * sine
    steps = np.diff(along)
    if not (steps > 0.0).all():
        raise InputError(
            f"the profile is inclined by {inclination:.3g} degrees and overhangs once it is "
            "level: must have one height at each place along its mean line"
        )
    spacing = float(np.mean(steps))
    if np.abs(steps - spacing).max() <= EVEN * spacing:
        return across, spacing, inclination
    spacing = float(np.median(np.diff(x)))
    even = np.arange(along[0], along[-1] + SAME_SPACING * spacing, spacing)
    even = np.minimum(even, along[-1])
    heights = PchipInterpolator(along, across)(even)
    before = np.clip(np.searchsorted(along, even, "right") - 1, 0, steps.size - 1)
    apart = np.minimum(even - along[before], along[before + 1] - even)
    in_gap = (steps[before] > LONGEST_GAP * spacing) & (apart > SAME_SPACING * spacing)
    return np.where(in_gap, np.nan, heights), spacing, inclination


def measure_profile(heights: np.ndarray, spacing: float) -> list[Measure]:
    """Measure a level profile.

    Parameters
    ----------
    heights : ndarray (n,) [m]
        NaN where missing.
    spacing : float [m]

    Returns
    -------
    list of Measure
        Rms height; Z2 (RMS slope); Hurst exponent H; Rp, the length along the profile over that of
        its mean line; and the JRC by each of `RELATIONS` and by Stigsson & Mas Ivars (2019), -4.3 +
        54.6 s + 4.3 H with the RMS height difference s [mm] over 1 mm. Their 95 % intervals are
        the scatter over self-affine profiles of the same length, 100 with the Hurst exponent found
        and 100 with each end of its 80 % interval.

    Raises
    ------
    InputError
        If the profile is flat, or no three neighbouring places have heights.
    """
    if not np.nanstd(heights) > 0.0:
        raise InputError("all heights are equal: the profile has no roughness")
    if not np.isfinite(np.diff(heights, 2)).any():
        raise InputError("no three neighbouring places have heights, which measures need")
    here = _profile_measures(heights, spacing)
    drawn = [_random_measures(heights.size, spacing, here["H"])]
    exponents = here["H"] + np.quantile(drawn[0]["H"] - drawn[0]["H"].mean(), [0.1, 0.9])
    drawn += [_random_measures(heights.size, spacing, exponent) for exponent in exponents.tolist()]
    scatter = {
        name: np.concatenate([[value], *(scattered(name, value, each[name]) for each in drawn)])
        for name, value in here.items()
    }
    # Rp - 1 is about half of the squared slope, and scatters as that
    scatter["Rp"] = 1.0 + (here["Rp"] - 1.0) * (scatter["Z2"] / here["Z2"]) ** 2
    lags = 1e3 * spacing * lags_of(heights.size)[[1, -1]]
    measures = [
        measure_of("rms height", 1e3 * scatter["rms height"], "mm"),
        measure_of("Z2", scatter["Z2"], remark=f"at {1e3 * spacing:.4g} mm"),
        measure_of("H", scatter["H"], remark=f"over {lags[0]:.4g} to {lags[1]:.4g} mm"),
        measure_of("Rp, length over that of the line", scatter["Rp"]),
    ]
    for name, relation in RELATIONS.items():
        found = slope_over_interval(
            relation.interval, scatter, scatter["Z2"], spacing, scatter["H"]
        )
        jrc, remark = jrc_of_relation(relation, *found)
        measures.append(measure_of(f"JRC, {name}", jrc, remark=remark))
    slope, how = slope_over_interval(1e-3, scatter, scatter["Z2"], spacing, scatter["H"])
    jrc = -4.3 + 54.6 * slope + 4.3 * scatter["H"]  # the slope is s [mm] over 1 mm
    return [*measures, measure_of("JRC, stigsson_mas_ivars", jrc, remark=f"{how}, and H")]


def _profile_measures(heights: np.ndarray, spacing: float) -> dict[str, float]:
    """Return the measures of a profile (n,) [m] by name.

    They are the rms height [m], RMS slopes at the spacing and at numbers of cells, the Hurst
    exponent by second differences, and Rp, the length over that of the mean line.
    """

    def rms(lag: int, order: int = 1) -> float:
        return float(
            np.sqrt(np.nanmean(height_differences(heights[None, :], "x", lag, order) ** 2))
        )

    steps = np.diff(heights) / spacing
    scaling = {"rms height": float(np.nanstd(heights)), "Z2": rms(1) / spacing}
    scaling["Rp"] = float(np.nanmean(np.hypot(1.0, steps)))
    lags = lags_of(heights.size)
    for lag in lags_of_relations(spacing, int(lags[-1])):
        scaling[f"Z2 at {lag}"] = rms(lag) / (lag * spacing)
    second = np.array([rms(lag, 2) ** 2 for lag in lags])
    bent = second > 0.0  # not where heights repeat
    scaling["H"] = hurst_of_squares(lags[bent], second[bent])
    return scaling


def _random_measures(count: int, spacing: float, hurst: float) -> dict[str, np.ndarray]:
    """Return the measures of random self-affine profiles of ``count`` points, by name.

    Each is an array (SCATTER_SAMPLES,), see `_profile_measures`.
    """
    rows = [_profile_measures(profile, spacing) for profile in _random_profiles(count, hurst)]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _random_profiles(count: int, hurst: float) -> list[np.ndarray]:
    """Return `SCATTER_SAMPLES` random self-affine profiles (count,), each less its mean line.

    They are halves of periodic profiles, so that they are not periodic. Their scale is arbitrary.
    """
    frequencies = np.fft.rfftfreq(2 * count)
    amplitudes = np.zeros(frequencies.size)
    amplitudes[1:] = frequencies[1:] ** -(min(max(hurst, 0.05), 1.0) + 0.5)
    profiles = []
    for number in range(SCATTER_SAMPLES):
        noise = generator(seed_of(_SEED, "profile", number)).standard_normal(2 * count)
        heights = np.fft.irfft(np.fft.rfft(noise) * amplitudes, 2 * count)[:count]
        profiles.append(detrended(heights[None, :])[0])
    return profiles

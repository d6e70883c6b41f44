"""The closure of a first loading in a tenth of a millisecond, from the bearing-area curve.

Where asperities break at once, what overlaps is crushed, and the crushed area carries the load.
So the closure at a nominal stress sigma is about the depth d at which rigid walls overlap in
the area fraction (docs/accuracy.md)

    A = a (sigma/sigma_c)^b,        d = depth of the highest A of the summed heights,

a bearing-area law (Abbott & Firestone 1933). Its constants are fitted to closed joints by
`jointclosure.studies.surrogate.calibration`; the table that the package has of them says what the
law was off by on joints to which it was not fitted.
"""

import csv
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from jointclosure.config.files import SURROGATE
from jointclosure.given_walls import checked_walls
from jointclosure.inputs import InputError, check_length, real_array
from jointclosure.parameters import Rock, check_rock
from jointclosure.surface.bearing import bearing_depths
from jointclosure.surface.roughness import rms_slope

ALL_ROCKS = "all"
"""Name of the constants that serve all rocks."""
_SAME = 1e-6
"""By what spacings and lengths may differ, relatively, and be the same."""


class BearingLaw(NamedTuple):
    """Area fraction a (sigma/sigma_c)^b: ``at_strength`` is a, ``exponent`` b."""

    at_strength: float
    exponent: float

    def fraction(self, stress_over_strength: ArrayLike) -> np.ndarray:
        """The area fraction that is crushed, at most 1."""
        ratio = np.asarray(stress_over_strength, dtype=float)
        return np.minimum(self.at_strength * ratio**self.exponent, 1.0)


class Estimate(NamedTuple):
    """What `estimate` gives; arrays where stresses are an array.

    ``closure`` [m] from first touch; ``crushed_fraction`` of the area; ``rms_error``: root mean
    square of the closure's relative error on single joints at such a stress, of the rock and
    roughness where it was largest; NaN where it was not measured.
    """

    closure: float | np.ndarray
    crushed_fraction: float | np.ndarray
    rms_error: float | np.ndarray


class _Range(NamedTuple):
    """What the law was fitted to: least and largest value of each."""

    stress_over_strength: tuple[float, float]
    rms_slope: tuple[float, float]
    height_over_slope: tuple[float, float]
    modulus_over_strength: tuple[float, float]
    spacing: tuple[float, float]
    length: tuple[float, float]


def estimate(
    upper: ArrayLike,
    lower: ArrayLike,
    *,
    spacing: float,
    rock: Rock,
    normal_stress: ArrayLike,
    extrapolate: bool = False,
) -> Estimate:
    """Closure of a joint at stresses of its first loading, by the bearing-area law.

    Parameters
    ----------
    upper, lower : array (ny, nx)
        Heights towards the other wall [m], as for `jointclosure.simulate`.
    spacing : float
        Grid spacing h [m].
    rock : Rock
        Of both walls.
    normal_stress : float or array
        Nominal normal stress [Pa], positive.
    extrapolate : bool
        Whether to give a closure, with an error that is NaN, where the law was not tested.

    Returns
    -------
    Estimate

    Raises
    ------
    InputError
        Bad walls or numbers; and, unless ``extrapolate``, a stress, roughness, rock, spacing or
        size beyond those of the joints that the law was tested on, with the range.

    Notes
    -----
    It is of the full model with the paper's settings, of independent walls, and of first loading
    only: it knows no unloading, no second cycle and no change of Young's modulus.
    """
    upper, lower = checked_walls(upper, lower)
    check_length("spacing", spacing)
    check_rock(rock)
    stresses = real_array("normal_stress", normal_stress)
    if not np.all(stresses > 0.0):
        raise InputError(f"normal_stress = {normal_stress!r} Pa: must be positive")
    law, tested, errors = _calibration()
    ratio = stresses / rock.compressive_strength
    outside = list(_outside(tested, upper, lower, spacing, rock, ratio))
    if outside and not extrapolate:
        raise InputError(f"{outside[0]}; extrapolate=True gives a closure without an error")
    fraction = law.fraction(ratio)
    closure = bearing_depths(upper + lower, fraction)
    error = np.full(ratio.shape, np.nan) if outside else _worst(errors, ratio)
    if stresses.ndim == 0:
        return Estimate(float(closure), float(fraction), float(error))
    return Estimate(closure, fraction, error)


def slope_and_height(upper: np.ndarray, lower: np.ndarray, spacing: float) -> tuple[float, float]:
    """RMS slope of both walls together, and RMS of their summed heights over it [m].

    The second grows with the length of the waves that the walls do not share: walls that are
    correlated, or whose long waves are weaker than those of the joints that the law was tested on,
    have less. It is infinite where walls are level.
    """
    squares = [rms_slope(wall, spacing) ** 2 for wall in (upper, lower)]
    slope = float(np.sqrt(0.5 * sum(squares)))
    return slope, float(np.std(upper + lower)) / slope if slope else np.inf


def _outside(tested: _Range, upper, lower, spacing: float, rock: Rock, ratio: np.ndarray):
    """What is beyond the joints that the law was tested on, one sentence each."""
    slope, height = slope_and_height(upper, lower, spacing)
    given = {
        "stress_over_strength": (ratio.min(), ratio.max()),
        "rms_slope": (slope, slope),
        "height_over_slope": (height, height),
        "modulus_over_strength": (rock.youngs_modulus / rock.compressive_strength,) * 2,
        "spacing": (spacing, spacing),
        "length": (spacing * min(upper.shape), spacing * max(upper.shape)),
    }
    names = {
        "stress_over_strength": "normal_stress over compressive strength",
        "rms_slope": "RMS slope of the walls",
        "height_over_slope": "RMS of the summed heights over the walls' RMS slope [m]",
        "modulus_over_strength": "Young's modulus over compressive strength",
        "spacing": "spacing [m]",
        "length": "length of the walls [m]",
    }
    for name, (low, high) in given.items():
        least, most = getattr(tested, name)
        if low < least * (1.0 - _SAME) or high > most * (1.0 + _SAME):
            value = low if low < least else high
            yield (
                f"{names[name]} = {value:.4g}: the law was tested from {least:.4g} to {most:.4g}"
            )


def _worst(errors: list[tuple[np.ndarray, np.ndarray]], ratio: np.ndarray) -> np.ndarray:
    """Largest error at the ratios, among rocks that were loaded so far, linear in log ratio."""
    at = np.log(ratio)
    found = [np.interp(at, logs, rms, right=np.nan) for logs, rms in errors]
    return np.nanmax(found, axis=0)


@lru_cache(maxsize=1)
def _calibration() -> tuple[BearingLaw, _Range, list[tuple[np.ndarray, np.ndarray]]]:
    """The law of all rocks, what it was tested on, and its errors by rock and roughness."""
    with SURROGATE.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["constants"] == ALL_ROCKS]
    columns = {name: np.array([float(row[name]) for row in rows]) for name in _NUMBERS}
    law = BearingLaw(columns["at_strength"][0], columns["exponent"][0])
    tested = _Range(
        *(
            (float(columns[low].min()), float(columns[high].max()))
            for low, high in (
                ("stress_over_strength", "stress_over_strength"),
                ("rms_slope", "rms_slope"),
                ("least_height_over_slope_m", "most_height_over_slope_m"),
                ("least_modulus_over_strength", "most_modulus_over_strength"),
                ("spacing_m", "spacing_m"),
                ("length_m", "length_m"),
            )
        )
    )
    errors = []
    kinds = [(row["rock"], row["jrc"]) for row in rows]
    for kind in dict.fromkeys(kinds):
        here = np.array([each == kind for each in kinds])
        logs = np.log(columns["stress_over_strength"][here])
        errors.append((logs, 0.01 * columns["rms_percent"][here]))
    return law, tested, errors


_NUMBERS = (
    "at_strength",
    "exponent",
    "stress_over_strength",
    "rms_slope",
    "least_height_over_slope_m",
    "most_height_over_slope_m",
    "least_modulus_over_strength",
    "most_modulus_over_strength",
    "spacing_m",
    "length_m",
    "rms_percent",
)
"""Columns of the table of the law that are read."""

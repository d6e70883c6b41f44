"""Closure of a first loading in a tenth of a millisecond, from the bearing-area curve.

If asperities break immediately, all overlapping cells are crushed, and the crushed area carries
the load. The closure at a nominal stress sigma is then about the depth d at which rigid walls
overlap in the area fraction (docs/accuracy.md)

    A = a (sigma/sigma_c)^b,        d = depth of the highest A of the summed heights,

a bearing-area law (Abbott & Firestone 1933). Its constants are fitted to closed joints by
`jointclosure.surrogate.calibration`. The package has a table of them, with the errors of the
law on joints to which it was not fitted.
"""

import csv
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from jointclosure.config.files import SURROGATES
from jointclosure.inputs import InputError, check_length, real_array
from jointclosure.joint.given_walls import checked_walls
from jointclosure.joint.rocks import rocks_of_walls
from jointclosure.parameters import Rock, strength_of
from jointclosure.surface.bearing import bearing_depths
from jointclosure.surrogate.domain import (
    MEASURES,
    Node,
    Outside,
    errors_at,
    nodes_around,
    stresses_of,
)

ALL_ROCKS = "all"
"""Name of the constants for all rocks."""
_SAME = 1e-6
"""Largest relative difference of spacings and lengths that count as equal."""


class BearingLaw(NamedTuple):
    """Area fraction a (sigma/sigma_c)^b: ``at_strength`` is a, ``exponent`` b."""

    at_strength: float
    exponent: float

    def fraction(self, stress_over_strength: ArrayLike) -> np.ndarray:
        """Return the crushed area fraction, at most 1."""
        ratio = np.asarray(stress_over_strength, dtype=float)
        return np.minimum(self.at_strength * ratio**self.exponent, 1.0)


class Estimate(NamedTuple):
    """Result of `estimate`, with arrays if stresses are an array.

    ``closure`` [m] from first touch, gross: with the elastic indentation of the half-spaces.
    ``crushed_fraction`` of the area. ``rms_error``: root mean square of the relative error of
    closures of single joints at such a stress, for the rock and roughness with the largest error;
    NaN if it was not measured. ``roll_off`` [m]: that of the walls whose constants were used; None
    for walls with waves of all lengths.
    """

    closure: float | np.ndarray
    crushed_fraction: float | np.ndarray
    rms_error: float | np.ndarray
    roll_off: float | None

    def __repr__(self) -> str:
        closure, crushed, error = (
            ", ".join(f"{scale * value:.3g}" for value in np.ravel(values))
            for values, scale in zip(self[:3], (1e3, 100.0, 100.0), strict=True)
        )
        stated = "error not known" if np.isnan(self.rms_error).any() else f"rms error {error} %"
        return (
            f"<Estimate: closes {closure} mm gross, from first touch ({stated}), "
            f"{crushed} % of the area crushed>"
        )


class WallMeasures(NamedTuple):
    """Statistics that identify the kind of walls.

    ``rms_slope``: that of both walls together. ``height_over_slope`` [m]: RMS of their summed
    heights over it. It grows with the length of the waves that the walls do not share, and is
    infinite for level walls. ``slope_ratio``: RMS slope at twice the spacing over that at the
    spacing. It grows with the Hurst exponent, and is smaller with a roll-off. ``correlation``: that
    of the upper wall's slopes with the negative of the lower wall's: 1 for mated walls, about 0 for
    independent walls.
    """

    rms_slope: float
    height_over_slope: float
    slope_ratio: float
    correlation: float


class _Calibration(NamedTuple):
    """Law for walls of one kind.

    ``tested``: smallest and largest values of each measure of `_TESTED` for which the law was
    fitted and tested. ``errors``: for each rock and roughness, logarithms of stress over strength,
    and RMS errors.
    """

    roll_off: float | None
    law: BearingLaw
    tested: dict[str, tuple[float, float]]
    errors: list[tuple[np.ndarray, np.ndarray]]

    def named(self) -> str:
        """Describe the kind of walls."""
        if self.roll_off is None:
            return "walls without roll-off"
        return f"walls of roll-off {1e3 * self.roll_off:g} mm"


def estimate(
    upper: ArrayLike,
    lower: ArrayLike,
    *,
    spacing: float,
    rock: str | Rock,
    max_normal_stress: ArrayLike,
    extrapolate: bool = False,
) -> Estimate:
    """Estimate the closure of a joint at stresses of its first loading, by the bearing-area law.

    Parameters
    ----------
    upper, lower : array (ny, nx)
        Heights towards the other wall [m], as for `jointclosure.simulate`.
    spacing : float
        Grid spacing h [m].
    rock : str or Rock
        Rock of both walls, by name (`jointclosure.joint.rocks.ROCKS`) or properties.
    max_normal_stress : float or array
        Nominal normal stress [Pa], positive.
    extrapolate : bool
        Whether to return a closure, with an error of NaN, where the law was not tested.

    Raises
    ------
    InputError
        If walls or numbers are not valid; and, unless ``extrapolate``, if stress, roughness,
        rock, spacing or size are outside of the range of the joints on which the law was tested.

    Notes
    -----
    The law is for the full model with the paper's settings, for independent walls, and for the
    first loading only; it does not contain unloading, later cycles or the effect of Young's
    modulus. Constants are those of walls with a roll-off of 3 mm or without roll-off, selected by
    the RMS height over slope of the given walls. They were fitted to joints of 25 mm at a spacing
    of 0.25 mm and JRC 5 to 10; at other spacings, sizes and JRC the error is that of joints
    simulated there (`jointclosure.surrogate.domain`), or that of the constants if it is larger.
    """
    check_length("spacing", spacing)
    upper, lower = checked_walls(upper, lower, spacing)
    intact = _one_rock(rock)
    stresses = real_array("max_normal_stress", max_normal_stress)
    if not stresses.size:
        raise InputError(
            f"max_normal_stress = {max_normal_stress!r}: must have at least one stress [Pa]"
        )
    if not np.all(stresses > 0.0):
        raise InputError(f"max_normal_stress = {max_normal_stress!r} Pa: must be positive")
    measures = wall_measures(upper, lower, spacing)
    ratio = stresses / strength_of(intact)
    chosen, error, outside = _tested_law(measures, upper.shape, spacing, intact, ratio)
    if outside and not extrapolate:
        raise InputError(f"{outside}; extrapolate=True returns a closure without an error")
    fraction = chosen.law.fraction(ratio)
    closure = bearing_depths(upper + lower, fraction)
    if stresses.ndim == 0:
        return Estimate(float(closure), float(fraction), float(error), chosen.roll_off)
    return Estimate(closure, fraction, error, chosen.roll_off)


def _tested_law(
    walls: WallMeasures, shape: tuple[int, ...], spacing: float, rock: Rock, ratio: np.ndarray
) -> tuple["_Calibration", np.ndarray, str]:
    """Return the law of a joint, its errors, and what lies outside of all tests ("": nothing).

    The law is tested at the joints of its constants, and with other errors in a wider domain.
    """
    chosen = _nearest(walls.height_over_slope)
    outside = dict(_outside(chosen, walls, shape, spacing, rock, ratio))
    if not outside:
        return chosen, _worst(chosen.errors, ratio), ""
    unknown = np.full(ratio.shape, np.nan)
    if set(outside) <= set(_LOADS):  # the wider domain is of other walls
        return chosen, unknown, next(iter(outside.values()))
    given = {name: (value, value) for name, value in walls._asdict().items()}
    given |= {"spacing": (spacing, spacing), "cells": (float(min(shape)), float(max(shape)))}
    around = [(kind, nodes_around(given, kind.roll_off)) for kind in _calibrations()]
    tested = [(kind, nodes) for kind, nodes in around if not isinstance(nodes, Outside)]
    if tested:
        kind, nodes = min(tested, key=lambda pair: _away(pair[1], walls.height_over_slope))
        wider = kind._replace(tested=kind.tested | {"stress_over_strength": stresses_of(nodes)})
        named = dict(_outside(wider, walls, shape, spacing, rock, ratio))
        for name in _LOADS:
            if name in named:
                return kind, unknown, named[name]
        # few joints of one rock at a node: not a proof of errors below those of the constants
        return kind, np.fmax(errors_at(nodes, ratio), _worst(kind.errors, ratio)), ""
    domain = next(found for kind, found in around if kind is chosen)
    return chosen, unknown, _nearest_domain(domain, outside)


_LOADS = ("stress_over_strength", "modulus_over_strength")
"""Tested ratios that do not depend on the walls."""


def _away(nodes: list[Node], height_over_slope: float) -> float:
    """Return how far heights over slope are from the middle of those of nodes, as a logarithm."""
    middle = np.mean([np.log(node.bounds["height_over_slope"]).mean() for node in nodes])
    return abs(float(np.log(height_over_slope) - middle))


def _nearest_domain(found: Outside | list[Node], outside: dict[str, str]) -> str:
    """Name the quantity that is outside of the wider domain, or of that of the constants."""
    measures = {name: outside[name] for name in MEASURES if name in outside}
    if isinstance(found, Outside) and found.name not in measures:
        title = _TESTED[found.name].title if found.name in _TESTED else "cells along a side"
        return (
            f"{title} = {found.value:.4g}: the law was tested from {found.least:.4g} to "
            f"{found.most:.4g}"
        )
    return next(iter((measures or outside).values()))


def _one_rock(rock: str | Rock) -> Rock:
    """Check and return the rock of both walls."""
    upper, lower = rocks_of_walls(rock)
    if upper != lower:
        raise InputError(f"rock: {rock!r}: must be one Rock, for which the law was tested")
    return upper


def wall_measures(upper: np.ndarray, lower: np.ndarray, spacing: float) -> WallMeasures:
    """Compute statistics that identify the kind of walls (y, x) [m] with a grid spacing [m]."""
    squares, product, doubled = np.zeros(2), 0.0, 0.0  # sums over the profiles along x and along y
    count = further = 0
    for above, below in ((upper, lower), (upper.T, lower.T)):
        steps = np.stack([wall[1:] - wall[:-1] for wall in (above, below)])
        squares += np.einsum("kij,kij->k", steps, steps)
        product += float(np.einsum("ij,ij->", *steps))
        pairs = steps[:, 1:] + steps[:, :-1]
        doubled += float(np.einsum("kij,kij->", pairs, pairs))
        count, further = count + steps.size, further + pairs.size
    mean = float(squares.sum()) / count
    if not mean > 0.0:
        return WallMeasures(0.0, np.inf, 0.0, 0.0)
    slope, both = float(np.sqrt(mean)) / spacing, float(np.sqrt(squares.prod()))
    return WallMeasures(
        slope,
        float(np.std(upper + lower)) / slope,
        0.5 * float(np.sqrt(doubled / further / mean)),
        -product / both if both > 0.0 else 0.0,
    )


def _nearest(height_over_slope: float) -> _Calibration:
    """Return the constants of walls with such heights over slope, or the nearest ones."""

    def away(calibration: _Calibration) -> tuple[bool, float]:
        least, most = calibration.tested["height_over_slope"]
        inside = least <= height_over_slope <= most
        ratio = np.clip(height_over_slope, _SAME * least, most / _SAME) / np.sqrt(least * most)
        return not inside, abs(float(np.log(ratio)))

    return min(_calibrations(), key=away)


class _Tested(NamedTuple):
    """Measure of joints; ``columns`` of its least and largest tested values in the law's table.

    ``cause``: probable reason for a value outside.
    """

    title: str
    columns: tuple[str, str]
    cause: str = ""


_TESTED = {
    "stress_over_strength": _Tested(
        "max_normal_stress over compressive strength", ("stress_over_strength",) * 2
    ),
    "rms_slope": _Tested("RMS slope of the walls", ("rms_slope",) * 2),
    "modulus_over_strength": _Tested(
        "Young's modulus over compressive strength",
        ("least_modulus_over_strength", "most_modulus_over_strength"),
    ),
    "spacing": _Tested("spacing [m]", ("spacing_m",) * 2),
    "length": _Tested("length of the walls [m]", ("length_m",) * 2),
    "height_over_slope": _Tested(
        "RMS of the summed heights over the walls' RMS slope [m]",
        ("least_height_over_slope_m", "most_height_over_slope_m"),
        "another roll-off or spectrum, or walls that are mated",
    ),
    "slope_ratio": _Tested(
        "RMS slope at twice the spacing over that at the spacing",
        ("least_slope_ratio", "most_slope_ratio"),
        "another roll-off, Hurst exponent or filter",
    ),
    "correlation": _Tested(
        "correlation of the upper wall's slopes with the lower one's negative",
        ("least_correlation", "most_correlation"),
        "walls that are not independent",
    ),
}


def _outside(
    chosen: _Calibration,
    walls: WallMeasures,
    shape: tuple[int, ...],
    spacing: float,
    rock: Rock,
    ratio: np.ndarray,
) -> Iterator[tuple[str, str]]:
    """Generate the name of each measure outside of the tested range, and a sentence on it."""
    given = {name: (value, value) for name, value in walls._asdict().items()} | {
        "stress_over_strength": (ratio.min(), ratio.max()),
        "modulus_over_strength": (rock.youngs_modulus / strength_of(rock),) * 2,
        "spacing": (spacing, spacing),
        "length": (spacing * min(shape), spacing * max(shape)),
    }
    for name, (title, _, cause) in _TESTED.items():
        low, high = given[name]
        least, most = chosen.tested[name]
        slack = _SAME * max(abs(least), abs(most))
        if low < least - slack or high > most + slack:
            value = low if low < least - slack else high
            message = f"{title} = {value:.4g}: {_ranges(name, chosen)}"
            if cause:
                message += (
                    f"; likely {cause}: `.venv/bin/snakemake surrogate` on a study of "
                    "such walls computes their constants"
                )
            yield name, message


def _ranges(name: str, chosen: _Calibration) -> str:
    """Describe the tested range; for heights, which select the constants, that of all kinds."""
    kinds = _calibrations() if name == "height_over_slope" else (chosen,)
    parts = []
    for kind in kinds:
        least, most = kind.tested[name]
        parts.append(f"from {least:.4g} to {most:.4g} on {kind.named()}")
    return "the law was tested " + " and ".join(parts)


def _worst(errors: list[tuple[np.ndarray, np.ndarray]], ratio: np.ndarray) -> np.ndarray:
    """Return the largest error at the ratios, among rocks with such loads, linear in log ratio."""
    at = np.log(ratio)
    errors_of_rocks = [np.interp(at, logs, rms, right=np.nan) for logs, rms in errors]
    return np.nanmax(errors_of_rocks, axis=0)


def law_of(roll_off: float | None) -> BearingLaw:
    """Return the law of walls with a roll-off [m] to which constants were fitted."""
    return next(kind.law for kind in _calibrations() if kind.roll_off == roll_off)


@lru_cache(maxsize=1)
def _calibrations() -> tuple[_Calibration, ...]:
    """Return the law of all rocks for every kind of walls to which it was fitted."""
    return tuple(_read(path) for path in SURROGATES)


def _read(path: Path) -> _Calibration:
    with path.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["constants"] == ALL_ROCKS]

    def column(name: str) -> np.ndarray:
        return np.array([float(row[name]) for row in rows])

    law = BearingLaw(*(column(name)[0] for name in BearingLaw._fields))
    tested = {
        name: (float(column(low).min()), float(column(high).max()))
        for name, (_, (low, high), _) in _TESTED.items()
    }
    errors = []
    kinds = [(row["rock"], row["jrc"]) for row in rows]
    for kind in dict.fromkeys(kinds):
        here = np.array([other == kind for other in kinds])
        logs = np.log(column("stress_over_strength")[here])
        errors.append((logs, 0.01 * column("rms_percent")[here]))
    roll_off = rows[0]["roll_off_mm"]
    return _Calibration(1e-3 * float(roll_off) if roll_off else None, law, tested, errors)

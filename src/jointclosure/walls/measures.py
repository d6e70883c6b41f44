"""Roughness measures of a wall with uncertainty: slopes, JRC, Hurst exponent, curvature, peaks.

Curvature and peaks are means over cells, computed from sums over tiles of the wall. Tiles are
resampled (a block bootstrap), because cells are not independent and tiles nearly are. Heights,
slopes, JRC and Hurst exponents also depend on waves as long as the wall, which tiles do not
contain. Their scatter is that of synthetic walls of the same slope and exponent.
"""

from typing import Any, NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.differences import (
    difference,
    mean_curvature,
    peak_cells,
    second_difference,
)
from jointclosure.walls.roughness import RELATIONS, Relation
from jointclosure.walls.synthesis import synthetic_wall

TILES = 6
"""Number of tiles along the shorter side."""
SMALLEST_WALL = 24
"""Smallest number of cells along the shorter side: four for each tile."""
DRAWS, LARGEST_DRAW = 100, 400
"""Number of synthetic walls, and largest number of cells along their sides; smaller walls scatter
more."""
_SLOPES = ("Z2 along x", "Z2 along y", "Z2, both directions")


class Measure(NamedTuple):
    """Measured quantity with the limits of its confidence interval."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    remark: str = ""


class Increments(NamedTuple):
    """RMS differences of heights over distances, all in [m]: the root structure function.

    ``x`` and ``y`` are differences of two heights along each axis. ``second_x`` and ``second_y``
    are second differences of three heights at equal distances.
    """

    distances: np.ndarray
    x: np.ndarray
    y: np.ndarray
    second_x: np.ndarray
    second_y: np.ndarray


def lags_of(cells: int) -> np.ndarray:
    """Return distances in cells, about evenly spaced in logarithm, up to a quarter of the wall."""
    return np.unique(np.round(np.geomspace(1.0, max(cells // 4, 2), 14)).astype(int))


def measure_wall(
    heights: np.ndarray,
    spacing: float,
    *,
    resamples: int = 1000,
    confidence: float = 0.95,
    seed: int = 1,
) -> list[Measure]:
    """Compute all measures of a wall.

    Parameters
    ----------
    heights : array (y, x)
        Plane-detrended heights [m], outwards, NaN where missing.
    spacing : float
        Grid spacing [m].
    resamples, confidence, seed
        Parameters of the block bootstrap.

    Returns
    -------
    list of Measure
        Measures as defined in docs/two_scans.md.

    Raises
    ------
    InputError
        If a side has fewer than `SMALLEST_WALL` cells.
    """
    if min(heights.shape) < SMALLEST_WALL:
        raise InputError(
            f"{heights.shape[0]} x {heights.shape[1]} cells (y, x): "
            f"measures need at least {SMALLEST_WALL} along each side"
        )
    if not np.nanstd(heights) > 0.0:
        raise InputError("all heights are equal: the wall has no roughness")
    means = _resampled_means(heights, spacing, resamples, seed)
    tail = 50.0 * (1.0 - confidence)

    def of(name: str, values: np.ndarray, unit: str, remark: str = "") -> Measure:
        low, high = np.nanpercentile(values[1:], [tail, 100.0 - tail])
        return Measure(name, float(values[0]), float(low), float(high), unit, remark)

    long = _scaling(heights, spacing)
    scatter = _scatter(long, heights.shape, spacing, seed)
    reach = "over {:g} to {:g} mm".format(*1e3 * spacing * _fitted_lags(heights)[[0, -1]])
    measures = [of("rms height", 1e3 * scatter["rms height"], "mm")]
    measures += [of(name, scatter[name], "1") for name in _SLOPES]
    for name in ("H along x", "H along y", "H, both directions"):
        measures.append(of(name, scatter[name], "1", reach))
    first = scatter["H by first differences"]
    measures.append(of("H by first differences", first, "1", f"{reach}; lower, see the docs"))
    for name, relation in RELATIONS.items():
        values, remark = _jrc(relation, scatter, spacing, first[0])
        measures.append(of(f"JRC, {name}", values, "1", remark))
    for axis in "xy":
        measures.append(
            of(f"rms curvature along {axis}", 1e-3 * np.sqrt(means["curvature", axis]), "1/mm")
        )
    share = np.where(means["peak"] > 0.0, means["peak"], np.nan)
    density = 1e-6 * means["peak"] / spacing**2
    measures.append(of("peaks", density, "1/mm2", "higher than all eight neighbours"))
    if share[0] > 0.0:
        measures += [
            of(
                "mean height of peaks",
                means["peak height"] / share / np.sqrt(means["square"]),
                "rms height",
            ),
            of("mean curvature of peaks", 1e-3 * means["peak curvature"] / share, "1/mm"),
        ]
    return measures


def increments(heights: np.ndarray, spacing: float) -> Increments:
    """Compute RMS height differences of a wall (y, x) [m] over all of `lags_of`."""
    lags = lags_of(min(heights.shape))
    rms = [
        np.array([np.sqrt(np.nanmean(order(heights, axis, lag) ** 2)) for lag in lags])
        for order in (difference, second_difference)
        for axis in "xy"
    ]
    return Increments(lags * spacing, *rms)


def hurst_of(heights: np.ndarray) -> float:
    """Estimate the Hurst exponent of a wall (y, x) from second differences in both directions.

    H is the slope of the logarithm of their rms over that of their distance, from two cells to a
    quarter of the wall. Second differences do not depend on the plane that was removed, nor on
    waves longer than the wall. These make H from first differences too low by 0.1 and more (Kent &
    Wood 1997; docs/two_scans.md).
    """
    return _scaling(heights, 1.0)["H, both directions"]


def _fitted_lags(heights: np.ndarray) -> np.ndarray:
    return lags_of(min(heights.shape))[1:]


def _scaling(heights: np.ndarray, spacing: float) -> dict[str, float]:
    """Return measures that depend on the longest waves: rms height [m], slopes, Hurst exponents."""
    computed = increments(heights, spacing)
    distances = computed.distances[1:]
    squares = {
        "H along x": computed.second_x**2,
        "H along y": computed.second_y**2,
        "H, both directions": computed.second_x**2 + computed.second_y**2,
        "H by first differences": computed.x**2 + computed.y**2,
    }
    exponents = {name: float(_slope(distances, values[1:])) for name, values in squares.items()}
    slopes = np.array(
        [computed.x[0], computed.y[0], np.hypot(computed.x[0], computed.y[0]) / np.sqrt(2.0)]
    )
    lengths = {"rms height": float(np.nanstd(heights))}
    lengths |= dict(zip(_SLOPES, (slopes / spacing).tolist(), strict=True))
    for lag in _relation_lags(heights.shape, spacing):
        both = [np.nanmean(difference(heights, axis, lag) ** 2) for axis in "xy"]
        lengths[f"Z2 at {lag}"] = float(np.sqrt(np.mean(both))) / (lag * spacing)
    return lengths | exponents


def _scatter(
    long: dict[str, Any], shape: tuple[int, int], spacing: float, seed: int
) -> dict[str, np.ndarray]:
    """Return `_scaling` with its scatter over synthetic walls: (1 + DRAWS,), the wall itself first.

    Heights and slopes scatter by factors, exponents by differences.
    """
    hurst = min(max(long["H, both directions"], 0.05), 1.0)
    shape = (min(shape[0], LARGEST_DRAW), min(shape[1], LARGEST_DRAW))
    draws = []
    for number in range(DRAWS):
        random = generator(seed_of(seed, "scatter", number))
        wall = synthetic_wall(long[_SLOPES[2]], shape, spacing, hurst, random, "expectation")
        draws.append(_scaling(wall, spacing))
    scatter = {}
    for name, measured in long.items():
        values = np.array([draw[name] for draw in draws])
        exponent = name.startswith("H")
        around = (
            measured + values - values.mean() if exponent else measured * values / values.mean()
        )
        scatter[name] = np.insert(around, 0, measured)
    return scatter


def _fields(heights: np.ndarray, spacing: float) -> Any:
    """Generate (name, values at cells (y, x), NaN where undefined)."""
    yield "square", (heights - np.nanmean(heights)) ** 2
    for axis in "xy":
        yield ("curvature", axis), (second_difference(heights, axis, 1) / spacing**2) ** 2
    curvature = mean_curvature(heights, spacing)
    peaks = peak_cells(heights)
    known = np.isfinite(curvature)
    above = np.where(np.isfinite(heights), heights - np.nanmean(heights), 0.0)
    yield "peak", np.where(known, peaks, np.nan)
    yield "peak height", np.where(known, peaks * above, np.nan)
    yield "peak curvature", np.where(known, np.where(peaks, curvature, 0.0), np.nan)


def _resampled_means(
    heights: np.ndarray, spacing: float, resamples: int, seed: int
) -> dict[Any, np.ndarray]:
    """Return means of all fields: (1 + resamples,), those of the whole wall first."""
    side = min(heights.shape) // TILES
    rows, columns = (-(-n // side) for n in heights.shape)
    tiles = rows * columns
    drawn = generator(seed_of(seed, "tiles")).multinomial(
        tiles, np.full(tiles, 1.0 / tiles), resamples
    )
    weights = np.vstack([np.ones(tiles), drawn])
    means = {}
    for name, values in _fields(heights, spacing):
        y, x = np.indices(values.shape) // side
        tile = (y * columns + x).ravel()
        known = np.isfinite(values).ravel()
        sums = np.bincount(tile[known], values.ravel()[known], tiles)
        counts = np.bincount(tile[known], minlength=tiles)
        with np.errstate(invalid="ignore"):
            means[name] = (weights @ sums) / (weights @ counts)
    return means


def _slope(distances: np.ndarray, squares: np.ndarray) -> np.ndarray:
    """Fit H by least squares: half the slope of log mean square difference over log distance."""
    logs = np.log(distances) - np.mean(np.log(distances))
    return 0.5 * np.tensordot(logs, np.log(np.asarray(squares)), axes=1) / np.sum(logs**2)


def _lag(relation: Relation, spacing: float) -> int:
    """Return the relation's interval in cells, or 0 if it is not a whole number of cells."""
    ratio = relation.interval / spacing
    return round(ratio) if ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio else 0


def _relation_lags(shape: tuple[int, int], spacing: float) -> list[int]:
    """Return intervals of relations in whole cells, up to a quarter of the wall."""
    lags = {_lag(relation, spacing) for relation in RELATIONS.values()}
    return sorted(lag for lag in lags if 0 < lag <= lags_of(min(shape))[-1])


def _jrc(relation: Relation, scatter: dict[str, Any], spacing: float, hurst: float) -> Any:
    """Return JRC (n,) by a relation with the scatter of its slope, and a remark on its source."""
    lag = _lag(relation, spacing)
    if f"Z2 at {lag}" in scatter:
        slope = scatter[f"Z2 at {lag}"]
        how = f"Z2 at its {1e3 * relation.interval:g} mm"
    else:
        carried = (relation.interval / spacing) ** (hurst - 1.0)
        slope = scatter[_SLOPES[2]] * carried
        how = f"Z2 carried from {1e3 * spacing:g} to its {1e3 * relation.interval:g} mm by H"
    jrc = relation.jrc(slope)
    inside = relation.smallest_jrc <= jrc[0] <= relation.largest_jrc
    range_ = f"{relation.smallest_jrc:g} to {relation.largest_jrc:g}"
    return jrc, f"{how}; holds for JRC {range_}" + ("" if inside else ": OUTSIDE")

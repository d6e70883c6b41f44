"""What a wall's roughness is, with an uncertainty: slopes, JRC, Hurst exponent, curvature, peaks.

Slopes, JRC, curvature and peaks are made of means over cells, and these of sums over tiles of the
wall. Tiles are drawn again and again (a block bootstrap): neighbouring cells are not independent,
tiles nearly are. The rms height and the Hurst exponents are made by what is as long as the wall, of
which tiles know nothing: synthetic walls of the same slope and exponent tell how they scatter.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.parameters import InputError
from jointclosure.randomness import generator, seed_of
from jointclosure.surface.roughness import RELATIONS, Relation
from jointclosure.surface.synthesis import synthetic_wall

TILES = 6
"""Tiles along the shorter side."""
SMALLEST_WALL = 24
"""Cells along the shorter side: four for each tile."""
DRAWS, LARGEST_DRAW = 100, 400
"""Synthetic walls, and the largest number of cells along their sides: smaller ones scatter more."""


class Measure(NamedTuple):
    """A measured quantity with the limits of its confidence interval."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    remark: str = ""


class Increments(NamedTuple):
    """RMS differences of heights over distances, all [m]: the root structure function.

    ``x`` and ``y`` are those of two heights along each axis, ``second_x`` and ``second_y`` second
    differences, of three heights at equal distances.
    """

    distances: np.ndarray
    x: np.ndarray
    y: np.ndarray
    second_x: np.ndarray
    second_y: np.ndarray


def lags_of(cells: int) -> np.ndarray:
    """Distances in cells, about evenly spaced in their logarithm, up to a quarter of the wall."""
    return np.unique(np.round(np.geomspace(1.0, max(cells // 4, 2), 14)).astype(int))


def measure_wall(
    heights: np.ndarray,
    spacing: float,
    *,
    resamples: int = 1000,
    confidence: float = 0.95,
    seed: int = 1,
) -> list[Measure]:
    """All measures of a wall.

    Parameters
    ----------
    heights : array (y, x)
        Plane-detrended heights [m], outwards, NaN where missing.
    spacing : float
        Grid spacing [m].
    resamples, confidence, seed
        Of the block bootstrap.

    Returns
    -------
    list of Measure
        See docs/measured_walls.md for the definition of each.

    Raises
    ------
    InputError
        Fewer cells along a side than `SMALLEST_WALL`.
    """
    if min(heights.shape) < SMALLEST_WALL:
        raise InputError(
            f"{heights.shape[0]} x {heights.shape[1]} cells (y, x): "
            f"measures need at least {SMALLEST_WALL} along each side"
        )
    if not np.nanstd(heights) > 0.0:
        raise InputError("all heights are the same: there is no roughness to be measured")
    means = _resampled_means(heights, spacing, resamples, seed)
    tail = 50.0 * (1.0 - confidence)

    def of(name: str, values: np.ndarray, unit: str, remark: str = "") -> Measure:
        low, high = np.nanpercentile(values[1:], [tail, 100.0 - tail])
        return Measure(name, float(values[0]), float(low), float(high), unit, remark)

    rms = np.sqrt(means["square"])
    slope = np.sqrt(_both(means, 1)) / spacing
    long = _scaling(heights, spacing)
    scatter = _scatter(long, slope[0], heights.shape, spacing, seed)
    reach = "over {:g} to {:g} mm".format(*1e3 * spacing * _fitted_lags(heights)[[0, -1]])
    found = [of("rms height", 1e3 * long["rms"] * scatter["rms"], "mm")]
    for axis in "xy":
        found.append(of(f"Z2 along {axis}", np.sqrt(means[axis, 1]) / spacing, "1"))
    found.append(of("Z2, both directions", slope, "1"))
    for name in ("H along x", "H along y", "H, both directions"):
        found.append(of(name, long[name] + scatter[name], "1", reach))
    first = long["H by first differences"] + scatter["H by first differences"]
    found.append(of("H by first differences", first, "1", f"{reach}; lower, see the docs"))
    for name, relation in RELATIONS.items():
        values, remark = _jrc(relation, means, spacing, first[0])
        found.append(of(f"JRC, {name}", values, "1", remark))
    bends = {axis: 1e-3 * np.sqrt(means["second", axis, 1]) / spacing**2 for axis in "xy"}
    for axis in "xy":
        found.append(of(f"rms curvature along {axis}", bends[axis], "1/mm"))
    share = np.where(means["peak"] > 0.0, means["peak"], np.nan)
    density = 1e-6 * means["peak"] / spacing**2
    found.append(of("peaks", density, "1/mm2", "higher than all eight neighbours"))
    if share[0] > 0.0:
        found += [
            of("mean height of peaks", means["peak height"] / share / rms, "rms height"),
            of("mean curvature of peaks", 1e-3 * means["peak bend"] / share, "1/mm"),
        ]
    return found


def increments(heights: np.ndarray, spacing: float) -> Increments:
    """RMS height differences of a wall (y, x) [m] over all of `lags_of`."""
    lags = lags_of(min(heights.shape))
    rms = [
        np.array([np.sqrt(np.nanmean(order(heights, axis, lag) ** 2)) for lag in lags])
        for order in (_difference, _second_difference)
        for axis in "xy"
    ]
    return Increments(lags * spacing, *rms)


def slope_correlation(heights: np.ndarray, lags: np.ndarray, axis: str) -> np.ndarray:
    """Correlation of the slopes along an axis with those so many cells further on."""
    steps = _difference(heights, axis, 1)
    if axis == "y":
        steps = steps.T
    size = np.nanmean(steps**2)
    return np.array(
        [np.nanmean(steps[:, : steps.shape[1] - lag] * steps[:, lag:]) / size for lag in lags]
    )


def peak_cells(heights: np.ndarray) -> np.ndarray:
    """Whether a cell (y, x) is higher than its eight neighbours; never at the edge."""
    here = heights[1:-1, 1:-1]
    higher = np.ones(here.shape, bool)
    ny, nx = heights.shape
    for down in (0, 1, 2):
        for right in (0, 1, 2):
            if (down, right) != (1, 1):
                higher &= here > heights[down : ny - 2 + down, right : nx - 2 + right]
    return np.pad(higher, 1)


def mean_curvature(heights: np.ndarray, spacing: float) -> np.ndarray:
    """Half of -(z_xx + z_yy) [1/m] by second differences: positive on peaks, NaN at edges."""
    curvature = np.full(heights.shape, np.nan)
    curvature[1:-1, 1:-1] = -0.5 * sum(
        (before - 2.0 * heights[1:-1, 1:-1] + after) / spacing**2
        for before, after in (
            (heights[1:-1, :-2], heights[1:-1, 2:]),
            (heights[:-2, 1:-1], heights[2:, 1:-1]),
        )
    )
    return curvature


def hurst_of(heights: np.ndarray) -> float:
    """Hurst exponent of a wall (y, x), both directions together, by second differences.

    H is the slope of the logarithm of their rms over that of their distance, from two cells to a
    quarter of the wall. Unlike first differences they know nothing of the plane that was
    removed, nor of what is longer than the wall, which make H come out low by 0.1 and more
    (Kent & Wood 1997; docs/measured_walls.md).
    """
    return _scaling(heights, 1.0)["H, both directions"]


def _fitted_lags(heights: np.ndarray) -> np.ndarray:
    return lags_of(min(heights.shape))[1:]


def _scaling(heights: np.ndarray, spacing: float) -> dict[str, float]:
    """Measures of what is as long as the wall: rms height [m] and Hurst exponents."""
    found = increments(heights, spacing)
    distances = found.distances[1:]
    squares = {
        "H along x": found.second_x**2,
        "H along y": found.second_y**2,
        "H, both directions": found.second_x**2 + found.second_y**2,
        "H by first differences": found.x**2 + found.y**2,
    }
    exponents = {name: float(_slope(distances, values[1:])) for name, values in squares.items()}
    return {"rms": float(np.nanstd(heights))} | exponents


def _scatter(long: dict, z2: float, shape, spacing: float, seed: int) -> dict[str, np.ndarray]:
    """How `_scaling` scatters over synthetic walls: (1 + DRAWS,), the neutral element first.

    The rms height by factors, exponents by differences.
    """
    hurst = min(max(long["H, both directions"], 0.05), 1.0)
    shape = tuple(min(cells, LARGEST_DRAW) for cells in shape)
    draws = []
    for number in range(DRAWS):
        random = generator(seed_of(seed, "scatter", number))
        draws.append(_scaling(synthetic_wall(z2, shape, spacing, hurst, random), spacing))
    scatter = {}
    for name in long:
        values = np.array([draw[name] for draw in draws])
        relative = values / values.mean() if name == "rms" else values - values.mean()
        scatter[name] = np.insert(relative, 0, 1.0 if name == "rms" else 0.0)
    return scatter


def _difference(heights: np.ndarray, axis: str, lag: int) -> np.ndarray:
    if axis == "x":
        return heights[:, lag:] - heights[:, :-lag]
    return heights[lag:] - heights[:-lag]


def _second_difference(heights: np.ndarray, axis: str, lag: int) -> np.ndarray:
    return _difference(_difference(heights, axis, lag), axis, lag)


def _fields(heights: np.ndarray, spacing: float):
    """(name, values at cells (y, x), NaN where there is none), one after the other."""
    lags = lags_of(min(heights.shape)).tolist()
    intervals = {_lag(relation, spacing) for relation in RELATIONS.values()}
    yield "square", (heights - np.nanmean(heights)) ** 2
    for axis in "xy":
        for lag in sorted(set(lags) | {lag for lag in intervals if 0 < lag <= lags[-1]}):
            yield (axis, lag), _difference(heights, axis, lag) ** 2
        for lag in lags:
            yield ("second", axis, lag), _second_difference(heights, axis, lag) ** 2
    curvature = mean_curvature(heights, spacing)
    peaks = peak_cells(heights)
    known = np.isfinite(curvature)
    above = np.where(np.isfinite(heights), heights - np.nanmean(heights), 0.0)
    yield "peak", np.where(known, peaks, np.nan)
    yield "peak height", np.where(known, peaks * above, np.nan)
    yield "peak bend", np.where(known, np.where(peaks, curvature, 0.0), np.nan)


def _resampled_means(heights: np.ndarray, spacing: float, resamples: int, seed: int) -> dict:
    """Means of all fields: (1 + resamples,), the wall's own first."""
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


def _both(means: dict, lag: int) -> np.ndarray:
    return 0.5 * (means["x", lag] + means["y", lag])


def _slope(distances: np.ndarray, squares) -> np.ndarray:
    """H by least squares: half the slope of log mean square difference over log distance."""
    logs = np.log(distances) - np.mean(np.log(distances))
    return 0.5 * np.tensordot(logs, np.log(np.asarray(squares)), axes=1) / np.sum(logs**2)


def _lag(relation: Relation, spacing: float) -> int:
    """The relation's interval in cells, 0 where it is no whole number of them."""
    ratio = relation.interval / spacing
    return round(ratio) if ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio else 0


def _jrc(relation: Relation, means: dict, spacing: float, hurst: float):
    """JRC (1 + resamples,) by a relation, and how it was come by."""
    lag = _lag(relation, spacing)
    if lag and ("x", lag) in means:
        slope = np.sqrt(_both(means, lag)) / relation.interval
        how = f"Z2 at its {1e3 * relation.interval:g} mm"
    else:
        slope = np.sqrt(_both(means, 1)) / spacing * (relation.interval / spacing) ** (hurst - 1.0)
        how = f"Z2 carried from {1e3 * spacing:g} to its {1e3 * relation.interval:g} mm by H"
    jrc = relation.jrc(slope)
    inside = relation.smallest_jrc <= jrc[0] <= relation.largest_jrc
    range_ = f"{relation.smallest_jrc:g} to {relation.largest_jrc:g}"
    return jrc, f"{how}; holds for JRC {range_}" + ("" if inside else ": OUTSIDE")

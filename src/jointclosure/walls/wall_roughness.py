"""Roughness of a wall with intervals: slopes, JRC, Hurst exponent, curvature, peaks."""

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.jrc import DEFAULT_RELATION, RELATIONS, Relation, jrc_of_z2, rms_slope
from jointclosure.walls.synthesis import Spectrum, synthetic_wall

TILES = 6
"""Tiles along the shorter side of a wall. The bootstrap draws whole tiles, because neighbouring
cells depend on each other."""
SMALLEST_WALL = 24  # cells along the shorter side: four for each tile
SCATTER_SAMPLES = 100
"""Synthetic walls or profiles whose scatter gives the intervals of measures of long waves."""
LARGEST_DRAW = 400  # most cells along a side of these walls
TAIL = 50.0 * (1.0 - 0.95)  # percentage beyond each limit of a 95 % interval
_SEED = 1  # of the random numbers of intervals, which are the same for all walls
_SLOPES = ("Z2 along x", "Z2 along y", "Z2, both directions")
"""Names of the RMS slopes of a wall."""
_EXPONENTS = ("H along x", "H along y", "H, both directions")
"""Names of the Hurst exponents of a wall."""


class Measure(NamedTuple):
    """Measured quantity with the limits of its confidence interval."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    remark: str = ""


def measure_of(name: str, values: np.ndarray, unit: str = "1", remark: str = "") -> Measure:
    """Return a measure from ``values`` (1 + n,): its value, and values that scatter as it does."""
    low, high = np.nanpercentile(values[1:], [TAIL, 100.0 - TAIL])
    return Measure(name, float(values[0]), float(low), float(high), unit, remark)


def measure_wall(heights: np.ndarray, spacing: float, *, resamples: int = 1000) -> list[Measure]:
    """Measure a wall (y, x) [m] less its plane, NaN where missing; see docs/two_scans.md.

    Intervals of local quantities are from so many ``resamples``. Raise `InputError` if the wall is
    too small, level, or has too few heights.
    """
    if min(heights.shape) < SMALLEST_WALL:
        size = heights.shape
        must = f"measures need at least {SMALLEST_WALL} along each side"
        raise InputError(f"{size[0]} x {size[1]} cells (y, x): {must}")
    if not np.nanstd(heights) > 0.0:
        raise InputError("all heights are equal: the wall has no roughness")
    for axis in "xy":
        if not np.isfinite(height_differences(heights, axis, 1, 2)).any():
            raise InputError(
                f"no three neighbouring cells along {axis} have heights, which measures need; "
                "choose a coarser grid spacing (--spacing), or export more digits of x and y"
            )
    means = _resampled_means(heights, spacing, resamples)
    measures = []

    def add(name: str, values: np.ndarray, unit: str = "1", remark: str = "") -> None:
        measures.append(measure_of(name, values, unit, remark))

    scatter = _scattered_measures(_long_wave_measures(heights, spacing), heights.shape, spacing)
    fitted = 1e3 * spacing * lags_of(min(heights.shape))[1:]
    reach = f"over {fitted[0]:g} to {fitted[-1]:g} mm"
    add("rms height", 1e3 * scatter["rms height"], "mm")
    for name in (*_SLOPES, *_EXPONENTS):
        add(name, scatter[name], remark=reach if name in _EXPONENTS else "")
    first = scatter["H by first differences"]
    add("H by first differences", first, remark=f"{reach}; lower, see the docs")
    for name, relation in RELATIONS.items():
        found = slope_over_interval(
            relation.interval, scatter, scatter[_SLOPES[2]], spacing, first[0]
        )
        jrc, remark = jrc_of_relation(relation, *found)
        used = "; the one of close" if name == DEFAULT_RELATION else ""
        add(f"JRC, {name}", jrc, remark=f"{remark}{used}")
    for axis in "xy":
        add(f"rms curvature along {axis}", 1e-3 * np.sqrt(means[f"curvature {axis}"]), "1/mm")
    share = np.where(means["peak"] > 0.0, means["peak"], np.nan)
    density = 1e-6 * means["peak"] / spacing**2
    add("peaks", density, "1/mm2", "higher than all eight neighbours")
    if share[0] > 0.0:
        height = means["peak height"] / share / np.sqrt(means["square"])
        add("mean height of peaks", height, "rms height")
        add("mean curvature of peaks", 1e-3 * means["peak curvature"] / share, "1/mm")
    return measures


def lags_of(cells: int) -> np.ndarray:
    """Return distances [cells] at about equal ratios, from one cell to a quarter of the wall."""
    return np.unique(np.round(np.geomspace(1.0, max(cells // 4, 2), 14)).astype(int))


def height_differences(heights: np.ndarray, axis: str, lag: int, order: int = 1) -> np.ndarray:
    """Return differences of a wall (y, x) over ``lag`` cells along an axis, of an ``order``.

    That of order 1 is the height further along the axis less the height of the cell.
    """
    along = heights.T if axis == "x" else heights
    for _ in range(order):
        along = along[lag:] - along[:-lag]
    return along.T if axis == "x" else along


def increments(heights: np.ndarray, spacing: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return distances [m], and RMS first and second height differences over them along x and y."""
    lags = lags_of(min(heights.shape))
    rms = {}
    for (order, prefix), axis in itertools.product(((1, ""), (2, "second_")), "xy"):
        squares = [np.nanmean(height_differences(heights, axis, lag, order) ** 2) for lag in lags]
        rms[prefix + axis] = np.sqrt(squares)
    return lags * spacing, rms


def hurst_of(heights: np.ndarray) -> float:
    """Return the Hurst exponent of a wall (y, x) by second differences of its heights.

    First differences give values that are lower by 0.1 and more.
    """
    return _long_wave_measures(heights, 1.0)[_EXPONENTS[2]]


def _long_wave_measures(heights: np.ndarray, spacing: float) -> dict[str, float]:
    """Return measures that scatter with the longest waves of a wall (y, x), of which it has few.

    They are the rms height [m], RMS slopes Z2, and Hurst exponents.
    """
    distances, rms = increments(heights, spacing)
    both = np.hypot(rms["x"][0], rms["y"][0]) / np.sqrt(2.0)
    slopes = np.array([rms["x"][0], rms["y"][0], both]) / spacing
    scaling = {"rms height": float(np.nanstd(heights))}
    scaling |= dict(zip(_SLOPES, slopes.tolist(), strict=True))
    for lag in lags_of_relations(spacing, int(lags_of(min(heights.shape))[-1])):
        squares = [np.nanmean(height_differences(heights, axis, lag) ** 2) for axis in "xy"]
        scaling[f"Z2 at {lag}"] = float(np.sqrt(np.mean(squares))) / (lag * spacing)
    along_x = rms["second_x"] ** 2
    along_y = rms["second_y"] ** 2
    for name, values in zip(_EXPONENTS, (along_x, along_y, along_x + along_y), strict=True):
        scaling[name] = hurst_of_squares(distances, values)
    first = rms["x"] ** 2 + rms["y"] ** 2
    return scaling | {"H by first differences": hurst_of_squares(distances, first)}


def hurst_of_squares(distances: np.ndarray, squares: np.ndarray) -> float:
    """Return the Hurst exponent: half the slope of log mean squares over log distances (n,).

    The shortest distance is left out.
    """
    logs = np.log(distances[1:]) - np.mean(np.log(distances[1:]))
    return float(0.5 * np.tensordot(logs, np.log(squares[1:]), axes=1) / np.sum(logs**2))


def _scattered_measures(
    scaling: dict[str, float], shape: tuple[int, ...], spacing: float
) -> dict[str, np.ndarray]:
    """Return each measure of a wall (1 + SCATTER_SAMPLES,).

    The first is its value, the others scatter as it does. The scatter is that of synthetic walls
    with the Hurst exponent and slope of the wall.
    """
    spectrum = Spectrum(min(max(scaling[_EXPONENTS[2]], 0.05), 1.0))
    size = (min(shape[0], LARGEST_DRAW), min(shape[1], LARGEST_DRAW))
    slope = scaling[_SLOPES[2]]
    draws = []
    for number in range(SCATTER_SAMPLES):
        random = generator(seed_of(_SEED, "scatter", number))
        wall = synthetic_wall(slope, size, spacing, spectrum, random, "expectation")
        draws.append(_long_wave_measures(wall, spacing))
    scatter = {}
    for name, value in scaling.items():
        drawn = np.array([draw[name] for draw in draws])
        scatter[name] = np.insert(scattered(name, value, drawn), 0, value)
    return scatter


def scattered(name: str, value: float, drawn: np.ndarray) -> np.ndarray:
    """Return values (n,) that scatter about a ``value`` as the drawn ones (n,) about their mean.

    For Hurst exponents their differences from the mean are kept, for other measures their ratios.
    """
    if name.startswith("H"):
        return value + drawn - drawn.mean()
    return value * drawn / drawn.mean()


def _local_quantities(heights: np.ndarray, spacing: float) -> Iterator[tuple[str, np.ndarray]]:
    """Generate quantities of single cells: name, and values (y, x), NaN where undefined."""
    yield "square", (heights - np.nanmean(heights)) ** 2
    for axis in "xy":
        yield f"curvature {axis}", (height_differences(heights, axis, 1, 2) / spacing**2) ** 2
    curvature = mean_curvature(heights, spacing)
    peaks = peak_cells(heights)
    known = np.isfinite(curvature)
    above = np.where(np.isfinite(heights), heights - np.nanmean(heights), 0.0)
    yield "peak", np.where(known, peaks, np.nan)
    yield "peak height", np.where(known, peaks * above, np.nan)
    yield "peak curvature", np.where(known, np.where(peaks, curvature, 0.0), np.nan)


def peak_cells(heights: np.ndarray, diagonal: bool = True) -> np.ndarray:
    """Return whether a cell (y, x) is above its eight or four neighbours; not at edges and gaps."""
    around = np.where(np.isnan(heights), np.inf, heights)
    ring = np.array([[diagonal, 1, diagonal], [1, 0, 1], [diagonal, 1, diagonal]])
    highest = scipy.ndimage.maximum_filter(around, footprint=ring, mode="constant", cval=np.inf)
    return heights > highest


def mean_curvature(heights: np.ndarray, spacing: float) -> np.ndarray:
    """Return -(z_xx + z_yy) / 2 [1/m] by second differences: positive on peaks, NaN at edges."""
    here = 2.0 * heights[1:-1, 1:-1]
    along_x = (heights[1:-1, :-2] - here + heights[1:-1, 2:]) / spacing**2
    along_y = (heights[:-2, 1:-1] - here + heights[2:, 1:-1]) / spacing**2
    return np.pad(-0.5 * (along_x + along_y), 1, constant_values=np.nan)


def _resampled_means(heights: np.ndarray, spacing: float, resamples: int) -> dict[str, np.ndarray]:
    """Return the mean of each local quantity, and its means in resamples: (1 + resamples,)."""
    side = min(heights.shape) // TILES
    rows, columns = (-(-n // side) for n in heights.shape)
    tiles = rows * columns
    random = generator(seed_of(_SEED, "tiles"))
    share = np.full(tiles, 1.0 / tiles)
    drawn = random.multinomial(tiles, share, resamples)
    weights = np.vstack([np.ones(tiles), drawn])
    means = {}
    for name, values in _local_quantities(heights, spacing):
        y, x = np.indices(values.shape) // side
        tile = (y * columns + x).ravel()
        known = np.isfinite(values).ravel()
        sums = np.bincount(tile[known], values.ravel()[known], tiles)
        counts = np.bincount(tile[known], minlength=tiles)
        with np.errstate(invalid="ignore"):
            means[name] = (weights @ sums) / (weights @ counts)
    return means


def lag_of(interval: float, spacing: float) -> int:
    """Return an interval [m] in cells, or 0 if it is not a whole number of cells."""
    ratio = interval / spacing
    return round(ratio) if ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio else 0


def lags_beside(interval: float, spacing: float) -> tuple[int, ...]:
    """Return the whole numbers of cells at an interval [m]: it, or those below and above it."""
    if lag := lag_of(interval, spacing):
        return (lag,)
    below = int(interval / spacing)
    return (below, below + 1) if below else ()


def lags_of_relations(spacing: float, largest: int) -> list[int]:
    """Return the numbers of cells, up to the largest, beside the intervals of `RELATIONS`."""
    lags = {lag for one in RELATIONS.values() for lag in lags_beside(one.interval, spacing)}
    return sorted(lag for lag in lags if lag <= largest)


def joint_jrc(walls: Iterable[np.ndarray], spacing: float) -> float:
    """Return the mean JRC of the walls (y, x) [m] of a joint; NaN if all are flat."""
    rough = [wall for wall in walls if rms_slope(wall, spacing) > 0.0]
    jrcs = [jrc_of_z2(rms_slope(wall, spacing), spacing, hurst_of(wall)) for wall in rough]
    return float(np.mean(jrcs)) if jrcs else float("nan")


def slope_over_interval(
    interval: float,
    scatter: dict[str, np.ndarray],
    slope: np.ndarray,
    spacing: float,
    hurst: float | np.ndarray,
) -> tuple[np.ndarray, str]:
    """Return the slope (n,) at an interval [m], and how it was found.

    It is that of heights so far apart ("Z2 at" so many cells in ``scatter``), or a power of the
    distance between those of the numbers of cells below and above. Otherwise the ``slope`` (n,) at
    the spacing [m] is carried to the interval by the Hurst exponent, of at most 1: no slope rises
    with the distance.
    """
    lags = lags_beside(interval, spacing)
    known = [scatter[f"Z2 at {lag}"] for lag in lags if f"Z2 at {lag}" in scatter]
    if known and len(known) == len(lags):
        if len(known) == 1:
            return known[0], f"Z2 at its {1e3 * interval:g} mm"
        share = math.log(interval / (lags[0] * spacing)) / math.log(lags[1] / lags[0])
        ends = " and ".join(f"{1e3 * lag * spacing:.4g}" for lag in lags)
        between = known[0] ** (1.0 - share) * known[1] ** share
        return between, f"Z2 at its {1e3 * interval:g} mm between those at {ends} mm"
    carried = slope * (interval / spacing) ** (np.minimum(hurst, 1.0) - 1.0)
    by = "H" if np.ravel(hurst)[0] <= 1.0 else "H = 1"
    return carried, f"Z2 carried from {1e3 * spacing:.4g} to its {1e3 * interval:g} mm by {by}"


def jrc_of_relation(relation: Relation, slope: np.ndarray, how: str) -> tuple[np.ndarray, str]:
    """Return JRC (n,) by a relation for slopes (n,) at its interval, and a remark.

    ``how`` describes how the slopes were found (`slope_over_interval`).
    """
    jrc = relation.jrc(slope)
    least, most = relation.smallest_jrc, relation.largest_jrc
    _, value, low, high, *_ = measure_of("", jrc)
    remark = f"{how}; holds for JRC {least:g} to {most:g}"
    if not least <= value <= most:
        return jrc, f"{remark}: OUTSIDE"
    return jrc, remark if least <= low <= high <= most else f"{remark}: the interval ends OUTSIDE"

"""Roughness of a wall with confidence intervals: slopes, JRC, Hurst exponent, curvature, peaks."""

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
SMALLEST_WALL = 24  # fewest cells along the shorter side: four for each tile
SCATTER_SAMPLES = 100
"""Number of synthetic walls, or profiles, whose scatter gives the intervals of measures that depend
on the longest waves."""
LARGEST_DRAW = 400  # largest number of cells along a side of these synthetic walls
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
    """Return a measure with its 95 % interval from ``values`` (1 + n,).

    The first of these is its value; the interval has the middle 95 % of the others, which scatter
    as the value would in repeated samples. NaN among them are ignored.
    """
    low, high = np.nanpercentile(values[1:], [TAIL, 100.0 - TAIL])
    return Measure(name, float(values[0]), float(low), float(high), unit, remark)


def measure_wall(heights: np.ndarray, spacing: float, *, resamples: int = 1000) -> list[Measure]:
    """Return the measures of roughness of a wall (y, x) [m] less its plane; see docs/two_scans.md.

    Missing heights are NaN; ``spacing`` [m] is that of the grid. Curvature and peaks have intervals
    by a bootstrap of so many ``resamples`` of tiles; the others by the scatter of synthetic walls.
    Raise `InputError` if the wall has fewer than `SMALLEST_WALL` cells along a side, if all its
    heights are equal, or if no three neighbouring cells along x or along y have heights.
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
    """Return the distances [cells] over which heights of a wall of so many cells are compared.

    They are at most 14, from one cell to a quarter of the wall, with about equal ratios.
    """
    return np.unique(np.round(np.geomspace(1.0, max(cells // 4, 2), 14)).astype(int))


def height_differences(heights: np.ndarray, axis: str, lag: int, order: int = 1) -> np.ndarray:
    """Return the height differences of a wall (y, x) [m] over ``lag`` cells along an axis.

    A difference of order 1 is the height further along the axis less that of the cell. A difference
    of order 2 is that of two such neighbouring differences. Each order takes ``lag`` cells from the
    axis. A difference with a missing height is NaN.
    """
    along = heights.T if axis == "x" else heights
    for _ in range(order):
        along = along[lag:] - along[:-lag]
    return along.T if axis == "x" else along


def increments(heights: np.ndarray, spacing: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return distances (n,) [m], and the RMS height differences (n,) [m] of a wall over these.

    Differences are by name: "x" and "y" for first differences along the axes, "second_x" and
    "second_y" for second ones. NaN are ignored.
    """
    lags = lags_of(min(heights.shape))
    rms = {}
    for (order, prefix), axis in itertools.product(((1, ""), (2, "second_")), "xy"):
        squares = [np.nanmean(height_differences(heights, axis, lag, order) ** 2) for lag in lags]
        rms[prefix + axis] = np.sqrt(squares)
    return lags * spacing, rms


def hurst_of(heights: np.ndarray) -> float:
    """Return the Hurst exponent of a wall (y, x) by second differences of its heights.

    Differences along x and y are used together. First differences would give values that are lower
    by 0.1 and more.
    """
    return _long_wave_measures(heights, 1.0)[_EXPONENTS[2]]


def _long_wave_measures(heights: np.ndarray, spacing: float) -> dict[str, float]:
    """Return the measures of a wall (y, x) [m] whose scatter is due to its few longest waves.

    They are, by name, the rms height [m], the RMS slopes Z2 at the spacing and at other numbers of
    cells, and the Hurst exponents.
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
    """Return the Hurst exponent of mean squared height differences (n,) at distances (n,).

    It is half the slope of the line through their logarithms. The first distance is left out.
    """
    logs = np.log(distances[1:]) - np.mean(np.log(distances[1:]))
    return float(0.5 * np.tensordot(logs, np.log(squares[1:]), axes=1) / np.sum(logs**2))


def _scattered_measures(
    scaling: dict[str, float], shape: tuple[int, ...], spacing: float
) -> dict[str, np.ndarray]:
    """Return for each measure of a wall its value and values that scatter about it, by name.

    Arrays (1 + SCATTER_SAMPLES,) begin with the value in ``scaling`` (`_long_wave_measures`). The
    scatter is that of synthetic walls with the Hurst exponent, slope and ``shape`` of the wall, of
    at most `LARGEST_DRAW` cells along a side.
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
    """Return values (n,) that scatter about a ``value`` as the ``drawn`` (n,) about their mean.

    Measures whose ``name`` begins with "H", Hurst exponents, keep the differences of the drawn
    values from their mean. Other measures keep the ratios of the drawn values to their mean.
    """
    if name.startswith("H"):
        return value + drawn - drawn.mean()
    return value * drawn / drawn.mean()


def _local_quantities(heights: np.ndarray, spacing: float) -> Iterator[tuple[str, np.ndarray]]:
    """Generate the quantities of single cells of which a wall (y, x) [m] has means.

    Each is a name with values (y, x), or fewer, as differences take cells; NaN where undefined.
    """
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
    """Return which cells (y, x) are peaks: higher than all eight neighbours.

    Without ``diagonal`` only the four neighbours along x and y count. Cells at the edges and beside
    missing heights are no peaks.
    """
    around = np.where(np.isnan(heights), np.inf, heights)
    ring = np.array([[diagonal, 1, diagonal], [1, 0, 1], [diagonal, 1, diagonal]])
    highest = scipy.ndimage.maximum_filter(around, footprint=ring, mode="constant", cval=np.inf)
    return heights > highest


def mean_curvature(heights: np.ndarray, spacing: float) -> np.ndarray:
    """Return the mean curvature (y, x) [1/m] of a wall, -(z_xx + z_yy) / 2 by second differences.

    It is positive on peaks, and NaN at the edges and beside missing heights.
    """
    here = 2.0 * heights[1:-1, 1:-1]
    along_x = (heights[1:-1, :-2] - here + heights[1:-1, 2:]) / spacing**2
    along_y = (heights[:-2, 1:-1] - here + heights[2:, 1:-1]) / spacing**2
    return np.pad(-0.5 * (along_x + along_y), 1, constant_values=np.nan)


def _resampled_means(heights: np.ndarray, spacing: float, resamples: int) -> dict[str, np.ndarray]:
    """Return the means of the local quantities of a wall, by name: arrays (1 + resamples,).

    The first is the mean over the wall, the others are those over tiles drawn with replacement
    (bootstrap of `TILES` tiles along the shorter side).
    """
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
    """Return an interval [m] as a number of cells of a ``spacing`` [m]; 0 if it is not whole."""
    ratio = interval / spacing
    return round(ratio) if ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio else 0


def lags_beside(interval: float, spacing: float) -> tuple[int, ...]:
    """Return the numbers of cells at an interval [m]: its own if whole, else those beside it.

    The result is empty if the interval is shorter than a cell.
    """
    if lag := lag_of(interval, spacing):
        return (lag,)
    below = int(interval / spacing)
    return (below, below + 1) if below else ()


def lags_of_relations(spacing: float, largest: int) -> list[int]:
    """Return the numbers of cells at or beside the intervals of `RELATIONS`, up to ``largest``."""
    lags = {lag for one in RELATIONS.values() for lag in lags_beside(one.interval, spacing)}
    return sorted(lag for lag in lags if lag <= largest)


def joint_jrc(walls: Iterable[np.ndarray], spacing: float) -> float:
    """Return the mean JRC, by `DEFAULT_RELATION`, of the walls (y, x) [m] of a joint.

    Flat walls do not count; it is NaN if all walls are flat.
    """
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
    """Return the RMS slope Z2 (n,) at an interval [m], and in words how it was found.

    If ``scatter`` has the slopes at the interval's number of cells ("Z2 at 4", for example), these
    are returned. If it has those at the numbers of cells below and above the interval, a power law
    of the distance interpolates. Otherwise the ``slope`` (n,) at the ``spacing`` [m] is carried to
    the interval by the Hurst exponent, but by at most 1, as no slope rises with the distance.
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
    """Return the JRC (n,) by a relation for RMS slopes (n,) at its interval, and a remark.

    The first slope is the measured one, the others give its interval. ``how`` describes how they
    were found (`slope_over_interval`). The remark says so, in which range of JRC the relation
    holds, and whether the JRC or its 95 % interval leaves that range.
    """
    jrc = relation.jrc(slope)
    least, most = relation.smallest_jrc, relation.largest_jrc
    _, value, low, high, *_ = measure_of("", jrc)
    remark = f"{how}; holds for JRC {least:g} to {most:g}"
    if not least <= value <= most:
        return jrc, f"{remark}: OUTSIDE"
    return jrc, remark if least <= low <= high <= most else f"{remark}: the interval ends OUTSIDE"

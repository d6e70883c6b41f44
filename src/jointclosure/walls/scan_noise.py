"""Noise of the heights of a scan, from its grid or from points that are close to each other."""

import itertools
import math
from functools import lru_cache

import numpy as np
import scipy

from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.planes import detrended_points
from jointclosure.walls.spectrum_end import SpectrumEnd
from jointclosure.walls.wall_roughness import height_differences

FALLING = 1.3
"""Ratio of squared height differences to the same at a longer distance, from which on passes of a
scanner lie apart. Walls and noise have at most 1, the published fracture has 1.02."""
_SAMPLE = 20_000  # most points whose nearest ones are compared
_NEIGHBOURS = 11  # nearest ones of each
_DISTANCES = 0.9 * np.geomspace(0.1, 1.6, 13)
"""Limits of their distances, in mean distances of points. None is near 1, so that the neighbours of
a grid that was turned and tilted are not parted by their directions, in which walls differ."""
_POINT_EXPONENTS = np.linspace(
    0.5, 1.0, 6
)  # Hurst exponents beside which noise of points is fitted
_NOISE_ORDER = 4
"""Order of the differences beside which noise is fitted. Waves near a roll-off of 3 mm hardly
enter; with second differences they were taken for a law without noise."""
_NOISE_LAGS = (1, 2, 3)
"""Distances of the heights in these differences [cells]; to six cells waves near a roll-off were
taken for a law without noise as well."""
_WHITE = float(math.comb(2 * _NOISE_ORDER, _NOISE_ORDER))
"""Mean square of such a difference of white noise, over its variance."""
_BLOCKS = 4  # parts of a scan along each side, of which one is left out by the jackknife
_NOISE_EXPONENTS = np.linspace(0.3, 1.0, 36)  # Hurst exponents beside which noise is fitted


def noise_of_grid(grid: Scan, rounding: float, end: SpectrumEnd | None) -> tuple[float, float]:
    """Estimate the white noise of a grid's heights: 95 % interval [m], NaN if the grid is small.

    White noise of standard deviation s adds 70 s^2 to the mean squared fourth differences of
    heights at each distance d. The differences of a self-affine wall grow as d^(2H) if the wall has
    waves shorter than the grid, sampled by the nodes, and otherwise as in a wall whose spectrum
    ends at the grid. Heights do not tell both laws apart, so that the interval contains the noise
    by both. Each fit has an amplitude along x and along y, H from 0.3 to 1, and s^2, negative ones
    too. The standard error of s^2 is found by a jackknife over `_BLOCKS` x `_BLOCKS` parts of the
    scan. The part of ``rounding``, the step of the heights [m], is subtracted. If the spectrum
    clearly ends at a circle (``end``, see `jointclosure.walls.spectrum_end`), the interval also
    contains the noise left beyond the circle. A filtered grid must not be given: the filter took
    its noise as well.
    """
    sums, counts = _squares_by_block(grid.heights, rounding)
    blocks = np.flatnonzero(counts[0] > 0)
    whole = sums.sum(axis=1)
    all_counts = counts.sum(axis=1)
    if len(blocks) < _BLOCKS or all_counts.min() < 100:
        return math.nan, math.nan
    squares = whole / all_counts
    if not (squares > 0.0).all():
        return math.nan, math.nan
    # all of the differences at the shortest lag along either axis would be noise
    most = float(squares[:: len(_NOISE_LAGS)].min()) / _WHITE
    student = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, len(blocks) - 1)
    ends = []
    for law in _growth_laws():
        without = np.array([
            _white_noise((whole - sums[:, block]) / (all_counts - counts[:, block]), law)
            for block in blocks
        ])  # fmt: skip
        half = float(student) * math.sqrt((len(blocks) - 1) * without.var())
        variance = _white_noise(squares, law)
        ends += [np.clip(variance - half, 0.0, most), np.clip(variance + half, 0.0, most)]
    if end is not None and end.clear:
        ends += [size**2 for size in end.noise_interval]
    return math.sqrt(min(ends)), math.sqrt(max(ends))


@lru_cache(maxsize=1)
def _growth_laws() -> tuple[np.ndarray, np.ndarray]:
    """Return how squared fourth differences of walls grow with the lag: (exponents, lags) twice.

    In the first law, d^(2H), walls have waves shorter than the grid; in the second law they have
    none, as their spectrum ends at the grid.
    """
    lags = np.array(_NOISE_LAGS, float)
    wave = np.pi * (np.arange(256) + 0.5) / 256.0
    square = wave[:, None] ** 2 + wave[None, :] ** 2
    along = np.array([(2.0 * np.sin(0.5 * wave * lag)) ** (2 * _NOISE_ORDER) for lag in lags])
    with_shorter = [lags ** (2.0 * exponent) for exponent in _NOISE_EXPONENTS]
    without = [along @ (square ** (-exponent - 1.0)).sum(axis=0) for exponent in _NOISE_EXPONENTS]
    return np.array(with_shorter), np.array([rows / rows[0] for rows in without])


def _squares_by_block(heights: np.ndarray, rounding: float) -> tuple[np.ndarray, np.ndarray]:
    """Return sums of squared fourth differences [m^2] less the part of rounding, and their counts.

    Both are (n, parts), with n = 2 * len(_NOISE_LAGS): each lag along y, then along x. Differences
    with a missing height are ignored.
    """
    sums = []
    counts = []
    for axis, lag in itertools.product("yx", _NOISE_LAGS):
        squares = (
            height_differences(heights, axis, lag, _NOISE_ORDER) ** 2 - _WHITE * rounding**2 / 12.0
        )
        ny, nx = (max(size, 1) for size in squares.shape)
        y, x = np.indices(squares.shape)
        block = (y * _BLOCKS // ny * _BLOCKS + x * _BLOCKS // nx)[known := np.isfinite(squares)]
        sums.append(np.bincount(block, squares[known], _BLOCKS**2))
        counts.append(np.bincount(block, minlength=_BLOCKS**2))
    return np.array(sums), np.array(counts)


def _white_noise(squares: np.ndarray, law: np.ndarray) -> float:
    """Fit the variance of white noise [m^2] beside the differences of the wall itself.

    ``squares`` (n,) are mean squared differences in the order of `_squares_by_block`, ``law``
    (exponents, lags) is the growth of a wall's differences for each Hurst exponent. The best
    exponent is taken.
    """
    fits = []
    weight = 1.0 / np.tile(_NOISE_LAGS, 2)  # about so many differences are independent
    for grown in law:
        zero = np.zeros_like(grown)
        one = np.ones_like(grown)
        columns = np.block([[grown, zero], [zero, grown], [one, one]]).T
        scaled = columns * (weight / squares)[:, None]
        parts, *_ = np.linalg.lstsq(scaled, weight, rcond=None)
        fits.append((float(((scaled @ parts - weight) ** 2).sum()), float(parts[2])))
    return min(fits)[1] / _WHITE


def noise_of_points(cloud: Cloud, distance: float) -> float:
    """Estimate the largest noise [m] of scattered points, by heights close to each other.

    ``distance`` [m] is the mean distance of neighbouring points. Mean squared height differences
    over the distance d are fitted by 2 s^2 + A d^(2H), with H from 0.5 to 1. The noise is at most s
    with H = 0.5, because few distances do not separate H from noise. Passes of a scanner that lie
    apart make differences that fall with the distance. Only distances that half of the points have
    are used: on steep rock some points are close to each other in the plan. The noise is 0 where
    these distances do not reach below 0.6 of the mean one.
    """
    points = cloud.points
    x, y, heights = points.T
    bare = detrended_points(x, y, heights)
    some = np.arange(0, len(points), -(-len(points) // _SAMPLE))
    tree = scipy.spatial.cKDTree(points[:, :2])
    near, number = tree.query(points[some, :2], k=min(_NEIGHBOURS + 1, len(points)))
    apart = near[:, 1:].ravel() / distance
    squares = ((bare[some, None] - bare[number[:, 1:]]) ** 2).ravel()
    most = 0.5 * len(some)
    _, mean = _means_by_distance(apart, squares, _DISTANCES, most)
    least = np.minimum.accumulate(mean[::-1])[::-1]  # at this distance and beyond
    if (mean > FALLING * least).any():
        return math.sqrt(0.5 * float((mean - least).max()))
    middle, mean = _means_by_distance(apart, squares, _DISTANCES[::2], most)
    if not len(mean) or middle[0] > 0.6 or not (mean > 0.0).all():
        return 0.0
    fits = []
    for exponent in _POINT_EXPONENTS:
        columns = np.stack([np.ones_like(middle), middle ** (2.0 * exponent)])
        parts, misfit = scipy.optimize.nnls((columns / mean).T, np.ones(len(mean)))
        fits.append((misfit, parts[0]))
    return math.sqrt(0.5 * min(min(fits)[1], fits[0][1]))


def _means_by_distance(
    apart: np.ndarray, squares: np.ndarray, edges: np.ndarray, most: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return means of distances and of squares (n,) in bins, given the edges of the bins.

    Bins with fewer than ``most`` values are left out.
    """
    place = np.digitize(apart, edges)
    count = np.bincount(place, minlength=len(edges) + 1)
    kept = count >= most
    kept[[0, -1]] = False
    middle, mean = (
        np.bincount(place, values, len(count))[kept] / count[kept] for values in (apart, squares)
    )
    return middle, mean

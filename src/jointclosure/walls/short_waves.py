"""Short waves that the heights of a scan lack, as after a filter or an interpolation.

A self-affine wall has a Hurst exponent H of at most 1, so that its mean squared third differences
grow with the distance d of the heights by at most d^2. Smooth heights reach d^6. Heights that were
filtered, or interpolated between points farther apart, grow like smooth ones at short distances.
"""

import itertools
import math
from functools import lru_cache

import numpy as np

from jointclosure.walls.gridding import Scan, points_of
from jointclosure.walls.neighbours import neighbour_pairs
from jointclosure.walls.wall_roughness import height_differences

STEEPEST = 3.0
"""Growth of squared third differences, as a power of the distance, from which short waves are
missing: half-way between the steepest rough wall (2) and heights whose slopes are such walls (4).
The differences are the means of both directions."""
ALONG = 3.5
"""The same along one direction, of which fewer differences are known."""
TIES = 0.02
"""Share of neighbours of equal height beyond that by rounding from which heights come from a rank
filter. A median of 3 x 3 to 7 x 7 heights makes 0.065 to 0.12, and heights with digits make 0."""
MEDIAN_WIDTH = math.sqrt((3**2 - 1) / 12.0)  # standard deviation of 3 points, in their distance
_ORDER = 3  # of the differences by which filters are found
_LAGS = (1, 2, 3, 4, 6, 8)  # distances of the heights in these differences [cells]
_HALF = 2.0 * math.pi / math.sqrt(math.log(2.0))
"""Wavelength at which a Gaussian filter leaves half of the power, over its standard deviation."""
_WIDTHS = np.concatenate([[0.0], np.geomspace(0.3, 8.0, 40)])
"""Standard deviations [cells] of the Gaussian filters that are compared with a scan; 0: none."""
_EXPONENTS = np.linspace(0.5, 1.0, 6)  # Hurst exponents of the walls that are compared


def shortest_wave(grid: Scan, rounding: float) -> float:
    """Return the wavelength [m] at which a grid lost half of its power; 0 without such a loss.

    The wavelength belongs to the Gaussian filter whose third differences are most like the third
    differences of the heights. Heights of a rank filter have the width of a median of 3 points.
    ``rounding`` [m] is the step of the heights (`jointclosure.walls.rounding.step_of`). A grid that
    was turned has interpolated heights and appears filtered: the grid must be as it was read.
    """
    squares = [_mean_squares(grid.heights, axis, rounding) for axis in "yx"]
    filtered = _grows_faster(np.mean(squares, axis=0), STEEPEST)
    widths = [
        _filter_width(of_axis) * step if filtered or _grows_faster(of_axis, ALONG) else 0.0
        for of_axis, step in zip(squares, grid.spacing, strict=True)
    ]
    if not max(widths) and _rank_filtered(grid, rounding):
        widths = [MEDIAN_WIDTH * max(grid.spacing)]
    return _HALF * max(widths)


def _difference_growth(squares: np.ndarray) -> np.ndarray:
    """Return the powers (3,) with which squared differences (6,) grow from a lag to its double.

    The squared differences are known at `_LAGS`, or NaN; so are the powers.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.log2([squares[1] / squares[0], squares[3] / squares[1], squares[5] / squares[3]])


def _grows_faster(squares: np.ndarray, most: float) -> bool:
    return bool((np.nan_to_num(_difference_growth(squares)) > most).any())


def _mean_squares(heights: np.ndarray, axis: str, rounding: float) -> np.ndarray:
    """Return mean squared third differences [m^2] at `_LAGS` less the part of rounding.

    A lag has NaN if fewer than 100 differences are known, the wall is short, or the part of
    rounding is half of the mean or more.
    """
    side = heights.shape["yx".index(axis)]
    # mean square of such a difference of rounding errors (variance step^2 / 12), over the step^2
    noise = math.comb(2 * _ORDER, _ORDER) / 12.0
    squares = np.full(len(_LAGS), np.nan)
    for place, lag in enumerate(_LAGS):
        if 4 * _ORDER * lag > side and lag > 2:
            break
        if _ORDER * lag >= side:
            break
        values = height_differences(heights, axis, lag, _ORDER) ** 2
        if np.isfinite(values).sum() < 100:
            break
        square = float(np.nanmean(values))
        less = square - noise * rounding**2
        squares[place] = less if less > 0.5 * square else np.nan
    return squares


def _filter_width(squares: np.ndarray) -> float:
    """Return the width, in cells, of the filter that explains squared differences at `_LAGS`."""
    known = np.isfinite(squares)
    apart = _expected_log_squares()[:, :, known] - np.log(squares[known])
    misfit = apart.var(axis=-1)
    return float(_WIDTHS[np.unravel_index(misfit.argmin(), misfit.shape)[1]])


@lru_cache(maxsize=1)
def _expected_log_squares() -> np.ndarray:
    """Return log squared third differences (exponents, widths, lags) of filtered walls."""
    wave = np.pi * (np.arange(256) + 0.5) / 256.0
    square = wave[:, None] ** 2 + wave[None, :] ** 2
    along = np.array([(2.0 * np.sin(0.5 * wave * lag)) ** (2 * _ORDER) for lag in _LAGS])
    rows = []
    for exponent, width in itertools.product(_EXPONENTS, _WIDTHS):
        power = (square ** (-exponent - 1.0) * np.exp(-square * width**2)).sum(axis=0)
        rows.append(np.log(along @ power))
    return np.reshape(rows, (len(_EXPONENTS), len(_WIDTHS), len(_LAGS)))


def _rank_filtered(grid: Scan, rounding: float) -> bool:
    """Return whether more neighbouring heights are equal than rounding to a step [m] explains.

    After a median filter more are equal. False if the step is too coarse to tell.
    """
    apart = np.abs(np.diff(points_of(grid)[:, 2][neighbour_pairs(grid)], axis=1).ravel())
    if not apart.size:
        return False
    equal = float(np.mean(apart == 0.0))
    if rounding > 0.3 * math.sqrt(float(np.mean(apart**2))):  # most ties come from rounding
        return False
    one = float(np.mean(np.abs(apart - rounding) < 0.5 * rounding)) if rounding > 0.0 else 0.0
    # about as many neighbours are one step up, and as many one step down, as are equal
    return equal > 1.5 * (0.5 * one) + TIES

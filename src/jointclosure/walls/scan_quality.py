"""Resolution of a scan: short waves that its heights lack, rounding, and noise of its points.

A self-affine wall has a Hurst exponent H of at most 1, so that its mean squared third differences
grow with the distance d of the heights by at most d^2. Smooth heights reach d^6. Heights that were
filtered, or interpolated between points farther apart, grow like smooth ones at short distances.
"""

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs.remarks import Caution, caution
from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.walls.gridding import Cloud, Scan, point_distance, points_of
from jointclosure.walls.jrc import DEFAULT_RELATION, RELATIONS
from jointclosure.walls.outliers import neighbour_pairs
from jointclosure.walls.planes import detrended_points
from jointclosure.walls.spectrum_end import SpectrumEnd, spectrum_end
from jointclosure.walls.wall_roughness import height_differences

STEEPEST = 3.0
"""Growth of squared third differences, as a power of the distance, from which short waves are
missing: half-way between the steepest rough wall (2) and heights whose slopes are such walls (4).
It is that of both directions together."""
ALONG = 3.5
"""The same along one direction, of which fewer differences are known."""
TIES = 0.02
"""Share of neighbours of equal height beyond that by rounding from which heights come from a rank
filter. A median of 3 x 3 to 7 x 7 heights makes 0.065 to 0.12, and heights with digits make 0."""
MEDIAN_WIDTH = math.sqrt((3**2 - 1) / 12.0)  # standard deviation of 3 points, in their distance
MOVED = 0.02  # relative change of the rms slope from which an error of heights is a warning
FALLING = 1.3
"""Ratio of squared height differences to those at a longer distance, from which passes of a scanner
lie apart. Of walls and of noise it is at most 1, of the published fracture 1.02."""
_SAMPLE = 20_000  # most points whose nearest ones are compared
_NEIGHBOURS = 11  # nearest ones of each
_DISTANCES = 0.9 * np.geomspace(0.1, 1.6, 13)
"""Limits of their distances, in mean distances of points. None is near 1, so that the neighbours of
a grid that was turned and tilted are not parted by their directions, in which walls differ."""
_ORDER = 3  # of the differences by which filters are found
_LAGS = (1, 2, 3, 4, 6, 8)  # distances of the heights in these differences [cells]
_HALF = 2.0 * math.pi / math.sqrt(math.log(2.0))
"""Wavelength at which a Gaussian filter leaves half of the power, over its standard deviation."""
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
_WIDTHS = np.concatenate([[0.0], np.geomspace(0.3, 8.0, 40)])
"""Standard deviations [cells] of the Gaussian filters that are compared with a scan; 0: none."""
_EXPONENTS = np.linspace(0.5, 1.0, 6)  # Hurst exponents of rock


class Rounding(NamedTuple):
    """Steps [m] of which heights and places of a scan are multiples, 0 if there is none.

    ``heights`` is that of all differences of heights. ``places`` is the smaller one of those of the
    points along x and y, and 0 for a grid.
    """

    heights: float
    places: float


def step_of(values: np.ndarray) -> float:
    """Return the step of which all differences of values (n,) are multiples; 0 if there is none.

    It is found as by Euclid's algorithm: the smallest difference, then the smallest remainder of
    the others, until none is left but rounding.
    """
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 3:
        return 0.0
    rounding = 16.0 * np.finfo(float).eps * float(np.abs(levels).max())
    between = np.diff(levels)
    between = between[between > rounding]
    if len(between) < 2:
        return 0.0
    least = 1e-4 * float(np.median(between))
    step = float(between.min())
    while step > max(least, 4.0 * rounding):
        left = np.abs(between - step * np.rint(between / step))
        left = left[left > np.maximum(0.01 * step, rounding)]
        if not left.size:
            whole = between / np.rint(between / step)
            return float(np.median(whole))
        step = float(left.min())
    return 0.0


def rounding_of(scan: Scan | Cloud) -> Rounding:
    """Return the rounding of a scan by the differences of its heights, and of a cloud's places."""
    points = points_of(scan)
    if isinstance(scan, Scan):
        return Rounding(step_of(points[:, 2]), 0.0)
    return Rounding(step_of(points[:, 2]), min(step_of(points[:, 0]), step_of(points[:, 1])))


def shortest_wave(scan: Scan | Cloud, level: Scan | Cloud | None = None) -> float:
    """Return the wavelength [m] at which a scanned grid lost half of its power; 0 if it did not.

    It is that of the Gaussian filter whose third differences are most like those of the scan. A
    grid is judged as it was read, as its heights are interpolated when it is turned. Points are
    judged by the grid on which they lie as scanned, or once they are level (``level``, the scan of
    `jointclosure.walls.levelling.levelled`); without a grid they give 0.
    """
    if isinstance(scan, Cloud) and level is not None:
        scan = level
    if isinstance(scan, Cloud):
        return 0.0
    rounding = rounding_of(scan).heights
    squares = [_mean_squares(scan.heights, axis, rounding) for axis in "yx"]
    filtered = _grows_faster(np.mean(squares, axis=0), STEEPEST)
    widths = [
        _filter_width(of_axis) * step if filtered or _grows_faster(of_axis, ALONG) else 0.0
        for of_axis, step in zip(squares, scan.spacing, strict=True)
    ]
    if not max(widths) and rank_filtered(scan):
        widths = [MEDIAN_WIDTH * max(scan.spacing)]
    return _HALF * max(widths)


def difference_growth(squares: np.ndarray) -> np.ndarray:
    """Return the powers with which squared differences at `_LAGS` grow from lag to double lag."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.log2([squares[1] / squares[0], squares[3] / squares[1], squares[5] / squares[3]])


def _grows_faster(squares: np.ndarray, most: float) -> bool:
    return bool((np.nan_to_num(difference_growth(squares)) > most).any())


def _mean_squares(heights: np.ndarray, axis: str, rounding: float) -> np.ndarray:
    """Return mean squared third differences at `_LAGS` less those of rounding, NaN if unknown."""
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


def noise_of_scan(scan: Scan | Cloud) -> tuple[float, float]:
    """Estimate the standard deviation [m] of a scan's white noise: its 95 % interval, or NaN.

    Of points without a grid the least is 0, and the largest that of `noise_of_points`.
    """
    if isinstance(scan, Scan):
        return noise_of_grid(scan)
    most = noise_of_points(scan)
    return (0.0, most) if most > 0.0 else (math.nan, math.nan)


def noise_of_grid(scan: Scan) -> tuple[float, float]:
    """Estimate the white noise of a scanned grid's heights, its 95 % interval [m].

    White noise of standard deviation s adds 70 s^2 to the mean squared fourth differences of
    heights at each distance d. Those of a self-affine wall grow as d^(2H) where waves are shorter
    than the grid as well, which its nodes sample, and otherwise as those of a wall whose spectrum
    ends at the grid. Heights do not show which law holds, so that the interval contains those of
    both. Each fit has an amplitude along x and along y, H from 0.3 to 1, and s^2, which may be
    negative. Its standard error is that of a jackknife over `_BLOCKS` x `_BLOCKS` parts of the
    scan. Rounding is subtracted. The result is NaN if the scan is too small, or was filtered, which
    takes noise as well. If the spectrum clearly ends at a circle (`spectrum_end`), the interval
    also contains the noise that is left beyond the circle.
    """
    if shortest_wave(scan) > 0.0:
        return math.nan, math.nan
    sums, counts = _squares_by_block(scan.heights, rounding_of(scan).heights)
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
    end = spectrum_end(scan)
    if end is not None and end.clear:
        ends += [size**2 for size in end.noise_interval]
    return math.sqrt(min(ends)), math.sqrt(max(ends))


@lru_cache(maxsize=1)
def _growth_laws() -> tuple[np.ndarray, np.ndarray]:
    """Return how squared fourth differences of walls grow with the lag: (exponents, lags) twice.

    The first law is that of walls with waves shorter than the grid, d^(2H), the second that of
    walls without them, whose spectrum ends at the grid.
    """
    lags = np.array(_NOISE_LAGS, float)
    wave = np.pi * (np.arange(256) + 0.5) / 256.0
    square = wave[:, None] ** 2 + wave[None, :] ** 2
    along = np.array([(2.0 * np.sin(0.5 * wave * lag)) ** (2 * _NOISE_ORDER) for lag in lags])
    with_shorter = [lags ** (2.0 * exponent) for exponent in _NOISE_EXPONENTS]
    without = [along @ (square ** (-exponent - 1.0)).sum(axis=0) for exponent in _NOISE_EXPONENTS]
    return np.array(with_shorter), np.array([rows / rows[0] for rows in without])


def _squares_by_block(heights: np.ndarray, rounding: float) -> tuple[np.ndarray, np.ndarray]:
    """Return sums of squared fourth differences [m^2] less those of rounding, and their counts.

    Both are (n, parts), with n = 2 * len(_NOISE_LAGS): each lag along y, then along x.
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

    ``squares`` (n,) are mean squared differences as of `_squares_by_block`, ``law`` (exponents,
    lags) those by which a wall of each Hurst exponent grows. The best exponent is taken.
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


def rank_filtered(scan: Scan) -> bool:
    """Return whether more neighbouring heights are equal than rounding explains.

    That is so after a median filter. False if rounding is too coarse to tell.
    """
    points = points_of(scan)
    apart = np.abs(np.diff(points[:, 2][neighbour_pairs(scan)], axis=1).ravel())
    if not apart.size:
        return False
    step = step_of(points[:, 2])
    equal = float(np.mean(apart == 0.0))
    if step > 0.3 * math.sqrt(float(np.mean(apart**2))):  # too many ties are those of rounding
        return False
    one = float(np.mean(np.abs(apart - step) < 0.5 * step)) if step > 0.0 else 0.0
    # about as many neighbours are one step up, and as many one step down, as are equal
    return equal > 1.5 * (0.5 * one) + TIES


def resolution_remarks(
    scan: Scan | Cloud, wall: np.ndarray, spacing: float, level: Scan | Cloud | None = None
) -> list[Caution]:
    """Return cautions about short waves that a wall (y, x) [m] lacks, and its rounding and noise.

    Of rounding and noise of heights only those are stated that raise the squared slope of the wall
    by about 4 % (2 `MOVED`) or more, with the rms slope and the JRC that result. The noise is that
    of the scattered points of a `Cloud` (`noise_of_points`); that of grids is `noise_of_grid`, and
    is not stated here. Rounding of x and y is stated for a `Cloud`, if it is more than a tenth of
    the point distance. ``scan`` is the scan before it was levelled, ``level`` that after it, as for
    `shortest_wave`.
    """
    remarks = []
    if (wave := shortest_wave(scan, level)) > 2.0 * spacing:
        remarks.append(lost_waves(wave, spacing))
    elif isinstance(scan, Scan) and not wave:
        end = spectrum_end(scan)
        remarks += [_ended_spectrum(end)] if end is not None and end.clear else []
    steps = [np.diff(wall, axis=axis) for axis in (0, 1)]
    square = float(np.nanmean(np.concatenate([part.ravel() ** 2 for part in steps])))
    rounding = rounding_of(scan)
    # what is wrong, and the squared difference of neighbours [m^2] that comes from it
    errors = [
        (f"heights are multiples of {1e6 * rounding.heights:.4g} um", rounding.heights**2 / 6.0)
    ]
    if isinstance(scan, Cloud):
        noise = noise_of_points(scan)
        about = (
            f"heights of points close to each other scatter by up to {1e6 * noise:.2g} um rms, by "
            "noise, by passes of the scanner that lie apart, or by steep slopes"
        )
        errors.append((about, 2.0 * noise**2))
        distance = point_distance(scan)
        if rounding.places > 0.1 * distance:
            remarks.append(
                caution(
                    f"x and y are multiples of {1e3 * rounding.places:.4g} mm, at points "
                    f"{1e3 * distance:.4g} mm apart: heights lie at wrong places, which changes "
                    "slopes; export more digits of x and y"
                )
            )
    for about, excess in errors:
        if excess > 2.0 * MOVED * square:
            remarks.append(_error_caution(about, square, excess, spacing))
    return remarks


def lost_waves(wave: float, spacing: float) -> Caution:
    """Return the caution about a scan that lacks waves shorter than a length [m].

    It states which waves the grid of this spacing [m] has.
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


def noise_of_points(cloud: Cloud) -> float:
    """Estimate noise [m] of scattered points, by the heights of those that are close to each other.

    Mean squared height differences over the distance d are fitted by 2 s^2 + A d^(2H), with H from
    0.5 to 1. The noise is at most that with 0.5, because few distances do not separate H from
    noise. Passes of a scanner that lie apart make differences that fall with the distance. Only
    distances that half of the points have are used: on steep rock some points are close to each
    other in the plan. The noise is 0 where these distances do not reach below 0.6 of the mean one.
    """
    points = cloud.points
    distance = point_distance(cloud)
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
    for exponent in _EXPONENTS:
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

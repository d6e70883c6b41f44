"""Detection of probable errors in walls: of units, orientation and order, and lost slopes."""

from typing import NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import Caution, caution
from jointclosure.parameters import AS_IT_IS, USUAL
from jointclosure.parameters.units import unit_meant
from jointclosure.walls.gridding import PAPER_SPACING, Cloud, Scan, node_counts, points_of
from jointclosure.walls.planes import detrended_points
from jointclosure.walls.wall_roughness import peak_cells

_ROCK = 0.045, 0.9
"""Rms slopes of rock joints at `PAPER_SPACING`: half of those of a JRC of 1, twice those of 20."""
_USUAL_HURST = 0.8  # with which a slope is carried to another spacing or distance
_CONFUSED = {
    2.54: "inches and cm",
    10.0: "cm and mm",
    25.4: "inches and mm",
    1e3: "mm and um, or m and mm",
}
"""Ratios of units that are confused."""
_ALIKE = 0.5  # correlation of slopes from which two walls count as similar
_PAIRS = 0.75, 1.25
"""Distances of the points, in cells, whose height differences are compared with those of cells."""
INTERCHANGED = 0.9
"""Share of the cells in which the upper wall of scans with one zero of heights lies below the lower
one, from which the walls are interchanged: interchanged walls have 0.998, others 0.002."""
_SAMPLE = 20_000  # most nodes, and points, that are asked for their neighbours


def check_scans(upper: Scan | Cloud, lower: Scan | Cloud) -> None:
    """Raise `InputError` if both scans are the same, or if the length of a side is unusual."""
    clouds = points_of(upper), points_of(lower)
    if np.array_equal(*clouds):
        raise InputError(f"upper and lower: the same scan was given twice; {AS_IT_IS}")
    for cloud in clouds:
        for side in np.ptp(cloud[:, :2], axis=0).tolist() if len(cloud) else ():
            _check_side(side)


def _check_side(side: float) -> None:
    """Raise `InputError` if the length [m] of a side of a scan is not usual."""
    low, high, unit = USUAL["side_of_scan"]
    if not low <= side <= high:
        meant = unit_meant(float(f"{side:.4g}"), low, high, unit)
        raise InputError(
            f"a side of the scan is {1e3 * side:.4g} mm long: not usual of a scan "
            f"({1e3 * low:g} mm to {high:g} m); {meant} "
            "The units of the file and the spacing of its points (units and scan_spacing, --units "
            f"and --scan-spacing) determine it; {AS_IT_IS}"
        )


def check_pair(gap: np.ndarray, correlation: float, common_frame: bool) -> None:
    """Raise `InputError` if walls are interchanged, or one is a copy of the other.

    ``gap`` (y, x) [m] is the upper wall less the lower one, ``correlation`` that of their heights
    towards each other. Only scans in a ``common_frame`` show whether they are interchanged.
    """
    if abs(correlation) > 1.0 - 1e-6:
        raise InputError(
            f"upper and lower: their heights correlate by {correlation:.7g}, so that one is a "
            f"copy of the other; {AS_IT_IS}"
        )
    below = float(np.mean(gap < 0.0))
    if common_frame and below > INTERCHANGED:
        raise InputError(
            f"upper and lower: the upper wall lies below the lower one in {100.0 * below:.3g} "
            f"% of the cells, by {-1e3 * gap.mean():.3g} mm in the mean; give the files in the "
            f"other order; {AS_IT_IS}"
        )


def slope_doubts(walls: dict[str, np.ndarray], spacing: float) -> list[str]:
    """Describe walls (y, x) [m] whose slopes no rough wall has: units are probably wrong."""
    return [
        f"{name}: its rms slope is {slope:.3g}, natural walls have 0.1 to 0.6; heights and "
        "spacing must both be in m"
        for name, slope in _slopes_of_rough(walls, spacing).items()
        if not 1e-3 <= slope <= 2.0
    ]


def unit_doubts(walls: dict[str, np.ndarray], spacing: float) -> tuple[list[str], list[str]]:
    """Describe walls (y, x) [m] whose heights are probably in another unit than x and y.

    The first list are contradictions between both walls, the second walls whose slopes are unlike
    those of rock.
    """
    slopes = _slopes_of_rough(walls, spacing)
    contradictions = []
    doubts = []
    if len(slopes) == 2:
        (other, other_slope), (one, slope) = sorted(slopes.items(), key=lambda item: item[1])
        ratio = slope / other_slope
        if ratio > 4.0:  # JRC 2 and 20 have 3.8
            contradictions.append(
                f"the {one} wall is {ratio:.3g} times as steep as the {other} one (rms slopes "
                f"{slope:.3g} and {other_slope:.3g}): {_unit_question(0.5 * ratio, 2.0 * ratio)}"
            )
        # 300 clean pairs (24 to 64 cells, JRC 2 to 20, mated beyond 0.5 to 10 mm) had up to 1.14
        elif (gain := _height_ratio(walls[one], walls[other])) > 1.5:
            contradictions.append(
                f"heights of one wall are {gain:.3g} times those of the other one, with which they "
                f"are mated: {_unit_question(0.8 * gain, 1.25 * gain)}"
            )
    low, high = np.array(_ROCK) * (spacing / PAPER_SPACING) ** (_USUAL_HURST - 1.0)
    unlike = {name: slope for name, slope in slopes.items() if not low <= slope <= high}
    by_question: dict[str, list[str]] = {}
    for name, slope in unlike.items():
        factors = sorted((low / slope, high / slope, slope / low, slope / high))[2:]
        by_question.setdefault(_unit_question(*factors), []).append(name)
    for question, names in by_question.items():
        of = " and that ".join(f"{_of_wall(name)} is {unlike[name]:.3g}" for name in names)
        doubts.append(
            f"the rms slope {of}, rock joints have {low:.2g} to {high:.2g} at this spacing: "
            f"{question}"
        )
    return contradictions, doubts


def _of_wall(name: str) -> str:
    """Return words for a wall by its name: "upper", "lower", or "wall" if there is one only."""
    return "of the wall" if name == "wall" else f"of the {name} wall"


def _height_ratio(one: np.ndarray, other: np.ndarray) -> float:
    """Return the ratio (1 or more) of the heights of two mated walls, 1 if they are not mated."""
    known = np.isfinite(one + other)
    y, x = np.nonzero(known)
    a, b = (detrended_points(x, y, wall[known]) for wall in (one, other))
    ratio = float(a.std() / b.std()) if abs(np.corrcoef(a, b)[0, 1]) >= 0.8 else 1.0
    return max(ratio, 1.0 / ratio)


def _unit_question(low: float, high: float) -> str:
    """Name the confused units with a factor from ``low`` to ``high``, and the remedy."""
    nearest = min(_CONFUSED, key=lambda factor: abs(np.log(factor**2 / (low * high))))
    near = [factor for factor in _CONFUSED if low <= factor <= high] or [nearest]
    factors = " or ".join(f"{factor:g} ({_CONFUSED[factor]})" for factor in near)
    return (
        f"are its heights in another unit than x and y, by a factor of {factors}? --units is that "
        "of heights and of x and y; convert the heights, or state their unit in the name of their "
        "column (z_um). If the spacing of a grid is stated (--scan-spacing, in mm), it may be "
        "wrong instead"
    )


def _height_steps(wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return differences of neighbours along y and x, on the cells that have both."""
    return np.diff(wall, axis=0)[:, 1:], np.diff(wall, axis=1)[1:]


def _slopes_of_rough(walls: dict[str, np.ndarray], spacing: float) -> dict[str, float]:
    """Return the rms slope of each wall that is rough."""
    return {
        name: float(np.sqrt(np.mean([np.nanmean(part**2) for part in _height_steps(wall)])))
        / spacing
        for name, wall in walls.items()
        if _is_rough(wall)
    }


def doubts(upper: np.ndarray, lower: np.ndarray, spacing: float) -> list[str]:
    """Describe probable errors of units or orientation of walls (y, x) [m], towards the other."""
    doubts = slope_doubts({"upper": upper, "lower": lower}, spacing)
    if not (_is_rough(upper) and _is_rough(lower)):
        return doubts
    as_given = _slope_correlation(upper, lower)
    if as_given > _ALIKE:
        doubts.append(
            f"the walls are alike (correlation {as_given:.2f}), but one wall of a joint is the "
            "negative of the other: heights count towards the other wall, so that the heights of "
            "an upper wall scanned in the frame of the lower one are -z"
        )
    for axis, reversed_ in (("y", upper[::-1]), ("x", upper[:, ::-1])):
        fit = _slope_correlation(reversed_, lower)
        if fit < -_ALIKE and as_given > -0.5 * _ALIKE:
            doubts.append(
                f"the walls fit if the upper one is reversed along {axis} (correlation "
                f"{-fit:.2f}), and not as given ({-as_given:.2f}): is its direction right?"
            )
    return doubts


def _slope_correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Return the correlation of the slopes of two walls, 0 if one has no slopes."""
    slopes = np.array([np.concatenate([s.ravel() for s in _height_steps(w)]) for w in (one, other)])
    a, b = slopes[:, np.isfinite(slopes).all(axis=0)]
    scale = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else 0.0


def _is_rough(wall: np.ndarray) -> bool:
    """Return whether ten cells are above their four neighbours; not of a lens or lattice."""
    return int(peak_cells(wall, diagonal=False).sum()) >= 10


class Slopes(NamedTuple):
    """Rms slopes [1] of a wall over about one cell, before and after its interpolation."""

    scanned: float  # between scanned points
    kept: float  # between nodes of the grid

    @property
    def lost_square(self) -> float:
        """Mean square slope [1] that interpolation took, 0 if it took none."""
        return max(self.scanned**2 - self.kept**2, 0.0)


def slopes_by_interpolation(
    points: np.ndarray, wall: np.ndarray, spacing: float, low: np.ndarray, high: np.ndarray
) -> Slopes | None:
    """Compare slopes of scanned points (n, 3) [m] with those of a wall (y, x) [m] made of them.

    The slopes of the points are those between points which are about one cell apart. Points whose
    height is NaN are left out. The first and the last node of the wall are at ``low`` and ``high``
    (x, y) [m]. None if the nodes lie on points, or there are too few points.
    """
    place = points[:, :2]
    edge = 0.5 * spacing
    inside = ((place > low - edge) & (place < high + edge)).all(axis=1) & np.isfinite(points[:, 2])
    x, y, heights = points[inside].T
    if len(x) < 4 or min(wall.shape) < 2:
        return None
    ny, nx = (max(count, 1) for count in node_counts(low, high, spacing))
    tree = scipy.spatial.cKDTree(np.column_stack([x, y]))
    row, column = np.divmod(np.arange(0, nx * ny, -(-nx * ny // _SAMPLE)), nx)
    nearest = tree.query(low + spacing * np.column_stack([column, row]))[0] / spacing
    # nearer nodes have the height of a point, and farther ones are in a hole
    if np.mean((nearest > 1e-5) & (nearest < 0.75)) < 0.05:
        return None
    some = np.arange(0, len(x), -(-len(x) // _SAMPLE))
    pairs = tree.sparse_distance_matrix(
        scipy.spatial.cKDTree(tree.data[some]), _PAIRS[1] * spacing, output_type="coo_matrix"
    )
    apart = pairs.data / spacing
    used = apart > _PAIRS[0]
    bare = detrended_points(x, y, heights)
    rise = (bare[pairs.row] - bare[some][pairs.col])[used] / apart[used] ** _USUAL_HURST
    if not rise.any():
        return None
    along = [np.diff(wall, axis=axis) for axis in (0, 1)]
    steps = np.concatenate([(part - np.nanmean(part)).ravel() for part in along])
    scanned, kept = (float(np.sqrt(np.nanmean(part**2))) / spacing for part in (rise, steps))
    return Slopes(scanned, kept)


def smoothing_of(
    scan: Scan | Cloud,
    wall: np.ndarray,
    spacing: float,
    low: np.ndarray | None = None,
    high: np.ndarray | None = None,
) -> tuple[Caution, ...]:
    """Return a caution if heights of a wall (y, x) [m] were interpolated between points.

    It states the slopes that were lost by this (`slopes_by_interpolation`). The first and last node
    of the wall are at ``low`` and ``high`` (x, y) [m].
    """
    points = points_of(scan)
    if low is None:
        at = scan.origin or (0.0, 0.0) if isinstance(scan, Scan) else points[:, 1::-1].min(axis=0)
        low = np.array(at)[::-1]
    if high is None:
        high = low + spacing * (np.array(wall.shape)[::-1] - 1)
    slopes = slopes_by_interpolation(points, wall, spacing, low, high)
    return smoothing_caution(slopes, spacing)


def smoothing_caution(slopes: Slopes | None, spacing: float) -> tuple[Caution, ...]:
    """Return a caution on slopes of a wall that interpolation changed; none if slopes are None."""
    if slopes is None:
        return ()
    change = "smoothed" if slopes.kept < slopes.scanned else "roughened"
    lost = (
        f"interpolation onto the grid {change} the wall: its rms slope over "
        f"{1e3 * spacing:.4g} mm is {slopes.kept:.3g} instead of {slopes.scanned:.3g} "
        f"({100.0 * (slopes.kept / slopes.scanned - 1.0):+.2g} %)"
    )
    if slopes.kept < slopes.scanned:
        lost += "; on a grid of larger spacing (--spacing) less of the slope is lost"
    return (caution(lost),)

"""Detection of probable errors of units or orientation in the walls of a joint, in sentences."""

import numpy as np

from jointclosure.walls.measured import PAPER_SPACING
from jointclosure.walls.roughness import plane_through

_STEEPEST, _FLATTEST = 2.0, 1e-3
"""Rms slopes of rough walls outside of which heights and spacing probably have different units.
Natural walls have 0.1 to 0.6."""
_ROCK = 0.045, 0.9
"""Rms slopes of rock joints at `PAPER_SPACING`: half of those of a JRC of 1, twice those of 20."""
_USUAL_HURST = 0.8
"""Hurst exponent with which a slope is carried to another spacing."""
_UNLIKE = 4.0
"""Ratio of the rms slopes of both walls of a joint from which one of them has another unit. Even
walls of JRC 2 and 20 have 3.8."""
_UNLIKE_GAIN, _MATED = 1.5, 0.8
"""Ratio of the heights of walls that correlate by so much or more from which one of them has
another unit: 300 such clean pairs (24 to 64 cells a side, JRC 2 to 20, mated beyond 0.5 to 10 mm)
had at most 1.14."""
_CONFUSED = {
    2.54: "inches and cm",
    10.0: "cm and mm",
    25.4: "inches and mm",
    1e3: "mm and um, or m and mm",
}
"""Ratios of units that are confused."""
_ALIKE = 0.5
"""Correlation of slopes from which two walls count as similar."""
_SUMMITS = 10
"""Number of summits from which a wall counts as rough. A lens or a lattice may resemble its
partner."""


def slope_doubts(walls: dict[str, np.ndarray], spacing: float) -> list[str]:
    """Describe walls whose slopes no rough wall has, so that their units are probably wrong.

    Parameters
    ----------
    walls : dict
        Heights (y, x) [m] by wall, NaN where missing.
    spacing : float
        [m].
    """
    return [
        f"{name}: its rms slope is {slope:.3g}, natural walls have 0.1 to 0.6; heights and "
        "spacing must both be in m"
        for name, slope in _slopes_of_rough(walls, spacing).items()
        if not _FLATTEST <= slope <= _STEEPEST
    ]


def unit_doubts(walls: dict[str, np.ndarray], spacing: float) -> tuple[list[str], list[str]]:
    """Describe scanned walls whose heights probably have another unit than x and y.

    Arguments are those of `slope_doubts`.

    Returns
    -------
    contradictions : list of str
        Walls of which one has heights in another unit than the other one.
    doubts : list of str
        Walls that are flatter or steeper than rock joints.
    """
    slopes = _slopes_of_rough(walls, spacing)
    contradictions, doubts = [], []
    if len(slopes) == 2:
        (one, slope), (other, other_slope) = sorted(slopes.items(), key=lambda item: -item[1])
        ratio = slope / other_slope
        if ratio > _UNLIKE:
            contradictions.append(
                f"the {one} wall is {ratio:.3g} times as steep as the {other} one (rms slopes "
                f"{slope:.3g} and {other_slope:.3g}): {_suspected(0.5 * ratio, 2.0 * ratio)}"
            )
        elif (gain := _gain(walls[one], walls[other])) > _UNLIKE_GAIN:
            contradictions.append(
                f"heights of one wall are {gain:.3g} times those of the other one, with which they "
                f"are mated: {_suspected(0.8 * gain, 1.25 * gain)}"
            )
    at_spacing = (spacing / PAPER_SPACING) ** (_USUAL_HURST - 1.0)
    low, high = (limit * at_spacing for limit in _ROCK)
    for name, slope in slopes.items():
        if not low <= slope <= high:
            factors = sorted((low / slope, high / slope, slope / low, slope / high))[2:]
            doubts.append(
                f"the {name} wall has an rms slope of {slope:.3g}, rock joints have {low:.2g} to "
                f"{high:.2g} at this spacing: {_suspected(*factors)}"
            )
    return contradictions, doubts


def _gain(one: np.ndarray, other: np.ndarray) -> float:
    """Return the ratio (1 or more) of the heights of two mated walls, 1 if they are not mated."""
    known = np.isfinite(one + other)
    y, x = np.nonzero(known)
    a, b = (wall[known] - plane_through(x, y, wall[known]).at(x, y) for wall in (one, other))
    if abs(np.corrcoef(a, b)[0, 1]) < _MATED:
        return 1.0
    ratio = float(a.std() / b.std())
    return max(ratio, 1.0 / ratio)


def _suspected(low: float, high: float) -> str:
    """Name the confused units with a factor from ``low`` to ``high``, and the remedy."""
    near = [factor for factor in _CONFUSED if low <= factor <= high] or [
        min(_CONFUSED, key=lambda factor: abs(np.log(factor**2 / (low * high))))
    ]
    factors = " or ".join(f"{factor:g} ({_CONFUSED[factor]})" for factor in near)
    return (
        f"are its heights in another unit than x and y, by a factor of {factors}? --units is that "
        "of heights and of x and y; convert the heights, or state their unit in the name of their "
        "column (z_um)"
    )


def _slopes_of_rough(walls: dict[str, np.ndarray], spacing: float) -> dict[str, float]:
    """Return the rms slope of each wall that is rough."""
    return {
        name: float(np.sqrt(np.mean([np.nanmean(part**2) for part in _slopes(wall)]))) / spacing
        for name, wall in walls.items()
        if _is_rough(wall)
    }


def doubts(upper: np.ndarray, lower: np.ndarray, spacing: float) -> list[str]:
    """Describe probable errors of units or of orientation, in sentences.

    Parameters
    ----------
    upper, lower : array (y, x)
        Heights towards the other wall [m], NaN where missing.
    spacing : float
        [m].
    """
    doubts = slope_doubts({"upper": upper, "lower": lower}, spacing)
    if not (_is_rough(upper) and _is_rough(lower)):
        return doubts
    fits = {
        "": _likeness(upper, lower),
        "y": _likeness(upper[::-1], lower),
        "x": _likeness(upper[:, ::-1], lower),
    }
    if fits[""] > _ALIKE:
        doubts.append(
            f"the walls are alike (correlation {fits['']:.2f}), but one wall of a joint is the "
            "negative of the other: heights count towards the other wall, so that the heights of "
            "an upper wall scanned in the frame of the lower one are -z"
        )
    for axis in ("y", "x"):
        if fits[axis] < -_ALIKE and fits[""] > -0.5 * _ALIKE:
            doubts.append(
                f"the walls fit if the upper one is reversed along {axis} (correlation "
                f"{-fits[axis]:.2f}), and not as given ({-fits['']:.2f}): is its direction right?"
            )
    return doubts


def _slopes(wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return differences of neighbours along y and x, on the cells that have both."""
    return np.diff(wall, axis=0)[:, 1:], np.diff(wall, axis=1)[1:]


def _likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Return the correlation of the slopes of two walls, 0 if one has no slopes."""
    a, b = (np.concatenate([part.ravel() for part in _slopes(wall)]) for wall in (one, other))
    known = np.isfinite(a) & np.isfinite(b)
    a, b = a[known], b[known]
    scale = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else 0.0


def _is_rough(wall: np.ndarray) -> bool:
    """Return whether enough inner cells of a wall are higher than their four neighbours."""
    if min(wall.shape) < 3:
        return False
    inner = wall[1:-1, 1:-1]
    beside = (wall[:-2, 1:-1], wall[2:, 1:-1], wall[1:-1, :-2], wall[1:-1, 2:])
    return int(np.logical_and.reduce([inner > side for side in beside]).sum()) >= _SUMMITS

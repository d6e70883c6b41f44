"""Detection of probable errors in walls on a grid: of units, orientation and order.

Every rough wall is compared by its rms slope. A wall is rough if ten cells are above their four
neighbours; a lens or a lattice, with fewer such cells, is not judged.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.parameters import AS_IT_IS
from jointclosure.walls.gridding import PAPER_SPACING, USUAL_HURST
from jointclosure.walls.planes import detrended_points
from jointclosure.walls.wall_roughness import peak_cells

_ROCK = 0.045, 0.9
"""Rms slopes of rock joints at `PAPER_SPACING`: half of those of a JRC of 1, twice those of 20."""
_CONFUSED = {
    2.54: "inches and cm",
    10.0: "cm and mm",
    25.4: "inches and mm",
    1e3: "mm and um, or m and mm",
}
"""Ratios of units that are confused."""
_ALIKE = 0.5  # correlation of slopes from which two walls count as similar
INTERCHANGED = 0.9
"""Share of the cells in which the upper wall of scans with one zero of heights lies below the lower
one, from which on the walls are interchanged: interchanged walls have 0.998, others 0.002."""


class UnitDoubts(NamedTuple):
    """Sentences on walls whose heights are probably in another unit than x and y."""

    impossible: list[str]  # slopes that no rough wall has
    contradictions: list[str]  # between the walls of a pair; none for a single wall
    unlike_rock: list[str]  # slopes that joints in rock do not have


def check_pair(gap: np.ndarray, correlation: float, common_frame: bool) -> None:
    """Raise `InputError` if walls are interchanged, or one is a copy of the other.

    ``gap`` (y, x) [m] is the upper wall less the lower one, ``correlation`` the correlation of the
    heights towards each other. Only scans in a ``common_frame`` show an interchange.
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


def unit_doubts(walls: Mapping[str, np.ndarray], spacing: float) -> UnitDoubts:
    """Describe walls whose heights are probably in another unit than x and y.

    ``walls`` are heights (y, x) [m], NaN where missing, by names: "upper" and "lower" for both
    walls of a joint, "wall" for a single one. Walls that are not rough are ignored.
    """
    slopes = _slopes_of_rough(walls, spacing)
    return UnitDoubts(
        _impossible(slopes), _contradictions(walls, slopes), _unlike_rock(slopes, spacing)
    )


def check_units(doubts: UnitDoubts) -> None:
    """Raise `InputError` if a wall has slopes of no rough wall, or both contradict each other."""
    if doubts.impossible or doubts.contradictions:
        problems = doubts.contradictions or doubts.unlike_rock or doubts.impossible
        raise InputError(f"{'; '.join(problems)}; {AS_IT_IS}")


def _impossible(slopes: dict[str, float]) -> list[str]:
    """Describe rms slopes that no rough wall has."""
    return [
        f"{name}: its rms slope is {slope:.3g}, natural walls have 0.1 to 0.6; heights and "
        "spacing must both be in m"
        for name, slope in slopes.items()
        if not 1e-3 <= slope <= 2.0
    ]


def _contradictions(walls: Mapping[str, np.ndarray], slopes: dict[str, float]) -> list[str]:
    """Describe two rough walls (y, x) [m] whose slopes, or heights where they mate, differ much."""
    if len(slopes) < 2:
        return []
    (other, other_slope), (one, slope) = sorted(slopes.items(), key=lambda item: item[1])
    ratio = slope / other_slope
    if ratio > 4.0:  # JRC 2 and 20 have 3.8
        return [
            f"the {one} wall is {ratio:.3g} times as steep as the {other} one (rms slopes "
            f"{slope:.3g} and {other_slope:.3g}): {_unit_question(0.5 * ratio, 2.0 * ratio)}"
        ]
    # 300 clean pairs (24 to 64 cells, JRC 2 to 20, mated beyond 0.5 to 10 mm) had up to 1.14
    if (gain := _height_ratio(walls[one], walls[other])) > 1.5:
        return [
            f"heights of one wall are {gain:.3g} times those of the other one, with which they "
            f"are mated: {_unit_question(0.8 * gain, 1.25 * gain)}"
        ]
    return []


def _unlike_rock(slopes: dict[str, float], spacing: float) -> list[str]:
    """Describe rms slopes at a spacing [m] that are unlike the slopes of rock joints.

    Walls with the same question about their units share a sentence.
    """
    low, high = np.array(_ROCK) * (spacing / PAPER_SPACING) ** (USUAL_HURST - 1.0)
    unlike = {name: slope for name, slope in slopes.items() if not low <= slope <= high}
    by_question: dict[str, list[str]] = {}
    for name, slope in unlike.items():
        factors = sorted((low / slope, high / slope, slope / low, slope / high))[2:]
        by_question.setdefault(_unit_question(*factors), []).append(name)
    doubts = []
    for question, names in by_question.items():
        of = " and that ".join(f"{_of_wall(name)} is {unlike[name]:.3g}" for name in names)
        doubts.append(
            f"the rms slope {of}, rock joints have {low:.2g} to {high:.2g} at this spacing: "
            f"{question}"
        )
    return doubts


def _of_wall(name: str) -> str:
    """Return words for a wall by its name: "upper", "lower", or "wall" for a single one."""
    return "of the wall" if name == "wall" else f"of the {name} wall"


def _height_ratio(one: np.ndarray, other: np.ndarray) -> float:
    """Return the ratio (1 or more) of the heights of two mated walls, 1 if they do not mate.

    Cells in which a wall (y, x) [m] has NaN are ignored.
    """
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
    """Return differences of neighbours along y and x (ny - 1, nx - 1) [m]."""
    return np.diff(wall, axis=0)[:, 1:], np.diff(wall, axis=1)[1:]


def _slopes_of_rough(walls: Mapping[str, np.ndarray], spacing: float) -> dict[str, float]:
    """Return the rms slope of each rough wall (y, x) [m] by its name."""
    return {
        name: float(np.sqrt(np.mean([np.nanmean(part**2) for part in _height_steps(wall)])))
        / spacing
        for name, wall in walls.items()
        if _is_rough(wall)
    }


def doubts(upper: np.ndarray, lower: np.ndarray, spacing: float) -> list[str]:
    """Describe probable errors of units or orientation of walls (y, x) [m] towards each other.

    Orientations are compared only if both walls are rough.
    """
    slopes = _slopes_of_rough({"upper": upper, "lower": lower}, spacing)
    doubts = _impossible(slopes)
    both_rough = len(slopes) == 2
    if not both_rough:
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
    """Return the correlation of the slopes of two walls (y, x) [m], 0 if one has no slopes."""
    slopes = np.array([np.concatenate([s.ravel() for s in _height_steps(w)]) for w in (one, other)])
    a, b = slopes[:, np.isfinite(slopes).all(axis=0)]
    scale = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else 0.0


def _is_rough(wall: np.ndarray) -> bool:
    """Return whether ten cells of a wall (y, x) are above their four neighbours."""
    return int(peak_cells(wall, diagonal=False).sum()) >= 10

"""Detection of probable errors of units or orientation in the walls of a joint, in sentences."""

import numpy as np

_STEEPEST, _FLATTEST = 2.0, 1e-3
"""Rms slopes of rough walls outside of which heights and spacing probably have different units.
Natural walls have 0.1 to 0.6."""
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
    doubts = []
    for name, wall in walls.items():
        if not _is_rough(wall):
            continue
        slope = float(np.sqrt(np.mean([np.nanmean(part**2) for part in _slopes(wall)]))) / spacing
        if not _FLATTEST <= slope <= _STEEPEST:
            doubts.append(
                f"{name}: its rms slope is {slope:.3g}, natural walls have 0.1 to 0.6; heights "
                "and spacing must both be in m"
            )
    return doubts


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

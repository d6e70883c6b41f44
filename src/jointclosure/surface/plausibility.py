"""What looks like a slip of units or of orientation in the walls of a joint, in sentences."""

import numpy as np

_STEEPEST, _FLATTEST = 2.0, 1e-3
"""Rms slopes of rough walls beyond which their heights rather have another unit than the spacing:
natural ones have 0.1 to 0.6."""
_ALIKE = 0.5
"""Correlation of slopes from which two walls count as alike."""
_SUMMITS = 10
"""From as many on a wall counts as rough: a lens or a lattice may be like its partner."""


def slope_doubts(walls: dict[str, np.ndarray], spacing: float) -> list[str]:
    """Walls whose slopes no rough wall has: their heights and spacing are rather of unlike units.

    Parameters
    ----------
    walls : dict
        Heights (y, x) [m] by the wall's name, NaN where missing.
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
                f"{name}: its rms slope is {slope:.3g}, and natural walls have 0.1 to 0.6; heights "
                "and spacing are both in m"
            )
    return doubts


def doubts(upper: np.ndarray, lower: np.ndarray, spacing: float) -> list[str]:
    """What looks like a slip of units or of orientation, in sentences.

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
            f"the walls are alike (correlation {fits['']:.2f}), where those of a joint are each "
            "other's negative: heights count towards the other wall, so that of a scanned upper "
            "wall in the frame of the lower one they are -z"
        )
    for axis in ("y", "x"):
        if fits[axis] < -_ALIKE and fits[""] > -0.5 * _ALIKE:
            doubts.append(
                f"the walls mate where the upper one is turned round along {axis} (correlation "
                f"{-fits[axis]:.2f}), and not as they are ({-fits['']:.2f}): is it the other "
                f"way round?"
            )
    return doubts


def _slopes(wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Differences of neighbours along y and x, on the cells that have both."""
    return np.diff(wall, axis=0)[:, 1:], np.diff(wall, axis=1)[1:]


def _likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of the slopes of two walls, 0 where one has none."""
    a, b = (np.concatenate([part.ravel() for part in _slopes(wall)]) for wall in (one, other))
    known = np.isfinite(a) & np.isfinite(b)
    a, b = a[known], b[known]
    scale = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else 0.0


def _is_rough(wall: np.ndarray) -> bool:
    """Whether enough inner cells of a wall are higher than their four neighbours."""
    if min(wall.shape) < 3:
        return False
    inner = wall[1:-1, 1:-1]
    beside = (wall[:-2, 1:-1], wall[2:, 1:-1], wall[1:-1, :-2], wall[1:-1, 2:])
    return int(np.logical_and.reduce([inner > side for side in beside]).sum()) >= _SUMMITS

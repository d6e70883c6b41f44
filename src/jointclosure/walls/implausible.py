"""Refusal of pairs of scans that are probably wrong, before a joint is closed."""

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.parameters import AS_IT_IS, check_usual
from jointclosure.walls.measured import Cloud, Scan
from jointclosure.walls.outliers import points_of

_COPY = 1e-6
"""Smallest difference from 1 of the correlation of heights of scans of two different walls. At 1e-6
the rms difference is a thousandth of the rms height, 0.3 um of a typical wall. Even two scans of
one wall do not repeat so well."""
_CROSSED = 0.9
"""Share of cells with the upper wall below the lower one from which the walls count as
interchanged. For the published walls that were tried it is 0.998 if they are interchanged, and
0.002 if not. It is about a half if the zero of each scan is at its mean."""


def check_scans(upper: Scan | Cloud, lower: Scan | Cloud, spacing: float) -> None:
    """Raise `InputError` if both scans are the same, or do not have the size of a wall.

    ``spacing`` is that of the joint's grid [m].
    """
    clouds = points_of(upper), points_of(lower)
    if np.array_equal(*clouds):
        raise InputError(f"upper and lower: the same scan was given twice; {AS_IT_IS}")
    check_usual((), spacing=spacing)
    for cloud in clouds:
        for side in np.ptp(cloud[:, :2], axis=0).tolist() if len(cloud) else ():
            check_usual((), side_of_scan=side)


def check_pair(gap: np.ndarray, correlation: float, common_frame: bool) -> None:
    """Raise `InputError` if walls are interchanged, or one is a copy of the other.

    Parameters
    ----------
    gap : array (y, x)
        Height of the upper wall less that of the lower one as scanned, z upwards [m].
    correlation : float
        Correlation of the heights of both walls.
    common_frame : bool
        Whether both scans have the same zero of heights.
    """
    if abs(correlation) > 1.0 - _COPY:
        raise InputError(
            f"upper and lower: their heights correlate by {correlation:.7g}, so that one is a "
            f"copy of the other; {AS_IT_IS}"
        )
    below = float(np.mean(gap < 0.0))
    if common_frame and below > _CROSSED:
        raise InputError(
            f"upper and lower: the upper wall lies below the lower one in {100.0 * below:.3g} "
            f"% of the cells, by {-1e3 * gap.mean():.3g} mm in the mean; give the files in the "
            f"other order; {AS_IT_IS}"
        )

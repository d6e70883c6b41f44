"""Pairs of scans that are more often a slip than meant: refused before a joint is closed."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.parameters import AS_IT_IS, check_usual
from jointclosure.surface.measured import Cloud, Scan
from jointclosure.surface.outliers import points_of

_COPY = 1e-6
"""By what the correlation of heights of two scans of different walls is below 1 at least. At 1e-6
the rms difference is a thousandth of the rms height, 0.3 um of a typical wall: no two scans of even
one wall repeat so well."""
_CROSSED = 0.9
"""Share of the cells in which the upper wall must lie below the lower one for the walls to count as
interchanged. Of the published walls that this was tried on it is 0.998, and 0.002 in their order;
where both scans have their zero at their own mean it is about a half."""


class Implausible(NamedTuple):
    """Refuses what is implausible of two scans, unless it is meant.

    ``allowed`` is what the caller's ``unusual_values`` says.
    """

    allowed: bool

    def check_scans(self, upper: Scan | Cloud, lower: Scan | Cloud, spacing: float) -> None:
        """Raise `InputError` where both scans are one, or have no size of a wall.

        Parameters
        ----------
        upper, lower : Scan or Cloud
            In metres.
        spacing : float
            Of the joint's grid [m].
        """
        if self.allowed:
            return
        clouds = points_of(upper), points_of(lower)
        if np.array_equal(*clouds):
            raise InputError(f"upper and lower: the same scan was given twice; {AS_IT_IS}")
        check_usual((), spacing=spacing)
        for cloud in clouds:
            for side in np.ptp(cloud[:, :2], axis=0).tolist() if len(cloud) else ():
                check_usual((), side_of_scan=side)

    def check_orientation(self, stated: str, clear: str) -> None:
        """Raise `InputError` where the stated orientation is not the one that is clear."""
        if not self.allowed and stated != clear:
            raise InputError(
                f"orientation = {stated!r}: {clear} fits clearly better, and closures of walls "
                "that lie wrong are several times too large; state that one or leave it out; "
                f"{AS_IT_IS}"
            )

    def check_pair(self, gap: np.ndarray, correlation: float, common_frame: bool) -> None:
        """Raise `InputError` where walls are interchanged, or one is a copy of the other.

        Parameters
        ----------
        gap : array (y, x)
            Height of the upper wall less that of the lower one as scanned, z upwards [m].
        correlation : float
            Of the heights of both walls.
        common_frame : bool
            Whether both scans have one zero of heights.
        """
        if self.allowed:
            return
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

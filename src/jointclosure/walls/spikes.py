"""Spikes: single points of a scan that stand out from their neighbours."""

import numpy as np
import scipy

from jointclosure.walls.gridding import Cloud, Scan, points_of, without_points
from jointclosure.walls.planes import detrended_points

NEIGHBOURS = 8  # nearest points with which the height of a point is compared
ROUNDS = 4  # most rounds of spike removal: higher spikes hide others


def spike_heights(points: np.ndarray) -> np.ndarray:
    """Return by what points (n, 3) [m] exceed all neighbours but one: (n,) [m], NaN for others.

    Points that lie lower have negative values. Only sharp points count: beyond eight times the
    usual difference of neighbours. Eight points or fewer have no spikes.
    """
    found = np.full(len(points), np.nan)
    left = np.arange(len(points))
    for _ in range(ROUNDS):
        if len(left) <= NEIGHBOURS:
            break
        x, y, heights = points[left].T
        bare = detrended_points(x, y, heights)
        places = points[left, :2]
        near = scipy.spatial.cKDTree(places).query(places, k=NEIGHBOURS + 1)[1][:, 1:]
        around = np.sort(bare[near], axis=1)
        usual = np.median(np.abs(bare[near] - bare[:, None]))
        up = bare - around[:, -2]
        down = around[:, 1] - bare
        heights = np.where(up >= down, up, -down)
        sharp = np.abs(heights) > 8.0 * usual  # self-affine walls reach 2
        if not sharp.any():
            break
        found[left[sharp]] = heights[sharp]
        left = left[~sharp]
    return found


def remove_spikes(scan: Scan | Cloud) -> tuple[Scan | Cloud, str]:
    """Return a scan without its spikes, and a text that describes them, empty without spikes.

    Points of a `Cloud` are left out, and cells of a `Scan` become missing; the given scan is not
    changed.
    """
    points = points_of(scan)
    heights = spike_heights(points)
    cut = np.isfinite(heights)
    if not cut.any():
        return scan, ""
    highest = np.nanargmax(np.abs(heights))
    x, y = 1e3 * points[highest, :2]
    return without_points(scan, cut), (
        f"{int(cut.sum())} of {len(points)} points are spikes: they stand out from all but one of "
        f"their eight neighbours by {1e3 * np.nanmin(np.abs(heights)):.3g} mm or more, the "
        f"highest by {1e3 * heights[highest]:.3g} mm at (x, y) = ({x:.4g}, {y:.4g}) mm"
    )

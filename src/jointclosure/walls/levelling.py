"""Levelling: rotation of inclined scans, so that heights are normal to the mean plane.

Heights less an inclined plane belong to a sheared wall, with slopes along the dip larger by
1 / cos^2 of the inclination (12 % at 19 degrees), and places closer by the cosine.
"""

import math
from collections.abc import Mapping

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls.gridding import Cloud, Scan, points_of
from jointclosure.walls.interpolation_remarks import interpolation_remarks
from jointclosure.walls.missing_heights import fill_with_nearest
from jointclosure.walls.motion import Motion, levelling_rotation, moved_heights
from jointclosure.walls.overlap import largest_rectangle
from jointclosure.walls.planes import Plane, plane_through
from jointclosure.walls.scans.points import SCATTERED, lattice_of

LEVEL = {Cloud: 2.0, Scan: 5.0}
"""Largest inclination [degrees] that is left: slopes along the dip are 0.1 and 0.8 % too large.

A turned grid has interpolated heights, with slopes about 1 % smaller at 5 degrees.
"""
STEEPEST = 45.0  # largest inclination [degrees] of a wall that is seen along z


def _mean_plane(scan: Scan | Cloud) -> Plane:
    """Return the least-squares plane of the known heights; `InputError` with fewer than four."""
    points = points_of(scan)
    known = points[np.isfinite(points[:, 2])]
    if len(known) < 4:
        raise InputError(f"{len(known)} heights: too few for a wall")
    return plane_through(*known.T)


def slopes_of(scan: Scan | Cloud) -> tuple[float, float]:
    """Return the slopes of a scan's mean plane along x and y; `InputError` below four heights."""
    plane = _mean_plane(scan)
    return plane.slope_x, plane.slope_y


def _inclination(plane: Plane) -> float:
    """Return the angle [degrees] between a plane and the horizontal."""
    return math.degrees(math.atan(math.hypot(plane.slope_x, plane.slope_y)))


def levelled(scan: Scan | Cloud, beyond: float | None = None) -> tuple[Scan | Cloud, Motion | None]:
    """Return a scan turned until its mean plane is level, if the plane is inclined too much.

    Points are moved, and become a grid if they lie on one after this. Heights of a grid are
    interpolated at nodes of the same spacing by cubic splines, in the largest rectangle covered by
    the scan; missing heights stay missing.

    Parameters
    ----------
    scan : Scan or Cloud
        In metres.
    beyond : float, optional
        Largest inclination that is left [degrees]: by default `LEVEL`.

    Returns
    -------
    scan : Scan or Cloud
        The level scan, with a remark on the turn and, for a grid, one on slopes that interpolation
        changed; or the given one.
    motion : Motion or None
        Rotation about the middle of the scan; None if it was left.

    Raises
    ------
    InputError
        If the mean plane is inclined by more than `STEEPEST` degrees, or fewer than four heights
        are known.
    """
    plane = _mean_plane(scan)
    if not _inclination(plane) > (LEVEL[type(scan)] if beyond is None else beyond):
        return scan, None
    return _level_scan(scan, plane)


def _level_scan(scan: Scan | Cloud, plane: Plane) -> tuple[Scan | Cloud, Motion]:
    """Return a scan turned until its mean ``plane`` is level, with remarks, and the rotation.

    Raise `InputError` if the plane is inclined by more than `STEEPEST` degrees.
    """
    tilt = _inclination(plane)
    if tilt > STEEPEST:
        raise InputError(
            f"the mean plane is inclined by {tilt:.1f} degrees: at most {STEEPEST:g}; turn the "
            "scan so that its heights lie along z, unless heights and the spacing of the points "
            "are in different units"
        )
    points = points_of(scan, missing=isinstance(scan, Scan))
    middle = 0.5 * (points[:, :2].min(axis=0) + points[:, :2].max(axis=0))
    about = np.append(middle, float(plane.at(middle[0], middle[1])))
    rotation = levelling_rotation((plane.slope_x, plane.slope_y))
    motion = Motion(np.eye(3), rotation, about, about, np.zeros((3, 3)))
    remark = (
        f"the mean plane is inclined by {tilt:.1f} degrees: the scan was turned until it lies level"
    )
    if isinstance(scan, Cloud):
        return _grid_if_regular(Cloud(motion.moved(scan.points), (*scan.remarks, remark))), motion
    grid = _turned_grid(scan, motion, plane)
    moved = motion.moved(points[np.isfinite(points[:, 2])])
    low = np.array((grid.origin or (0.0, 0.0))[::-1])
    square = math.isclose(*grid.spacing, rel_tol=1e-6)
    lost = interpolation_remarks(Cloud(moved), grid.heights, grid.spacing[0], low) if square else ()
    return grid._replace(remarks=(*scan.remarks, remark, *lost)), motion


def _grid_if_regular(cloud: Cloud) -> Scan | Cloud:
    """Return points as the regular grid on which they lie, or as they are without such a grid."""
    grid = lattice_of(cloud.points)
    if grid is None or grid.heights is None:
        return cloud
    remarks = tuple(remark for remark in cloud.remarks if remark != SCATTERED)
    return Scan(grid.heights, grid.spacing, grid.origin, remarks + grid.remarks)


def _turned_grid(scan: Scan, motion: Motion, plane: Plane) -> Scan:
    """Return the heights of a grid after a motion, at nodes of the same spacing about its middle.

    The largest rectangle of nodes covered by the moved grid is kept. Heights are less the height of
    the middle, and NaN where a missing height took part. ``plane`` is the grid's mean plane.
    """
    steps = np.array(scan.spacing[::-1])
    corners = points_of(scan._replace(heights=np.zeros_like(scan.heights)))
    corners[:, 2] = plane.at(corners[:, 0], corners[:, 1])
    reach = np.abs(motion.moved(corners)[:, :2] - motion.place[:2]).max(axis=0)
    # an odd or even number of nodes as in the scan, which has a node or the middle of a cell there
    size = np.array(scan.heights.shape[::-1])
    count = size + 2 * np.floor((reach - 0.5 * steps * (size - 1)) / steps).astype(int)
    low = motion.place[:2] - 0.5 * steps * (count - 1)
    x, y = (low[axis] + steps[axis] * np.arange(count[axis]) for axis in (0, 1))
    nodes = np.stack(np.meshgrid(x, y), axis=-1)
    slopes = plane.slope_x, plane.slope_y
    whole = scan._replace(heights=fill_with_nearest(scan.heights))
    heights = moved_heights(whole, motion, slopes)(nodes)
    rows, columns = largest_rectangle(np.isfinite(heights))
    kept = heights[rows, columns]
    if np.isnan(scan.heights).any():
        known = moved_heights(scan, motion, slopes)(nodes[rows, columns])
        kept = np.where(np.isnan(known), np.nan, kept)
    origin = float(y[rows.start]), float(x[columns.start])
    return Scan(kept - motion.place[2], scan.spacing, origin)


def levelled_together(scans: Mapping[str, Scan | Cloud]) -> dict[str, Scan | Cloud]:
    """Return two scans of one frame turned level, so that their cells still lie on each other.

    Both are turned if one of them is inclined. If both are grids with places, the cells common to
    both are kept.

    Raises
    ------
    InputError
        If inclined grids have different cells, or a mean plane is steeper than `STEEPEST`.
    """
    planes = {side: _mean_plane(scan) for side, scan in scans.items()}
    if not any(_inclination(plane) > LEVEL[type(scans[side])] for side, plane in planes.items()):
        return dict(scans)
    grids = [scan for scan in scans.values() if isinstance(scan, Scan)]
    if len({(grid.heights.shape, grid.spacing) for grid in grids}) > 1:
        raise InputError(
            "the scans are inclined, and their grids have different cells: a registration finds "
            "the area that both cover (bring_together: true in a study)"
        )
    pairs = {side: _level_scan(scan, planes[side]) for side, scan in scans.items()}
    turned = {side: pair[0] for side, pair in pairs.items()}
    starts = {}
    ends = {}
    for side, (scan, motion) in pairs.items():
        if not (isinstance(scan, Scan) and isinstance(scans[side], Scan) and scan.origin):
            return turned
        first = (np.array(scan.origin) - motion.place[1::-1]) / scan.spacing
        starts[side] = first
        ends[side] = first + np.array(scan.heights.shape)
    first = np.max(list(starts.values()), axis=0)
    last = np.min(list(ends.values()), axis=0)
    common: dict[str, Scan | Cloud] = {}
    for side, scan in turned.items():
        assert isinstance(scan, Scan)
        y, x = (
            slice(*np.rint(part).astype(int))
            for part in zip(first - starts[side], last - starts[side], strict=True)
        )
        common[side] = scan._replace(heights=scan.heights[y, x])
    return common

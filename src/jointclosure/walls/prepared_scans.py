"""Scans before their registration: each inspected and measured once, then sampled on a grid."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.parameters import AS_IT_IS, USUAL, check_usual
from jointclosure.parameters.units import unit_meant
from jointclosure.walls import gridding
from jointclosure.walls.gridding import Cloud, Scan, point_distance, points_of
from jointclosure.walls.interpolation_remarks import interpolation_remarks
from jointclosure.walls.levelling import levelled
from jointclosure.walls.motion import Motion
from jointclosure.walls.registration_options import FLIPS, RegistrationOptions
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_quality import ScanQuality, quality_of
from jointclosure.walls.spikes import remove_spikes

SIDES = ("upper", "lower")
_SAME = 0.05
"""Relative difference up to which scattered points count as being as far apart as points of a grid.
Holes of a tenth of a wall make the mean distance of scattered points larger by as much."""


class PreparedScan(NamedTuple):
    """One wall before the registration: its scan without defects and spikes, and its quality."""

    scan: Scan | Cloud  # as it is registered; the plane of the other scan for a flat wall
    as_read: Scan | Cloud  # before it was turned level; `scan` if it was not turned
    quality: ScanQuality | None  # measured once, before levelling; None for a flat wall
    point_distance: float  # [m] of neighbouring points, spikes among them
    levelling: Motion | None  # by which the scan was turned level; None if it lies as scanned
    remarks: list[str]  # of reading, inspection and levelling; they do not name the side


class PreparedScans(NamedTuple):
    """Both walls before their registration, and the spacing of the grid for them."""

    upper: PreparedScan
    lower: PreparedScan
    distance: float  # [m] between neighbouring points, common to both scans
    spacing: float  # [m] of the finest grid on which the walls are laid: stated, or the usual one

    @property
    def by_side(self) -> dict[str, PreparedScan]:
        """Both walls by the names of their sides."""
        return {"upper": self.upper, "lower": self.lower}

    @property
    def qualities(self) -> dict[str, ScanQuality]:
        """Qualities of the walls that were scanned, by the names of their sides."""
        return {
            side: wall.quality for side, wall in self.by_side.items() if wall.quality is not None
        }

    @property
    def flat_side(self) -> str | None:
        """Side of the flat wall, None if both walls were scanned."""
        return next((side for side in SIDES if side not in self.qualities), None)

    @property
    def shortest_waves(self) -> tuple[float, float]:
        """Shortest waves [m] held by the upper and the lower scan; 0: all, or a flat wall."""
        upper, lower = (wall.quality for wall in (self.upper, self.lower))
        return upper.shortest_wave if upper else 0.0, lower.shortest_wave if lower else 0.0

    @property
    def rounding_of_sum(self) -> float:
        """Standard deviation [m] of the rounding of the sum of both walls.

        Heights that are rounded to multiples of a step have an even distribution of errors over
        the step, with a variance of step^2 / 12; variances of both walls add.
        """
        steps = [quality.rounding.heights for quality in self.qualities.values()]
        return float(np.sqrt(np.sum(np.square(steps)) / 12.0))

    @property
    def remarks(self) -> list[str]:
        """Remarks on both scans, with the names of their sides."""
        return [
            remark
            for side, wall in self.by_side.items()
            for remark in with_side(side, wall.remarks)
        ]


class SampledScans(NamedTuple):
    """Both scans, fine grids with heights only at the nodes of the grid for the joint."""

    upper: Scan | Cloud
    lower: Scan | Cloud
    upper_points: np.ndarray  # (n, 3) [m] of the upper scan, heights NaN where missing
    lower_points: np.ndarray  # (n, 3) [m] of the lower scan, heights NaN where missing
    remarks: list[str]  # on fine scans, with the names of their sides


def prepared_scans(
    scans: Mapping[str, Scan | Cloud], options: RegistrationOptions, spacing: float | None = None
) -> PreparedScans:
    """Inspect, level and measure the scans of a joint, and find the spacing of its grid.

    Parameters
    ----------
    scans : mapping
        Scans by their sides, one or two (`jointclosure.walls.flat_walls.walls_not_flat`); a missing
        side is a flat wall. The given scans are not changed.
    options : RegistrationOptions
        If values may be unusual, defects are not looked for, and no scan is implausible. Spikes are
        cut or kept.
    spacing : float, optional
        Stated grid spacing [m], by default the usual one for the distance of the points.

    Returns
    -------
    PreparedScans
        The lower scan is level, as it states the frame of the walls. Over a flat lower wall the
        upper scan states the frame, and is level too; heights of an aperture map ("common_frame")
        are distances along z, so that the map is not turned. A flat wall is the mean plane of the
        other scan.

    Raises
    ------
    InputError
        If a scan is inclined by more than 45 degrees, has fewer than four heights, or its points
        lie on one line. Unless values may be unusual, also if both scans are the same, or a side of
        a scan or the spacing is unusual.
    """
    frame = "lower" if "lower" in scans else "upper"
    is_map = frame == "upper" and options.orientation == "common_frame"
    prepared = {
        side: _prepared_scan(scan, options, states_frame=side == frame, is_map=is_map)
        for side, scan in scans.items()
    }
    distance = _common_distance(prepared.values())
    for side, other in (SIDES, SIDES[::-1]):
        if side not in prepared:
            prepared[side] = _flat_wall(side, prepared[other], options)
    if not options.unusual_values:
        _check_scans(prepared["upper"].scan, prepared["lower"].scan)
        if spacing is None:
            check_usual((), spacing=distance)
    nodes = gridding.usual_grid_spacing(distance) if spacing is None else float(spacing)
    return PreparedScans(prepared["upper"], prepared["lower"], distance, nodes)


def _prepared_scan(
    scan: Scan | Cloud, options: RegistrationOptions, *, states_frame: bool, is_map: bool
) -> PreparedScan:
    """Inspect and measure one scan, and turn it level if it states the frame of the walls.

    A map of apertures is not turned. Other points are levelled also where another scan states the
    frame, but only to find the grid on which they may lie. Raise `InputError` if the scan cannot be
    levelled, or its points lie on one line.
    """
    measured = scan if options.unusual_values else inspected(scan)
    spikes = ""
    if options.spikes == "cut":
        measured, spikes = remove_spikes(measured)
    level, turn = measured, None
    if not is_map and (states_frame or isinstance(measured, Cloud)):
        level, turn = levelled(measured)
    used, levelling = (level, turn) if states_frame else (measured, None)
    # points that were cut do not make the others lie farther apart
    distance = point_distance(scan if isinstance(used, Cloud) and levelling is None else used)
    remarks = [*used.remarks, *([f"{spikes}; they were cut"] if spikes else [])]
    return PreparedScan(used, measured, quality_of(measured, level), distance, levelling, remarks)


def _flat_wall(side: str, scanned: PreparedScan, options: RegistrationOptions) -> PreparedScan:
    """Return the flat wall of a side, with the places and the mean plane of the scanned wall."""
    sign = 1
    if side == "lower":
        sign = round(FLIPS[options.orientation or "common_frame"][2, 2])
    plane = gridding.plane_of(scanned.scan, sign)
    return PreparedScan(plane, plane, None, scanned.point_distance, None, [])


def _common_distance(scans: Iterable[PreparedScan]) -> float:
    """Return the largest point distance [m] of scans, or the spacing of a grid nearly as large.

    Holes make the mean distance of scattered points larger. A grid brought to this distance would
    be interpolated, and lose short waves, although its points are as far apart as the others.
    """
    scans = list(scans)
    largest = max(wall.point_distance for wall in scans)
    grids = [wall.point_distance for wall in scans if isinstance(wall.scan, Scan)]
    alike = [distance for distance in grids if distance >= (1.0 - _SAME) * largest]
    return max(alike, default=largest)


def _check_scans(upper: Scan | Cloud, lower: Scan | Cloud) -> None:
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


def sampled_if_finer(prepared: PreparedScans) -> SampledScans:
    """Return both scans, with heights of fine grids at the nodes of the grid for the joint.

    A `Scan` is replaced if its points are at most half of the grid spacing apart. Each scan of such
    fine points, a `Cloud` too, has a remark; the lower one, if it is a `Scan`, may have another, on
    slopes that interpolation lost.
    """
    spacing = prepared.spacing
    scans = {side: wall.scan for side, wall in prepared.by_side.items()}
    anchor = _anchor_of_nodes(scans)
    remarks: list[str] = []
    for side in SIDES:
        scan = scans[side]
        distance = point_distance(scan)
        if 2.0 * distance > spacing:
            continue
        remarks.append(
            f"{side} wall: points are {1e3 * distance:.4g} mm apart, of which heights were "
            f"taken every {1e3 * spacing:.4g} mm, the grid spacing of the joint"
        )
        if isinstance(scan, Scan):
            scans[side] = nodes = gridding.sample_grid(scan, spacing, anchor)
            if side == "lower":  # heights of the upper one are taken at the lower's nodes
                first = np.array(nodes.origin)[::-1]
                lost = interpolation_remarks(scan, nodes.heights, spacing, first)
                remarks += with_side(side, lost)
    upper, lower = scans["upper"], scans["lower"]
    points = points_of(upper, missing=True), points_of(lower, missing=True)
    return SampledScans(upper, lower, *points, remarks)


def _anchor_of_nodes(scans: dict[str, Scan | Cloud]) -> tuple[float, float]:
    """Return the place (y, x) [m] of a node: a grid's origin, the lower scan's if both have one."""
    for scan in (scans["lower"], scans["upper"]):
        if isinstance(scan, Scan) and scan.origin is not None:
            return scan.origin
    return 0.0, 0.0


def with_side(side: str, remarks: Iterable[str]) -> list[str]:
    """Put the name of a wall before remarks and keep their type."""
    return [type(remark)(f"{side} wall: {remark}") for remark in remarks]

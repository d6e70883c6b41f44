"""Scans before their registration: inspected, without spikes, level, and sampled on a grid."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls import gridding, plausibility
from jointclosure.walls.gridding import FLAT, Cloud, Scan, point_distance, points_of
from jointclosure.walls.levelling import levelled
from jointclosure.walls.motion import Motion
from jointclosure.walls.registration_options import FLIPS, RegistrationOptions
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_quality import rounding_of, shortest_wave
from jointclosure.walls.spikes import remove_spikes

SIDES = ("upper", "lower")
_SAME = 0.05
"""Relative difference up to which scattered points count as being as far apart as those of a grid.
Holes of a tenth of a wall make their mean distance larger by as much."""


class PreparedScans(NamedTuple):
    """Scans before their registration, without spikes; by their sides those that are not flat."""

    measured: dict[str, Scan | Cloud]  # as scanned
    level: dict[str, Scan | Cloud]  # turned until their mean planes are level, if steep
    upper: Scan | Cloud  # as it is registered; a flat one has the places of the other
    lower: Scan | Cloud
    levelling: Motion | None  # by which the scan that states the frame of the walls was turned
    distance: float  # of points [m], with spikes, as `_common_distance`
    shortest_waves: tuple[float, float]  # [m] that the upper and the lower scan resolve; 0: all
    remarks: list[str]

    @property
    def flat_side(self) -> str | None:
        """Side of the flat wall, None if both walls were scanned."""
        return next((side for side in SIDES if side not in self.measured), None)

    @property
    def rounding_of_sum(self) -> float:
        """Standard deviation [m] of the rounding of the sum of both walls.

        Heights that are rounded to multiples of a step have an even distribution of errors over
        the step, whose variance is step^2 / 12; variances of both walls add.
        """
        steps = [rounding_of(scan).heights for scan in self.measured.values()]
        return float(np.sqrt(np.sum(np.square(steps)) / 12.0))


class SampledScans(NamedTuple):
    """Both scans with heights at most every grid spacing, as far as they lie on fine grids."""

    upper: Scan | Cloud
    lower: Scan | Cloud
    upper_points: np.ndarray  # (n, 3) [m] of this scan, NaN where a height is missing
    lower_points: np.ndarray
    remarks: list[str]


def scans_by_side(
    upper: Scan | Cloud | str, lower: Scan | Cloud | str, orientation: str | None
) -> dict[str, Scan | Cloud]:
    """Return the walls that are not flat, by their sides.

    Raise `InputError` if a wall is no scan and not "flat", both are flat, or the orientation does
    not suit the flat one.
    """
    for side, wall in (("upper", upper), ("lower", lower)):
        if isinstance(wall, str) and wall != FLAT:
            raise InputError(f"{side} = {wall!r}: must be a Scan, a Cloud or {FLAT!r}")
    if isinstance(upper, str):
        if isinstance(lower, str):
            raise InputError("upper and lower: both walls are flat; one must be a scan")
        if orientation is not None:
            raise InputError(f"orientation = {orientation!r}: must be left out for a flat wall")
        return {"lower": lower}
    if isinstance(lower, str):
        if orientation not in ("common_frame", "towards"):
            stated = "" if orientation is None else f" = {orientation!r}"
            raise InputError(
                f"orientation{stated}: must be stated where the lower wall is flat: common_frame "
                "(the heights are an aperture map) or towards (they count towards the other wall)"
            )
        return {"upper": upper}
    return {"upper": upper, "lower": lower}


def prepared_scans(scans: dict[str, Scan | Cloud], options: RegistrationOptions) -> PreparedScans:
    """Inspect scans for defects, cut their spikes, and level the one that states the frame.

    ``scans`` are those of `scans_by_side`. The frame is that of the lower scan, or of the upper one
    if the lower wall is flat. Heights of an aperture map ("common_frame" over a flat wall) are
    distances along z, so it is not turned. Raise `InputError` if a scan has a defect.
    """
    measured, cut = _without_defects(scans, options)
    # levelling interpolates the heights of grids, so noise and resolution are measured before it
    in_frame = dict(measured)
    levelling = None
    frame = "lower" if "lower" in scans else "upper"
    if frame == "lower" or options.orientation == "towards":
        in_frame[frame], levelling = levelled(measured[frame])
    level = dict(in_frame)
    if len(scans) == 2 and isinstance(in_frame["upper"], Cloud):
        level["upper"], _ = levelled(in_frame["upper"])
    # points that were cut do not make the others lie farther apart
    uncut = {side: scans[side] for side, scan in in_frame.items() if isinstance(scan, Cloud)}
    if levelling is not None:
        uncut[frame] = in_frame[frame]
    distance = _common_distance((in_frame | uncut).values())
    remarks: list[str] = []
    for side, scan in in_frame.items():
        remarks += with_side(side, [*scan.remarks, *cut.get(side, ())])
    upper, lower = _both_walls(in_frame, options.orientation)
    waves = [
        shortest_wave(measured[side], level[side]) if side in measured else 0.0 for side in SIDES
    ]
    return PreparedScans(
        measured, level, upper, lower, levelling, distance, (waves[0], waves[1]), remarks
    )


def _without_defects(
    scans: dict[str, Scan | Cloud], options: RegistrationOptions
) -> tuple[dict[str, Scan | Cloud], dict[str, list[str]]]:
    """Return inspected scans without spikes, and a remark on those that were cut, by their sides.

    Nothing is refused if unusual values are allowed, and spikes are kept if they shall be.
    """
    measured = {
        side: scan if options.unusual_values else inspected(scan) for side, scan in scans.items()
    }
    cut: dict[str, list[str]] = {}
    if options.spikes == "cut":
        for side in scans:
            measured[side], removed = remove_spikes(measured[side])
            if removed:
                cut[side] = [f"{removed}; they were cut"]
    return measured, cut


def _both_walls(
    scans: dict[str, Scan | Cloud], orientation: str | None
) -> tuple[Scan | Cloud, Scan | Cloud]:
    """Return both walls as scans; a flat one has the places and the mean plane of the other."""
    if "upper" not in scans:
        return gridding.plane_of(scans["lower"]), scans["lower"]
    if "lower" not in scans:
        sign = round(FLIPS[orientation or "common_frame"][2, 2])
        return scans["upper"], gridding.plane_of(scans["upper"], sign)
    return scans["upper"], scans["lower"]


def _common_distance(scans: Iterable[Scan | Cloud]) -> float:
    """Return the largest point distance [m] of scans, or that of a grid if it is nearly as large.

    Holes make the mean distance of scattered points larger. A grid with this spacing would be
    interpolated, and lose its short waves, although its points are as far apart.
    """
    scans = list(scans)
    largest = max(map(point_distance, scans))
    grids = [point_distance(scan) for scan in scans if isinstance(scan, Scan)]
    alike = [distance for distance in grids if distance >= (1.0 - _SAME) * largest]
    return max(alike, default=largest)


def sampled_if_finer(prepared: PreparedScans, spacing: float) -> SampledScans:
    """Return both scans, those on fine grids with heights at the nodes of one grid.

    It replaces a `Scan` whose points are at most half of ``spacing`` [m] apart. Each scan that is
    so fine, clouds too, has a remark; the lower one, if it is a `Scan`, may have another, on slopes
    that are lost.
    """
    scans = {"upper": prepared.upper, "lower": prepared.lower}
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
                lost = plausibility.smoothing_of(scan, nodes.heights, spacing, first)
                remarks += with_side(side, lost)
    upper, lower = scans["upper"], scans["lower"]
    points = points_of(upper, missing=True), points_of(lower, missing=True)
    return SampledScans(upper, lower, *points, remarks)


def _anchor_of_nodes(scans: dict[str, Scan | Cloud]) -> tuple[float, float]:
    """Return the place (y, x) [m] of a node: that of the lower scan if both have an origin."""
    for scan in (scans["lower"], scans["upper"]):
        if isinstance(scan, Scan) and scan.origin is not None:
            return scan.origin
    return 0.0, 0.0


def with_side(side: str, remarks: Iterable[str]) -> list[str]:
    """Put the name of a wall before remarks and keep their type."""
    return [type(remark)(f"{side} wall: {remark}") for remark in remarks]

"""Registration of the scans of the two walls of a joint (`registered`), see docs/two_scans.md."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_one_of
from jointclosure.inputs.remarks import Caution, caution, cautions
from jointclosure.parameters import AS_IT_IS
from jointclosure.walls import measured, plausibility
from jointclosure.walls.mating import (
    CONFIDENCE,
    Mating,
    Mismatch,
    best_shift,
    mating,
    measured_mismatch,
    slope_correlation_over_shifts,
)
from jointclosure.walls.measured import FLAT, LARGEST_FILLED_SHARE, Cloud, Scan
from jointclosure.walls.outliers import without_plateaus, without_spikes
from jointclosure.walls.overlap import Overlap, overlap_of
from jointclosure.walls.roughness import detrended

LEAST_OVERLAP = 0.5
"""Smallest share of the smaller wall that must overlap; other shifts are not tried."""
COMPARED_CELLS = 64
"""Smallest number of cells along the shorter side in the comparison of orientations."""
CLEAR = 1.5
"""Ratio of the best correlation of slopes to the second from which an orientation is clear: none of
900 pairs of independent walls was (64 to 128 cells, H 0.5 to 1), with 1.4 seven were."""
STEEP_PLANE, STEEP_WEDGE = 5.0, 1.0
"""Unusual inclinations of the common plane and of the walls to each other [degrees]."""
_FAR = 1.5
"""Largest usual distance from first touch to that of a thousandth, in deviations of the
aperture."""
_ALIKE = 0.99
"""Correlation of heights beyond which walls that fit at all wavelengths may be one wall."""
SHIFTS = ("scanned", "mated")
_SIDES = ("upper", "lower")


class Orientation(NamedTuple):
    """Frame of the upper scan: sign of its heights, -1 towards the lower wall, reversed (y, x)."""

    sign: int
    mirrored: tuple[bool, bool]
    meaning: str

    def grid(self, wall: np.ndarray) -> np.ndarray:
        """Return the heights (y, x) of a wall in the frame of the lower one."""
        y, x = (slice(None, None, -1 if reverse else 1) for reverse in self.mirrored)
        return self.sign * wall[y, x]

    def points(self, points: np.ndarray, placed: "_Placed", spacing: float) -> np.ndarray:
        """Reverse points (n, 3) like the grid of their wall, about the middle of the grid."""
        turned = points * np.array([1.0, 1.0, self.sign])
        for axis, column in ((0, 1), (1, 0)):
            if self.mirrored[axis]:
                across = (placed.wall.shape[axis] - 1) * spacing
                turned[:, column] = 2.0 * placed.low[axis] + across - turned[:, column]
        return turned


ORIENTATIONS = {
    "common_frame": Orientation(1, (False, False), "both scans in one frame, z upwards"),
    "rotated": Orientation(1, (True, True), "z upwards, turned by 180 degrees in the plane"),
    "turned_about_x": Orientation(-1, (True, False), "the wall was turned over about x"),
    "turned_about_y": Orientation(-1, (False, True), "the wall was turned over about y"),
    "towards": Orientation(-1, (False, False), "heights towards the lower wall, plan as it lies"),
    "towards_rotated": Orientation(-1, (True, True), "as towards, turned by 180 degrees"),
    "mirrored_x": Orientation(1, (False, True), "z upwards, x reversed"),
    "mirrored_y": Orientation(1, (True, False), "z upwards, y reversed"),
}
"""Orientations of the upper wall's scan that are compared."""


class Fit(NamedTuple):
    """Fit of the walls in an orientation: correlation of slopes at the best shift (y, x) [m]."""

    orientation: str
    correlation: float
    shift: tuple[float, float]


class RegisteredPair(NamedTuple):
    """Two registered walls on a grid of ``spacing`` [m]; places and shifts are (y, x).

    ``upper`` and ``lower`` (y, x) are heights [m] towards the other wall, ``aperture`` is their
    distance at ``first_touch``, ``holes`` are cells taken out of contact because a scan has no
    height there. ``fits`` are those of all `ORIENTATIONS`, the best first; ``shift`` [m] was
    applied to the upper wall, ``mating_shift`` is that of best fit. ``correlation`` is that of
    heights, ``mating`` by wavelength, ``overlap`` the share of the smaller scan, ``report`` the
    results in sentences.
    """

    upper: np.ndarray
    lower: np.ndarray
    spacing: float
    aperture: np.ndarray
    first_touch: tuple[int, int]
    orientation: str
    fits: list[Fit]
    shift: tuple[float, float]
    mating_shift: tuple[float, float]
    correlation: float
    mating: Mating
    mismatch: Mismatch
    overlap: float
    holes: np.ndarray
    report: list[str]

    @property
    def warnings(self) -> list[Caution]:
        """Warnings among the sentences of the report."""
        return cautions(self.report)

    def __repr__(self) -> str:
        (ny, nx), step = self.upper.shape, 1e3 * self.spacing
        return (
            f"<RegisteredPair: {nx} x {ny} cells of {step:.4g} mm, {self.orientation}, correlation "
            f"{self.correlation:.3g}, mean aperture {1e3 * self.aperture.mean():.4g} mm>"
        )


def registered(
    upper: Scan | Cloud | str,
    lower: Scan | Cloud | str,
    spacing: float | None = None,
    *,
    orientation: str | None = None,
    shift: str | None = None,
    cut_spikes: bool = True,
    largest_filled_share: float = LARGEST_FILLED_SHARE,
    unusual_values: bool = False,
) -> RegisteredPair:
    """Register two scans of the walls of one joint.

    Parameters
    ----------
    upper, lower : Scan, Cloud or "flat"
        In metres; heights of the lower scan count towards the upper wall. One of both may be flat.
        If that is the lower one, ``orientation`` has to be stated: an aperture map is an upper wall
        in a "common_frame", and heights of a scan from above count "towards" the lower wall.
    spacing : float, optional
        Grid spacing of the walls [m]: by default the larger point distance of the scans, or the
        multiple of it that is nearest to 0.25 mm. Regular grids of at most half of it are sampled.
    orientation : str, optional
        Orientation of the upper scan, a key of `ORIENTATIONS`: by default the one with the best
        correlation of the walls' slopes, if it is clear.
    shift : {"scanned", "mated"}, optional
        Leave the walls in their scanned position, or move the upper one to the best fit: by default
        "scanned" in a common frame, otherwise "mated".
    cut_spikes : bool
        Whether to leave out spikes, points that differ from all but one of their neighbours
        (`jointclosure.walls.outliers.without_spikes`).
    largest_filled_share : float
        Largest share of cells in holes inside the walls for which they are taken out of contact:
        they receive the height of the other wall and the largest aperture of the cells around.
    unusual_values : bool
        Whether to accept pairs that are probably wrong, see Raises.

    Raises
    ------
    InputError
        If no orientation is clear and none is stated, or if the walls are inclined too much or
        do not overlap. Unless ``unusual_values``, also if both scans are the same or copies, the
        walls are interchanged, another orientation than the stated one is clear, or spacing or
        size are not those of a wall.
    """
    if orientation is not None:
        check_one_of("orientation", orientation, tuple(ORIENTATIONS))
    if shift is not None:
        check_one_of("shift", shift, SHIFTS)
    flat = next((side for side, s in zip(_SIDES, (upper, lower), strict=True) if s == FLAT), None)
    scans = list(_both_scans(upper, lower, orientation))
    distance = max(map(measured.point_distance, scans))
    stated = distance if spacing is None else float(spacing)
    if not unusual_values:
        plausibility.check_scans(scans[0], scans[1], stated)
    spacing = measured.paper_spacing(distance) if spacing is None else stated
    report: list[str] = []
    for place, side in enumerate(_SIDES):
        if side != flat and not unusual_values:
            scans[place] = without_plateaus(scans[place])
        report += _named(side, scans[place].remarks)
        if side != flat and cut_spikes:
            scans[place], removed = without_spikes(scans[place])
            report += [f"{side} wall: {removed}; they were cut"] if removed else []
    scans = _not_finer(scans, spacing, report)
    clouds = [measured.points_of(scan, missing=True) for scan in scans]
    placed = _placed(clouds[0], spacing), _placed(clouds[1], spacing)
    fits: list[Fit] = []
    name, mated, moved = orientation or "common_frame", (0.0, 0.0), False
    if flat:
        report.append(f"the {flat} wall is flat, parallel to the mean plane of the other")
    else:
        fits = _compared(*placed, spacing)
        name = _chosen(fits, orientation, unusual_values, report)
        fit = next(fit for fit in fits if fit.orientation == name)
        mated = _refined(*placed, spacing, fit, all(isinstance(scan, Scan) for scan in scans))
        moved = shift == "mated" or (shift is None and name != "common_frame")
        by = f"({1e3 * mated[1]:.3g}, {1e3 * mated[0]:.3g}) mm along (x, y)"
        report.append(
            f"the upper wall was moved by {by}, to the position of best fit"
            if moved
            else "the walls were left in their scanned position; best fit with the upper moved by "
            f"{by}"
        )
    applied = mated if moved else (0.0, 0.0)
    turned = ORIENTATIONS[name].points(clouds[0], placed[0], spacing)
    clouds[0] = turned + np.array([applied[1], applied[0], 0.0])
    distances = [measured.point_distance(scan) for scan in scans]
    overlap = overlap_of(clouds, spacing, distances, largest_filled_share)
    if flat:
        overlap = _flattened(overlap, flat)
    for side, cloud, holes in zip(_SIDES, clouds, overlap.holes, strict=True):
        if side != flat:
            known = np.where(holes, np.nan, getattr(overlap, side))
            lost = plausibility.smoothing_of(Cloud(cloud), known, spacing, *overlap.box)
            report += _named(side, lost)
    pair = _described(overlap, spacing, name, fits, applied, mated, report)
    walls = {"upper": pair.upper, "lower": pair.lower}
    contradictions, unlike_rock = plausibility.unit_doubts(walls, spacing)
    if not unusual_values:
        impossible = plausibility.slope_doubts(walls, spacing)
        if impossible or contradictions:
            problems = contradictions or unlike_rock or impossible
            raise InputError(f"{'; '.join(problems)}; {AS_IT_IS}")
        common_frame = name == "common_frame" and not flat
        plausibility.check_pair(overlap.upper - overlap.lower, pair.correlation, common_frame)
    report += [caution(doubt) for doubt in contradictions + unlike_rock]
    return pair


def _named(side: str, remarks: Iterable[str]) -> list[str]:
    """Put the name of a wall before remarks and keep their type."""
    return [type(remark)(f"{side} wall: {remark}") for remark in remarks]


def _both_scans(
    upper: Scan | Cloud | str, lower: Scan | Cloud | str, orientation: str | None
) -> tuple[Scan | Cloud, Scan | Cloud]:
    """Return both walls as scans; a flat one has the places and the mean plane of the other."""
    for side, wall in (("upper", upper), ("lower", lower)):
        if isinstance(wall, str) and wall != FLAT:
            raise InputError(f"{side} = {wall!r}: must be a Scan, a Cloud or {FLAT!r}")
    if isinstance(upper, str):
        if isinstance(lower, str):
            raise InputError("upper and lower: both walls are flat; one must be a scan")
        if orientation is not None:
            raise InputError(f"orientation = {orientation!r}: must be left out for a flat wall")
        return measured.plane_of(lower), lower
    if isinstance(lower, str):
        if orientation not in ("common_frame", "towards"):
            stated = "" if orientation is None else f" = {orientation!r}"
            raise InputError(
                f"orientation{stated}: must be stated where the lower wall is flat: common_frame "
                "(the heights are an aperture map) or towards (they count towards the other wall)"
            )
        return upper, measured.plane_of(upper, ORIENTATIONS[orientation].sign)
    return upper, lower


def _flattened(overlap: Overlap, side: str) -> Overlap:
    """Make the flat wall of an overlap flat without rounding; the other one has all holes."""
    of_flat, other = (0, "lower") if side == "upper" else (1, "upper")
    gap, holes = overlap.upper - overlap.lower, overlap.holes.any(axis=0)
    rough = np.where(holes, (2 * of_flat - 1) * gap, getattr(overlap, other))
    flat = {side: np.zeros(rough.shape), other: rough}
    return overlap._replace(**flat, holes=holes * (np.arange(2)[:, None, None] != of_flat))


def _not_finer(scans: list[Scan | Cloud], spacing: float, report: list[str]) -> list[Scan | Cloud]:
    """Sample scanned grids of at most half of the spacing [m] at the nodes of one grid."""
    origins = [scan.origin for scan in scans if isinstance(scan, Scan) and scan.origin is not None]
    anchor = origins[-1] if origins else (0.0, 0.0)  # that of the lower wall if both have one
    result = []
    for side, scan in zip(_SIDES, scans, strict=True):
        distance = measured.point_distance(scan)
        if 2.0 * distance <= spacing:
            report.append(
                f"{side} wall: points are {1e3 * distance:.4g} mm apart, of which heights were "
                f"taken every {1e3 * spacing:.4g} mm, the grid spacing of the joint"
            )
            if isinstance(scan, Scan):
                nodes = measured.sampled(scan, spacing, anchor)
                first = np.array(nodes.origin)[::-1]
                lost = plausibility.smoothing_of(scan, nodes.heights, spacing, first)
                report += _named(side, lost)
                scan = nodes
        result.append(scan)
    return result


class _Placed(NamedTuple):
    """Wall (y, x) less its plane, NaN where missing, and the place (y, x) of its first cell."""

    wall: np.ndarray
    low: np.ndarray


def _placed(points: np.ndarray, spacing: float) -> _Placed:
    return _Placed(measured.wall_on_grid(Cloud(points), spacing), points[:, 1::-1].min(axis=0))


def _block_cells(upper: _Placed, lower: _Placed) -> int:
    """Return the number of cells along the side of the blocks that are compared."""
    return max(min(*upper.wall.shape, *lower.wall.shape) // COMPARED_CELLS, 1)


def _compared(upper: _Placed, lower: _Placed, spacing: float) -> list[Fit]:
    """Compare the walls in all orientations, on means over blocks of cells; the best first."""
    cells = _block_cells(upper, lower)
    fixed = _block_means(lower.wall, cells)
    fits = []
    for name, orientation in ORIENTATIONS.items():
        moved = _block_means(orientation.grid(upper.wall), cells)
        shifts = slope_correlation_over_shifts(fixed, moved, LEAST_OVERLAP)
        blocks, correlation = best_shift(shifts)
        if np.isnan(correlation):
            raise InputError("the scans have too few heights for a comparison")
        y, x = lower.low - upper.low + spacing * cells * np.array(blocks)
        fits.append(Fit(name, correlation, (float(y), float(x))))
    return sorted(fits, key=lambda fit: -fit.correlation)


def _block_means(wall: np.ndarray, cells: int) -> np.ndarray:
    """Return means of the known heights in blocks of cells, NaN for blocks without any."""
    ny, nx = (size // cells for size in wall.shape)
    blocks = wall[: ny * cells, : nx * cells].reshape(ny, cells, nx, cells)
    known = np.isfinite(blocks).sum(axis=(1, 3))
    return np.where(known > 0, np.nansum(blocks, axis=(1, 3)) / np.maximum(known, 1), np.nan)


def _chosen(fits: list[Fit], stated: str | None, unusual: bool, report: list[str]) -> str:
    """Return the stated or the clear orientation; `InputError` if none or another is clear."""
    best, second = fits[:2]
    clear = best.correlation >= CLEAR * max(second.correlation, 0.0)
    listed = ", ".join(f"{fit.orientation} {fit.correlation:.2f}" for fit in fits)
    if stated is None and not clear:
        raise InputError(
            f"the orientation of the upper wall is not clear: slopes correlate by {listed}, but "
            f"the best must be {CLEAR:g} times the second; state the orientation "
            f"({', '.join(ORIENTATIONS)}), or check that these are the walls of one joint"
        )
    name = best.orientation if stated is None else stated
    how = "found" if stated is None else "stated"
    report.append(
        f"orientation of the upper wall, {how}: {name} ({ORIENTATIONS[name].meaning}); slopes "
        f"correlate by {listed}"
    )
    if clear and best.orientation != name:
        if not unusual:
            raise InputError(
                f"orientation = {stated!r}: {best.orientation} fits clearly better, and closures "
                "of walls in a wrong orientation are several times too large; state "
                f"{best.orientation} or leave orientation out; {AS_IT_IS}"
            )
        wrong = (
            f"the stated orientation {stated} fits worse than {best.orientation}, which is clear; "
            "in a wrong orientation closures are several times too large"
        )
        report.append(caution(wrong))
    return name


def _refined(
    upper: _Placed, lower: _Placed, spacing: float, fit: Fit, whole_cells: bool
) -> tuple[float, float]:
    """Refine the best shift (y, x) [m] of a comparison of blocks, to cells or a fraction of one."""
    shifts = slope_correlation_over_shifts(
        lower.wall, ORIENTATIONS[fit.orientation].grid(upper.wall), 0.9 * LEAST_OVERLAP
    )
    start = (np.array(fit.shift) - lower.low + upper.low) / spacing
    distance = [
        np.abs((np.arange(n) - at + n / 2.0) % n - n / 2.0)
        for n, at in zip(shifts.shape, start, strict=True)
    ]
    reach = 2.0 * _block_cells(upper, lower)
    near = np.maximum(distance[0][:, None], distance[1][None, :]) <= reach
    cells = np.array(best_shift(np.where(near, shifts, np.nan))[0])
    around = np.roll(shifts, 1 - cells, (0, 1))[:3, :3]
    part = np.zeros(2) if whole_cells else [_vertex(around[:, 1]), _vertex(around[1])]
    y, x = lower.low - upper.low + spacing * (cells + part)
    return float(y), float(x)


def _vertex(values: np.ndarray) -> float:
    """Return the position of the vertex of the parabola through three values at -1, 0 and 1."""
    bend = values[0] - 2.0 * values[1] + values[2]
    if not bend < 0.0:
        return 0.0
    return float(np.clip(0.5 * (values[0] - values[2]) / bend, -0.5, 0.5))


def _described(
    overlap: Overlap, spacing: float, name: str, fits: list[Fit], applied: tuple[float, float],
    mated: tuple[float, float], report: list[str],
) -> RegisteredPair:  # fmt: skip
    """Make the registered pair, seated parallel, and add its description to the report."""
    upper, lower = detrended(-overlap.upper), detrended(overlap.lower)
    together = upper + lower
    aperture = together.max() - together
    y, x = (int(i) for i in np.unravel_index(int(np.argmin(aperture)), aperture.shape))
    cells = f"{upper.shape[0]} x {upper.shape[1]} cells (y, x) of {1e3 * spacing:.4g} mm"
    shares = [f"{100.0 * share:.0f} %" for share in overlap.shares]
    if fits:
        correlation = float(np.corrcoef(upper.ravel(), -lower.ravel())[0, 1])
        mismatch, fit = measured_mismatch(upper, lower, spacing), mating(upper, lower, spacing)
        report += [
            f"overlap: {cells}, {shares[0]} of the upper scan and {shares[1]} of the lower",
            f"the plane common to both walls, inclined by {overlap.inclination:.2f} degrees, was "
            f"removed; the walls were inclined to each other by {overlap.relative:.3f} degrees and "
            "are set parallel",
            f"heights correlate by {correlation:.3f}; {_describe_mating(mismatch)}",
        ]
    else:  # one wall is flat and has no waves
        correlation, mismatch = 0.0, Mismatch(np.inf, np.inf, np.inf)
        fit = Mating(np.empty(0), np.empty(0), np.empty(0))
        report.append(
            f"largest rectangle of the scan without missing heights: {cells}, {shares[0]} of it; "
            "its mean plane was removed"
        )
    early = float(np.quantile(aperture, 1e-3))
    touches = f"one cell in a thousand touches after {1e3 * early:.3g} mm of closure"
    spike = (
        "the first contact stands out far and may be a remaining spike; use closures since "
        "seating, not those from first touch"
    )
    report += [
        f"at first touch, at cell (y, x) = ({y}, {x}), the mean aperture is "
        f"{1e3 * aperture.mean():.3g} mm",
        caution(spike, f"{touches}: ") if early > _FAR * aperture.std() else touches,
    ]
    report += [caution(doubt) for doubt in _doubts(overlap, bool(fits), applied == mated)]
    if mismatch.wavelength == 0.0 and correlation > _ALIKE:
        alike = (
            "the walls fit each other at all wavelengths of the grid, as two scans of one wall "
            "do; check that the files are of different walls"
        )
        report.append(caution(alike))
    if fits and name == "common_frame" and applied == (0.0, 0.0):
        gap = float(np.mean(overlap.upper - overlap.lower))
        lies = f"as scanned the upper wall lies {1e3 * abs(gap):.3g} mm "
        lies += f"{'above' if gap > 0.0 else 'below'} the lower one in the mean"
        wrong = (
            "if both scans have one zero of heights, the walls are interchanged or heights count "
            "downwards"
        )
        report.append(lies if gap > 0.0 else caution(wrong, f"{lies}: "))
    return RegisteredPair(
        upper, lower, spacing, aperture, (y, x), name, fits, applied, mated, correlation,
        fit, mismatch, max(overlap.shares), np.logical_or(*overlap.holes), report,
    )  # fmt: skip


def _doubts(overlap: Overlap, both: bool, best_fit: bool) -> list[str]:
    """Describe unusual overlap and inclinations; ``best_fit`` says that the walls are mated."""
    doubts = overlap.doubts()
    share = max(overlap.shares)
    if both and share < LEAST_OVERLAP:
        question = (
            "in the position of best fit: are the scans of the same part of the joint?"
            if best_fit
            else "are the scans in one frame? (--shift mated moves them to the best fit)"
        )
        doubts.append(
            f"the walls overlap in {100.0 * share:.0f} % of the smaller scan, less than "
            f"{100.0 * LEAST_OVERLAP:.0f} %{', even ' if best_fit else ': '}{question}"
        )
    if overlap.inclination > STEEP_PLANE:
        doubts.append(
            f"the {'common plane' if both else 'plane'} is inclined by {overlap.inclination:.1f} "
            f"degrees, more than {STEEP_PLANE:g}; it was removed along z, so that heights are not "
            "normal to it; turn the scans"
        )
    if both and overlap.relative > STEEP_WEDGE:
        doubts.append(
            f"the walls are inclined to each other by {overlap.relative:.1f} degrees, more than "
            f"{STEEP_WEDGE:g}; walls of one joint are about parallel"
        )
    return doubts


def _describe_mating(mismatch: Mismatch) -> str:
    if mismatch.wavelength == 0.0:
        return "the walls are mated at all wavelengths of the grid"
    if np.isinf(mismatch.wavelength):
        return "the walls are mated at no wavelength"
    low = f"{1e3 * mismatch.low:.3g}" if mismatch.low > 0.0 else "the grid's shortest"
    high = f"{1e3 * mismatch.high:.3g} mm" if np.isfinite(mismatch.high) else "the walls' length"
    return (
        f"the walls are mated at wavelengths beyond {1e3 * mismatch.wavelength:.3g} mm (mismatch "
        f"wavelength, where they correlate by 0.5; {100 * CONFIDENCE:g} % interval {low} to {high})"
    )

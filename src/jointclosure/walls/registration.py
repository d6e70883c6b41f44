"""Registration of the scans of the two walls of a joint: orientation, shift, overlap, mating.

Files are read by `jointclosure.walls.scans`. See docs/two_scans.md.
"""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import Caution, caution, cautions, prefixed
from jointclosure.parameters import AS_IT_IS
from jointclosure.walls.implausible import check_pair, check_scans
from jointclosure.walls.mating import Mating, best_shift, mating, slope_correlation_over_shifts
from jointclosure.walls.measured import (
    FLAT,
    LARGEST_FILLED_SHARE,
    Cloud,
    Scan,
    paper_spacing,
    plane_of,
    point_distance,
    sampled,
    wall_on_grid,
)
from jointclosure.walls.mismatch import CONFIDENCE, Mismatch, measured_mismatch
from jointclosure.walls.outliers import points_of, without_plateaus, without_spikes
from jointclosure.walls.overlap import Overlap, overlap_of
from jointclosure.walls.plausibility import slope_doubts, unit_doubts
from jointclosure.walls.roughness import detrended
from jointclosure.walls.smoothing import smoothing, smoothing_of

LEAST_OVERLAP = 0.5
"""Smallest share of the smaller wall that must overlap; other shifts are not tried."""
COMPARED_CELLS = 64
"""Smallest number of cells along the shorter side for the comparison of orientations, which long
waves distinguish."""
CLEAR = 1.5
"""An orientation is clear if its correlation of slopes is this many times that of any other. Of 900
pairs of independent walls (64 to 128 cells, H 0.5 to 1) none was clear by chance; with a factor of
1.4 seven were."""


class Orientation(NamedTuple):
    """Direction of the heights and of the plan of the upper scan in the frame of the lower one.

    ``sign`` is 1 if heights count away from the lower wall's rock, as those of the lower scan do,
    and -1 if they count towards the lower wall. ``mirrored`` says which axes (y, x) are reversed.
    """

    sign: int
    mirrored: tuple[bool, bool]
    meaning: str


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
SHIFTS = ("scanned", "mated")


class Fit(NamedTuple):
    """Fit of the walls in an orientation: correlation of slopes at the best shift."""

    orientation: str
    correlation: float
    shift: tuple[float, float]


class RegisteredPair(NamedTuple):
    """Two registered scanned walls; lengths are in m, places and shifts (y, x).

    ``upper`` and ``lower`` (y, x) are heights towards the other wall, less the plane of the wall,
    on a grid of ``spacing``, ``aperture`` (y, x) is their distance at first touch, which is at the
    cell ``first_touch``. ``holes`` (y, x) are cells that were taken out of contact because a scan
    has no height there. ``orientation`` is a key of `ORIENTATIONS`, and ``fits`` are those of all
    orientations, the best first. ``shift`` was applied to the upper wall, ``mating_shift`` is that
    of best fit. ``correlation`` is that of the heights of both walls, ``mating`` by wavelength, and
    ``mismatch`` the mismatch wavelength with its interval. ``overlap`` is the share of the smaller
    scan's cells that lie in the walls, ``report`` has the results in sentences.
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
    _check_choices(orientation, shift)
    flat = [side for side, scan in (("upper", upper), ("lower", lower)) if isinstance(scan, str)]
    upper, lower = _both_scans(upper, lower, orientation)
    distances = point_distance(upper), point_distance(lower)
    if not unusual_values:
        check_scans(upper, lower, max(distances) if spacing is None else float(spacing))
    spacing = paper_spacing(max(distances)) if spacing is None else float(spacing)
    report: list[str] = []
    kept = []
    for side, scan in (("upper", upper), ("lower", lower)):
        if side not in flat and not unusual_values:
            scan = without_plateaus(scan)
        report += [prefixed(f"{side} wall: ", remark) for remark in scan.remarks]
        kept.append(
            _without_spikes(scan, side, report) if cut_spikes and side not in flat else scan
        )
    upper, lower = _not_finer(kept[0], kept[1], spacing, report)
    distances = point_distance(upper), point_distance(lower)
    clouds = [points_of(upper, missing=True), points_of(lower, missing=True)]
    placed = [_Placed.of(cloud, spacing) for cloud in clouds]
    if flat:
        fits, name, mated = [], orientation or "common_frame", (0.0, 0.0)
        report.append(f"the {flat[0]} wall is flat, parallel to the mean plane of the other")
    else:
        fits = _compared(placed[0], placed[1], spacing)
        name = _chosen(fits, orientation, unusual_values, report)
        best = _refined(
            placed[0], placed[1], spacing, next(fit for fit in fits if fit.orientation == name)
        )
        whole_cells = all(isinstance(scan, Scan) for scan in (upper, lower))
        mated = best.whole if whole_cells else best.exact
    moved = not flat and (shift == "mated" or (shift is None and name != "common_frame"))
    applied = mated if moved else (0.0, 0.0)
    if not flat:
        report.append(_describe_shift(mated, moved))
    turned = _oriented(clouds[0], placed[0], spacing, ORIENTATIONS[name])
    raised = turned + np.array([applied[1], applied[0], 0.0])
    overlap = overlap_of(raised, clouds[1], spacing, distances, largest_filled_share)
    if flat:
        overlap = _flattened(overlap, flat[0])
    box = (
        np.maximum(*(cloud[:, :2].min(axis=0) for cloud in (raised, clouds[1]))),
        np.minimum(*(cloud[:, :2].max(axis=0) for cloud in (raised, clouds[1]))),
    )
    for side, cloud, holes in zip(
        ("upper", "lower"), (raised, clouds[1]), overlap.holes, strict=True
    ):
        if side not in flat:
            known = np.where(holes, np.nan, getattr(overlap, side))
            lost = smoothing(cloud, known, spacing, box)
            report += [prefixed(f"{side} wall: ", remark) for remark in lost]
    pair = _described(overlap, spacing, name, fits, applied, mated, report)
    walls = {"upper": pair.upper, "lower": pair.lower}
    contradictions, unlike_rock = unit_doubts(walls, spacing)
    if not unusual_values:
        if (impossible := slope_doubts(walls, spacing)) or contradictions:
            problems = contradictions or unlike_rock or impossible
            raise InputError(f"{'; '.join(problems)}; {AS_IT_IS}")
        common_frame = name == "common_frame" and not flat
        check_pair(overlap.upper - overlap.lower, pair.correlation, common_frame)
    report += [caution(doubt) for doubt in contradictions + unlike_rock]
    return pair


def _both_scans(
    upper: Scan | Cloud | str, lower: Scan | Cloud | str, orientation: str | None
) -> tuple[Scan | Cloud, Scan | Cloud]:
    """Return both walls as scans; a flat one has the places and the mean plane of the other."""
    for side, wall in (("upper", upper), ("lower", lower)):
        if isinstance(wall, str) and wall != FLAT:
            raise InputError(f"{side} = {wall!r}: must be a Scan, a Cloud or {FLAT!r}")
    if isinstance(upper, str) and isinstance(lower, str):
        raise InputError("upper and lower: both walls are flat; one must be a scan")
    if isinstance(upper, str):
        assert not isinstance(lower, str)
        if orientation is not None:
            raise InputError(f"orientation = {orientation!r}: must be left out for a flat wall")
        return plane_of(lower), lower
    if isinstance(lower, str):
        if orientation not in ("common_frame", "towards"):
            stated = "" if orientation is None else f" = {orientation!r}"
            raise InputError(
                f"orientation{stated}: must be stated where the lower wall is flat: common_frame "
                "(the heights are an aperture map) or towards (they count towards the other wall)"
            )
        return upper, plane_of(upper, ORIENTATIONS[orientation].sign)
    return upper, lower


def _flattened(overlap: Overlap, side: str) -> Overlap:
    """Make the flat wall of an overlap flat without rounding; the other one has all holes."""
    of_flat, other = (0, "lower") if side == "upper" else (1, "upper")
    gap, holes = overlap.upper - overlap.lower, overlap.holes.any(axis=0)
    rough = np.where(holes, (2 * of_flat - 1) * gap, getattr(overlap, other))
    flat = {side: np.zeros(rough.shape), other: rough}
    return overlap._replace(**flat, holes=holes * (np.arange(2)[:, None, None] != of_flat))


def _without_spikes(scan: Scan | Cloud, side: str, report: list[str]) -> Scan | Cloud:
    kept, removed = without_spikes(scan)
    report += [f"{side} wall: {removed}; they were cut"] if removed else []
    return kept


def _not_finer(
    upper: Scan | Cloud, lower: Scan | Cloud, spacing: float, report: list[str]
) -> tuple[Scan | Cloud, Scan | Cloud]:
    """Sample scanned grids of at most half of the spacing [m] at the nodes of one grid."""
    anchor = (0.0, 0.0)
    for scan in (upper, lower):
        if isinstance(scan, Scan) and scan.origin is not None:
            anchor = scan.origin  # that of the lower wall if both have one
    result = []
    for side, scan in (("upper", upper), ("lower", lower)):
        distance = point_distance(scan)
        if 2.0 * distance <= spacing:
            report.append(
                f"{side} wall: points are {1e3 * distance:.4g} mm apart, of which heights were "
                f"taken every {1e3 * spacing:.4g} mm, the grid spacing of the joint"
            )
            if isinstance(scan, Scan):
                nodes = sampled(scan, spacing, anchor)
                first = np.array([nodes.origin])[:, ::-1]
                lost = smoothing_of(scan, nodes.heights, spacing, first)
                report += [prefixed(f"{side} wall: ", remark) for remark in lost]
                scan = nodes
        result.append(scan)
    return result[0], result[1]


class _Placed(NamedTuple):
    """Wall (y, x) less its plane, NaN where missing, and the place (y, x) of its first cell."""

    wall: np.ndarray
    low: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray, spacing: float) -> "_Placed":
        return cls(wall_on_grid(Cloud(points), spacing), points[:, 1::-1].min(axis=0))


class _Shift(NamedTuple):
    """Shift (y, x) [m] of best fit, to a fraction of a cell and in whole cells."""

    exact: tuple[float, float]
    whole: tuple[float, float]


def _check_choices(orientation: str | None, shift: str | None) -> None:
    for name, value, allowed in (
        ("orientation", orientation, ORIENTATIONS),
        ("shift", shift, SHIFTS),
    ):
        if value is not None and value not in allowed:
            raise InputError(f"{name} = {value!r}: must be one of {', '.join(allowed)}")


def _turned(wall: np.ndarray, orientation: Orientation) -> np.ndarray:
    steps = tuple(slice(None, None, -1 if axis else 1) for axis in orientation.mirrored)
    return orientation.sign * wall[steps]


def _oriented(
    points: np.ndarray, placed: _Placed, spacing: float, orientation: Orientation
) -> np.ndarray:
    """Reverse points of the upper wall like its grid, about the middle of the grid."""
    turned = points * np.array([1.0, 1.0, orientation.sign])
    for axis, column in ((0, 1), (1, 0)):
        if orientation.mirrored[axis]:
            across = (placed.wall.shape[axis] - 1) * spacing
            turned[:, column] = 2.0 * placed.low[axis] + across - turned[:, column]
    return turned


def _compared(upper: _Placed, lower: _Placed, spacing: float) -> list[Fit]:
    """Compare the walls in all orientations, on means over blocks of cells; the best first."""
    cells = max(min(*upper.wall.shape, *lower.wall.shape) // COMPARED_CELLS, 1)
    fixed = _block_means(lower.wall, cells)
    fits = []
    for name, orientation in ORIENTATIONS.items():
        moved = _block_means(_turned(upper.wall, orientation), cells)
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
    """Return the stated or the clear orientation; raise `InputError` if there is none.

    Unless ``unusual`` values are accepted, also if another orientation than the stated is clear.
    """
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
    if stated is not None and clear and best.orientation != stated:
        if not unusual:
            raise InputError(
                f"orientation = {stated!r}: {best.orientation} fits clearly better, and closures "
                "of walls in a wrong orientation are several times too large; state "
                f"{best.orientation} or leave orientation out; {AS_IT_IS}"
            )
        report.append(
            caution(
                f"the stated orientation {stated} fits worse than {best.orientation}, which "
                f"is clear; in a wrong orientation closures are several times too large"
            )
        )
    return name


def _refined(upper: _Placed, lower: _Placed, spacing: float, fit: Fit) -> _Shift:
    """Refine the best shift of a comparison of blocks at the spacing of the grid."""
    orientation = ORIENTATIONS[fit.orientation]
    shifts = slope_correlation_over_shifts(
        lower.wall, _turned(upper.wall, orientation), 0.9 * LEAST_OVERLAP
    )
    cells = max(min(*upper.wall.shape, *lower.wall.shape) // COMPARED_CELLS, 1)
    start = (np.array(fit.shift) - lower.low + upper.low) / spacing
    distance = [
        np.abs((np.arange(n) - at + n / 2.0) % n - n / 2.0)
        for n, at in zip(shifts.shape, start, strict=True)
    ]
    near = np.maximum(distance[0][:, None], distance[1][None, :]) <= 2.0 * cells
    whole = np.array(best_shift(np.where(near, shifts, np.nan))[0])
    part = [_vertex(np.roll(shifts, 1 - whole, (0, 1))[line]) for line in (_COLUMN, _ROW)]
    at = [lower.low - upper.low + spacing * (whole + more) for more in (np.zeros(2), part)]
    return _Shift(*((float(y), float(x)) for y, x in at[::-1]))


_COLUMN, _ROW = np.s_[:3, 1], np.s_[1, :3]


def _vertex(values: np.ndarray) -> float:
    """Return the position of the vertex of the parabola through three values at -1, 0 and 1."""
    bend = values[0] - 2.0 * values[1] + values[2]
    if not bend < 0.0:
        return 0.0
    return float(np.clip(0.5 * (values[0] - values[2]) / bend, -0.5, 0.5))


def _describe_shift(mated: tuple[float, float], moved: bool) -> str:
    by = f"({1e3 * mated[1]:.3g}, {1e3 * mated[0]:.3g}) mm along (x, y)"
    if moved:
        return f"the upper wall was moved by {by}, to the position of best fit"
    return f"the walls were left in their scanned position; best fit with the upper moved by {by}"


def _described(
    overlap: Overlap, spacing: float, name: str, fits: list[Fit], applied: tuple[float, float],
    mated: tuple[float, float], report: list[str],
) -> RegisteredPair:  # fmt: skip
    """Make the registered pair, seated parallel, and add its description to the report."""
    upper, lower = detrended(-overlap.upper), detrended(overlap.lower)
    together = upper + lower
    aperture = together.max() - together
    ny, nx = upper.shape
    y, x = (int(i) for i in np.unravel_index(int(np.argmin(aperture)), aperture.shape))
    if fits:
        correlation = float(np.corrcoef(upper.ravel(), -lower.ravel())[0, 1])
        mismatch, fit = measured_mismatch(upper, lower, spacing), mating(upper, lower, spacing)
    else:  # one wall is flat and has no waves
        correlation, mismatch = 0.0, Mismatch(np.inf, np.inf, np.inf)
        fit = Mating(np.empty(0), np.empty(0), np.empty(0))
    early = float(np.quantile(aperture, 1e-3))
    gap = float(np.mean(overlap.upper - overlap.lower))
    cells = f"{ny} x {nx} cells (y, x) of {1e3 * spacing:.4g} mm"
    shares = [f"{100.0 * share:.0f} %" for share in overlap.shares]
    of_both = [
        f"overlap: {cells}, {shares[0]} of the upper scan and {shares[1]} of the lower",
        f"the plane common to both walls, inclined by {overlap.inclination:.2f} degrees, was "
        f"removed; the walls were inclined to each other by {overlap.relative:.3f} degrees and are "
        "set parallel",
        f"heights correlate by {correlation:.3f}; {_describe_mating(mismatch)}",
    ]
    of_one = [
        f"largest rectangle of the scan without missing heights: {cells}, {shares[0]} of it; its "
        "mean plane was removed"
    ]
    report += [
        *(of_both if fits else of_one),
        f"at first touch, at cell (y, x) = ({y}, {x}), the mean aperture is "
        f"{1e3 * aperture.mean():.3g} mm",
    ]
    touches = f"one cell in a thousand touches after {1e3 * early:.3g} mm of closure"
    stands_out = early > _FAR * aperture.std()
    report.append(caution(_STANDS_OUT, f"{touches}: ") if stands_out else touches)
    report += [caution(doubt) for doubt in _doubts(overlap, bool(fits), applied == mated)]
    if mismatch.wavelength == 0.0 and correlation > _ALIKE:
        report.append(caution(_ONE_WALL))
    if fits and name == "common_frame" and applied == (0.0, 0.0):
        side = "above" if gap > 0.0 else "below"
        lies = (
            f"as scanned the upper wall lies {1e3 * abs(gap):.3g} mm {side} the lower one in the "
            "mean"
        )
        report.append(lies if gap > 0.0 else caution(_BELOW, f"{lies}: "))
    return RegisteredPair(
        upper, lower, spacing, aperture, (y, x), name, fits, applied, mated, correlation,
        fit, mismatch, max(overlap.shares), np.logical_or(*overlap.holes), report,
    )  # fmt: skip


def _doubts(overlap: Overlap, both: bool, best_fit: bool) -> list[str]:
    """Describe unusual overlap and inclinations of both scans of a joint, or of its only one.

    ``best_fit`` says that the walls are in the position of best fit.
    """
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
        plane = "common plane" if both else "plane"
        doubts.append(
            f"the {plane} is inclined by {overlap.inclination:.1f} degrees, more than "
            f"{STEEP_PLANE:g}; it was removed along z, so that heights are not normal to it; turn "
            "the scans"
        )
    if both and overlap.relative > STEEP_WEDGE:
        doubts.append(
            f"the walls are inclined to each other by {overlap.relative:.1f} degrees, more than "
            f"{STEEP_WEDGE:g}; walls of one joint are about parallel"
        )
    return doubts


STEEP_PLANE, STEEP_WEDGE = 5.0, 1.0
"""Inclinations [degrees] above which the plane of two scans, and the angle between them, are
unusual. 5 degrees cause errors of heights and lengths of 0.4 %; 1 degree opens 65 mm by 1.1 mm."""
_FAR = 1.5
"""Largest usual distance, in standard deviations of the aperture, between first touch and the touch
of a thousandth of the cells. Of 144 Gaussian pairs (64 to 256 cells a side, H 0.5 and 0.8) the
largest was 0.95."""
_STANDS_OUT = (
    "the first contact stands out far and may be a remaining spike; use closures since "
    "seating, not those from first touch"
)
_ALIKE = 0.99
"""Correlation of heights beyond which walls that fit at all wavelengths may be one wall."""
_ONE_WALL = (
    "the walls fit each other at all wavelengths of the grid, as two scans of one wall do; check "
    "that the files are of different walls"
)
_BELOW = (
    "if both scans have one zero of heights, the walls are interchanged or heights count downwards"
)


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

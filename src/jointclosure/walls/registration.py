"""Registration of the scans of the two walls of a joint (`registered`), see docs/two_scans.md."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_one_of
from jointclosure.inputs.remarks import Caution, caution, cautions
from jointclosure.parameters import AS_IT_IS
from jointclosure.statistics.number_texts import grid_text, percent
from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.walls import Walls, gridding, plausibility
from jointclosure.walls.gridding import FLAT, Cloud, Scan, point_distance, points_of
from jointclosure.walls.levelling import levelled, slopes_of
from jointclosure.walls.mating import Mating, Mismatch, mating, measured_mismatch
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.motion import (
    BLOCKS,
    CLEAR,
    LEAST_OVERLAP,
    Motion,
    SlopeFit,
    Surface,
    compare_rotations,
    flip_about_middle,
    laid_on_nodes,
    moved_heights,
    refined_motion,
    surface_of,
)
from jointclosure.walls.outliers import remove_spikes
from jointclosure.walls.overlap import Overlap, overlap_of
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_errors import ScanErrors, noise_of, scale_of, scales_differ
from jointclosure.walls.scan_quality import (
    MOVED,
    noise_of_scan,
    resolution_remarks,
    rounding_of,
    shortest_wave,
)

# All constants were chosen; the pairs of known truth of docs/two_scans.md were registered by them.
ON_NODES = 0.02
"""Largest distance [cells] by which the upper wall is displaced so that its nodes lie on those of
the lower one and no heights are interpolated; twice the error of the fit, up to 0.5, if more."""
LARGEST_HOLES = 0.15  # share of cells in holes of either scan, taken out of contact by default
MOST_CELLS = 500  # along a side of walls that are registered at the spacing of the scans
IN_PLACE = 0.02
"""Largest shift of the corners by the best fit, over half of the longer side, with which the scans
count as being in one frame."""
STEEP_PLANE = 5.0  # inclination of the plane common to both walls from which users are warned [deg]
STEEP_WEDGE = 1.0  # inclination of the walls to each other from which users are warned [degrees]
LEAST_CELLS = 16  # along the shorter side of walls on a grid that the scan resolves
_FAR = 1.5
"""Closure until one cell in a thousand touches, in standard deviations of the aperture, from which
the first contact may be a spike."""
_SAME = 0.05
"""Relative difference up to which scattered points count as being as far apart as those of a grid.
Holes of a tenth of a wall make their mean distance larger by as much."""
_ONE_PEAK = 20.0
"""Difference of two rotations [degrees] up to which both may belong to one peak of correlation."""
_WIDTHS = (5.5, 6.4, 8.0, 10.0)
"""Widths of an overlap [mismatch wavelengths] at which errors of fits were measured."""
_ERRORS_OF_FITS = (2.4, 1.55, 1.15, 1.0)
"""Errors of rotation and shift over their standard errors by the fit at these `_WIDTHS` (rms of the
three errors of 24 pairs of walls each, benchmarks/results/registration_small_*; from 10 on those of
benchmarks/results/registration). On walls of 4.6 wavelengths they are as at 5.5."""
_ALIKE = 0.99  # correlation beyond which walls that fit at all wavelengths may be one wall
SHIFTS = ("scanned", "mated")  # positions of the upper wall: as scanned, or of best fit
SPIKES = ("keep", "cut")  # what is done with spikes
_SIDES = ("upper", "lower")

ORIENTATIONS = {
    "common_frame": "z upwards on both scans",
    "turned_over": "the wall was turned over",
    "towards": "heights towards the lower wall, plan as it lies",
    "mirrored": "z upwards, mirrored",
}
"""Orientations of the upper wall's scan, each compared over the full circle."""
_SIGNS = (1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (1.0, 1.0, -1.0), (-1.0, 1.0, 1.0)
"""Signs by which each orientation multiplies x, y and z of the upper wall's scan."""
_FLIPS = dict(zip(ORIENTATIONS, map(np.diag, _SIGNS), strict=True))
"""The same as matrices (3, 3), by the names of the orientations."""
_TURNED_OVER = (
    "; angles count from a wall that was turned over about its x axis, so that a wall turned over "
    "about its y axis is at 180 degrees"
)


class FineWalls(NamedTuple):
    """Registered walls on a finer grid than that of the joint, which the scans do not resolve."""

    upper: np.ndarray  # heights (y, x) [m] towards the other wall
    lower: np.ndarray
    holes: np.ndarray
    step: int  # spacing of the joint, in cells of this grid


class RegisteredPair(NamedTuple):
    """Two registered walls on a grid; places are (y, x), except for ``first``."""

    upper: np.ndarray  # heights (y, x) [m] towards the other wall
    lower: np.ndarray
    spacing: float  # [m]
    aperture: np.ndarray  # distance (y, x) [m] at first touch
    first_touch_cell: tuple[int, int]
    orientation: str
    fits: list[SlopeFit]  # the best of each orientation, the best first
    motion: Motion  # applied to the upper wall
    mated: Motion | None  # that of best fit
    correlation: float  # of heights
    mating: Mating
    mismatch: Mismatch
    overlap: float  # share of the smaller scan
    holes: np.ndarray  # cells (y, x) out of contact, as a scan has no height there
    first: np.ndarray  # place (x, y) [m] of the first cell in the lower scan
    report: list[str]  # results in sentences
    fine: FineWalls | None = None
    waves: tuple[float, float] = (0.0, 0.0)  # [m] below which the scans hold nothing; 0: all
    rounding: float = 0.0  # standard deviation [m] of the rounding of the sum of both walls
    scale: float = 1.0  # heights of the upper wall over those of the lower one, 1 unless clear
    scan_noise: tuple[tuple[str, float, float], ...] = ()
    """Name of each scanned wall, and the ends [m] of the 95 % interval of the standard deviation of
    its white noise, NaN if it is not known (`jointclosure.walls.scan_quality.noise_of_scan`)."""

    @property
    def warnings(self) -> list[Caution]:
        """Warnings among the sentences of the report."""
        return cautions(self.report)

    def _noise_of_sum(self, walls: Walls) -> tuple[float, float]:
        """Return the smallest and largest estimate [m] of the noise of the sum of both walls.

        It comes from the spectra (`noise_of`): all by which the walls depart from each other at the
        shortest waves of the grid. Part of that may be roughness that is too short for the grid,
        which interpolation of a turned wall replaces by other roughness. Where the noise of all
        scans was measured, it is at least that, and that where the spectra show none.
        """
        low, high = noise_of(*walls)
        intervals = np.array([ends for _, *ends in self.scan_noise]).reshape(-1, 2)
        if not np.isfinite(intervals).all() or not intervals.size:
            return low, high
        least, most = np.sqrt((intervals**2).sum(axis=0))
        return max(low, float(least)), max(high, float(least if high > 0.0 else most))

    @property
    def mismatch_wavelengths(self) -> float:
        """Width of the overlap in mismatch wavelengths; infinite if there is no such wavelength."""
        wavelength = self.mismatch.wavelength
        if not 0.0 < wavelength < np.inf:
            return np.inf
        return min(self.upper.shape) * self.spacing / wavelength

    @property
    def error_factor(self) -> float:
        """Factor from standard errors of the fit to those of rotation and shift in `errors`.

        Few waves of the walls fit each other on an overlap of few mismatch wavelengths, and the
        residuals of the fit show less than its error. The factor was measured (`_ERRORS_OF_FITS`).
        """
        return float(np.interp(self.mismatch_wavelengths, _WIDTHS, _ERRORS_OF_FITS))

    @property
    def finest(self) -> FineWalls:
        """Walls on the finest grid of the scans, to which the ``errors`` refer.

        It is the grid of the joint, unless the scans do not resolve it and the joint has a coarser
        one.
        """
        return self.fine or FineWalls(self.upper, self.lower, self.holes, 1)

    @property
    def errors(self) -> ScanErrors:
        """Standard errors of the position, 0 if the walls stayed as scanned, and of the heights.

        Those of the position are those of the fit times the `error_factor`.
        """
        fine = self.finest
        walls = (fine.upper, fine.lower)
        spacing = self.spacing / fine.step
        covariance = np.zeros((3, 3))
        offset = np.zeros(3)
        if self.mated is not None and np.isfinite(self.motion.covariance).all():
            scale = np.array([1.0, spacing, spacing])
            offset = self.motion.difference_to(self.mated) / scale * self.motion.covariance.any()
            covariance = self.motion.covariance / np.outer(scale, scale) * self.error_factor**2
        middle = (self.motion.place[:2] - self.first) / spacing
        noise = self._noise_of_sum(walls)
        waves = [wave / spacing for wave in self.waves]
        steps = np.concatenate([np.diff(sum(walls), axis=axis).ravel() for axis in (0, 1)])
        if self.rounding**2 > MOVED * float(np.mean(steps**2)):
            noise = max(noise[0], self.rounding), max(noise[1], self.rounding)
        return ScanErrors(
            offset, covariance, middle, noise, fine.holes, fine.step,
            waves=(waves[0] * (waves[0] > 2.0), waves[1] * (waves[1] > 2.0)), scale=self.scale,
        )  # fmt: skip


def registered(
    upper: Scan | Cloud | str,
    lower: Scan | Cloud | str,
    spacing: float | None = None,
    *,
    orientation: str | None = None,
    shift: str | None = None,
    spikes: str = "cut",
    largest_filled_share: float = LARGEST_HOLES,
    unusual_values: bool = False,
) -> RegisteredPair:
    """Register two scans of the walls of one joint, see docs/two_scans.md.

    Parameters
    ----------
    upper, lower : Scan, Cloud or "flat"
        In metres; heights of the lower scan count towards the upper wall. One of both may be flat.
        If that is the lower one, ``orientation`` has to be stated: an aperture map is an upper wall
        in a "common_frame", and heights of a scan from above count "towards" the lower wall.
    spacing : float, optional
        Grid spacing of the walls [m]: by default the larger point distance of the scans (that of a
        grid, if the scattered points of the other scan are on average up to 5 % farther apart), or
        the multiple of it that is nearest to 0.25 mm. Regular grids of at most half of it are
        sampled.
        If a scan holds no waves of twice this spacing, the default is the multiple of it that the
        scan resolves, up to 16 cells along the shorter side (``LEAST_CELLS``).
    orientation : str, optional
        Orientation of the upper scan, a key of `ORIENTATIONS`: by default the one with the best
        correlation of the walls' slopes over all rotations, if it is clear.
    shift : {"scanned", "mated"}, optional
        Leave the walls in their scanned position, or move the upper one to the best fit, the
        default. Walls that do not mate stay as scanned; they need their orientation.
    spikes : {"keep", "cut"}
        Whether to leave out points that differ from all but one of their neighbours
        (`jointclosure.walls.outliers.remove_spikes`).
    largest_filled_share : float
        Largest share of cells in holes inside the walls for which they are taken out of contact:
        they receive the height of the other wall and the largest aperture of the cells around.
    unusual_values : bool
        Whether to accept pairs that are probably wrong.

    Raises
    ------
    InputError
        If the fit is ambiguous and orientation and shift are not stated, or the pair is unusual.
    """
    check_options(orientation, shift, spikes)
    flat = next((side for side, s in zip(_SIDES, (upper, lower), strict=True) if s == FLAT), None)
    rough = _rough_scans(upper, lower, orientation)
    prepared = _prepared_scans(rough, orientation, spikes == "cut", not unusual_values)
    usual_spacing = spacing is None
    stated = prepared.distance if spacing is None else float(spacing)
    if not unusual_values:
        plausibility.check_scans(*prepared.both, stated)
    spacing = gridding.usual_grid_spacing(prepared.distance) if spacing is None else stated
    report = list(prepared.remarks)
    waves = _shortest_waves(prepared)
    sampled = _sampled_if_finer(prepared.both, spacing, report)
    clouds = [points_of(scan, missing=True) for scan in sampled]
    if flat:
        report.append(f"the {flat} wall is flat, parallel to the mean plane of the other")
        fit = _BestFit(orientation or "common_frame", [], None)
    else:
        fit = _best_fit(
            prepared, sampled, clouds, spacing, orientation, shift, unusual_values, report
        )
    scanned = flip_about_middle(clouds[0], _FLIPS[fit.orientation])
    if prepared.levelling is not None and flat is None:
        scanned = prepared.levelling.after(scanned)
    motion = scanned
    in_place = True
    if not flat:
        motion, in_place = _final_position(
            fit, scanned, prepared.both[0], clouds, spacing, shift, unusual_values, report
        )
    position = len(report)  # remarks on the errors of the position follow here
    overlap = _overlap_after(
        motion, prepared, sampled[1], spacing, largest_filled_share, flat, report
    )
    walls = overlap.parallel_walls
    step = _resolved_step(waves, spacing, overlap.upper.shape) if usual_spacing else 1
    fine = None
    if step > 1:
        fine = FineWalls(*walls, np.logical_or(*overlap.holes), step)
        report.append(_coarser_grid_caution(spacing, step))
        overlap = _every_node(overlap, step)
        spacing *= step
    in_frame = fit.orientation == "common_frame" and not flat and (in_place or shift == "scanned")
    pair = _registered_pair(overlap, spacing, fit, motion, in_frame, report)
    report[position:position] = _width_remarks(pair)
    scale, error = scale_of(*walls)
    differ = scales_differ(scale, error)
    pair = pair._replace(
        fine=fine, waves=waves, rounding=_rounding_of_sum(prepared), scale=scale if differ else 1.0,
        scan_noise=tuple((side, *noise_of_scan(scan)) for side, scan in prepared.measured.items()),
    )  # fmt: skip
    if differ:
        report.append(_scale_caution(scale, error))
    contradictions, unlike_rock = plausibility.unit_doubts(_by_side(pair), spacing)
    if not unusual_values:
        _check_usual_slopes(pair, contradictions, unlike_rock)
        if shift != "scanned":
            _check_found(fit)
        plausibility.check_pair(overlap.upper - overlap.lower, pair.correlation, in_frame)
    report += [caution(doubt) for doubt in contradictions + unlike_rock]
    return pair


def check_options(
    orientation: str | None = None, shift: str | None = None, spikes: str = "cut", **_: Any
) -> None:
    """Raise `InputError` if an option of `registered` is none of its words."""
    if orientation is not None:
        check_one_of("orientation", orientation, tuple(ORIENTATIONS))
    if shift is not None:
        check_one_of("shift", shift, SHIFTS)
    check_one_of("spikes", spikes, SPIKES)


class _PreparedScans(NamedTuple):
    """Scans before their registration, without spikes; by their sides those that are not flat."""

    measured: dict[str, Scan | Cloud]  # as scanned
    level: dict[str, Scan | Cloud]  # turned until their mean planes are level, if steep
    both: tuple[Scan | Cloud, Scan | Cloud]  # upper and lower wall as they are registered
    levelling: Motion | None  # by which the scan that states the frame of the walls was turned
    distance: float  # of points [m], with spikes, as `_common_distance`
    remarks: list[str]


class _BestFit(NamedTuple):
    """Orientation of the upper wall, the best fit of each orientation, and the refined one."""

    orientation: str
    fits: list[SlopeFit]  # the best first; none if a wall is flat
    mated: Motion | None  # None if the fit is ambiguous or a wall is flat


def _prepared_scans(
    rough: dict[str, Scan | Cloud], orientation: str | None, cut_spikes: bool, inspect: bool
) -> _PreparedScans:
    """Inspect scans for defects, cut their spikes, and level the one that states the frame.

    That is the lower one, or the upper one if the lower wall is flat. Heights of an aperture map
    ("common_frame" over a flat wall) are distances along z, so it is not turned.
    """
    measured = dict(rough)
    spiky: dict[str, str] = {}
    for side, scan in rough.items():
        whole = inspected(scan) if inspect else scan
        measured[side] = whole
        if cut_spikes:
            measured[side], removed = remove_spikes(whole)
            if removed:
                spiky[side] = f"{side} wall: {removed}; they were cut"
    # levelling interpolates the heights of grids, so noise and resolution are measured before it
    turned = dict(measured)
    levelling = None
    frame = "lower" if "lower" in rough else "upper"
    if frame == "lower" or orientation == "towards":
        turned[frame], levelling = levelled(measured[frame])
    level = dict(turned)
    if len(rough) == 2 and isinstance(turned["upper"], Cloud):
        level["upper"], _ = levelled(turned["upper"])
    both = _both_scans(turned, orientation)
    # points that were cut do not make the others lie farther apart
    whole_scans = {side: rough[side] for side, scan in turned.items() if isinstance(scan, Cloud)}
    if levelling is not None:
        whole_scans[frame] = turned[frame]
    distance = _common_distance((turned | whole_scans).values())
    remarks: list[str] = []
    for side, scan in turned.items():
        remarks += _with_side(side, scan.remarks)
        if side in spiky:
            remarks.append(spiky[side])
    return _PreparedScans(measured, level, both, levelling, distance, remarks)


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


def _shortest_waves(prepared: _PreparedScans) -> tuple[float, float]:
    """Return the shortest waves [m] that the upper and the lower scan resolve; 0: all."""
    upper, lower = (
        shortest_wave(prepared.measured[side], prepared.level[side])
        if side in prepared.measured
        else 0.0
        for side in _SIDES
    )
    return upper, lower


def _rounding_of_sum(prepared: _PreparedScans) -> float:
    """Return the standard deviation [m] of the rounding of the sum of both walls.

    Heights that are rounded to multiples of a step have an even distribution of errors over the
    step, whose variance is step^2 / 12; variances of both walls add.
    """
    steps = [rounding_of(scan).heights for scan in prepared.measured.values()]
    return float(np.sqrt(np.sum(np.square(steps)) / 12.0))


def _best_fit(
    prepared: _PreparedScans, sampled: list[Scan | Cloud], clouds: list[np.ndarray],
    spacing: float, orientation: str | None, shift: str | None, unusual: bool, report: list[str],
) -> _BestFit:  # fmt: skip
    """Fit the upper wall to the lower one on a grid with the distance of the scanned points.

    ``clouds`` are the points (n, 3) [m] of the ``sampled`` scans. The shortest waves mate least, so
    a fit on a finer grid than that of the joint is the better one; beyond `MOST_CELLS` along a side
    it is made on the grid of the joint.
    """
    longest = max(np.ptp(points[:, :2], axis=0).max() for points in clouds)
    distance = prepared.distance
    cell = distance if longest < MOST_CELLS * distance else spacing
    upper, lower = prepared.both if cell == distance else sampled
    level, levelling = levelled(upper, gridding.LARGEST_TILT)
    surfaces = [surface_of(points_of(scan, missing=True), cell) for scan in (level, lower)]
    fit = _oriented_fit(surfaces, orientation, shift, unusual, report)
    if fit.mated is not None and levelling is not None:
        return fit._replace(mated=fit.mated.after(levelling))
    return fit


def _final_position(
    fit: _BestFit, scanned: Motion, upper: Scan | Cloud, clouds: list[np.ndarray],
    spacing: float, shift: str | None, unusual: bool, report: list[str],
) -> tuple[Motion, bool]:  # fmt: skip
    """Return the motion of the upper wall, and whether its best fit is where it was scanned.

    ``clouds`` are the points (n, 3) [m] of both walls as scanned. The upper wall is not lifted by
    the motion of best fit, as walls are set to first touch later. Its nodes are laid on those of
    the lower wall where that moves them by less than `ON_NODES` or twice the error of the fit.
    """
    reach = 0.5 * np.ptp(clouds[0][:, :2], axis=0)
    mated = fit.mated
    in_place = mated is None or mated.corner_distance(scanned, reach) < IN_PLACE * reach.max()
    if shift == "scanned" or mated is None:
        report.append("the walls were left in their scanned position")
        if mated is not None and np.isfinite(mated.covariance).all():
            _check_unturned(mated, reach, spacing, unusual, report)
        return scanned, in_place
    report.append(f"the upper wall was {mated}, to the position of best fit")
    motion = mated._replace(place=np.append(mated.place[:2], mated.middle[2]))
    if isinstance(upper, Scan):
        most = min(max(ON_NODES * spacing, 2.0 * mated.corner_error(reach)), 0.5 * spacing)
        motion = laid_on_nodes(motion, upper, clouds[1][:, :2].min(axis=0), most)
    return motion, in_place


def _overlap_after(
    motion: Motion, prepared: _PreparedScans, lower: Scan | Cloud, spacing: float,
    largest_filled_share: float, flat: str | None, report: list[str],
) -> Overlap:  # fmt: skip
    """Return the overlap of the moved upper wall, at its scanned points, with the lower one.

    Sentences on each wall that is not flat are added to ``report``: slopes that interpolation
    changed, and doubts about resolution, rounding and noise.
    """
    upper = prepared.both[0]
    clouds = [_moved_points(points_of(upper, missing=True), motion), points_of(lower, missing=True)]
    upper_at = None
    if isinstance(upper, Scan):
        slopes = slopes_of(upper) if motion.tilt > gridding.LARGEST_TILT else (0.0, 0.0)
        upper_at = moved_heights(upper, motion, slopes)
    distances = [point_distance(scan) for scan in (upper, lower)]
    overlap = overlap_of(clouds, spacing, distances, largest_filled_share, upper_at)
    if flat:
        overlap = _with_flat_wall(overlap, flat)
    for side, cloud, hole in zip(_SIDES, clouds, overlap.holes, strict=True):
        if side != flat:
            known = np.where(hole, np.nan, getattr(overlap, side))
            lost = plausibility.smoothing_of(Cloud(cloud), known, spacing, *overlap.box)
            report += _with_side(side, lost)
            measured = prepared.measured[side]
            level = prepared.level[side]
            report += _with_side(side, resolution_remarks(measured, known, spacing, level))
    return overlap


def _resolved_step(waves: tuple[float, float], spacing: float, shape: tuple[int, ...]) -> int:
    """Return the cells of a grid from one node to the next one that both scans resolve.

    A grid resolves waves of two cells or more. At least `LEAST_CELLS` nodes remain along the
    shorter side of a grid of ``shape`` (y, x).
    """
    step = int(np.ceil(max(waves) / (2.0 * spacing) - 1e-6))
    return max(min(step, min(shape) // LEAST_CELLS), 1)


def _every_node(overlap: Overlap, step: int) -> Overlap:
    """Return an overlap on a grid of which one node in ``step`` is kept along each axis."""
    thin = np.s_[::step, ::step]
    return overlap._replace(
        upper=overlap.upper[thin], lower=overlap.lower[thin], holes=overlap.holes[:, *thin]
    )


def _by_side(pair: RegisteredPair) -> dict[str, np.ndarray]:
    """Return the heights (y, x) [m] of both walls by the names of their sides."""
    return {"upper": pair.upper, "lower": pair.lower}


def _check_usual_slopes(
    pair: RegisteredPair, contradictions: list[str], unlike_rock: list[str]
) -> None:
    """Refuse walls whose slopes no rough wall has, or whose heights contradict each other."""
    impossible = plausibility.slope_doubts(_by_side(pair), pair.spacing)
    if impossible or contradictions:
        problems = contradictions or unlike_rock or impossible
        raise InputError(f"{'; '.join(problems)}; {AS_IT_IS}")


def _check_found(fit: _BestFit) -> None:
    """Refuse a fit of slopes that least squares of heights do not confirm."""
    if fit.mated is not None and not np.isfinite(fit.mated.covariance).all():
        raise InputError(
            f"the fit of the walls is ambiguous: slopes correlate by {fit.fits[0]}, but least "
            "squares of heights find no position there; walls that do not mate need "
            "shift: scanned"
        )


def _coarser_grid_caution(spacing: float, step: int) -> Caution:
    """State that a joint has a coarser grid than the usual one of a spacing [m]."""
    return caution(
        f"heights were taken every {1e3 * step * spacing:.4g} mm, which the scans resolve, and not "
        f"every {1e3 * spacing:.4g} mm. The range has joints of both spacings, with lost "
        f"waves drawn at random (--spacing {1e3 * spacing:.4g} simulates the joint at that spacing)"
    )


def _scale_caution(scale: float, error: float) -> Caution:
    """Warn of heights of the upper wall whose scale differs from that of the lower wall."""
    return caution(
        f"heights of the upper wall are {scale:.3f} +- {scale * error:.3f} (standard error) times "
        "those of the lower one at the waves by which they mate: calibrate both scans. The range "
        "has walls of one scale, between both"
    )


def _with_side(side: str, remarks: Iterable[str]) -> list[str]:
    """Put the name of a wall before remarks and keep their type."""
    return [type(remark)(f"{side} wall: {remark}") for remark in remarks]


def _rough_scans(
    upper: Scan | Cloud | str, lower: Scan | Cloud | str, orientation: str | None
) -> dict[str, Scan | Cloud]:
    """Return the walls that are not flat, by their sides."""
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


def _both_scans(
    rough: dict[str, Scan | Cloud], orientation: str | None
) -> tuple[Scan | Cloud, Scan | Cloud]:
    """Return both walls as scans; a flat one has the places and the mean plane of the other."""
    if "upper" not in rough:
        return gridding.plane_of(rough["lower"]), rough["lower"]
    if "lower" not in rough:
        sign = round(_FLIPS[orientation or "common_frame"][2, 2])
        return rough["upper"], gridding.plane_of(rough["upper"], sign)
    return rough["upper"], rough["lower"]


def _with_flat_wall(overlap: Overlap, side: str) -> Overlap:
    """Make the flat wall of an overlap exactly flat, and count all holes to the other wall."""
    of_flat, other = (0, "lower") if side == "upper" else (1, "upper")
    gap = overlap.upper - overlap.lower
    holes = overlap.holes.any(axis=0)
    rough = np.where(holes, (2 * of_flat - 1) * gap, getattr(overlap, other))
    flat = {side: np.zeros(rough.shape), other: rough}
    return overlap._replace(**flat, holes=holes * (np.arange(2)[:, None, None] != of_flat))


def _sampled_if_finer(
    scans: tuple[Scan | Cloud, Scan | Cloud], spacing: float, report: list[str]
) -> list[Scan | Cloud]:
    """Return both scans, those on fine grids with heights at the nodes of one grid.

    It replaces a `Scan` whose points are at most half of ``spacing`` [m] apart. Each scan that is
    so fine, clouds too, has a sentence added to ``report``; the lower one, if it is a `Scan`, may
    have another, on slopes that are lost.
    """
    origins = [scan.origin for scan in scans if isinstance(scan, Scan) and scan.origin is not None]
    anchor = origins[-1] if origins else (0.0, 0.0)  # that of the lower wall if both have one
    result = list(scans)
    for place, (side, scan) in enumerate(zip(_SIDES, scans, strict=True)):
        distance = point_distance(scan)
        if 2.0 * distance > spacing:
            continue
        report.append(
            f"{side} wall: points are {1e3 * distance:.4g} mm apart, of which heights were "
            f"taken every {1e3 * spacing:.4g} mm, the grid spacing of the joint"
        )
        if isinstance(scan, Scan):
            result[place] = nodes = gridding.sample_grid(scan, spacing, anchor)
            if side == "lower":  # heights of the upper one are taken at the lower's nodes
                first = np.array(nodes.origin)[::-1]
                lost = plausibility.smoothing_of(scan, nodes.heights, spacing, first)
                report += _with_side(side, lost)
    return result


def _moved_points(points: np.ndarray, motion: Motion) -> np.ndarray:
    """Move points (n, 3); missing heights remain, their places are those of the mean height."""
    missing = np.isnan(points[:, 2])
    filled = np.where(missing, np.nanmean(points[:, 2]), points[:, 2])
    moved = motion.moved(np.column_stack([points[:, :2], filled]))
    moved[missing, 2] = np.nan
    return moved


def _oriented_fit(
    surfaces: list[Surface], orientation: str | None, shift: str | None, unusual: bool,
    report: list[str],
) -> _BestFit:  # fmt: skip
    """Find orientation and motion of best fit; no motion if the fit is ambiguous and not needed."""
    upper, lower = surfaces
    for blocks in BLOCKS:
        tried = compare_rotations(upper, lower, _FLIPS, blocks)
        best = tried[0]
        second = _second_fit(upper, lower, tried)
        if clear := best.correlation >= CLEAR * max(second.correlation, 0.0):
            break
    best_of = {fit.orientation: fit for fit in reversed(tried)}  # later entries replace worse ones
    fits = [fit for fit in tried if fit is best_of[fit.orientation]]
    if not clear and orientation is None:
        raise InputError(
            f"the fit of the walls is ambiguous: slopes correlate by {best} and by {second}, "
            f"but the best must be {CLEAR:g} times the second; check that these are the walls of "
            f"one joint; {_remedy(best, second)}; walls that do not mate need their orientation "
            f"({', '.join(ORIENTATIONS)}) alone, and keep their scanned position"
        )
    used = orientation or best.orientation
    how = "found" if orientation is None else "stated"
    report.append(
        f"orientation of the upper wall, {how}: {used} ({ORIENTATIONS[used]}); slopes correlate by "
        f"{', '.join(map(str, fits))}{_TURNED_OVER if used == 'turned_over' else ''}"
    )
    wrong = used != best.orientation
    if clear and wrong:
        better = (
            f"orientation = {orientation!r}: {best.orientation} fits clearly better, and closures "
            "of walls in a wrong orientation are several times too large"
        )
        if not unusual:
            remedy = f"state {best.orientation} or leave orientation out"
            raise InputError(f"{better}; {remedy}; {AS_IT_IS}")
        report.append(caution(better))
    if (shift != "mated" and not clear) or (shift == "scanned" and wrong):
        return _BestFit(used, fits, None)
    mated = refined_motion(upper, lower, _FLIPS[used], best_of[used])
    return _BestFit(used, fits, mated)


def _remedy(best: SlopeFit, second: SlopeFit) -> str:
    """Say how two fits of mating walls differ, and how one of them is chosen."""
    if second.orientation != best.orientation:
        return (
            f"if they mate, the orientation is {best.orientation} or {second.orientation}: state "
            "the one in which the walls were scanned, and shift mated (--orientation "
            f"{best.orientation} --shift mated); if it is not known, do so with both, and keep the "
            "one whose heights correlate more, which the report of the registration states"
        )
    return (
        f"both fits are {best.orientation}, and their rotations differ by "
        f"{best.turned_from(second):g} degrees: if the walls mate, --orientation "
        f"{best.orientation} --shift mated (orientation and shift in Python) takes the first of "
        "them; it is right only if it is about the rotation in which the walls were scanned, and "
        "if the report of the registration states a high correlation of heights; otherwise rotate "
        "one scan to within a few degrees of the other before this"
    )


def _second_fit(upper: Surface, lower: Surface, tried: list[SlopeFit]) -> SlopeFit:
    """Return the second best of all fits, the best first, or the next one if it is the same fit.

    The peak of the correlation about a rotation is broad on walls with long waves or of few cells,
    so that it can contain two fits whose angles differ by more than `DIFFERENT_ROTATIONS`. They
    count as one if both, refined by heights, lead to the same position within a cell.
    """
    best = tried[0]
    second = next(fit for fit in tried if fit.differs_from(best))
    clear = best.correlation >= CLEAR * max(second.correlation, 0.0)
    if clear or second.turned_from(best) > _ONE_PEAK:
        return second
    flip = _FLIPS[best.orientation]
    one, other = (refined_motion(upper, lower, flip, fit) for fit in (best, second))
    reach = 0.5 * upper.spacing * np.array(upper.heights.shape[::-1])
    known = np.isfinite([one.covariance, other.covariance]).all()
    if known and one.corner_distance(other, reach) < upper.spacing:
        return next(fit for fit in tried if fit.turned_from(best) > _ONE_PEAK)
    return second


def _check_unturned(
    mated: Motion, reach: np.ndarray, spacing: float, unusual: bool, report: list[str]
) -> None:
    """Refuse walls in their scanned position whose local shift grows from the middle."""
    report.append(f"best fit with the upper wall {mated}")
    error = mated.standard_errors()[0]
    edge = abs(np.radians(mated.angle)) * float(reach.max())
    if edge > 0.25 * spacing and abs(mated.angle) > 4.0 * error:
        turned = (
            f"the scanned walls are rotated by {mated.angle:.3f} +- {error:.3f} degrees against "
            f"each other (standard error): their shift grows from the middle to "
            f"{1e3 * edge:.3g} mm at the edge, and they mate only in the middle"
        )
        if not unusual and reach.min() > 40.0 * spacing:
            raise InputError(f"{turned}; leave shift: scanned out; {AS_IT_IS}")
        report.append(caution(turned))


def _registered_pair(
    overlap: Overlap, spacing: float, fit: _BestFit, motion: Motion, in_frame: bool,
    report: list[str],
) -> RegisteredPair:  # fmt: skip
    """Make the registered pair, seated parallel, and add its description to the report.

    ``in_frame``: both scans have one frame, in which the walls lie as they were scanned.
    """
    upper, lower = overlap.parallel_walls
    together = upper + lower
    aperture = together.max() - together
    y, x = (int(i) for i in np.unravel_index(int(np.argmin(aperture)), aperture.shape))
    cells = f"{grid_text(upper.shape, spacing)} (x, y)"
    shares = [f"{100.0 * share:.0f} %" for share in overlap.shares]
    if fit.fits:
        correlation = float(np.corrcoef(upper.ravel(), -lower.ravel())[0, 1])
        holes = overlap.holes.any(axis=0)  # filled by the other wall, which they fit
        one, other = (
            fill_missing(np.where(holes, np.nan, w), "linear", 1.0) for w in (upper, lower)
        )
        mismatch = measured_mismatch(one, other, spacing)
        correlations = mating(one, other, spacing)
        report += [
            f"overlap: {cells}, {shares[0]} of the upper scan and {shares[1]} of the lower",
            f"the plane common to both walls, inclined by {overlap.inclination:.2f} degrees, was "
            f"removed; the walls were left inclined to each other by {overlap.relative:.3f} "
            "degrees and are set parallel",
            f"heights correlate by {correlation:.3f}; {describe_mating(mismatch)}",
        ]
    else:  # one wall is flat and has no waves
        correlation = 0.0
        mismatch = Mismatch(*[np.inf] * 3)
        correlations = Mating(*[np.empty(0)] * 3)
        report.append(
            f"largest rectangle of the scan without missing heights: {cells}, {shares[0]} of it; "
            "its mean plane was removed"
        )
    report += _first_touch_remarks(aperture, y, x)
    report += map(caution, _overlap_doubts(overlap, bool(fit.fits), bool(motion.covariance.any())))
    if mismatch.wavelength == 0.0 and correlation > _ALIKE:
        alike = (
            "the walls fit each other at all wavelengths of the grid, as two scans of one wall "
            "do; check that the files are of different walls"
        )
        report.append(caution(alike))
    if in_frame:
        report.append(_frame_remark(overlap))
    return RegisteredPair(
        upper, lower, spacing, aperture, (y, x), fit.orientation, fit.fits, motion, fit.mated,
        correlation, correlations, mismatch, max(overlap.shares), np.logical_or(*overlap.holes),
        overlap.first, report,
    )  # fmt: skip


def _width_remarks(pair: RegisteredPair) -> list[str]:
    """Say that standard errors of a fit are too small on walls of few mismatch wavelengths."""
    factor = pair.error_factor
    if factor == 1.0 or not pair.motion.covariance.any():
        return []
    angle, *errors = (factor * error for error in pair.motion.standard_errors())
    x, y = (f"{1e3 * error:.4f}" for error in errors)
    return [
        f"the overlap is only {pair.mismatch_wavelengths:.2g} mismatch wavelengths wide: in a "
        f"test, errors of rotation and shift on such walls were {factor:.2g} times as large as "
        f"these standard errors. They are therefore taken as {angle:.3f} degrees and "
        f"({x}, {y}) mm in the range of the joint (docs/two_scans.md#how-the-scans-are-registered)"
    ]


def _first_touch_remarks(aperture: np.ndarray, y: int, x: int) -> list[str]:
    """Describe the aperture (y, x) [m] at first touch, and how far the first contact stands out."""
    early = float(np.quantile(aperture, 1e-3))
    touches = f"one cell in a thousand touches after {1e3 * early:.3g} mm of closure"
    exact = (
        "this and the next length are exact for the walls as registered, and the range of the "
        "results has other positions of them"
    )
    spike = (
        "the first contact stands out far and may be a remaining spike; use closures since "
        "seating, not those from first touch"
    )
    return [
        f"at first touch, at cell (x, y) = ({x}, {y}), the mean aperture is "
        f"{1e3 * aperture.mean():.3g} mm; {exact}",
        caution(spike, f"{touches}: ") if early > _FAR * aperture.std() else touches,
    ]


def _frame_remark(overlap: Overlap) -> str:
    """Describe the mean distance of walls in one frame, or say that it is not known.

    Walls with one zero of heights hardly overlap in the order in which they are given, or nearly
    everywhere if they are interchanged. In other scans neither is so.
    """
    gaps = overlap.upper - overlap.lower
    gap = float(np.mean(gaps))
    where = f"{1e3 * abs(gap):.3g} mm {'above' if gap > 0.0 else 'below'} the lower one"
    lies = f"in the scans the upper wall lies {where} in the mean"
    below = float(np.mean(gaps < 0.0))
    if below > plausibility.INTERCHANGED:
        return caution("the walls are interchanged or heights count downwards", f"{lies}: ")
    if below < 1.0 - plausibility.INTERCHANGED:
        return lies
    return caution(
        "the scans have no common zero of heights, as each wall lies partly below the other: the "
        "data do not show whether the files are interchanged, in which case the aperture would be "
        "that of other walls; check that the first file is the upper wall"
    )


def _overlap_doubts(overlap: Overlap, both: bool, best_fit: bool) -> list[str]:
    """Describe holes, unusual overlap and inclinations.

    ``both``: neither wall is flat; ``best_fit``: they are in the position of best fit.
    """
    doubts = []
    share = 100.0 * max(overlap.shares)
    size = overlap.upper.size
    lost = int(overlap.holes.any(axis=0).sum())
    if lost > 0:
        upper, lower = overlap.holes.sum(axis=(1, 2)).tolist()
        doubts.append(
            f"{lost} of {size} cells ({percent(lost / size)}) lie in holes of a scan "
            f"({upper} of the upper, {lower} of the lower); they were taken out of contact, with "
            "the largest aperture of those around them"
        )
    if overlap.cut > 0:
        doubts.append(
            f"{overlap.cut} cells in large holes of a scan were left out: the joint is the largest "
            f"rectangle without such holes, {share:.0f} % of the smaller scan"
        )
    if both and max(overlap.shares) < LEAST_OVERLAP:
        question = (
            ", even in the position of best fit: are the scans of the same part of the joint?"
            if best_fit
            else ": are the scans in one frame? (--shift mated moves them to the best fit)"
        )
        doubts.append(
            f"the walls overlap in {share:.0f} % of the smaller scan, less than "
            f"{100.0 * LEAST_OVERLAP:.0f} %{question}"
        )
    if overlap.inclination > STEEP_PLANE:
        doubts.append(
            f"the {'common plane' if both else 'plane'} is inclined by "
            f"{overlap.inclination:.1f} degrees, more than {STEEP_PLANE:g}; it was removed along "
            "z, so that heights are not normal to it; turn the scans"
        )
    if both and overlap.relative > STEEP_WEDGE:
        doubts.append(
            f"the walls are inclined to each other by {overlap.relative:.1f} degrees, more than "
            f"{STEEP_WEDGE:g}; walls of one joint are about parallel"
        )
    return doubts


def describe_mating(mismatch: Mismatch) -> str:
    """Describe at which wavelengths walls are mated."""
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

"""Registration of the scans of the two walls of a joint (`registered`), see docs/two_scans.md."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_length
from jointclosure.inputs.remarks import caution
from jointclosure.parameters import AS_IT_IS, check_usual
from jointclosure.walls import gridding, plausibility
from jointclosure.walls.gridding import Cloud, Scan, point_distance, points_of
from jointclosure.walls.levelling import slopes_of
from jointclosure.walls.mating import Mating, Mismatch, mating, measured_mismatch
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.motion import NO_MOTION, Motion, moved_heights
from jointclosure.walls.overlap import HeightsAt, Overlap, overlap_of
from jointclosure.walls.pair_remarks import (
    best_fit_remarks,
    coarser_grid_caution,
    scale_caution,
    wall_remarks,
    width_remarks,
)
from jointclosure.walls.position_search import (
    BestFit,
    Position,
    at_best_fit,
    best_fit,
    check_found,
    position_of,
)
from jointclosure.walls.prepared_scans import (
    SIDES,
    PreparedScans,
    SampledScans,
    prepared_scans,
    sampled_if_finer,
    scans_by_side,
    with_side,
)
from jointclosure.walls.registered_pair import FineWalls, RegisteredPair
from jointclosure.walls.registration_options import LARGEST_HOLES, RegistrationOptions
from jointclosure.walls.scan_errors import scale_of, scales_differ
from jointclosure.walls.scan_quality import noise_of_scan, resolution_remarks

# All constants were chosen; the pairs of known truth of docs/two_scans.md were registered by them.
LEAST_CELLS = 16  # along the shorter side of walls on a grid that the scan resolves


class _GridOfJoint(NamedTuple):
    """Overlap of two walls on the grid of the joint, and on a finer one if the scans have it."""

    overlap: Overlap
    spacing: float  # [m]
    fine: FineWalls | None  # None if the grid of the joint is the finest
    remarks: list[str]


class _Agreement(NamedTuple):
    """How far both walls fit each other."""

    correlation: float  # of heights
    mating: Mating
    mismatch: Mismatch


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
        Grid spacing of the walls [m], by default the multiple of the larger point distance of both
        scans that is nearest to 0.25 mm, at least this distance itself. If a scan holds no waves of
        twice this spacing, the default is the multiple of it that the scan resolves, up to 16 cells
        along the shorter side (``LEAST_CELLS``).

        If the scattered points of one scan are on average up to 5 % farther apart than those of a
        grid, the distance is that of the grid. A grid whose points are at most half of the spacing
        apart is sampled: single heights are taken at the nodes of the coarser grid.
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
        they receive the height of the other wall and the largest aperture of the cells around. If
        the share is larger, the walls are cut to the largest rectangle without holes.
    unusual_values : bool
        Whether to accept pairs that are probably wrong.

    Returns
    -------
    RegisteredPair
        Both walls (y, x) [m] on one grid, parallel to each other, heights towards the other wall,
        with the motion of the upper one, its errors, and remarks.

    Raises
    ------
    InputError
        If an option is none of its words, the spacing is no length, or a flat wall has no or a
        wrong orientation; if no fit is clearly best and ``orientation`` is not stated, even if
        ``shift`` is; if the walls are too inclined or overlap in too few cells. Unless
        ``unusual_values``, also if the spacing is unusual, a scan has a defect, a stated
        orientation fits clearly worse than another one, walls left in their "scanned" position are
        rotated against each other, least squares of heights find no position (not with ``shift``
        "scanned"), or heights, slopes or units of the pair are unusual.
    """
    options = RegistrationOptions(
        orientation=orientation,
        shift=shift,
        spikes=spikes,
        largest_filled_share=largest_filled_share,
        unusual_values=unusual_values,
    )
    if spacing is not None:
        check_length("spacing", spacing)
        if not unusual_values:
            check_usual((), spacing=spacing)
    return registered_by(options, upper, lower, spacing)


def registered_by(
    options: RegistrationOptions,
    upper: Scan | Cloud | str,
    lower: Scan | Cloud | str,
    spacing: float | None = None,
) -> RegisteredPair:
    """Register two scans as `registered` does, with options and a spacing [m] that were checked.

    Raise `InputError` as `registered`.
    """
    scans = scans_by_side(upper, lower, options.orientation)
    prepared = prepared_scans(scans, options)
    if not options.unusual_values:
        plausibility.check_scans(prepared.upper, prepared.lower)
        if spacing is None:
            check_usual((), spacing=prepared.distance)
    of_nodes = gridding.usual_grid_spacing(prepared.distance) if spacing is None else float(spacing)
    sampled = sampled_if_finer(prepared, of_nodes)
    fit = best_fit(prepared, sampled, of_nodes, options)
    position = position_of(fit, prepared, sampled, of_nodes, options)
    overlap, lost_square, overlap_remarks = _overlap_at(
        position.motion, prepared, sampled.lower, of_nodes, options.largest_filled_share
    )
    step = _resolved_step(prepared.shortest_waves, of_nodes, overlap.upper.shape)
    grid = _grid_of_joint(overlap, of_nodes, step if spacing is None else 1)
    pair = _registered_pair(grid, fit, position, prepared)
    scale, scale_remarks = _clear_scale(pair)
    contradictions, unlike_rock = plausibility.unit_doubts(_by_side(pair), pair.spacing)
    if not options.unusual_values:
        _check_possible_slopes(pair, contradictions, unlike_rock)
        if options.shift != "scanned":
            check_found(fit)
        plausibility.check_pair(grid.overlap.gap, pair.correlation, position.in_frame)
    remarks = [
        *prepared.remarks,
        *sampled.remarks,
        *fit.remarks,
        *position.remarks,
        *width_remarks(pair),
        *overlap_remarks,
        *grid.remarks,
        *wall_remarks(pair, grid.overlap, position.in_frame),
        *_apart_remarks(pair, prepared, sampled, of_nodes, options),
        *scale_remarks,
        *map(caution, contradictions + unlike_rock),
    ]
    return pair._replace(scale=scale, lost_square_slope=lost_square, remarks=remarks)


def _apart_remarks(
    pair: RegisteredPair,
    prepared: PreparedScans,
    sampled: SampledScans,
    spacing: float,
    options: RegistrationOptions,
) -> list[str]:
    """Warn of walls whose stated scanned position fits clearly worse than that of best fit.

    The overlap there is of a grid of a ``spacing`` [m].
    """
    mated = pair.mated
    if options.shift != "scanned" or mated is None or not np.isfinite(mated.covariance).all():
        return []
    share = options.largest_filled_share
    try:
        best, _, _ = _overlap_at(at_best_fit(mated), prepared, sampled.lower, spacing, share)
    except InputError:  # the walls do not overlap there
        return []
    return best_fit_remarks(pair, best)


def _overlap_at(
    motion: Motion,
    prepared: PreparedScans,
    lower: Scan | Cloud,
    spacing: float,
    largest_filled_share: float,
) -> tuple[Overlap, float, list[str]]:
    """Return the overlap of the moved upper wall, at its scanned points, with the lower one.

    The second value is the mean square slope [1] that interpolation onto the grid took from both
    walls together. The remarks are on each wall that is not flat: slopes that interpolation
    changed, and doubts about resolution, rounding and noise.
    """
    upper = prepared.upper
    upper_at = None
    if isinstance(upper, Scan):
        slopes = slopes_of(upper) if motion.tilt > gridding.LARGEST_TILT else (0.0, 0.0)
        upper_at = moved_heights(upper, motion, slopes)
    lower_heights = _lower_heights(prepared, lower, spacing)
    heights_at = (upper_at, lower_heights.at if lower_heights else None)
    clouds = [_moved_points(points_of(upper, missing=True), motion), points_of(lower, missing=True)]
    distances = [point_distance(scan) for scan in (upper, lower)]
    overlap = overlap_of(clouds, spacing, distances, largest_filled_share, heights_at)
    if prepared.flat_side:
        overlap = overlap.with_flat_wall(prepared.flat_side)
    holes = (overlap.upper_holes, overlap.lower_holes)
    remarks = []
    lost_square = 0.0
    scanned = (clouds[0], lower_heights.points if lower_heights else clouds[1])
    for side, cloud, hole in zip(SIDES, scanned, holes, strict=True):
        if side != prepared.flat_side:
            known = np.where(hole, np.nan, getattr(overlap, side))
            found = plausibility.slopes_by_interpolation(cloud, known, spacing, *overlap.box)
            lost_square += found.lost_square if found else 0.0
            remarks += with_side(side, plausibility.smoothing_caution(found, spacing))
            measured = prepared.measured[side]
            level = prepared.level[side]
            remarks += with_side(side, resolution_remarks(measured, known, spacing, level))
    return overlap, lost_square, remarks


class _InterpolatedGrid(NamedTuple):
    """A scanned grid that is interpolated at nodes which do not lie on its points."""

    at: HeightsAt
    points: np.ndarray  # (n, 3) [m] of the scan about its mean plane, for their slopes


def _lower_heights(
    prepared: PreparedScans, lower: Scan | Cloud, spacing: float
) -> _InterpolatedGrid | None:
    """Return the interpolation of the lower scan by cubic splines, on a grid of a spacing [m].

    None if the scan is no grid, or if the nodes lie on points of the scan. A steep scan, which was
    turned until it lies level, is interpolated as it was read, so that its heights are not
    interpolated twice.
    """
    if not isinstance(lower, Scan):
        return None
    cells = spacing / np.array(lower.spacing)
    if np.allclose(cells, np.rint(cells), rtol=1e-6):
        return None
    as_read = prepared.measured.get("lower")
    levelling = prepared.levelling
    if levelling is None or not isinstance(as_read, Scan):
        return _InterpolatedGrid(moved_heights(lower, NO_MOTION), points_of(lower, missing=True))
    slopes = slopes_of(as_read)
    # a level scan has its heights from the middle of its plane on
    motion = levelling._replace(place=levelling.place * [1.0, 1.0, 0.0])
    points = points_of(as_read, missing=True)
    x, y, heights = (points - levelling.middle).T
    # less an inclined plane, slopes along the dip are 1 / cos^2 and those across it 1 / cos as
    # large as normal to it; moved points would lie at distances that depend on their slope
    cosine = 1.0 / np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
    points[:, 2] = (heights - slopes[0] * x - slopes[1] * y) * cosine**1.5
    return _InterpolatedGrid(moved_heights(as_read, motion, slopes), points)


def _moved_points(points: np.ndarray, motion: Motion) -> np.ndarray:
    """Move points (n, 3); missing heights remain, their places are those of the mean height."""
    missing = np.isnan(points[:, 2])
    filled = np.where(missing, np.nanmean(points[:, 2]), points[:, 2])
    moved = motion.moved(np.column_stack([points[:, :2], filled]))
    moved[missing, 2] = np.nan
    return moved


def _resolved_step(waves: tuple[float, float], spacing: float, shape: tuple[int, ...]) -> int:
    """Return the cells of a grid from one node to the next one that both scans resolve.

    A grid resolves waves of two cells or more. At least `LEAST_CELLS` nodes remain along the
    shorter side of a grid of ``shape`` (y, x).
    """
    step = int(np.ceil(max(waves) / (2.0 * spacing) - 1e-6))
    return max(min(step, min(shape) // LEAST_CELLS), 1)


def _grid_of_joint(overlap: Overlap, spacing: float, step: int) -> _GridOfJoint:
    """Return an overlap on a grid of which one node in ``step`` is kept along each axis."""
    if step == 1:
        return _GridOfJoint(overlap, spacing, None, [])
    fine = FineWalls(*overlap.parallel_walls, overlap.holes, step)
    remark = coarser_grid_caution(spacing, step)
    return _GridOfJoint(overlap.every_node(step), step * spacing, fine, [remark])


def _registered_pair(
    grid: _GridOfJoint, fit: BestFit, position: Position, prepared: PreparedScans
) -> RegisteredPair:
    """Make the registered pair, seated parallel, still without scale and remarks."""
    overlap = grid.overlap
    upper, lower = overlap.parallel_walls
    together = upper + lower
    aperture = together.max() - together
    y, x = (int(i) for i in np.unravel_index(int(np.argmin(aperture)), aperture.shape))
    agreement = (
        _NO_AGREEMENT
        if prepared.flat_side
        else _agreement_of(upper, lower, overlap.holes, grid.spacing)
    )
    noise = [(side, *noise_of_scan(scan)) for side, scan in prepared.measured.items()]
    return RegisteredPair(
        upper=upper,
        lower=lower,
        spacing=grid.spacing,
        aperture=aperture,
        first_touch_cell=(y, x),
        orientation=fit.orientation,
        fits=fit.fits,
        motion=position.motion,
        mated=fit.mated,
        correlation=agreement.correlation,
        mating=agreement.mating,
        mismatch=agreement.mismatch,
        overlap_share=max(overlap.shares),
        holes=overlap.holes,
        first=overlap.first,
        remarks=[],
        fine=grid.fine,
        waves=prepared.shortest_waves,
        rounding=prepared.rounding_of_sum,
        scan_noise=tuple(noise),
    )


_NO_AGREEMENT = _Agreement(0.0, Mating(*[np.empty(0)] * 3), Mismatch(*[np.inf] * 3))
"""Agreement with a flat wall, which has no waves."""


def _agreement_of(
    upper: np.ndarray, lower: np.ndarray, holes: np.ndarray, spacing: float
) -> _Agreement:
    """Return how far walls (y, x) [m], heights towards each other, fit each other.

    Correlations by wavelength leave out ``holes`` (y, x), which were filled by the other wall.
    """
    correlation = float(np.corrcoef(upper.ravel(), -lower.ravel())[0, 1])
    one, other = (
        fill_missing(np.where(holes, np.nan, wall), "linear", 1.0) for wall in (upper, lower)
    )
    mismatch = measured_mismatch(one, other, spacing)
    return _Agreement(correlation, mating(one, other, spacing), mismatch)


def _clear_scale(pair: RegisteredPair) -> tuple[float, list[str]]:
    """Return the scale of the upper wall's heights to the lower one's, with a remark on it.

    It is 1, without a remark, unless it clearly differs from that.
    """
    finest = pair.finest
    scale, error = scale_of(finest.upper, finest.lower)
    if not scales_differ(scale, error):
        return 1.0, []
    return scale, [scale_caution(scale, error)]


def _by_side(pair: RegisteredPair) -> dict[str, np.ndarray]:
    """Return the heights (y, x) [m] of both walls by the names of their sides."""
    return {"upper": pair.upper, "lower": pair.lower}


def _check_possible_slopes(
    pair: RegisteredPair, contradictions: list[str], unlike_rock: list[str]
) -> None:
    """Refuse walls whose slopes no rough wall has, or whose heights contradict each other."""
    impossible = plausibility.slope_doubts(_by_side(pair), pair.spacing)
    if impossible or contradictions:
        problems = contradictions or unlike_rock or impossible
        raise InputError(f"{'; '.join(problems)}; {AS_IT_IS}")

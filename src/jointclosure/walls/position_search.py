"""Search for the orientation of the upper wall and for its position on the lower one."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.parameters import AS_IT_IS
from jointclosure.walls.gridding import LARGEST_TILT, Scan, points_of
from jointclosure.walls.levelling import levelled
from jointclosure.walls.motion import Motion, flip_about_middle, laid_on_nodes
from jointclosure.walls.motion_fit import refined_motion
from jointclosure.walls.pair_remarks import levelling_remark
from jointclosure.walls.prepared_scans import PreparedScans, SampledScans
from jointclosure.walls.registration_options import FLIPS, ORIENTATIONS, RegistrationOptions
from jointclosure.walls.rotation_search import BLOCKS, CLEAR, SlopeFit, compare_rotations
from jointclosure.walls.surfaces import Surface, surface_of

# All constants were chosen; the pairs of known truth of docs/two_scans.md were registered by them.
ON_NODES = 0.02
"""Largest distance [cells] by which the upper wall is displaced, so that its nodes lie on nodes of
the lower one and no heights are interpolated; twice the error of the fit, up to 0.5, if more."""
MOST_CELLS = 500  # along a side of walls that are registered at the spacing of the scans
IN_PLACE = 0.02
"""Largest shift of the corners by the best fit, over half of the longer side, with which the scans
count as being in one frame."""
_ONE_PEAK = 20.0
"""Difference of two rotations [degrees] up to which both may belong to one peak of correlation."""
_TURNED_OVER = (
    "; angles count from a wall that was turned over about its x axis, so that a wall turned over "
    "about its y axis is at 180 degrees"
)


class BestFit(NamedTuple):
    """Best fit of the upper wall to the lower one."""

    orientation: str  # of the upper wall, stated or found
    fits: list[SlopeFit]  # of slopes, the best of each orientation, the best first; none if flat
    mated: Motion | None  # refined by heights; None if the fit is ambiguous or a wall is flat
    remarks: list[str]  # on the orientation


class Position(NamedTuple):
    """Position of the upper wall in the frame of the lower one, and the fit that led to it."""

    motion: Motion  # from where the upper wall was scanned
    in_frame: bool  # whether both scans have one frame, in which the walls lie as scanned
    fit: BestFit  # from which the position was taken, unless the walls stay as scanned
    remarks: list[str]  # on the fit, then on the position
    levelling: Motion | None = None  # by which scans whose scanned position is kept became level

    @property
    def confirmed(self) -> bool:
        """Whether least squares of heights confirm the fit of slopes, if there is one."""
        mated = self.fit.mated
        return mated is None or bool(np.isfinite(mated.covariance).all())


class _ComparedFits(NamedTuple):
    """Fits of slopes over all rotations and orientations."""

    fits: list[SlopeFit]  # the best of each orientation, the best first
    second: SlopeFit  # the second best of all fits, as far as it is another one than the best
    clear: bool  # whether the best is `CLEAR` times the second

    @property
    def best(self) -> SlopeFit:
        """Best of all fits."""
        return self.fits[0]


def found_position(
    prepared: PreparedScans, sampled: SampledScans, options: RegistrationOptions
) -> Position:
    """Find where the upper wall lies in the frame of the lower one: as scanned, or of best fit.

    A flat wall is not fitted, and lies as the other one was scanned. Raise `InputError` if the fit
    is ambiguous and the orientation not stated. Unless values may be unusual, raise it also if a
    stated orientation fits clearly worse than another one, or walls that are left as scanned are
    rotated against each other. A fit that heights do not confirm is not refused here, because
    heights in a wrong unit, which have a better error message, may be the reason.
    """
    fit = _best_fit(prepared, sampled, options)
    return _position_of(fit, prepared, sampled, options)


def _best_fit(
    prepared: PreparedScans, sampled: SampledScans, options: RegistrationOptions
) -> BestFit:
    """Fit the upper wall to the lower one on a grid with the distance of the scanned points.

    The shortest waves mate least, so a fit on a finer grid than the grid of the joint is the better
    one; beyond `MOST_CELLS` along a side the fit is made on the grid of the joint. A flat wall has
    an orientation alone. Raise `InputError` if the fit is ambiguous and the orientation not stated,
    or a stated orientation fits clearly worse.
    """
    if prepared.flat_side:
        remark = f"the {prepared.flat_side} wall is flat, parallel to the mean plane of the other"
        return BestFit(options.orientation or "common_frame", [], None, [remark])
    points = (sampled.upper_points, sampled.lower_points)
    longest = max(np.ptp(part[:, :2], axis=0).max() for part in points)
    cell = prepared.distance if longest < MOST_CELLS * prepared.distance else prepared.spacing
    above, below = (
        (prepared.upper.scan, prepared.lower.scan)
        if cell == prepared.distance
        else (sampled.upper, sampled.lower)
    )
    level, levelling = levelled(above, LARGEST_TILT)
    upper, lower = (surface_of(points_of(scan, missing=True), cell) for scan in (level, below))
    fit = _oriented_fit(upper, lower, options)
    if fit.mated is not None and levelling is not None:
        return fit._replace(mated=fit.mated.after(levelling))
    return fit


def _oriented_fit(upper: Surface, lower: Surface, options: RegistrationOptions) -> BestFit:
    """Find orientation and motion of best fit; no motion if the fit is ambiguous and not needed.

    Raise `InputError` if the fit is ambiguous and the orientation not stated, or a stated
    orientation fits clearly worse.
    """
    compared = _compared_fits(upper, lower)
    best = compared.best
    if not compared.clear and options.orientation is None:
        raise InputError(
            f"the fit of the walls is ambiguous: slopes correlate by {best} and by "
            f"{compared.second}, but the best must be {CLEAR:g} times the second; check that these "
            f"are the walls of one joint; {_remedy(best, compared.second)}; walls that do not mate "
            f"need their orientation ({', '.join(ORIENTATIONS)}) alone, and keep their scanned "
            "position"
        )
    used = options.orientation or best.orientation
    how = "found" if options.orientation is None else "stated"
    remarks = [
        f"orientation of the upper wall, {how}: {used} ({ORIENTATIONS[used]}); slopes correlate by "
        f"{', '.join(map(str, compared.fits))}{_TURNED_OVER if used == 'turned_over' else ''}"
    ]
    wrong = used != best.orientation
    if compared.clear and wrong:
        remarks.append(_wrong_orientation(best, options))
    not_believed = options.shift != "mated" and not compared.clear
    not_needed = options.shift == "scanned" and wrong
    if not_believed or not_needed:
        return BestFit(used, compared.fits, None, remarks)
    start = next(fit for fit in compared.fits if fit.orientation == used)
    mated = refined_motion(upper, lower, FLIPS[used], start)
    return BestFit(used, compared.fits, mated, remarks)


def _compared_fits(upper: Surface, lower: Surface) -> _ComparedFits:
    """Compare slopes over all rotations and orientations, on finer blocks if no fit is clear."""
    for blocks in BLOCKS:
        tried = compare_rotations(upper, lower, FLIPS, blocks)
        second = _second_fit(upper, lower, tried)
        if clear := tried[0].correlation >= CLEAR * max(second.correlation, 0.0):
            break
    best_of = {fit.orientation: fit for fit in reversed(tried)}  # later entries replace worse ones
    fits = [fit for fit in tried if fit is best_of[fit.orientation]]
    return _ComparedFits(fits, second, clear)


def _wrong_orientation(best: SlopeFit, options: RegistrationOptions) -> str:
    """Return a warning of a stated orientation, where another one has the ``best`` and clear fit.

    Raise `InputError` with the same words unless values may be unusual.
    """
    better = (
        f"orientation = {options.orientation!r}: {best.orientation} fits clearly better, and "
        "closures of walls in a wrong orientation are several times too large"
    )
    if not options.unusual_values:
        remedy = f"state {best.orientation} or leave orientation out"
        raise InputError(f"{better}; {remedy}; {AS_IT_IS}")
    return caution(better)


def _remedy(best: SlopeFit, second: SlopeFit) -> str:
    """Say how two fits of mating walls differ, and how to choose one of both."""
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
    """Return the second best of fits, listed the best first, as far as it is not the best one.

    The peak of the correlation about a rotation is broad on walls with long waves or of few cells,
    and can contain two fits with angles that differ by more than `DIFFERENT_ROTATIONS`. Both count
    as one if least squares of heights lead from both to the same position within a cell; the next
    fit beyond the peak is then the second best.
    """
    best = tried[0]
    second = next(fit for fit in tried if fit.differs_from(best))
    clear = best.correlation >= CLEAR * max(second.correlation, 0.0)
    if clear or second.turned_from(best) > _ONE_PEAK:
        return second
    flip = FLIPS[best.orientation]
    one, other = (refined_motion(upper, lower, flip, fit) for fit in (best, second))
    reach = 0.5 * upper.spacing * np.array(upper.heights.shape[::-1])
    known = np.isfinite([one.covariance, other.covariance]).all()
    if known and one.corner_distance(other, reach) < upper.spacing:
        return next(fit for fit in tried if fit.turned_from(best) > _ONE_PEAK)
    return second


def _position_of(
    fit: BestFit, prepared: PreparedScans, sampled: SampledScans, options: RegistrationOptions
) -> Position:
    """Return where the upper wall is laid: as it was scanned, or in the position of best fit.

    The upper wall is not lifted by the motion of best fit (`at_best_fit`). Its nodes are laid on
    nodes of the lower wall if they move by less than `ON_NODES` or twice the error of the fit.
    Raise `InputError` if walls in their scanned position are rotated against each other, unless
    values may be unusual.
    """
    spacing = prepared.spacing
    scanned = flip_about_middle(sampled.upper_points, FLIPS[fit.orientation])
    if prepared.flat_side:
        return Position(scanned, False, fit, fit.remarks)
    if prepared.lower.levelling is not None:
        scanned = prepared.lower.levelling.after(scanned)
    reach = 0.5 * np.ptp(sampled.upper_points[:, :2], axis=0)
    mated = fit.mated
    in_place = mated is None or mated.corner_distance(scanned, reach) < IN_PLACE * reach.max()
    in_frame = fit.orientation == "common_frame" and (in_place or options.shift == "scanned")
    if options.shift == "scanned" or mated is None:
        remarks = ["the walls were left in their scanned position"]
        levelling = prepared.lower.levelling if options.shift == "scanned" else None
        remarks += [levelling_remark(levelling)] if levelling else []
        if mated is not None and np.isfinite(mated.covariance).all():
            remarks += _rotation_remarks(mated, reach, spacing, options.unusual_values)
        return Position(scanned, in_frame, fit, fit.remarks + remarks, levelling)
    motion = at_best_fit(mated)
    if isinstance(prepared.upper.scan, Scan):
        most = min(max(ON_NODES * spacing, 2.0 * mated.corner_error(reach)), 0.5 * spacing)
        corner = sampled.lower_points[:, :2].min(axis=0)
        motion = laid_on_nodes(motion, prepared.upper.scan, corner, most)
    moved = f"the upper wall was {mated}, to the position of best fit"
    return Position(motion, in_frame, fit, [*fit.remarks, moved])


def at_best_fit(mated: Motion) -> Motion:
    """Return the motion of best fit without its lift, as walls are set to first touch later."""
    return mated._replace(place=np.append(mated.place[:2], mated.middle[2]))


def _rotation_remarks(mated: Motion, reach: np.ndarray, spacing: float, unusual: bool) -> list[str]:
    """Describe the best fit of walls in their scanned position, and warn of a rotation.

    A rotation lets the local shift of the walls grow from the middle up to ``reach`` (x, y) [m],
    half of the sides of the upper wall. Raise `InputError` if the shift is clear on walls of more
    than 80 cells of the ``spacing`` [m], unless ``unusual`` values are allowed.
    """
    remarks = [f"best fit with the upper wall {mated}"]
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
        remarks.append(caution(turned))
    return remarks

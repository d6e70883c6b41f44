"""Check of a registered pair, and the remarks on its registration."""

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.walls import plausibility
from jointclosure.walls.interpolation_remarks import interpolation_caution
from jointclosure.walls.joint_grid import JointGrid, overlap_in_position
from jointclosure.walls.pair_remarks import (
    best_fit_remarks,
    coarser_grid_caution,
    scale_caution,
    wall_remarks,
    width_remarks,
)
from jointclosure.walls.position_search import Position, at_best_fit
from jointclosure.walls.prepared_scans import PreparedScans, SampledScans, with_side
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.registration_options import RegistrationOptions
from jointclosure.walls.scan_errors import scale_of, scales_differ
from jointclosure.walls.scan_quality import quality_remarks


def checked_pair(
    pair: RegisteredPair,
    grid: JointGrid,
    position: Position,
    prepared: PreparedScans,
    sampled: SampledScans,
    options: RegistrationOptions,
) -> RegisteredPair:
    """Return a pair with the scale of its heights and the remarks of all steps that made it.

    Unless values may be unusual, raise `InputError` if heights contradict the units of x and y,
    least squares of heights do not confirm the fit (ignored for walls that stay as scanned), one
    wall is a copy of the other, or the walls are interchanged: in this order, as heights in a wrong
    unit may be why a fit is not confirmed.
    """
    units = plausibility.unit_doubts({"upper": pair.upper, "lower": pair.lower}, pair.spacing)
    if not options.unusual_values:
        plausibility.check_units(units)
        if options.shift != "scanned":
            check_confirmed(position)
        plausibility.check_pair(grid.overlap.gap, pair.correlation, position.in_frame)
    scale, scale_remarks = _clear_scale(pair)
    remarks = [
        *prepared.remarks,
        *sampled.remarks,
        *position.remarks,
        *width_remarks(pair),
        *_scan_remarks(grid, prepared),
        *wall_remarks(pair, grid.overlap, position.in_frame),
        *_apart_remarks(pair, prepared, sampled, options),
        *scale_remarks,
        *map(caution, units.contradictions + units.unlike_rock),
    ]
    return pair._replace(scale=scale, remarks=remarks)


def check_confirmed(position: Position) -> None:
    """Raise `InputError` if least squares of heights do not confirm the fit of slopes."""
    if not position.confirmed:
        raise InputError(
            f"the fit of the walls is ambiguous: slopes correlate by {position.fit.fits[0]}, but "
            "least squares of heights find no position there; walls that do not mate need "
            "shift: scanned"
        )


def _scan_remarks(grid: JointGrid, prepared: PreparedScans) -> list[str]:
    """Return remarks on what each scanned wall lost on the finest grid, and on a coarser grid.

    Cells in holes have filled heights and are ignored.
    """
    remarks = []
    for side, quality in prepared.qualities.items():
        lost = interpolation_caution(grid.slopes[side], grid.finest_spacing)
        limits = quality_remarks(quality, grid.finest.scanned(side), grid.finest_spacing)
        remarks += with_side(side, [*lost, *limits])
    if grid.step > 1:
        remarks.append(coarser_grid_caution(grid.finest_spacing, grid.step))
    return remarks


def _apart_remarks(
    pair: RegisteredPair,
    prepared: PreparedScans,
    sampled: SampledScans,
    options: RegistrationOptions,
) -> list[str]:
    """Return a warning if walls that stay as scanned fit clearly better at the best fit.

    None if the position is not stated, or if the walls have no best fit or do not overlap there.
    """
    mated = pair.mated
    if options.shift != "scanned" or mated is None or not np.isfinite(mated.covariance).all():
        return []
    share = options.largest_filled_share
    try:
        best, _ = overlap_in_position(at_best_fit(mated), prepared, sampled, share)
    except InputError:  # the walls do not overlap there
        return []
    return best_fit_remarks(pair, best)


def _clear_scale(pair: RegisteredPair) -> tuple[float, list[str]]:
    """Return the heights of the upper wall over the heights of the lower wall, with a remark.

    The scale is 1, without a remark, unless it clearly differs from 1.
    """
    finest = pair.finest
    scale, error = scale_of(finest.upper, finest.lower)
    if not scales_differ(scale, error):
        return 1.0, []
    return scale, [scale_caution(scale, error)]

"""Registration of the scans of the two walls of a joint (`registered`), see docs/two_scans.md."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_length
from jointclosure.parameters import check_usual
from jointclosure.walls.flat_walls import walls_not_flat
from jointclosure.walls.gridding import FLAT, Cloud, Scan
from jointclosure.walls.joint_grid import JointGrid, joint_grid
from jointclosure.walls.mating import Mating, Mismatch, mating, measured_mismatch
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.pair_checks import checked_pair
from jointclosure.walls.position_search import Position, found_position
from jointclosure.walls.prepared_scans import PreparedScans, prepared_scans, sampled_if_finer
from jointclosure.walls.registered_pair import FineWalls, RegisteredPair
from jointclosure.walls.registration_options import LARGEST_HOLES, RegistrationOptions


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
        Over a flat lower wall ``orientation`` has to be stated: an aperture map is an upper wall in
        a "common_frame", and heights of a scan from above count "towards" the lower wall.
    spacing : float, optional
        Grid spacing of the walls [m], by default the multiple of the larger point distance of both
        scans nearest to 0.25 mm, at least this distance itself. If a scan holds no waves of twice
        this spacing, the default is the smallest multiple of the spacing resolved by the scan, with
        at least 16 cells along the shorter side (`jointclosure.walls.joint_grid.LEAST_CELLS`).

        If the scattered points of one scan are on average up to 5 % farther apart than the points
        of a grid, the distance is taken from the grid. A grid whose points are at most half of the
        spacing apart is sampled: single heights are taken at the nodes of the coarser grid.
    orientation : str, optional
        Orientation of the upper scan, a key of `ORIENTATIONS`: by default the one with the best
        correlation of the walls' slopes over all rotations, if the best is clear.
    shift : {"scanned", "mated"}, optional
        Leave the walls in their scanned position, or move the upper one to the best fit, the
        default. Walls that do not mate stay as scanned; they need their orientation.
    spikes : {"keep", "cut"}
        Whether to leave out points that differ from all but one of their neighbours
        (`jointclosure.walls.spikes.remove_spikes`).
    largest_filled_share : float
        Largest share of cells in holes inside the walls for which these cells are taken out of
        contact: they receive the height of the other wall and the largest aperture of the cells
        around. If the share is larger, the walls are cut to the largest rectangle without holes.
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
        ``unusual_values``, also if the spacing or a side of a scan is unusual, both scans are the
        same or copies, a stated orientation fits clearly worse than another one, walls left in
        their "scanned" position are rotated against each other, slopes or units of the pair are
        unusual, least squares of heights find no position (not with ``shift`` "scanned"), or the
        walls are interchanged.
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
    scans: dict[str, Scan | Cloud] = {}
    for side, wall in walls_not_flat(upper, lower, orientation).items():
        if isinstance(wall, str):
            raise InputError(f"{side} = {wall!r}: must be a Scan, a Cloud or {FLAT!r}")
        scans[side] = wall
    return registered_by(options, scans, spacing)


def registered_by(
    options: RegistrationOptions,
    scans: Mapping[str, Scan | Cloud],
    spacing: float | None = None,
    most_cells: int | None = None,
) -> RegisteredPair:
    """Register two walls as `registered` does, with options and a spacing [m] that were checked.

    ``scans`` are the walls that are not flat (`walls_not_flat`), by the names of their sides. A
    joint of more than ``most_cells`` is refused, if a number is stated. Raise `InputError` as
    `registered`.
    """
    prepared = prepared_scans(scans, options, spacing)
    sampled = sampled_if_finer(prepared)
    position = found_position(prepared, sampled, options)
    grid = joint_grid(
        position.motion,
        prepared,
        sampled,
        options.largest_filled_share,
        resolved=spacing is None,
        most_cells=most_cells,
    )
    pair = _pair_on(grid, position, prepared)
    return checked_pair(pair, grid, position, prepared, sampled, options)


def _pair_on(grid: JointGrid, position: Position, prepared: PreparedScans) -> RegisteredPair:
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
    fine = None
    if grid.step > 1:
        fine = FineWalls(*grid.finest.parallel_walls, grid.finest.holes, grid.step)
    return RegisteredPair(
        upper=upper,
        lower=lower,
        spacing=grid.spacing,
        aperture=aperture,
        first_touch_cell=(y, x),
        orientation=position.fit.orientation,
        fits=position.fit.fits,
        motion=position.motion,
        mated=position.fit.mated,
        correlation=agreement.correlation,
        mating=agreement.mating,
        mismatch=agreement.mismatch,
        overlap_share=max(overlap.shares),
        holes=overlap.holes,
        first=overlap.first,
        remarks=[],
        fine=fine,
        waves=prepared.shortest_waves,
        rounding=prepared.rounding_of_sum,
        levelling=position.levelling,
        lost_square_slope=grid.lost_square_slope,
        scan_noise=tuple((side, *scan.noise) for side, scan in prepared.qualities.items()),
    )


_NO_AGREEMENT = _Agreement(0.0, Mating(*[np.empty(0)] * 3), Mismatch(*[np.inf] * 3))
"""Agreement with a flat wall, which has no waves."""


def _agreement_of(
    upper: np.ndarray, lower: np.ndarray, holes: np.ndarray, spacing: float
) -> _Agreement:
    """Return how far walls (y, x) [m], heights towards each other, fit each other.

    Correlations by wavelength leave out ``holes`` (y, x), as their heights are of the other wall.
    """
    correlation = float(np.corrcoef(upper.ravel(), -lower.ravel())[0, 1])
    one, other = (
        fill_missing(np.where(holes, np.nan, wall), "linear", 1.0) for wall in (upper, lower)
    )
    mismatch = measured_mismatch(one, other, spacing)
    return _Agreement(correlation, mating(one, other, spacing), mismatch)

"""Grid of a joint: both walls laid on it in their position, and its spacing and size."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.gridding import LARGEST_TILT, Cloud, Scan, point_distance, points_of
from jointclosure.walls.interpolation_remarks import Slopes, slopes_by_interpolation
from jointclosure.walls.levelling import slopes_of
from jointclosure.walls.motion import NO_MOTION, Motion, moved_heights
from jointclosure.walls.overlap import HeightsAt, Overlap, overlap_of
from jointclosure.walls.prepared_scans import PreparedScan, PreparedScans, SampledScans

LEAST_CELLS = 16  # along the shorter side of walls on a grid that the scan resolves
LARGEST = 1000 * 1000  # most cells of a joint without a stated grid spacing
SUGGESTED = 200  # cells along the longer side for which a coarser spacing is suggested


class JointGrid(NamedTuple):
    """Both walls where they overlap: on the grid of the joint, and on the finest grid of scans."""

    overlap: Overlap  # at the nodes of the joint
    spacing: float  # [m] of the nodes of the joint
    finest: Overlap  # at all nodes; the joint has one node in `step` along each axis
    finest_spacing: float  # [m] of all nodes
    step: int  # 1 if the joint has all nodes
    slopes: dict[str, Slopes | None]
    """Rms slopes of each scanned wall at all nodes and between its scanned points, by its side;
    None for a wall that was not interpolated."""

    @property
    def lost_square_slope(self) -> float:
        """Mean square slope [1] that interpolation took from both walls together."""
        return sum(slopes.lost_square for slopes in self.slopes.values() if slopes)


class _InterpolatedGrid(NamedTuple):
    """A scanned grid that is interpolated at nodes of a joint which do not lie on its points."""

    at: HeightsAt
    points: np.ndarray  # (n, 3) [m] of the scan about its mean plane, for their slopes


def joint_grid(
    motion: Motion,
    prepared: PreparedScans,
    sampled: SampledScans,
    largest_filled_share: float,
    resolved: bool,
    most_cells: int | None = None,
) -> JointGrid:
    """Lay the upper wall, moved, and the lower wall on the grid of their joint.

    Parameters
    ----------
    motion : Motion
        From where the upper wall was scanned to its position on the lower one.
    prepared, sampled : PreparedScans, SampledScans
        The upper wall has heights of its scanned points, the lower one of the sampled points.
    largest_filled_share : float
        Largest share of cells in holes, beyond which walls are cut (`registered`).
    resolved : bool
        Whether the joint has a coarser grid than its walls, if the scans resolve only this.
    most_cells : int, optional
        Largest number of cells, by default any.

    Raises
    ------
    InputError
        If the walls overlap in too few cells, are too inclined, or the grid has too many cells.
    """
    spacing = prepared.spacing
    finest, points = overlap_in_position(motion, prepared, sampled, largest_filled_share)
    slopes = {
        side: slopes_by_interpolation(points[side], finest.scanned(side), spacing, *finest.box)
        for side in prepared.qualities
    }
    step = 1
    if resolved:
        waves = [quality.shortest_wave for quality in prepared.qualities.values()]
        step = _resolved_step(max(waves), spacing, finest.upper.shape)
    overlap = finest if step == 1 else finest.every_node(step)
    grid = JointGrid(
        overlap, spacing if step == 1 else step * spacing, finest, spacing, step, slopes
    )
    if most_cells is not None:
        check_cells(overlap.upper.shape, grid.spacing, most_cells)
    return grid


def overlap_in_position(
    motion: Motion, prepared: PreparedScans, sampled: SampledScans, largest_filled_share: float
) -> tuple[Overlap, dict[str, np.ndarray]]:
    """Return the upper wall, moved, and the lower wall on the finest grid of their scans.

    The second value are the scanned points (n, 3) [m] of each wall by its side, from which slopes
    are taken. Arguments and errors are as for `joint_grid`.
    """
    upper = prepared.upper.scan
    upper_at = None
    if isinstance(upper, Scan):
        plane = slopes_of(upper) if motion.tilt > LARGEST_TILT else (0.0, 0.0)
        upper_at = moved_heights(upper, motion, plane)
    lower = _interpolated_lower(prepared.lower, sampled.lower, prepared.spacing)
    moved = _moved_points(points_of(upper, missing=True), motion)
    overlap = overlap_of(
        [moved, sampled.lower_points],
        prepared.spacing,
        [point_distance(scan) for scan in (upper, sampled.lower)],
        largest_filled_share,
        (upper_at, lower.at if lower else None),
    )
    if prepared.flat_side:
        overlap = overlap.with_flat_wall(prepared.flat_side)
    return overlap, {"upper": moved, "lower": lower.points if lower else sampled.lower_points}


def _interpolated_lower(
    prepared: PreparedScan, sampled: Scan | Cloud, spacing: float
) -> _InterpolatedGrid | None:
    """Return the lower scan as a grid to be interpolated by cubic splines at nodes of a joint.

    None if the scan is no grid, or if nodes of this ``spacing`` [m] lie on points of the
    ``sampled`` scan. A steep scan, which was turned until it lies level, is interpolated as it was
    read, so that its heights are not interpolated twice.
    """
    if not isinstance(sampled, Scan):
        return None
    cells = spacing / np.array(sampled.spacing)
    if np.allclose(cells, np.rint(cells), rtol=1e-6):
        return None
    as_read = prepared.as_read
    levelling = prepared.levelling
    if levelling is None or not isinstance(as_read, Scan):
        return _InterpolatedGrid(moved_heights(sampled, NO_MOTION), points_of(sampled))
    plane = slopes_of(as_read)
    # a level scan has its heights from the middle of its plane on
    motion = levelling._replace(place=levelling.place * [1.0, 1.0, 0.0])
    points = points_of(as_read)
    x, y, heights = (points - levelling.middle).T
    # less an inclined plane, slopes along the dip are 1 / cos^2 and those across it 1 / cos as
    # large as normal to it; moved points would lie at distances that depend on their slope
    cosine = 1.0 / np.sqrt(1.0 + plane[0] ** 2 + plane[1] ** 2)
    points[:, 2] = (heights - plane[0] * x - plane[1] * y) * cosine**1.5
    return _InterpolatedGrid(moved_heights(as_read, motion, plane), points)


def _moved_points(points: np.ndarray, motion: Motion) -> np.ndarray:
    """Move points (n, 3) [m]; points without a height move as if they had the mean height."""
    missing = np.isnan(points[:, 2])
    filled = np.where(missing, np.nanmean(points[:, 2]), points[:, 2])
    moved = motion.moved(np.column_stack([points[:, :2], filled]))
    moved[missing, 2] = np.nan
    return moved


def _resolved_step(wave: float, spacing: float, shape: tuple[int, ...]) -> int:
    """Return the nodes from one to the next on a grid that resolves waves of a length [m].

    A grid resolves waves of two cells or more. At least `LEAST_CELLS` nodes remain along the
    shorter side of a grid of ``shape`` (y, x) and ``spacing`` [m].
    """
    step = int(np.ceil(wave / (2.0 * spacing) - 1e-6))
    return max(min(step, min(shape) // LEAST_CELLS), 1)


def check_cells(shape: tuple[int, ...], spacing: float, most: int) -> None:
    """Raise `InputError` if a grid of ``shape`` (y, x) and ``spacing`` [m] has too many cells."""
    ny, nx = shape
    if ny * nx > most:
        raise InputError(
            f"{grid_text((ny, nx), spacing)}: must be at most {most:,} cells unless the grid "
            f"spacing is stated; {coarser_grid((ny, nx), spacing)}"
        )


def coarser_grid(shape: tuple[int, int], spacing: float) -> str:
    """Suggest a multiple of the spacing [m] at which a joint has about `SUGGESTED` cells a side."""
    step = max(int(np.ceil(max(shape) / SUGGESTED)), 2)
    return (
        f"a grid spacing of {1e3 * step * spacing:.4g} mm (--spacing, or spacing= in m) takes "
        "less, but a cell is an asperity: its effect is in the range with other choices"
    )

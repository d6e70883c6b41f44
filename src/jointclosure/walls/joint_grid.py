"""Grid of a joint: both walls laid on it in their position, and its spacing and size."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.gridding import LARGEST_TILT, Scan, point_distance, points_of
from jointclosure.walls.levelling import slopes_of
from jointclosure.walls.motion import Motion, moved_heights
from jointclosure.walls.overlap import Overlap, overlap_of
from jointclosure.walls.prepared_scans import PreparedScans, SampledScans

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
    points: dict[str, np.ndarray]
    """Scanned points (n, 3) [m] of each wall by its side, in the position of the walls; heights are
    NaN where missing."""


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
    upper = prepared.upper.scan
    upper_at = None
    if isinstance(upper, Scan):
        slopes = slopes_of(upper) if motion.tilt > LARGEST_TILT else (0.0, 0.0)
        upper_at = moved_heights(upper, motion, slopes)
    points = {
        "upper": _moved_points(points_of(upper, missing=True), motion),
        "lower": sampled.lower_points,
    }
    distances = [point_distance(scan) for scan in (upper, sampled.lower)]
    finest = overlap_of([*points.values()], spacing, distances, largest_filled_share, upper_at)
    if prepared.flat_side:
        finest = finest.with_flat_wall(prepared.flat_side)
    step = 1
    if resolved:
        waves = [quality.shortest_wave for quality in prepared.qualities.values()]
        step = _resolved_step(max(waves), spacing, finest.upper.shape)
    overlap = finest if step == 1 else finest.every_node(step)
    grid = JointGrid(
        overlap, spacing if step == 1 else step * spacing, finest, spacing, step, points
    )
    if most_cells is not None:
        check_cells(overlap.upper.shape, grid.spacing, most_cells)
    return grid


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

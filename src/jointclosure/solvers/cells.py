"""Cells of the grid: their neighbours, curvatures, peaks and contacts.

Walls are arrays (y, x) of heights towards the other wall. For curvature a neighbour outside the
grid is the mirror image of the one inside; for gouge and peaks it does not exist.
"""

import math

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import asperity_compliance
from jointclosure.mechanics.curvature import gaussian_curvature


@kernel
def neighbourhood(heights, y, x, out):
    """Set ``out`` (8,) [m] to the heights of a cell's neighbours, infinite outside the grid."""
    ny, nx = heights.shape
    if 0 < y < ny - 1 and 0 < x < nx - 1:
        for i in range(3):
            out[i] = heights[y - 1, x - 1 + i]
            out[5 + i] = heights[y + 1, x - 1 + i]
        out[3] = heights[y, x - 1]
        out[4] = heights[y, x + 1]
        return
    k = 0
    for dy in range(-1, 2):
        for dx in range(-1, 2):
            if dy != 0 or dx != 0:
                inside = 0 <= y + dy < ny and 0 <= x + dx < nx
                out[k] = heights[y + dy, x + dx] if inside else math.inf
                k += 1


@kernel
def wall_curvature(here, west, east, south, north, least_curvature, concave, spacing):
    """Compute the Gaussian curvature 1/R [1/m] of a wall's cell from its neighbours' heights [m].

    An infinite height stands for a neighbour outside the grid, and is replaced by the opposite
    neighbour's height. The curvature is at least ``least_curvature`` [1/m], and equal to it if the
    grid has a single cell along y or x. ``concave`` and ``spacing`` [m] are as in
    `gaussian_curvature`.
    """
    left = east if west == math.inf else west
    right = west if east == math.inf else east
    below = north if south == math.inf else south
    above = south if north == math.inf else north
    curvature = gaussian_curvature(left, right, below, above, here, concave, spacing)
    # with a single cell in a direction the curvature is NaN, and the profile counts as straight
    return curvature if curvature > least_curvature else least_curvature


@kernel
def curvature_among(here, neighbours, law):
    """Compute the `wall_curvature` [1/m] of a cell from its height and `neighbourhood` (8,) [m]."""
    south = neighbours[1]
    west = neighbours[3]
    east = neighbours[4]
    north = neighbours[6]
    return wall_curvature(
        here, west, east, south, north, law.least_curvature, law.concave, law.spacing
    )


@kernel
def row_of(cell, inverse):
    """Return the row of a cell, given by flat index, in a grid with rows of 1 / ``inverse`` cells.

    It is computed in floating point, since the division of integers is slow. The half that is added
    to the index is much more than the rounding.
    """
    return int((cell + 0.5) * inverse)


@kernel
def profiles(heights, cells, out):
    """Set the rows of ``out`` (5, n) to heights of cells (n,) and of their edge neighbours [m].

    The rows are the cells and their neighbours west, east, south and north, which are infinite
    outside the grid of ``heights`` (y, x) [m]. Cells are given by flat index.
    """
    ny, nx = heights.shape
    flat = heights.ravel()
    inverse = 1.0 / nx
    for i in range(cells.size):
        cell = cells[i]
        y = row_of(cell, inverse)
        x = cell - y * nx
        out[0, i] = flat[cell]
        out[1, i] = flat[cell - 1] if x > 0 else math.inf
        out[2, i] = flat[cell + 1] if x < nx - 1 else math.inf
        out[3, i] = flat[cell - nx] if y > 0 else math.inf
        out[4, i] = flat[cell + nx] if y < ny - 1 else math.inf


@kernel
def curvatures_at(heights, cells, law):
    """Compute the `wall_curvature` [1/m] at cells (n,), given by flat index, of a wall (y, x)."""
    n = cells.size
    curvature = np.empty(n)
    profile = np.empty((5, n))
    profiles(heights, cells, profile)
    # apart from the copying, so that it becomes vector code
    for i in range(n):
        curvature[i] = wall_curvature(
            profile[0, i],
            profile[1, i],
            profile[2, i],
            profile[3, i],
            profile[4, i],
            law.least_curvature,
            law.concave,
            law.spacing,
        )
    return curvature


@kernel
def is_peak(height, neighbours):
    """Return whether a cell is strictly higher than all its neighbours (8,) in the grid.

    Infinite neighbours are outside the grid, and left out. A cell without neighbours is no peak.
    """
    count = 0
    for k in range(8):
        if neighbours[k] != math.inf:
            count += 1
            if neighbours[k] >= height:
                return False
    return count > 0


@kernel
def peak_map(upper, lower):
    """Return the states (y, x) of pairs of cells: 2 x (upper is a peak) + (lower is a peak)."""
    ny, nx = upper.shape
    state = np.empty((ny, nx), np.int64)
    around = np.empty(8)
    for y in range(ny):
        for x in range(nx):
            neighbourhood(upper, y, x, around)
            state[y, x] = 2 * is_peak(upper[y, x], around)
            neighbourhood(lower, y, x, around)
            state[y, x] += is_peak(lower[y, x], around)
    return state


@kernel
def overlapping_cells(upper, lower, offset, peaks, law):
    """Find the cells at which two walls overlap without interaction, with their contacts.

    ``upper`` and ``lower`` are heights (y, x) [m]. ``offset`` [m], the closure from first touch, is
    added to their sum. ``peaks`` (y, x) are the states of the pairs of cells (`ContactLaw`). Return
    flat indices, overlaps [m], summed curvatures of both walls [1/m] and compliances B [m
    N^(-2/3)], all (n,).
    """
    ny, nx = upper.shape
    cells = np.empty(ny * nx, np.int64)
    gaps = np.empty(ny * nx)
    count = 0
    for y in range(ny):
        for x in range(nx):
            gap = upper[y, x] + lower[y, x] + offset
            # without a branch, because it would be unpredictable
            cells[count] = y * nx + x
            gaps[count] = gap
            count += gap > 0.0
    cells = cells[:count].copy()
    overlap = gaps[:count].copy()
    curvature = curvatures_at(upper, cells, law) + curvatures_at(lower, cells, law)
    compliance = np.empty(count)
    states = peaks.ravel()
    for i in range(count):
        compliance[i] = law.asperity_modulus[states[cells[i]]]
    for i in range(count):
        compliance[i] = asperity_compliance(curvature[i], compliance[i])
    return cells, overlap, curvature, compliance

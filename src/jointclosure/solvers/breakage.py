"""Breakage to rest at fixed closure and fixed interaction.

An overstressed pair is lowered in steps until it holds, has lost contact or
is confined, its gouge laid on its neighbours; what a change touches is looked
at again, first come first served. The order of breakage is not prescribed by
the model: docs/decisions/0006-order-of-breakage.md measures what it is worth.
"""

import math
from functools import lru_cache

import numpy as np

from jointclosure.compilation import kernel
from jointclosure.mechanics.gouge import drops, spread, upper_share
from jointclosure.mechanics.strength import is_overstressed
from jointclosure.solvers.cells import is_peak, wall_curvature


_MARGIN = 2
"""Cells around the grid, infinitely high and never in contact: no edge to watch for."""


@kernel
def padded(field, outside):
    """A field (y, x) with a margin around it, as one flat array."""
    ny, nx = field.shape
    stride = nx + 2 * _MARGIN
    flat = np.full((ny + 2 * _MARGIN) * stride, outside)
    for y in range(ny):
        start = (y + _MARGIN) * stride + _MARGIN
        for x in range(nx):
            flat[start + x] = field[y, x]
    return flat


@kernel
def unpad(flat, field):
    """Copy a flat array with its margin back into a field (y, x)."""
    ny, nx = field.shape
    stride = nx + 2 * _MARGIN
    for y in range(ny):
        start = (y + _MARGIN) * stride + _MARGIN
        for x in range(nx):
            field[y, x] = flat[start + x]


@kernel
def take_around(heights, cell, stride, out):
    """Heights of the eight neighbours, in the order of `jointclosure.mechanics.gouge`."""
    for i in range(3):
        out[i] = heights[cell - stride - 1 + i]
        out[5 + i] = heights[cell + stride - 1 + i]
    out[3] = heights[cell - 1]
    out[4] = heights[cell + 1]


@kernel
def put_around(heights, cell, stride, values):
    """Inverse of `take_around`."""
    for i in range(3):
        heights[cell - stride - 1 + i] = values[i]
        heights[cell + stride - 1 + i] = values[5 + i]
    heights[cell - 1] = values[3]
    heights[cell + 1] = values[4]


@kernel
def touched_cells(stride):
    """Offsets of the cells whose state a breakage step can change, (20,).

    Heights change up to one cell away, curvatures up to two along the axes.
    """
    offsets = np.empty(20, np.int64)
    k = 0
    for dy in range(-2, 3):
        for dx in range(-2, 3):
            if (dy != 0 or dx != 0) and abs(dy) + abs(dx) < 4:
                offsets[k] = dy * stride + dx
                k += 1
    return offsets


@kernel
def shed_gouge(
    height_upper,
    height_lower,
    around_upper,
    around_lower,
    falls_upper,
    falls_lower,
    breakage_step,
    share,
    tie_tolerance,
):
    """One breakage step of a pair, its gouge laid on the lower neighbours.

    Parameters
    ----------
    height_upper, height_lower : float
        Heights of the cell on both walls [m].
    around_upper, around_lower : array (8,)
        Their neighbours, lifted in place [m].
    falls_upper, falls_lower : array (8,)
        Scratch.
    breakage_step, share : float
        Height to take off the pair [m]; the upper wall's share in it.
    tie_tolerance : float
        See `jointclosure.mechanics.gouge.drops` [m].

    Returns
    -------
    loss_upper, loss_lower : float
        What the walls lost [m]; both 0 for a confined pair. A wall without a
        lower neighbour passes its share to the other, and each share is cut
        so that it lifts no neighbour above the lowered cell.
    """
    total_upper, most_upper = drops(height_upper, around_upper, tie_tolerance, falls_upper)
    total_lower, most_lower = drops(height_lower, around_lower, tie_tolerance, falls_lower)
    if total_upper == 0.0:
        share = 0.0
    elif total_lower == 0.0:
        share = 1.0
    loss_upper = min(breakage_step * share, most_upper)
    loss_lower = min(breakage_step * (1.0 - share), most_lower)
    if loss_upper > 0.0:
        spread(around_upper, loss_upper, falls_upper, total_upper)
    if loss_lower > 0.0:
        spread(around_lower, loss_lower, falls_lower, total_lower)
    return loss_upper, loss_lower


@lru_cache(maxsize=None)
def breakage_kernel(gouge: bool, current_peaks: bool):
    """Kernel that breaks all pairs to rest at a fixed interaction.

    The kernel's signature is ``(upper, lower, offset, interaction, peaks, law,
    breakage_step, tie_tolerance, most_steps) -> (steps, confined)``: walls
    (y, x) [m] changed in place, the offset as in `overlapping_cells` [m], the
    interaction (y, x) [m]; the number of breakage steps taken (``most_steps``
    where it did not come to rest) and a map (y, x) of confined pairs. An
    effect that is off is not compiled. One long function, because a cached
    Numba closure may hold plain booleans only, not other compiled functions.
    """

    @kernel
    def break_to_rest(
        upper, lower, offset, interaction, peaks, law, breakage_step, tie_tolerance, most_steps
    ):
        ny, nx = upper.shape
        cells = ny * nx
        stride = nx + 2 * _MARGIN
        top, bottom = padded(upper, math.inf), padded(lower, math.inf)
        lift = padded(offset - interaction, -math.inf)
        state = padded(peaks, 0)
        waiting = padded(np.zeros((ny, nx), np.bool_), True)
        confined = padded(np.zeros((ny, nx), np.bool_), False)
        touched = touched_cells(stride)
        around_top, around_bottom = np.empty(8), np.empty(8)
        falls_top, falls_bottom = np.empty(8), np.empty(8)
        queue = np.empty(cells, np.int64)
        head = 0
        length = 0
        for cell in range(top.size):
            if top[cell] + bottom[cell] + lift[cell] > 0.0:
                queue[length] = cell
                waiting[cell] = True
                length += 1
        steps = 0
        while length > 0 and steps < most_steps:
            cell = queue[head]
            head = head + 1 if head + 1 < cells else 0
            length -= 1
            waiting[cell] = False
            confined[cell] = False
            high, low = top[cell], bottom[cell]
            take_around(top, cell, stride, around_top)
            take_around(bottom, cell, stride, around_bottom)
            raised = lift[cell]
            kind = state[cell]
            bend, breaking_force = law.bend[kind], law.breaking_force[kind]
            taken = 0
            while steps < most_steps:
                overlap = high + low + raised
                if not overlap > 0.0:
                    break
                if current_peaks:
                    kind = 2 * is_peak(high, around_top) + is_peak(low, around_bottom)
                    bend, breaking_force = law.bend[kind], law.breaking_force[kind]
                bend_top = wall_curvature(high, around_top, law.least_curvature, law.spacing)
                bend_bottom = wall_curvature(low, around_bottom, law.least_curvature, law.spacing)
                if not is_overstressed(
                    overlap,
                    bend_top + bend_bottom,
                    bend,
                    breaking_force,
                    law.substrate,
                ):
                    break
                share = upper_share(bend_top, bend_bottom)
                if gouge:
                    loss_top, loss_bottom = shed_gouge(
                        high,
                        low,
                        around_top,
                        around_bottom,
                        falls_top,
                        falls_bottom,
                        breakage_step,
                        share,
                        tie_tolerance,
                    )
                    if loss_top + loss_bottom == 0.0:
                        confined[cell] = True
                        break
                    high -= loss_top
                    low -= loss_bottom
                else:
                    high -= breakage_step * share
                    low -= breakage_step * (1.0 - share)
                steps += 1
                taken += 1
            if taken == 0:
                continue
            top[cell], bottom[cell] = high, low
            put_around(top, cell, stride, around_top)
            put_around(bottom, cell, stride, around_bottom)
            for k in range(touched.size):
                near = cell + touched[k]
                if not waiting[near] and top[near] + bottom[near] + lift[near] > 0.0:
                    tail = head + length
                    queue[tail if tail < cells else tail - cells] = near
                    waiting[near] = True
                    length += 1
        unpad(top, upper)
        unpad(bottom, lower)
        held = np.empty((ny, nx), np.bool_)
        unpad(confined, held)
        return steps, held

    return break_to_rest

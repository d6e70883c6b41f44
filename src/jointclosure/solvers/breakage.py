"""Breakage to rest at fixed closure and fixed interaction.

An overstressed pair is lowered in steps until it holds, has lost contact or
is confined, its gouge laid on its neighbours. Contacts are looked at from the
deepest to the shallowest, then the neighbours of what broke, first come first
served, and when none is left all contacts again, until nothing breaks. The
order of breakage is not prescribed by the model:
docs/decisions/0006-order-of-breakage.md measures what it is worth.
"""

import math
from functools import lru_cache

import numpy as np

from jointclosure.compilation import kernel
from jointclosure.mechanics.gouge import drops, passed_share, shed, upper_share
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
def neighbour_offsets(stride):
    """Offsets of the eight neighbours of a cell in a flat array, (8,)."""
    return np.array([-stride - 1, -stride, -stride + 1, -1, 1, stride - 1, stride, stride + 1])


@kernel
def curvature_bound(heights, cell, stride, least_curvature, spacing):
    """Upper bound of a cell's `wall_curvature` [1/m], for a third of its cost.

    The sides of the triangles are at least as long as the spacing. NaN or
    infinite at the edge of the grid, where it bounds nothing.
    """
    here = heights[cell]
    bend = abs((heights[cell - 1] - here) + (heights[cell + 1] - here)) * abs(
        (heights[cell - stride] - here) + (heights[cell + stride] - here)
    )
    return max(math.sqrt(bend) / (spacing * spacing), least_curvature)


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
        waiting = padded(np.zeros((ny, nx), np.int64), 1)
        confined = padded(np.zeros((ny, nx), np.bool_), False)
        beside = neighbour_offsets(stride)
        around_top, around_bottom = np.empty(8), np.empty(8)
        falls_top, falls_bottom = np.empty(8), np.empty(8)
        mask = 1  # of a ring longer than there are cells, its length a power of two
        while mask <= cells:
            mask = 2 * mask + 1
        queue = np.empty(mask + 1, np.int64)
        head = 0
        length = 0
        found = np.empty(cells, np.int64)
        depth = np.empty(cells)
        steps = 0
        seen = -1  # steps when all cells were last looked at
        while steps < most_steps:
            if length == 0:
                # what broke changes curvatures up to two cells away: look at all
                # contacts again, the deepest first
                if seen == steps:
                    break
                seen = steps
                count = 0
                for cell in range(top.size):
                    if top[cell] + bottom[cell] + lift[cell] > 0.0:
                        found[count] = cell
                        depth[count] = -(top[cell] + bottom[cell] + lift[cell])
                        count += 1
                order = np.argsort(depth[:count], kind="mergesort")
                for k in range(count):
                    queue[(head + length) & mask] = found[order[k]]
                    waiting[found[order[k]]] = 1
                    length += 1
                continue
            cell = queue[head]
            head = (head + 1) & mask
            length -= 1
            waiting[cell] = 0
            confined[cell] = False
            high, low, raised = top[cell], bottom[cell], lift[cell]
            if not high + low + raised > 0.0:
                continue
            kind = state[cell]
            bend, breaking_force = law.bend[kind], law.breaking_force[kind]
            if not current_peaks:
                # most of what is looked at again still holds, and is soon found to
                most = curvature_bound(top, cell, stride, law.least_curvature, law.spacing)
                most += curvature_bound(bottom, cell, stride, law.least_curvature, law.spacing)
                if most < math.inf and not is_overstressed(
                    high + low + raised, most, bend, breaking_force, law.substrate
                ):
                    continue
            take_around(top, cell, stride, around_top)
            take_around(bottom, cell, stride, around_bottom)
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
                    total_top, least_top = drops(high, around_top, tie_tolerance, falls_top)
                    total_bottom, least_bottom = drops(
                        low, around_bottom, tie_tolerance, falls_bottom
                    )
                    if total_top == 0.0 and total_bottom == 0.0:
                        confined[cell] = True
                        break
                    share = passed_share(share, total_top, total_bottom)
                loss_top = breakage_step * share
                loss_bottom = breakage_step * (1.0 - share)
                if gouge and loss_top > 0.0:
                    loss_top = shed(around_top, loss_top, falls_top, total_top, least_top)
                if gouge and loss_bottom > 0.0:
                    loss_bottom = shed(
                        around_bottom, loss_bottom, falls_bottom, total_bottom, least_bottom
                    )
                high -= loss_top
                low -= loss_bottom
                steps += 1
                taken += 1
            if taken == 0:
                continue
            top[cell], bottom[cell] = high, low
            for k in range(8):
                near = cell + beside[k]
                top[near] = around_top[k]
                bottom[near] = around_bottom[k]
                # without a branch, which could not be predicted
                new = (1 - waiting[near]) & (top[near] + bottom[near] + lift[near] > 0.0)
                queue[(head + length) & mask] = near
                waiting[near] |= new
                length += new
        unpad(top, upper)
        unpad(bottom, lower)
        held = np.empty((ny, nx), np.bool_)
        unpad(confined, held)
        return steps, held

    return break_to_rest

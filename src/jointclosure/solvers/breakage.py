"""Breakage to rest at fixed closure and fixed interaction.

An overstressed pair is lowered until it holds, has lost contact or is
confined, its gouge laid on its neighbours. Pairs are coloured so that the
neighbourhoods of one colour do not overlap; the colours take turns, each with
all its pairs that wait, many at a time (`jointclosure.solvers.pair_batch`).
What breaks makes its neighbours wait, and when none waits all contacts are
looked at again, until nothing breaks. The order of breakage is not prescribed
by the model: docs/decisions/0006-order-of-breakage.md measures what it is worth.
"""

import math
from functools import lru_cache

import numpy as np

from jointclosure.compilation import kernel
from jointclosure.mechanics.contact import force_of_overlap
from jointclosure.mechanics.gouge import drops
from jointclosure.solvers.cells import is_peak, neighbourhood
from jointclosure.solvers.pair_batch import (
    ACTIVE,
    BATCH,
    BEND,
    CENTRE,
    CONFINED,
    LOWER,
    STRENGTH,
    TAKEN,
    UPPER,
    gather,
    measure,
    measure_falls,
    new_batch,
    returning_losses,
    scale_losses,
    scatter,
    share_losses,
    shed_losses,
)

_MARGIN = 2
"""Cells around the grid, infinitely high and never in contact: no edge to watch for."""
_COLOURS = 9
"""Every third cell in each direction: their neighbours are not shared."""
_MOST_PASSES = 4
"""Steps in a row of one pair, before it waits for its next turn."""


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
def neighbour_offsets(stride):
    """Offsets of the eight neighbours of a cell in a flat array, (8,)."""
    return np.array([-stride - 1, -stride, -stride + 1, -1, 1, stride - 1, stride, stride + 1])


@kernel
def strength_limits(upper, lower, cells, curvature, compliance, peaks, law, gouge, tie, band):
    """Forces (n,) [N] that the contacts at the cells can carry; see `breakage_kernel`.

    Infinite where a pair cannot break: flat, or confined on both walls.
    """
    nx = upper.shape[1]
    around, falls = np.empty(8), np.empty(8)
    limit = np.full(cells.size, np.inf)
    for i in range(cells.size):
        y, x = divmod(cells[i], nx)
        free = not gouge
        if gouge:
            neighbourhood(upper, y, x, around)
            free = drops(upper[y, x], around, tie, falls)[0] > 0.0
            neighbourhood(lower, y, x, around)
            free = free or drops(lower[y, x], around, tie, falls)[0] > 0.0
        if free and curvature[i] > 0.0:
            kind = peaks[y, x]
            square = curvature[i] * curvature[i]
            strength = law.bend[kind] / curvature[i]
            if law.substrate > 0.0:  # 0 times an infinite force is not a number
                strength += law.substrate * law.breaking_force[kind] / square
            limit[i] = force_of_overlap(
                (1.0 + 0.5 * band) * strength, law.substrate, compliance[i]
            )[0]
    return limit


@kernel
def colour_map(ny, nx):
    """Colours (y, x): cells of one colour are three apart both ways."""
    colours = np.empty((ny, nx), np.int64)
    for y in range(ny):
        for x in range(nx):
            colours[y, x] = 3 * (y % 3) + x % 3
    return colours


@kernel
def set_laws(batch, n, cells, state, law):
    """Strength of the pairs, by whether their cells are soft peaks."""
    for i in range(n):
        kind = state[cells[i]]
        batch[BEND * BATCH + i] = law.bend[kind]
        batch[STRENGTH * BATCH + i] = law.substrate * law.breaking_force[kind]


@kernel
def set_current_laws(batch, n, cells, state, law):
    """The same, where peaks are those of the walls as they are."""
    around = np.empty(8)
    for i in range(n):
        kind = 0
        for wall in (UPPER, LOWER):
            for k in range(8):
                around[k] = batch[(wall + k + (k >= CENTRE)) * BATCH + i]
            kind = 2 * kind + is_peak(batch[(wall + CENTRE) * BATCH + i], around)
        state[cells[i]] = kind
    set_laws(batch, n, cells, state, law)


@lru_cache(maxsize=None)
def breakage_kernel(gouge: bool, current_peaks: bool, resolved: bool):
    """Kernel that breaks all pairs to rest at a fixed interaction.

    The kernel's signature is ``(upper, lower, offset, interaction, peaks, law,
    breakage_step, band, tie_tolerance, most_steps) -> (steps, confined)``:
    walls (y, x) [m] changed in place, the offset as in `overlapping_cells` [m],
    the interaction (y, x) [m]; the number of breakage steps taken
    (``most_steps`` or more where it did not come to rest) and a map (y, x) of
    confined pairs. A pair loses ``breakage_step`` [m] at a time; ``resolved``,
    what brings it back to its strength, which it may then exceed by half the
    ``band`` before it breaks again. An effect that is off is not compiled.
    """

    @kernel
    def break_to_rest(
        upper,
        lower,
        offset,
        interaction,
        peaks,
        law,
        breakage_step,
        band,
        tie_tolerance,
        most_steps,
    ):
        ny, nx = upper.shape
        stride = nx + 2 * _MARGIN
        top, bottom = padded(upper, math.inf), padded(lower, math.inf)
        lift = padded(offset - interaction, -math.inf)
        state = padded(peaks, 0)
        waiting = padded(np.zeros((ny, nx), np.int64), 1)
        colours = padded(colour_map(ny, nx), 0)
        confined = padded(np.zeros((ny, nx), np.bool_), False)
        beside = neighbour_offsets(stride)
        spacing = law.spacing
        least_curvature, concave = law.least_curvature, law.concave
        allowed = 1.0 + 0.5 * band if resolved else 1.0
        batch = new_batch()
        lists = np.empty((_COLOURS, ny * nx + 1), np.int64)
        counts = np.zeros(_COLOURS, np.int64)
        taken = np.empty(ny * nx, np.int64)
        some = np.empty(BATCH + 1, np.int64)
        steps = 0
        seen = -1  # steps when all cells were last looked at
        colour = 0
        while steps < most_steps:
            if counts.sum() == 0:
                # what broke changes curvatures up to two cells away: look at all again
                if seen == steps:
                    break
                seen = steps
                for cell in range(top.size):
                    if top[cell] + bottom[cell] + lift[cell] > 0.0:
                        own = colours[cell]
                        lists[own, counts[own]] = cell
                        counts[own] += 1
                        waiting[cell] = 1
            colour = (colour + 1) % _COLOURS
            number = counts[colour]
            counts[colour] = 0
            taken[:number] = lists[colour, :number]
            for first in range(0, number, BATCH):
                cells = taken[first : min(first + BATCH, number)]
                n = cells.size
                # most that are looked at again still hold
                gather(batch, n, cells, top, bottom, lift, stride, current_peaks)
                if current_peaks:
                    set_current_laws(batch, n, cells, state, law)
                else:
                    set_laws(batch, n, cells, state, law)
                measure(batch, n, least_curvature, concave, spacing, allowed)
                m = 0
                for i in range(n):
                    waiting[cells[i]] = 0
                    confined[cells[i]] = False
                    some[m] = cells[i]
                    m += int(batch[ACTIVE * BATCH + i])
                if m == 0:
                    continue
                gather(batch, m, some, top, bottom, lift, stride, True)
                set_laws(batch, m, some, state, law)
                for i in range(m):
                    batch[TAKEN * BATCH + i] = 0.0
                going = m
                for turn in range(_MOST_PASSES):
                    if current_peaks and turn > 0:
                        set_current_laws(batch, m, some, state, law)
                    measure(batch, m, least_curvature, concave, spacing, allowed)
                    if gouge:
                        measure_falls(batch, m, UPPER, 0, tie_tolerance)
                        measure_falls(batch, m, LOWER, 1, tie_tolerance)
                    share_losses(batch, m, gouge)
                    going = 0
                    for i in range(m):
                        going += int(batch[ACTIVE * BATCH + i])
                        if gouge:
                            confined[some[i]] |= batch[CONFINED * BATCH + i] > 0.0
                    if going == 0:
                        break
                    steps += going
                    if resolved:
                        returning_losses(
                            batch, m, band, tie_tolerance, least_curvature, concave, spacing, gouge
                        )
                    else:
                        scale_losses(batch, m, breakage_step)
                    shed_losses(batch, m, UPPER, 0, tie_tolerance, gouge)
                    shed_losses(batch, m, LOWER, 1, tie_tolerance, gouge)
                for i in range(m):
                    if batch[TAKEN * BATCH + i] == 0.0:
                        continue
                    cell = some[i]
                    scatter(batch, i, cell, top, bottom, stride)
                    if going > 0:
                        waiting[cell] = 1
                        lists[colour, counts[colour]] = cell
                        counts[colour] += 1
                    for k in range(8):
                        near = cell + beside[k]
                        own = colours[near]
                        # without a branch, which could not be predicted
                        new = (1 - waiting[near]) & (top[near] + bottom[near] + lift[near] > 0.0)
                        lists[own, counts[own]] = near
                        counts[own] += new
                        waiting[near] |= new
        unpad(top, upper)
        unpad(bottom, lower)
        unpad(state, peaks)
        held = np.empty((ny, nx), np.bool_)
        unpad(confined, held)
        return steps, held

    return break_to_rest

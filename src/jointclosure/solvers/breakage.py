"""Breakage to rest at fixed closure and fixed interaction.

An overstressed pair is lowered until it holds, has lost contact or is
locked, its gouge laid on its neighbours. Pairs are coloured so that the
neighbourhoods of one colour do not overlap. The colours take turns:

1. of the pairs of a colour that wait, `BATCH` at a time, the overstressed are picked out;
2. these break together, up to `_MOST_PASSES` steps in a row, as
   `jointclosure.solvers.pair_batch` says;
3. they are written back; whoever still breaks waits for the colour's next turn, and each
   neighbour that overlaps for its own.

When none waits all overlapping pairs are looked at again, until nothing breaks. The
order of breakage is not prescribed by the model: docs/decisions/0006-order-of-breakage.md
measures what it is worth.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import force_of_overlap
from jointclosure.mechanics.gouge import drops
from jointclosure.solvers.cells import is_peak, neighbourhood
from jointclosure.solvers.pair_batch import (
    BATCH,
    CENTRE,
    LOWER,
    UPPER,
    assess,
    fixed_losses,
    gather,
    measure_drops,
    returning_losses,
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


class Cells(NamedTuple):
    """A joint as flat arrays with a margin around it, rows of ``stride``.

    Heights and ``approach`` [m] as in `jointclosure.solvers.pair_batch`; ``kind``, the
    state of a pair as from `jointclosure.solvers.cells.peak_map`.
    """

    upper: np.ndarray
    lower: np.ndarray
    approach: np.ndarray
    kind: np.ndarray
    locked: np.ndarray
    stride: int


class Turns(NamedTuple):
    """Who waits: by cell its colour and 1 or 0, by colour a list of cells and their count."""

    colour: np.ndarray
    waits: np.ndarray
    lists: np.ndarray
    counts: np.ndarray


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

    Infinite where a pair cannot break: flat, or locked on both walls.
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
            strength = law.critical_indentation[kind] / curvature[i]
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
def padded_cells(upper, lower, approach, peaks):
    """`Cells` of walls, approach [m] and states of the pairs (y, x)."""
    ny, nx = upper.shape
    return Cells(
        padded(upper, math.inf),
        padded(lower, math.inf),
        padded(approach, -math.inf),
        padded(peaks, 0),
        padded(np.zeros((ny, nx), np.bool_), False),
        nx + 2 * _MARGIN,
    )


@kernel
def new_turns(ny, nx):
    """`Turns` of a grid in which nobody waits."""
    return Turns(
        padded(colour_map(ny, nx), 0),
        padded(np.zeros((ny, nx), np.int64), 1),
        np.empty((_COLOURS, ny * nx + 1), np.int64),
        np.zeros(_COLOURS, np.int64),
    )


@kernel
def let_overlapping_wait(cells, turns):
    """All cells that overlap wait; before, none did."""
    for cell in range(cells.upper.size):
        if cells.upper[cell] + cells.lower[cell] + cells.approach[cell] > 0.0:
            own = turns.colour[cell]
            turns.lists[own, turns.counts[own]] = cell
            turns.counts[own] += 1
            turns.waits[cell] = 1


@kernel
def let_neighbours_wait(cells, turns, cell, beside):
    """The neighbours of a cell wait, where they overlap and do not wait yet."""
    for k in range(8):
        near = cell + beside[k]
        own = turns.colour[near]
        overlap = cells.upper[near] + cells.lower[near] + cells.approach[near]
        # without a branch, which could not be predicted
        new = (1 - turns.waits[near]) & (overlap > 0.0)
        turns.lists[own, turns.counts[own]] = near
        turns.counts[own] += new
        turns.waits[near] |= new


@kernel
def set_laws(batch, n, some, kind, law):
    """Strength of the pairs at some cells (n,), by whether their cells are soft peaks."""
    for i in range(n):
        own = kind[some[i]]
        batch.critical_indentation[i] = law.critical_indentation[own]
        batch.substrate_strength[i] = law.substrate * law.breaking_force[own]


@kernel
def find_peaks(batch, n, some, kind):
    """Which cells of the pairs are peaks of the walls as they are."""
    around = np.empty(8)
    for i in range(n):
        own = 0
        for wall in (UPPER, LOWER):
            for k in range(8):
                around[k] = batch.heights[wall, k + (k >= CENTRE), i]
            own = 2 * own + is_peak(batch.heights[wall, CENTRE, i], around)
        kind[some[i]] = own


@kernel
def pick_overstressed(batch, n, looked_at, cells, turns, overstressed):
    """Those of the cells looked at (n,) whose pairs break, and how many; none waits any more."""
    m = 0
    for i in range(n):
        turns.waits[looked_at[i]] = 0
        cells.locked[looked_at[i]] = False
        overstressed[m] = looked_at[i]
        m += int(batch.breaks[i])
    return m


@kernel
def count_breaking(batch, n):
    """How many pairs of a batch break in this step."""
    count = 0
    for i in range(n):
        count += int(batch.breaks[i])
    return count


@kernel
def note_locked(batch, n, some, locked):
    """Mark the cells (n,) whose pairs turned out to be locked."""
    for i in range(n):
        locked[some[i]] |= batch.locked[i] > 0.0


@kernel
def write_back(batch, n, some, still_breaking, cells, turns, beside):
    """Write pairs that broke back to the walls; they, if they still do, and neighbours wait."""
    for i in range(n):
        if batch.steps[i] == 0.0:
            continue
        cell = some[i]
        scatter(batch, i, cell, cells.upper, cells.lower, cells.stride)
        if still_breaking:
            own = turns.colour[cell]
            turns.waits[cell] = 1
            turns.lists[own, turns.counts[own]] = cell
            turns.counts[own] += 1
        let_neighbours_wait(cells, turns, cell, beside)


@lru_cache(maxsize=None)
def breakage_kernel(gouge: bool, current_peaks: bool, resolved: bool):
    """Kernel that breaks all pairs to rest at a fixed interaction.

    The kernel's signature is ``(upper, lower, offset, interaction, peaks, law,
    breakage_step, band, tie_tolerance, most_steps, memory) -> (steps, locked)``:
    walls (y, x) [m] changed in place, the offset as in `overlapping_cells` [m],
    the interaction (y, x) [m]; the number of breakage steps taken
    (``most_steps`` or more where it did not come to rest) and a map (y, x) of
    locked pairs. A pair loses ``breakage_step`` [m] at a time; ``resolved``,
    what brings it back to its strength, which it may then exceed by half the
    ``band`` before it breaks again. ``memory``, from
    `jointclosure.solvers.pair_batch.batch_memory`, is room to work in. An effect that
    is off is not compiled.
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
        memory,
    ):
        ny, nx = upper.shape
        batch = memory[0]
        cells = padded_cells(upper, lower, offset - interaction, peaks)
        stride, kind = cells.stride, cells.kind
        turns = new_turns(ny, nx)
        beside = neighbour_offsets(stride)
        spacing, flattest, concave = law.spacing, law.least_curvature, law.concave
        allowed = 1.0 + 0.5 * band if resolved else 1.0
        taken = np.empty(ny * nx, np.int64)
        some = np.empty(BATCH + 1, np.int64)
        steps = 0
        seen = -1  # steps when all cells were last looked at
        colour = 0
        while steps < most_steps:
            if turns.counts.sum() == 0:
                # what broke changes curvatures up to two cells away: look at all again
                if seen == steps:
                    break
                seen = steps
                let_overlapping_wait(cells, turns)
            colour = (colour + 1) % _COLOURS
            number = turns.counts[colour]
            turns.counts[colour] = 0
            taken[:number] = turns.lists[colour, :number]
            for first in range(0, number, BATCH):
                looked_at = taken[first : min(first + BATCH, number)]
                n = looked_at.size
                # most that are looked at again still hold
                gather(
                    batch,
                    n,
                    looked_at,
                    cells.upper,
                    cells.lower,
                    cells.approach,
                    stride,
                    current_peaks,
                )
                if current_peaks:
                    find_peaks(batch, n, looked_at, kind)
                set_laws(batch, n, looked_at, kind, law)
                assess(batch, n, flattest, concave, spacing, allowed)
                n = pick_overstressed(batch, n, looked_at, cells, turns, some)
                if n == 0:
                    continue
                gather(batch, n, some, cells.upper, cells.lower, cells.approach, stride, True)
                set_laws(batch, n, some, kind, law)
                batch.steps[:n] = 0.0
                for turn in range(_MOST_PASSES):
                    if current_peaks and turn > 0:
                        find_peaks(batch, n, some, kind)
                        set_laws(batch, n, some, kind, law)
                    assess(batch, n, flattest, concave, spacing, allowed)
                    if gouge:
                        measure_drops(batch, n, UPPER, tie_tolerance)
                        measure_drops(batch, n, LOWER, tie_tolerance)
                    share_losses(batch, n, gouge)
                    if gouge:
                        note_locked(batch, n, some, cells.locked)
                    breaking = count_breaking(batch, n)
                    if breaking == 0:
                        break
                    steps += breaking
                    if resolved:
                        returning_losses(
                            batch, n, band, tie_tolerance, flattest, concave, spacing, gouge
                        )
                    else:
                        fixed_losses(batch, n, breakage_step)
                    shed_losses(batch, n, UPPER, tie_tolerance, gouge)
                    shed_losses(batch, n, LOWER, tie_tolerance, gouge)
                write_back(batch, n, some, breaking > 0, cells, turns, beside)
        unpad(cells.upper, upper)
        unpad(cells.lower, lower)
        unpad(kind, peaks)
        locked = np.empty((ny, nx), np.bool_)
        unpad(cells.locked, locked)
        return steps, locked

    return break_to_rest

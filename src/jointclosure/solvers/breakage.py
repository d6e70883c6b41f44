"""Breakage until rest at fixed closure and fixed interaction.

An overstressed pair is lowered until it holds, has lost contact or is locked, and its gouge is
distributed on its neighbours. Waiting pairs are examined `BATCH` at a time. The overstressed ones
break up to `_MOST_PASSES` steps in a row and are written back. Their overlapping neighbours then
wait, and so do they if they may break again. When no pair waits, all overlapping pairs are checked
again, until nothing breaks.

With fixed steps a pair that holds is checked again only when the approach has grown to where it
will break, or walls within two cells of it have changed. That approach follows from the overlap
ratio, the overlap over that at breakage. It is kept from call to call (`WorkSpace`), which
changes no result.

Resolved breakage also walks through a step in short steps, with the growth of the approach known
beforehand. A pair that holds is examined again when its overlap, which grows evenly, reaches that
at breakage, or when walls within two cells of it have changed: a short step in which nothing breaks
costs nothing. Pairs that exceed their strength only at the end of the step are left to the
equilibrium there.

The model does not prescribe the order of breakage (docs/decisions.md#0006-order-of-breakage).
Resolved breakage lowers all waiting pairs from the same walls, and then adds up what each has lost
and shed. With fixed steps pairs are coloured so that the neighbourhoods of one colour do not
overlap, and the colours are processed in turn.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.gouge import is_above_any
from jointclosure.mechanics.strength import bounded_strength
from jointclosure.solvers.cells import is_peak, neighbourhood
from jointclosure.solvers.contacts import Contacts, contact_roots
from jointclosure.solvers.pair_batch import (
    BATCH,
    CENTRE,
    LOWER,
    UPPER,
    Rules,
    assess,
    batch_memory,
    copy_pair,
    fixed_losses,
    gather,
    keep_assessment,
    measure_drops,
    returning_losses,
    scatter,
    share_losses,
    shed_losses,
    unsigned,
    whole_vectors,
)
from jointclosure.solvers.products import assign

_MARGIN = 2
"""Width in cells of the margin around the grid, infinitely high and never in contact."""
_APART = 3
"""Distance of the cells of one colour with fixed steps, which then share no neighbours."""
_NEAR = 1e-9
"""Relative distance of a pair's overlap from that at breakage, below which the pair is checked. It
is much more than the rounding of the overlap ratio, so that skipping pairs changes no result."""
_ROUNDING = 1e-14
"""Rounding of an overlap, relative to the heights and the approach of which it is the sum."""
_MOST_PASSES = 4
"""Largest number of consecutive steps of one pair before it waits for its next turn."""


class Cells(NamedTuple):
    """Walls, approach and states of the pairs of a grid, as flat arrays with a margin.

    See `padded`.
    """

    upper: np.ndarray  # heights of the walls [m], infinite in the margin
    lower: np.ndarray
    approach: np.ndarray  # offset less interaction [m]; with both heights it gives the overlap
    kind: np.ndarray  # state of each pair, see `ContactLaw`
    locked: np.ndarray  # whether a pair is beyond its strength, but has nowhere to shed its gouge
    stride: int  # number of cells from one row to the next


class Due(NamedTuple):
    """Cells to examine at the end of each short step of breakage, in one list for each short step.

    The end of a short step is a *moment*, given by the number of the step from 1 on; 0 stands for
    no moment. The end of the last short step has no list. A cell that becomes due at another moment
    is not removed from its former list, where it would have to be searched. Of the entries of a
    cell in a list the latest counts, and only if the cell is due at the moment of this list.
    """

    moment: np.ndarray  # at which each cell is due, 0 for none
    lists: np.ndarray  # cells (moments, most entries)
    counts: np.ndarray  # number of entries of each list


class Turns(NamedTuple):
    """Cells that wait to be examined for breakage, in one list for each colour."""

    colour: np.ndarray  # of each cell
    waits: np.ndarray  # 1 for a cell in a list, else 0; 1 in the margin, never added to a list
    lists: np.ndarray  # cells (colours, most cells of a colour)
    counts: np.ndarray  # number of waiting cells of each colour
    colour_beside: np.ndarray  # colours of the neighbours of each colour (colours, 8)


class WorkSpace(NamedTuple):
    """Memory of `breakage_kernel` for one joint, which lasts from call to call."""

    cells: Cells
    turns: Turns
    holds_to: np.ndarray  # approach [m] up to which a cell's pair is known to hold, or -infinity
    following: np.ndarray  # new walls (2, cells) [m] of pairs that break together
    taken: np.ndarray  # cells being examined, overwritten from the start by those that broke
    some: np.ndarray  # cells of the pairs in the batch
    batch: np.ndarray  # (1,), see `Batch`


@kernel
def padded(field, outside):
    """Return a field (y, x) with a margin of the value ``outside``, as one flat array."""
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
    """Set a field (y, x) to the values of a flat array with a margin (`padded`)."""
    ny, nx = field.shape
    stride = nx + 2 * _MARGIN
    for y in range(ny):
        start = (y + _MARGIN) * stride + _MARGIN
        for x in range(nx):
            field[y, x] = flat[start + x]


@kernel
def strength_limits(upper, lower, cells, curvature, compliance, peaks, law, gouge, tie, band):
    """Return the largest forces (n,) [N] that contacts at cells (n,) carry (resolved breakage).

    ``curvature`` (n,) [1/m] and ``compliance`` (n,) [m N^(-2/3)] are those of the contacts, the
    other parameters those of `breakage_kernel`; ``tie`` is its ``tie_tolerance``. The largest force
    is that at 1 + band/2 times the overlap at breakage. It is infinite for contacts that do not
    break: flat ones without a bound of strength, and with ``gouge`` those without a lower neighbour
    on either wall.
    """
    nx = upper.shape[1]
    around = np.empty(8)
    breaks = np.empty(cells.size, np.bool_)
    critical = np.empty(cells.size)
    filling = np.empty(cells.size)
    substrate_strength = np.empty(cells.size)
    for i in range(cells.size):
        y, x = divmod(cells[i], nx)
        kind = peaks[y, x]
        critical[i] = law.critical_indentation[kind]
        filling[i] = law.filling[kind]
        substrate_strength[i] = law.substrate * law.breaking_force[kind]
        free = not gouge
        if gouge:
            neighbourhood(upper, y, x, around)
            free = is_above_any(upper[y, x], around, tie)
            if not free:
                neighbourhood(lower, y, x, around)
                free = is_above_any(lower[y, x], around, tie)
        breaks[i] = free and (curvature[i] > 0.0 or filling[i] > 0.0)
    # apart from the copying, so that it is vector code
    overlap = np.empty(cells.size)
    for i in range(cells.size):
        kappa, indentation = bounded_strength(curvature[i], critical[i], filling[i])
        square = kappa * kappa
        strength = indentation / kappa
        if law.substrate > 0.0:  # 0 times an infinite force would be NaN
            strength += substrate_strength[i] / square
        overlap[i] = (1.0 + 0.5 * band) * strength if breaks[i] else 0.0
    contacts = Contacts(cells, overlap, compliance, overlap, law.substrate)
    root = contact_roots(contacts, overlap, np.zeros(cells.size))
    limit = root * root * root
    for i in range(cells.size):
        limit[i] = limit[i] if breaks[i] else np.inf
    return limit


@kernel
def colour_map(ny, nx, apart):
    """Return the colours (y, x) of cells: cells of one colour are ``apart`` cells apart.

    They are so in both directions, and there are ``apart`` squared colours.
    """
    colours = np.empty((ny, nx), np.int64)
    for y in range(ny):
        for x in range(nx):
            colours[y, x] = apart * (y % apart) + x % apart
    return colours


@kernel
def colours_beside(apart):
    """Return the colours (colours, 8) of the neighbours of cells of each colour of `colour_map`."""
    colours = np.empty((apart * apart, 8), np.int64)
    for colour in range(apart * apart):
        for k in range(8):
            place = k + (k >= CENTRE)  # among the 3 x 3 cells
            y = (colour // apart + place // 3 + apart - 1) % apart
            x = (colour % apart + place % 3 + apart - 1) % apart
            colours[colour, k] = apart * y + x
    return colours


@kernel
def padded_cells(upper, lower, approach, peaks):
    """Make `Cells` of walls, approach [m] and states of the pairs (y, x)."""
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
def new_turns(ny, nx, apart):
    """Return `Turns` of a grid whose cells of one colour are ``apart`` cells apart; none waits."""
    colours = apart * apart
    of_a_colour = ((ny + apart - 1) // apart) * ((nx + apart - 1) // apart)
    return Turns(
        padded(colour_map(ny, nx, apart), 0),
        padded(np.zeros((ny, nx), np.int64), 1),
        np.empty((colours, of_a_colour + 1), np.int64),
        np.zeros(colours, np.int64),
        colours_beside(apart),
    )


def work_space(shape: tuple[int, int], resolved: bool) -> WorkSpace:
    """Make the `WorkSpace` of a grid for resolved breakage, or for fixed steps."""
    high = np.full(shape, math.inf)
    level = np.zeros(shape)
    cells = padded_cells(high, high, level, np.zeros(shape, np.int64))
    return WorkSpace(
        cells,
        new_turns(*shape, 1 if resolved else _APART),
        np.full(cells.upper.size, -math.inf),
        np.stack((cells.upper, cells.lower)),
        np.empty(level.size, np.int64),
        np.empty(BATCH + 1, np.int64),
        batch_memory(),
    )


@kernel
def forget(holds_to, cell, reach, stride):
    """Set ``holds_to`` to -infinity, not known, within ``reach`` cells of a changed cell."""
    for row in range(-reach, reach + 1):
        for near in range(cell + row * stride - reach, cell + row * stride + reach + 1):
            holds_to[unsigned(near)] = -math.inf


@kernel
def number_of_changes(one, other):
    """Return at how many places the values of two arrays (n,) differ."""
    count = 0
    for i in range(one.size):
        count += one[i] != other[i]
    return count


@kernel
def take_over(space, upper, lower, offset, interaction, peaks):
    """Copy the present walls, approach [m] and states of the pairs (y, x) to the work space.

    No pair is then waiting or locked. ``holds_to`` becomes unknown within one cell of a cell whose
    wall or state has changed.
    """
    cells = space.cells
    waits = space.turns.waits
    holds_to = space.holds_to
    ny, nx = upper.shape
    for y in range(ny):
        start = (y + _MARGIN) * cells.stride + _MARGIN
        approach = cells.approach[start : start + nx]
        acting = interaction[y]
        for x in range(nx):
            approach[x] = offset - acting[x]
        cells.locked[start : start + nx] = False
        waits[start : start + nx] = 0
        changed = number_of_changes(upper[y], cells.upper[start : start + nx])
        changed += number_of_changes(lower[y], cells.lower[start : start + nx])
        changed += number_of_changes(peaks[y], cells.kind[start : start + nx])
        for x in range(nx if changed else 0):
            cell = start + x
            same = upper[y, x] == cells.upper[cell] and lower[y, x] == cells.lower[cell]
            if not same or peaks[y, x] != cells.kind[cell]:
                cells.upper[cell] = upper[y, x]
                cells.lower[cell] = lower[y, x]
                cells.kind[cell] = peaks[y, x]
                forget(holds_to, cell, 1, cells.stride)
    space.turns.counts[:] = 0


@kernel
def note_holding(batch, n, looked_at, cells, holds_to):
    """Set ``holds_to``, the approach [m] up to which the pairs (n,) that hold now will hold.

    Pairs that break now, or do not overlap, are left out. The overlap ratio is 1 where the overlap
    is overlap / ratio. The approach is a little smaller than it would be there (`_NEAR`), and is
    infinite for a pair whose ratio is not positive.
    """
    for i in range(n):
        cell = unsigned(looked_at[i])
        overlap = batch.overlap[i]
        ratio = batch.overlap_ratio[i]
        approach = cells.approach[cell]
        most = overlap / ratio
        heights = abs(cells.upper[cell]) + abs(cells.lower[cell]) + abs(approach)
        holding = approach + ((1.0 - _NEAR) * most - overlap) - _ROUNDING * heights
        holding = holding if ratio > 0.0 else math.inf
        # selections without a branch, because it would be unpredictable
        holds = (batch.breaks[i] == 0.0) & (overlap > 0.0)
        holds_to[cell] = holding if holds else holds_to[cell]


@kernel
def let_wait(turns, cell):
    """Add a cell, which must not be waiting yet, to the waiting cells of its colour."""
    colour = turns.colour[cell]
    turns.lists[colour, turns.counts[colour]] = cell
    turns.counts[colour] += 1
    turns.waits[cell] = 1


@kernel
def overlaps(cells, cell):
    """Return whether both walls of a cell overlap, at its present approach."""
    return cells.upper[cell] + cells.lower[cell] + cells.approach[cell] > 0.0


@kernel
def let_overlapping_wait(cells, turns, holds_to):
    """Make all overlapping cells wait that are not known to hold (``holds_to``).

    No cell may be waiting before.
    """
    for cell in range(cells.upper.size):
        # one branch that is seldom taken, in place of two that are unpredictable
        if (cells.approach[cell] > holds_to[cell]) & overlaps(cells, cell):
            let_wait(turns, cell)


@kernel
def starts_to_wait(cells, turns, cell):
    """Return 1 for a cell that overlaps and is not waiting yet, else 0; nothing is changed."""
    return (1 - turns.waits[cell]) & overlaps(cells, cell)


@kernel
def let_neighbours_wait(cells, turns, broken, beside, colour):
    """Make the neighbours of broken cells (n,) of a colour wait if their walls overlap.

    Neighbours that wait already are not listed again. All neighbours at one of the offsets
    ``beside`` have one colour, so that only one list grows at a time.
    """
    for k in range(beside.size):
        offset = beside[k]
        its_colour = turns.colour_beside[colour, k]
        waiting = turns.lists[its_colour]
        count = turns.counts[its_colour]
        for cell in broken:
            near = unsigned(cell + offset)
            # without a branch, because it would be unpredictable
            before = turns.waits[near]
            after = before | overlaps(cells, near)
            waiting[unsigned(count)] = near
            count += after - before
            turns.waits[near] = after
        turns.counts[its_colour] = count


@kernel
def no_cells_due(cells, short_steps):
    """Return an empty `Due` for ``cells``, a number of cells, and a number of short steps."""
    return Due(
        np.zeros(cells, np.int64),
        np.empty((short_steps, 2 * cells), np.int64),
        np.zeros(short_steps, np.int64),
    )


@kernel
def remove_old_entries(due, moment):
    """Keep of each cell that is due at a moment its latest entry in the list of the moment.

    All other entries of this list are removed.
    """
    entries = due.lists[moment]
    first = entries.size  # of those that are kept, which are collected at the end of the list
    for k in range(due.counts[moment] - 1, -1, -1):
        cell = entries[k]
        if due.moment[cell] == moment:
            due.moment[cell] = 0
            first -= 1
            entries[first] = cell
    count = 0
    for k in range(first, entries.size):
        entries[count] = entries[k]
        due.moment[entries[k]] = moment
        count += 1
    due.counts[moment] = count


@kernel
def listed_moment(due, moment):
    """Return a moment if `Due` has a list for it, else 0, as for the end of the last short step.

    A cell whose moment is 0 is due at no moment.
    """
    return moment if moment < due.counts.size else 0


@kernel
def set_due(due, cell, moment):
    """Make a cell due at one moment and no other; at none if the moment is the end of the step."""
    moment = listed_moment(due, moment)
    if due.moment[cell] == moment:
        return
    due.moment[cell] = moment
    if moment > 0:
        entry = due.counts[moment]
        due.lists[moment, entry] = cell
        due.counts[moment] = entry + 1
        # a list has room for two entries of every cell: at least half of it is free then
        if entry + 1 == due.lists.shape[1]:
            remove_old_entries(due, moment)


@kernel
def let_due_wait(due, moment, turns):
    """Move the cells that are due at a moment to the waiting cells, the latest entry first.

    They are then due at no moment, and the list of the moment is empty.
    """
    for k in range(due.counts[moment] - 1, -1, -1):
        cell = due.lists[moment, k]
        if due.moment[cell] == moment:
            due.moment[cell] = 0
            let_wait(turns, cell)
    due.counts[moment] = 0


@kernel
def foresee(batch, n, looked_at, growth, due, moment, allowed):
    """Set the moments at which pairs (n,) that hold now will exceed the overlap ratio ``allowed``.

    The walls are assumed to stay as they are. The overlap grows evenly, by ``growth`` (cells) [m]
    over the whole step, and the overlap ratio with it. A pair that does not exceed ``allowed``
    before the end of the step is due at no moment. Pairs that break now are left alone.
    """
    last = due.counts.size  # the moment at the end of the step
    for i in range(n):
        cell = looked_at[i]
        if batch.breaks[i] > 0.0:
            continue
        rate = growth[cell] / last
        overlap = batch.overlap[i]
        ratio = batch.overlap_ratio[i]
        following = last
        if rate > 0.0 and overlap != 0.0 and ratio != 0.0:
            missing = (allowed * overlap / ratio - overlap) / rate
            if missing < last:
                following = moment + 1 + max(int(missing), 0)
        set_due(due, cell, following)


@kernel
def let_ring_be_due(cells, due, broken, ring, moment):
    """Make the overlapping cells two cells away from broken cells (n,) due at the next moment.

    In the last short step, whose end has no list, they are due at no moment.
    """
    following = listed_moment(due, moment + 1)
    for cell in broken:
        for offset in ring:
            near = unsigned(cell + offset)
            # most are due already, which is faster to see than their overlap
            if due.moment[near] != following and overlaps(cells, near):
                set_due(due, cell + offset, following)


@kernel
def set_laws(batch, n, some, kind, law):
    """Set the strength of the pairs at cells ``some`` (n,) in a batch, by the states ``kind``."""
    for i in range(n):
        state = unsigned(kind[unsigned(some[i])])
        batch.critical_indentation[i] = law.critical_indentation[state]
        batch.filling[i] = law.filling[state]
        batch.substrate_strength[i] = law.substrate * law.breaking_force[state]


@kernel
def find_peaks(batch, n, some, kind):
    """Set the states ``kind`` of the pairs at cells ``some`` (n,) from their present heights."""
    around = np.empty(8)
    for i in range(n):
        state = 0
        for wall in (UPPER, LOWER):
            for k in range(8):
                around[k] = batch.heights[wall, k + (k >= CENTRE), i]
            state = 2 * state + is_peak(batch.heights[wall, CENTRE, i], around)
        kind[some[i]] = state


@kernel
def pick_overstressed(batch, n, looked_at, cells, turns, overstressed):
    """Set ``overstressed`` to the examined cells (n,) whose pairs break; return their number.

    The assessments of these pairs become the first part of the batch, but not their heights. None
    of the examined cells waits or is locked any more.
    """
    m = 0
    for i in range(n):
        cell = unsigned(looked_at[i])
        turns.waits[cell] = 0
        cells.locked[cell] = False
        overstressed[m] = looked_at[i]
        keep_assessment(batch, i, m)
        m += int(batch.breaks[i])
    batch.breaks[:m] = 1.0
    return m


@kernel
def write_back(batch, n, some, still_breaking, cells, turns, holds_to, beside, colour):
    """Write broken pairs of a colour back to the walls, and make their overlapping neighbours wait.

    The broken cells wait too if any pair of the batch is ``still_breaking``. They become the first
    of ``some`` (n,). What was known of how far pairs within two cells hold (``holds_to``) is
    forgotten.
    """
    m = 0
    for i in range(n):
        if batch.steps[i] == 0.0:
            continue
        cell = some[i]
        scatter(batch, i, cell, cells.upper, cells.lower, cells.stride)
        forget(holds_to, cell, 2, cells.stride)
        if still_breaking:
            let_wait(turns, cell)
        some[m] = cell
        m += 1
    let_neighbours_wait(cells, turns, some[:m], beside, colour)


@kernel
def add_changes_of_walls(batch, i, cell, cells, walls, broken, count):
    """Add what pair i has changed to ``walls`` (2, cells) [m], and append its cell to ``broken``.

    ``walls`` are the new walls. Changes are added because pairs that break together may share
    neighbours. Return ``count``, the number of broken cells so far. A pair without breakage steps
    changes nothing.
    """
    if batch.steps[i] == 0.0:
        return count
    for k in range(9):
        near = unsigned(cell + (k // 3 - 1) * cells.stride + k % 3 - 1)
        if cells.upper[near] < math.inf:
            walls[UPPER, near] += batch.heights[UPPER, k, i] - cells.upper[near]
            walls[LOWER, near] += batch.heights[LOWER, k, i] - cells.lower[near]
    broken[count] = cell
    return count + 1


@kernel
def take_out_resting(batch, n, some, cells, walls, broken, count):
    """Take pairs that break no more out of the batch, and add what they changed to ``walls``.

    ``walls`` (2, cells) [m] are the new walls. Return how many pairs are left in the batch, whose
    cells become the first of ``some``, and how many cells are listed in ``broken``.
    """
    i = 0
    while i < n:
        if batch.breaks[i] > 0.0:
            i += 1
            continue
        count = add_changes_of_walls(batch, i, some[i], cells, walls, broken, count)
        n -= 1
        if i < n:
            copy_pair(batch, n, i)
            some[i] = some[n]
    return n, count


@kernel
def write_together(walls, broken, cells, turns, around):
    """Copy the new walls around broken cells (n,) to the walls, and make overlapping cells wait.

    The cells that may wait are the broken ones and their neighbours. Pairs that break together have
    one colour.
    """
    for cell in broken:
        for offset in around:
            near = unsigned(cell + offset)
            cells.upper[near] = walls[UPPER, near]
            cells.lower[near] = walls[LOWER, near]
    waiting = turns.lists[0]
    count = turns.counts[0]
    for cell in broken:
        for offset in around:
            near = unsigned(cell + offset)
            new = starts_to_wait(cells, turns, near)
            waiting[unsigned(count)] = near
            count += new
            turns.waits[near] |= new
    turns.counts[0] = count


@kernel
def neighbour_offsets(stride):
    """Return offsets from a cell to cells around it in a flat array with rows of ``stride`` cells.

    They are three arrays: to its eight neighbours, to these and the cell itself, and to the sixteen
    cells that are two cells away.
    """
    up = stride
    down = -stride
    beside = np.array([down - 1, down, down + 1, -1, 1, up - 1, up, up + 1])
    around = np.append(beside, 0)
    ring = np.array([
        2 * down - 2, 2 * down - 1, 2 * down, 2 * down + 1, 2 * down + 2,
        down - 2, down + 2, -2, 2, up - 2, up + 2,
        2 * up - 2, 2 * up - 1, 2 * up, 2 * up + 1, 2 * up + 2,
    ])  # fmt: skip
    return beside, around, ring


@lru_cache(maxsize=None)
def breakage_kernel(gouge: bool, current_peaks: bool, resolved: bool, bounded: bool):
    """Return the kernel that breaks all pairs until rest at a fixed interaction.

    ``current_peaks``: peaks are those of the present walls, else of the pristine ones.
    ``resolved``: resolved breakage, else fixed steps. ``bounded``: the base of an asperity bounds
    its strength. The code of an effect that is off is not compiled.
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
        space,
        growth,
        short_steps,
    ):
        """Break pairs; return the number of breakage steps, and which cells (y, x) are locked.

        Walls ``upper`` and ``lower`` (y, x) [m], and the states ``peaks`` (y, x) of pairs, are
        changed in place. The overlap of a pair is the sum of both heights and the ``offset`` [m],
        closure from first touch, less the ``interaction`` (y, x) [m]. Fixed steps lower a pair by
        ``breakage_step`` [m]; resolved breakage lets overlap ratios lie up to half of the ``band``
        above 1. Height differences up to ``tie_tolerance`` [m] make no neighbour lower. With more
        than one of the ``short_steps`` the offset is that at the end of a step, in which the
        approach grows by ``growth`` (y, x) [m]. Breakage ends unfinished after ``most_steps``.
        ``space`` is the `WorkSpace` of the joint.
        """
        ny, nx = upper.shape
        # not in functions of their own, as these would have the code of effects that are off
        take_over(space, upper, lower, offset, interaction, peaks)
        batch = space.batch[0]
        some = space.some
        cells = space.cells
        turns = space.turns
        following = space.following
        taken = space.taken
        beside, around, ring = neighbour_offsets(cells.stride)
        colours = turns.counts.size
        walks = short_steps > 1
        growing = padded(growth, 0.0) if walks else cells.approach
        due = no_cells_due(cells.upper.size if walks else 0, short_steps)
        moment = 0  # short steps that are done
        left = 1.0 if walks else 0.0  # share of the step that is to come
        if resolved:
            assign(following[UPPER], cells.upper)
            assign(following[LOWER], cells.lower)
        shape = law.least_curvature, law.concave, law.spacing
        rules = Rules(tie_tolerance, *shape, gouge, bounded)
        allowed = 1.0 + 0.5 * band if resolved else 1.0
        steps = 0
        seen = -1  # steps when all cells were last checked
        if walks:
            let_overlapping_wait(cells, turns, space.holds_to)
        colour = 0
        while steps < most_steps:
            if turns.counts.sum() == 0:
                if walks:
                    moment += 1
                    if moment == short_steps:
                        break
                    left = 1.0 - moment / short_steps
                    let_due_wait(due, moment, turns)
                    continue
                # breakage changes curvatures up to two cells away: check all cells again
                if seen == steps:
                    break
                seen = steps
                let_overlapping_wait(cells, turns, space.holds_to)
            colour = (colour + 1) % colours
            number = turns.counts[colour]
            broken = 0
            turns.counts[colour] = 0
            assign(taken, turns.lists[colour, :number])
            for first in range(0, number, BATCH):
                looked_at = taken[first : min(first + BATCH, number)]
                n = looked_at.size
                # most waiting cells hold, which can be seen without the corners around them
                gather(
                    batch, n, looked_at, cells.upper, cells.lower, cells.approach,
                    growing, left, cells.stride, current_peaks,
                )  # fmt: skip
                if current_peaks:
                    find_peaks(batch, n, looked_at, cells.kind)
                set_laws(batch, n, looked_at, cells.kind, law)
                assess(batch, whole_vectors(n), allowed, rules)
                if walks:
                    foresee(batch, n, looked_at, growing, due, moment, allowed)
                if not resolved:
                    note_holding(batch, n, looked_at, cells, space.holds_to)
                n = pick_overstressed(batch, n, looked_at, cells, turns, some)
                if n == 0:
                    continue
                gather(
                    batch, n, some, cells.upper, cells.lower, cells.approach,
                    growing, left, cells.stride, True,
                )  # fmt: skip
                batch.steps[:n] = 0.0
                # several breakage steps in a row, before the neighbours are examined
                for turn in range(_MOST_PASSES):
                    if current_peaks and turn > 0:
                        find_peaks(batch, n, some, cells.kind)
                        set_laws(batch, n, some, cells.kind, law)
                    wide = whole_vectors(n)
                    if turn > 0:
                        assess(batch, wide, allowed, rules)
                    if gouge:
                        measure_drops(batch, wide, UPPER, tie_tolerance)
                        measure_drops(batch, wide, LOWER, tie_tolerance)
                    share_losses(batch, wide, gouge)
                    for i in range(n if gouge else 0):
                        cells.locked[some[i]] |= batch.locked[i] > 0.0
                    breaking = int(batch.breaks[:n].sum())
                    if resolved:
                        n, broken = take_out_resting(
                            batch, n, some, cells, following, taken, broken
                        )
                    if breaking == 0:
                        break
                    steps += breaking
                    if resolved:
                        returning_losses(batch, n, band, rules)
                    else:
                        fixed_losses(batch, wide, breakage_step)
                    wide = whole_vectors(n)
                    shed_losses(batch, wide, UPPER, tie_tolerance, gouge)
                    shed_losses(batch, wide, LOWER, tie_tolerance, gouge)
                if resolved:
                    for i in range(n):
                        broken = add_changes_of_walls(
                            batch, i, some[i], cells, following, taken, broken
                        )
                else:
                    write_back(
                        batch, n, some, breaking > 0, cells, turns, space.holds_to, beside, colour
                    )
            if resolved:
                write_together(following, taken[:broken], cells, turns, around)
                if walks:
                    let_ring_be_due(cells, due, taken[:broken], ring, moment)
        if steps > 0:
            unpad(cells.upper, upper)
            unpad(cells.lower, lower)
        if current_peaks:
            unpad(cells.kind, peaks)
        locked = np.empty((ny, nx), np.bool_)
        unpad(cells.locked, locked)
        return steps, locked

    return break_to_rest

"""Arithmetic of one breakage step for many pairs of cells at a time.

A `Batch` holds up to `BATCH` pairs. With fixed steps their neighbourhoods do not overlap. A step
is `assess`, `measure_drops` (with gouge), `share_losses`, `fixed_losses` or `returning_losses`, and
`shed_losses`, which change the batch in place, for its first n pairs. Every field has contiguous
values for all pairs in one block of memory, so that LLVM generates vector code: ``a if condition
else b`` is a selection there, not a branch, and values that do not apply to a pair are computed and
not used.

`jointclosure.mechanics.gouge` and `jointclosure.mechanics.strength` have the same equations for one
pair, as the reference solver uses them. tests/solvers/test_breakage.py compares both.

The 3 x 3 heights of a wall around a pair are in the order of (y, x) offsets, with the cell itself
at `CENTRE`; heights outside the grid are infinite.
"""

import math
from typing import NamedTuple

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.gouge import fall, passed_share, upper_share
from jointclosure.mechanics.strength import bounded_strength
from jointclosure.solvers.cells import wall_curvature
from jointclosure.solvers.products import LANES

BATCH = 128  # most pairs of a batch; chosen
UPPER = 0  # index of the upper wall
LOWER = 1  # index of the lower wall
_MOST_NARROWED = 60
"""Largest number of steps of false position for a loss; nearly all need two to four."""
_FEW = 0.25
"""Share of unsolved pairs below which they are solved one by one."""
# Indices in 3 x 3 heights: the cell itself and its edge neighbours.
SOUTH = 1  # y - 1
WEST = 3  # x - 1
CENTRE = 4
EAST = 5  # x + 1
NORTH = 7  # y + 1


def _batch_fields(*names: str, shape: tuple[int, ...] = ()) -> list[tuple]:
    """Return fields of `Batch` by name, each with an array of a ``shape`` for every pair."""
    return [(name, np.float64, (*shape, BATCH)) for name in names]


Batch = np.dtype(
    (
        np.record,
        [
            # the walls, by wall and neighbour [m]
            *_batch_fields("heights", shape=(2, 9)),
            # closure less the elastic displacement, from first touch [m]; the overlap is the
            # sum of both heights and this value
            *_batch_fields("approach", "overlap"),
            # strength: q = delta_break/R_a, substrate compliance times breaking force times
            # kappa_a^2 (see `jointclosure.mechanics.strength.is_overstressed`), and the curvature
            # [1/m] below which strength is bounded
            *_batch_fields("critical_indentation", "substrate_strength", "filling"),
            # overlap over the overlap at breakage
            *_batch_fields("overlap_ratio"),
            # whether the pair breaks in this step, and whether it is locked (1 or 0); number of
            # its breakage steps so far
            *_batch_fields("breaks", "locked", "steps"),
            # by wall: curvature [1/m], sum and smallest of the drops to lower neighbours [m],
            # loss of height (at first its share) [m]
            *_batch_fields("curvature", "total_drop", "least_drop", "loss", shape=(2,)),
            # return mapping: largest possible loss; bracket of the loss, and by how much the
            # overlap ratio exceeds its goal at both ends; end that moved last, -1 or 1; trial
            # loss, and whether it is the solution, 1 or 0
            *_batch_fields("most", "left", "right", "excess", "shortage", "moved", "trial", "done"),
        ],
    )
)


def batch_memory() -> np.ndarray:
    """Allocate memory of one batch, (1,): its only element is the batch."""
    return np.zeros(1, Batch)


class Rules(NamedTuple):
    """Values that are the same for all pairs of a batch."""

    tie_tolerance: float  # height difference [m] up to which a neighbour is not lower
    least_curvature: float  # lower bound of a wall's curvature [1/m]
    concave: float  # see `ContactLaw`
    spacing: float  # of the grid [m]
    gouge: bool  # whether neighbours receive gouge
    bounded: bool  # whether strength is bounded by the base of an asperity


@kernel
def unsigned(index):
    """Return an index >= 0 as an unsigned integer, for which no check of its sign is compiled."""
    return np.uint64(index)


@kernel
def whole_vectors(n):
    """Return a number n of pairs, rounded up to whole vectors of the processor.

    A loop over whole vectors has no part that is not vector code. What it computes for places of
    the batch beyond n is not used.
    """
    return n + -n % LANES


@kernel
def gather(batch, n, cells, upper, lower, approach, growth, left, stride, with_corners):
    """Copy approaches and heights around cells (n,) into a batch, optionally with corners.

    ``approach`` (cells,) [m] is that at the end of a step, in which it grows by ``growth`` (cells,)
    [m]. ``left`` is the share of the step that is still to come. Without corners only the cell and
    its four edge neighbours are copied. ``stride`` is the number of cells from one row to the next.
    """
    for i in range(n):
        cell = cells[i]
        at = unsigned(cell)
        batch.approach[i] = approach[at] - left * growth[at]
        for row in range(3):
            for column in range(3):
                if with_corners or row == 1 or column == 1:
                    near = unsigned(cell + (row - 1) * stride + column - 1)
                    batch.heights[UPPER, 3 * row + column, i] = upper[near]
                    batch.heights[LOWER, 3 * row + column, i] = lower[near]


@kernel
def scatter(batch, i, cell, upper, lower, stride):
    """Copy the 3 x 3 heights of both walls of pair i from the batch back around its ``cell``."""
    for row in range(3):
        start = cell + (row - 1) * stride - 1
        for column in range(3):
            near = unsigned(start + column)
            upper[near] = batch.heights[UPPER, 3 * row + column, i]
            lower[near] = batch.heights[LOWER, 3 * row + column, i]


@kernel
def assess(batch, n, allowed, rules):
    """Set whether the first n pairs of a batch break, in place; return nothing.

    Their ``curvature``, ``overlap``, ``overlap_ratio`` and ``breaks`` are set from heights,
    approach and the fields of strength, which must be set before. The ratio is the overlap over
    that at breakage, with the bound of strength if ``rules.bounded``. A pair breaks (1, else 0) if
    the ratio exceeds ``allowed``. Locked pairs are not treated apart.
    """
    for i in range(n):
        for wall in range(2):
            batch.curvature[wall, i] = wall_curvature(
                batch.heights[wall, CENTRE, i],
                batch.heights[wall, WEST, i],
                batch.heights[wall, EAST, i],
                batch.heights[wall, SOUTH, i],
                batch.heights[wall, NORTH, i],
                rules.least_curvature,
                rules.concave,
                rules.spacing,
            )
        kappa = batch.curvature[UPPER, i] + batch.curvature[LOWER, i]
        overlap = (
            batch.heights[UPPER, CENTRE, i] + batch.heights[LOWER, CENTRE, i] + batch.approach[i]
        )
        indentation = batch.critical_indentation[i]
        if rules.bounded:
            kappa, indentation = bounded_strength(kappa, indentation, batch.filling[i])
        load = overlap * kappa * kappa
        strength = indentation * kappa + batch.substrate_strength[i]
        batch.overlap[i] = overlap
        batch.overlap_ratio[i] = load / strength
        batch.breaks[i] = 1.0 if load > allowed * strength else 0.0


@kernel
def keep_assessment(batch, at, to):
    """Copy what `assess` and the laws have set for the pair ``at`` to the place ``to``.

    These are curvatures, overlap, overlap ratio and strength. Heights, approach, `breaks`, drops
    and losses are not copied.
    """
    batch.curvature[UPPER, to] = batch.curvature[UPPER, at]
    batch.curvature[LOWER, to] = batch.curvature[LOWER, at]
    batch.overlap[to] = batch.overlap[at]
    batch.overlap_ratio[to] = batch.overlap_ratio[at]
    batch.critical_indentation[to] = batch.critical_indentation[at]
    batch.substrate_strength[to] = batch.substrate_strength[at]
    batch.filling[to] = batch.filling[at]


@kernel
def smaller_drop(drop, least):
    """Return the smaller of a drop and the smallest drop so far; a drop of 0 does not count."""
    return drop if 0.0 < drop < least else least


@kernel
def drop_of_neighbour(batch, wall, neighbour, i, tie_tolerance):
    """Return the drop [m] from the cell of pair i to a neighbour, 0 if it is not lower."""
    here = batch.heights[wall, CENTRE, i]
    return fall(here, batch.heights[wall, neighbour, i], tie_tolerance)


@kernel
def measure_drops(batch, n, wall, tie_tolerance):
    """Compute the sum and the least of the drops [m] from a wall's cells to their neighbours.

    The least drop is that of the lower neighbours, infinite if there are none, as in
    `mechanics.gouge.drops`.
    """
    for i in range(n):
        a = drop_of_neighbour(batch, wall, 0, i, tie_tolerance)
        b = drop_of_neighbour(batch, wall, 1, i, tie_tolerance)
        c = drop_of_neighbour(batch, wall, 2, i, tie_tolerance)
        d = drop_of_neighbour(batch, wall, 3, i, tie_tolerance)
        e = drop_of_neighbour(batch, wall, 5, i, tie_tolerance)
        f = drop_of_neighbour(batch, wall, 6, i, tie_tolerance)
        g = drop_of_neighbour(batch, wall, 7, i, tie_tolerance)
        h = drop_of_neighbour(batch, wall, 8, i, tie_tolerance)
        least = smaller_drop(a, math.inf)
        least = smaller_drop(b, least)
        least = smaller_drop(c, least)
        least = smaller_drop(d, least)
        least = smaller_drop(e, least)
        least = smaller_drop(f, least)
        least = smaller_drop(g, least)
        batch.least_drop[wall, i] = smaller_drop(h, least)
        batch.total_drop[wall, i] = ((a + b) + (c + d)) + ((e + f) + (g + h))


@kernel
def share_losses(batch, n, gouge):
    """Decide which of the first n pairs break, and set the share of a loss of each wall.

    The shares of both walls add to 1, and are 0 for a pair that does not break. With gouge a pair
    without a lower neighbour on either wall is locked, and does not break. `breaks`, `locked` and
    the number of steps of the batch are set too.
    """
    for i in range(n):
        share = upper_share(batch.curvature[UPPER, i], batch.curvature[LOWER, i])
        breaks = batch.breaks[i]
        if gouge:
            upper = batch.total_drop[UPPER, i]
            lower = batch.total_drop[LOWER, i]
            share = passed_share(share, upper, lower)
            locked = breaks if upper + lower == 0.0 else 0.0
            batch.locked[i] = locked
            breaks -= locked
        batch.breaks[i] = breaks
        batch.steps[i] += breaks
        batch.loss[UPPER, i] = breaks * share
        batch.loss[LOWER, i] = breaks * (1.0 - share)


@kernel
def fixed_losses(batch, n, breakage_step):
    """Turn the shares of loss of both walls into losses [m], by the fixed ``breakage_step`` [m]."""
    for i in range(n):
        batch.loss[UPPER, i] *= breakage_step
        batch.loss[LOWER, i] *= breakage_step


@kernel
def raise_neighbour(batch, wall, neighbour, i, rate, tie_tolerance):
    """Raise a neighbour of pair i by gouge, by ``rate`` times its drop below the cell.

    ``rate`` is the loss over the sum of the drops [1].
    """
    height = batch.heights[wall, neighbour, i]
    drop = fall(batch.heights[wall, CENTRE, i], height, tie_tolerance)
    batch.heights[wall, neighbour, i] = height + rate * drop


@kernel
def shed_losses(batch, n, wall, tie_tolerance, gouge):
    """Lower a wall's cells by their losses, which with gouge raise the lower neighbours.

    A neighbour rises in proportion to its drop below the cell. As in `mechanics.gouge.shed` a loss
    is limited so that no neighbour ends above the cell; `loss` itself stays as it was.
    """
    for i in range(n):
        loss = batch.loss[wall, i]
        here = batch.heights[wall, CENTRE, i]
        if gouge:
            total = batch.total_drop[wall, i]
            least = batch.least_drop[wall, i]
            full = loss / total
            cut = least / (total + least)
            rate = full if full < cut else cut
            rate = rate if loss > 0.0 else 0.0
            raise_neighbour(batch, wall, 0, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 1, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 2, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 3, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 5, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 6, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 7, i, rate, tie_tolerance)
            raise_neighbour(batch, wall, 8, i, rate, tie_tolerance)
            loss = rate * total if rate > 0.0 else 0.0
        batch.heights[wall, CENTRE, i] = here - loss


@kernel
def curvature_after(batch, i, wall, loss, rules):
    """Compute the curvature [1/m] of a wall's cell after pair i has lost a height ``loss`` [m].

    ``loss`` is that of both walls together, of which the wall has the share in `batch.loss`. With
    gouge the curvature is that after the lower neighbours have received the wall's part.
    """
    here = batch.heights[wall, CENTRE, i]
    share = batch.loss[wall, i]
    west = batch.heights[wall, WEST, i]
    east = batch.heights[wall, EAST, i]
    south = batch.heights[wall, SOUTH, i]
    north = batch.heights[wall, NORTH, i]
    if rules.gouge:
        rise = share * loss / batch.total_drop[wall, i]
        rise = rise if share > 0.0 else 0.0
        west += rise * fall(here, west, rules.tie_tolerance)
        east += rise * fall(here, east, rules.tie_tolerance)
        south += rise * fall(here, south, rules.tie_tolerance)
        north += rise * fall(here, north, rules.tie_tolerance)
    shape = rules.least_curvature, rules.concave, rules.spacing
    return wall_curvature(here - share * loss, west, east, south, north, *shape)


@kernel
def ratio_after(batch, i, loss, rules):
    """Compute the overlap ratio of pair i after a loss of height [m], see `curvature_after`."""
    kappa = curvature_after(batch, i, UPPER, loss, rules)
    kappa += curvature_after(batch, i, LOWER, loss, rules)
    indentation = batch.critical_indentation[i]
    if rules.bounded:
        kappa, indentation = bounded_strength(kappa, indentation, batch.filling[i])
    strength = indentation * kappa + batch.substrate_strength[i]
    return (batch.overlap[i] - loss) * kappa * kappa / strength


@kernel
def level_loss(batch, i, wall):
    """Return the loss [m] of pair i at which a wall's cell is level with a neighbour.

    It is the loss of both walls together at which the highest of the lower neighbours, raised by
    gouge, reaches the cell; infinite if the wall has no share of the loss.
    """
    share = batch.loss[wall, i]
    total = batch.total_drop[wall, i]
    least = batch.least_drop[wall, i]
    return least * total / (share * (total + least)) if share > 0.0 else math.inf


@kernel
def bracket_losses(batch, n, goal, gouge):
    """Bracket the losses that bring the overlap ratios to ``goal``, and set the first trials.

    A bracket starts at 0. It ends where contact is lost, or with gouge where a cell is level with a
    neighbour, if that is less (`level_loss`). The first trial is the solution for an unchanged
    curvature. Pairs that do not break are done.
    """
    for i in range(n):
        overlap = batch.overlap[i]
        most = overlap  # until contact is lost
        if gouge:
            level = level_loss(batch, i, UPPER)
            most = level if level < most else most
            level = level_loss(batch, i, LOWER)
            most = level if level < most else most
        ratio = batch.overlap_ratio[i]
        # solution for an unchanged curvature
        first = overlap * (1.0 - goal / ratio)
        first = first if first < most else most
        batch.most[i] = most
        batch.left[i] = 0.0
        batch.excess[i] = ratio - goal
        batch.right[i] = most
        batch.shortage[i] = math.inf  # unknown yet
        batch.moved[i] = 0.0
        batch.trial[i] = first
        batch.done[i] = 1.0 - batch.breaks[i]


@kernel
def narrow_loss(batch, i, goal, near, rules):
    """Do one step of false position for the loss of pair i, in the Illinois variant.

    As in that variant the value at an end of the bracket that stays twice is halved. It differs
    from the textbook in its start: the first trial is the solution for an unchanged curvature, and
    the value at the right end is not computed before a trial falls on it. The pair is done when the
    overlap ratio is within ``near`` of the goal, or too large even at the largest possible loss.
    """
    trial = batch.trial[i]
    answer = ratio_after(batch, i, trial, rules) - goal
    most = batch.most[i]
    left = batch.left[i]
    right = batch.right[i]
    excess = batch.excess[i]
    shortage = batch.shortage[i]
    moved = batch.moved[i]
    done = batch.done[i] > 0.0
    ends = done or abs(answer) <= near or (answer > 0.0 and trial >= most)
    high = answer > 0.0
    # the value at an end that stays twice is halved
    next_excess = answer if high else (0.5 * excess if moved < 0.0 else excess)
    next_shortage = (0.5 * shortage if moved > 0.0 else shortage) if high else answer
    next_left = trial if high else left
    next_right = right if high else trial
    following = (next_left * next_shortage - next_right * next_excess) / (
        next_shortage - next_excess
    )
    following = following if next_shortage < math.inf else most
    batch.left[i] = next_left
    batch.right[i] = next_right
    batch.excess[i] = next_excess
    batch.shortage[i] = next_shortage
    batch.moved[i] = 1.0 if high else -1.0
    batch.trial[i] = trial if ends else following
    batch.done[i] = 1.0 if ends else 0.0


@kernel
def returning_losses(batch, n, band, rules):
    """Compute by return mapping the losses that bring breaking pairs back to their strength.

    The overlap ratio becomes 1 - band/2, to within band/4, if a loss can lower it so far. The
    shares in `batch.loss` are replaced by losses [m]. All pairs do the same number of steps in
    vector code, until few are unsolved; these go on one by one.
    """
    goal = 1.0 - 0.5 * band
    near = 0.25 * band
    wide = whole_vectors(n)
    bracket_losses(batch, wide, goal, rules.gouge)
    unsolved = n
    for _ in range(_MOST_NARROWED):
        for i in range(wide):
            narrow_loss(batch, i, goal, near, rules)
        unsolved = 0
        for i in range(n):
            unsolved += batch.done[i] == 0.0
        if unsolved < _FEW * n:
            break
    for i in range(n):
        for _ in range(_MOST_NARROWED):
            if batch.done[i] > 0.0:
                break
            narrow_loss(batch, i, goal, near, rules)
    for i in range(n):
        batch.loss[UPPER, i] *= batch.trial[i]
        batch.loss[LOWER, i] *= batch.trial[i]


@kernel
def copy_pair(batch, at, to):
    """Copy an assessed pair, with its heights, drops and shares, to another place in the batch."""
    for wall in range(2):
        for k in range(9):
            batch.heights[wall, k, to] = batch.heights[wall, k, at]
        batch.total_drop[wall, to] = batch.total_drop[wall, at]
        batch.least_drop[wall, to] = batch.least_drop[wall, at]
        batch.loss[wall, to] = batch.loss[wall, at]
    keep_assessment(batch, at, to)
    batch.approach[to] = batch.approach[at]
    batch.breaks[to] = batch.breaks[at]
    batch.steps[to] = batch.steps[at]

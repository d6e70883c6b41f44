"""Pairs of cells, many at a time: the arithmetic of breakage, laid out for vector units.

A batch holds up to `BATCH` pairs whose neighbourhoods do not overlap. It is one
flat array of rows of that constant length: row r of pair i is at r * BATCH + i,
so that every loop below runs over contiguous numbers, without a branch, and
LLVM turns it into vector code.

Rows 0 to 8 are the 3 x 3 heights of the upper wall in the order of (y, x)
offsets, 9 to 17 those of the lower, the cell itself in the middle; heights
outside the grid are infinite.
"""

import math

import numpy as np

from jointclosure.compilation import kernel
from jointclosure.mechanics.curvature import gaussian_curvature
from jointclosure.mechanics.gouge import fall, passed_share, upper_share

BATCH = 128
UPPER, LOWER, CENTRE = 0, 9, 4
LIFT, OVERLAP, RATIO = 18, 19, 20
BEND, STRENGTH = 21, 22  # q of `breaking_bend`, and substrate times breaking force
CURVATURE, TOTAL, LEAST, LOSS = 23, 25, 27, 29  # upper, then lower
ACTIVE, TAKEN, CONFINED = 31, 32, 33
MOST, LEFT, RIGHT, EXCESS, SHORTAGE, SIDE, DONE, TRIAL = 34, 35, 36, 37, 38, 39, 40, 41
ROWS = 42


@kernel
def new_batch():
    """Memory of a batch."""
    return np.zeros(ROWS * BATCH)


@kernel
def gather(batch, n, cells, top, bottom, lift, stride, everything):
    """Copy heights around cells (n,) into a batch; the corners only if ``everything``.

    ``top``, ``bottom`` and ``lift`` are flat arrays with margins, rows of
    ``stride``.
    """
    for i in range(n):
        cell = cells[i]
        for row in range(3):
            start = cell + (row - 1) * stride
            batch[(UPPER + 3 * row + 1) * BATCH + i] = top[start]
            batch[(LOWER + 3 * row + 1) * BATCH + i] = bottom[start]
        batch[(UPPER + 3) * BATCH + i] = top[cell - 1]
        batch[(UPPER + 5) * BATCH + i] = top[cell + 1]
        batch[(LOWER + 3) * BATCH + i] = bottom[cell - 1]
        batch[(LOWER + 5) * BATCH + i] = bottom[cell + 1]
        batch[LIFT * BATCH + i] = lift[cell]
    if everything:
        for i in range(n):
            above, below = cells[i] - stride, cells[i] + stride
            batch[(UPPER + 0) * BATCH + i] = top[above - 1]
            batch[(UPPER + 2) * BATCH + i] = top[above + 1]
            batch[(UPPER + 6) * BATCH + i] = top[below - 1]
            batch[(UPPER + 8) * BATCH + i] = top[below + 1]
            batch[(LOWER + 0) * BATCH + i] = bottom[above - 1]
            batch[(LOWER + 2) * BATCH + i] = bottom[above + 1]
            batch[(LOWER + 6) * BATCH + i] = bottom[below - 1]
            batch[(LOWER + 8) * BATCH + i] = bottom[below + 1]


@kernel
def scatter(batch, i, cell, top, bottom, stride):
    """Copy the heights of pair i back around its cell."""
    for row in range(3):
        start = cell + (row - 1) * stride - 1
        for column in range(3):
            k = 3 * row + column
            top[start + column] = batch[(UPPER + k) * BATCH + i]
            bottom[start + column] = batch[(LOWER + k) * BATCH + i]


@kernel
def curvature_of(here, west, east, south, north, least_curvature, concave, spacing):
    """`jointclosure.solvers.cells.wall_curvature` without a branch."""
    left = east if west == math.inf else west
    right = west if east == math.inf else east
    below = north if south == math.inf else south
    above = south if north == math.inf else north
    found = gaussian_curvature(left, right, below, above, here, concave, spacing)
    # not a number for a single cell in a direction, which is straight
    return found if found > least_curvature else least_curvature


@kernel
def measure(batch, n, least_curvature, concave, spacing, allowed):
    """Curvatures, overlap, stress ratio and whether a pair is overstressed.

    The ratio is the overlap over that at which the pair breaks, see
    `jointclosure.mechanics.strength.is_overstressed`; ``allowed`` is what it
    may reach.
    """
    for i in range(n):
        high = batch[(UPPER + CENTRE) * BATCH + i]
        low = batch[(LOWER + CENTRE) * BATCH + i]
        bend_upper = curvature_of(
            high,
            batch[(UPPER + 3) * BATCH + i],
            batch[(UPPER + 5) * BATCH + i],
            batch[(UPPER + 1) * BATCH + i],
            batch[(UPPER + 7) * BATCH + i],
            least_curvature,
            concave,
            spacing,
        )
        bend_lower = curvature_of(
            low,
            batch[(LOWER + 3) * BATCH + i],
            batch[(LOWER + 5) * BATCH + i],
            batch[(LOWER + 1) * BATCH + i],
            batch[(LOWER + 7) * BATCH + i],
            least_curvature,
            concave,
            spacing,
        )
        overlap = high + low + batch[LIFT * BATCH + i]
        bend = bend_upper + bend_lower
        load = overlap * bend * bend
        strength = batch[BEND * BATCH + i] * bend + batch[STRENGTH * BATCH + i]
        batch[CURVATURE * BATCH + i] = bend_upper
        batch[(CURVATURE + 1) * BATCH + i] = bend_lower
        batch[OVERLAP * BATCH + i] = overlap
        batch[RATIO * BATCH + i] = load / strength
        batch[ACTIVE * BATCH + i] = 1.0 if load > allowed * strength else 0.0


@kernel
def least_of(drop, least):
    """The smaller of a drop and the least so far, where there is a drop."""
    return drop if 0.0 < drop < least else least


@kernel
def measure_falls(batch, n, wall, side, tie_tolerance):
    """Sum and least of the drops to lower neighbours: `jointclosure.mechanics.gouge.drops`.

    Rows ``TOTAL + side`` and ``LEAST + side``, of the wall whose heights start
    at row ``wall``.
    """
    for i in range(n):
        here = batch[(wall + CENTRE) * BATCH + i]
        a = fall(here, batch[(wall + 0) * BATCH + i], tie_tolerance)
        b = fall(here, batch[(wall + 1) * BATCH + i], tie_tolerance)
        c = fall(here, batch[(wall + 2) * BATCH + i], tie_tolerance)
        d = fall(here, batch[(wall + 3) * BATCH + i], tie_tolerance)
        e = fall(here, batch[(wall + 5) * BATCH + i], tie_tolerance)
        f = fall(here, batch[(wall + 6) * BATCH + i], tie_tolerance)
        g = fall(here, batch[(wall + 7) * BATCH + i], tie_tolerance)
        h = fall(here, batch[(wall + 8) * BATCH + i], tie_tolerance)
        least = least_of(a, math.inf)
        least = least_of(b, least)
        least = least_of(c, least)
        least = least_of(d, least)
        least = least_of(e, least)
        least = least_of(f, least)
        least = least_of(g, least)
        batch[(LEAST + side) * BATCH + i] = least_of(h, least)
        batch[(TOTAL + side) * BATCH + i] = ((a + b) + (c + d)) + ((e + f) + (g + h))


@kernel
def share_losses(batch, n, gouge):
    """Both walls' shares of a loss of 1, 0 for a pair that does not break.

    `jointclosure.mechanics.gouge.upper_share` and `passed_share`; marks pairs
    confined on both walls, which do not break.
    """
    for i in range(n):
        share = upper_share(batch[CURVATURE * BATCH + i], batch[(CURVATURE + 1) * BATCH + i])
        active = batch[ACTIVE * BATCH + i]
        if gouge:
            upper, lower = batch[TOTAL * BATCH + i], batch[(TOTAL + 1) * BATCH + i]
            share = passed_share(share, upper, lower)
            confined = active if upper + lower == 0.0 else 0.0
            batch[CONFINED * BATCH + i] = confined
            active -= confined
        batch[ACTIVE * BATCH + i] = active
        batch[TAKEN * BATCH + i] += active
        batch[LOSS * BATCH + i] = active * share
        batch[(LOSS + 1) * BATCH + i] = active * (1.0 - share)


@kernel
def scale_losses(batch, n, breakage_step):
    """The fixed step: both walls lose their shares of it."""
    for i in range(n):
        batch[LOSS * BATCH + i] *= breakage_step
        batch[(LOSS + 1) * BATCH + i] *= breakage_step


@kernel
def shed_losses(batch, n, wall, side, tie_tolerance, gouge):
    """Lower a wall's cells by their losses and lay these on the lower neighbours.

    `jointclosure.mechanics.gouge.shed`: cut so that no neighbour is lifted above
    the lowered cell.
    """
    for i in range(n):
        loss = batch[(LOSS + side) * BATCH + i]
        here = batch[(wall + CENTRE) * BATCH + i]
        if gouge:
            total = batch[(TOTAL + side) * BATCH + i]
            least = batch[(LEAST + side) * BATCH + i]
            full = loss / total
            cut = least / (total + least)
            rate = full if full < cut else cut
            rate = rate if loss > 0.0 else 0.0
            a = batch[(wall + 0) * BATCH + i]
            b = batch[(wall + 1) * BATCH + i]
            c = batch[(wall + 2) * BATCH + i]
            d = batch[(wall + 3) * BATCH + i]
            e = batch[(wall + 5) * BATCH + i]
            f = batch[(wall + 6) * BATCH + i]
            g = batch[(wall + 7) * BATCH + i]
            h = batch[(wall + 8) * BATCH + i]
            batch[(wall + 0) * BATCH + i] = a + rate * fall(here, a, tie_tolerance)
            batch[(wall + 1) * BATCH + i] = b + rate * fall(here, b, tie_tolerance)
            batch[(wall + 2) * BATCH + i] = c + rate * fall(here, c, tie_tolerance)
            batch[(wall + 3) * BATCH + i] = d + rate * fall(here, d, tie_tolerance)
            batch[(wall + 5) * BATCH + i] = e + rate * fall(here, e, tie_tolerance)
            batch[(wall + 6) * BATCH + i] = f + rate * fall(here, f, tie_tolerance)
            batch[(wall + 7) * BATCH + i] = g + rate * fall(here, g, tie_tolerance)
            batch[(wall + 8) * BATCH + i] = h + rate * fall(here, h, tie_tolerance)
            loss = rate * total if rate > 0.0 else 0.0
        batch[(wall + CENTRE) * BATCH + i] = here - loss


@kernel
def curvature_after(
    batch, i, wall, side, loss, tie_tolerance, least_curvature, concave, spacing, gouge
):
    """Curvature of a wall's cell once pair i has lost a height [m], its gouge laid around."""
    here = batch[(wall + CENTRE) * BATCH + i]
    share = batch[(LOSS + side) * BATCH + i]
    west = batch[(wall + 3) * BATCH + i]
    east = batch[(wall + 5) * BATCH + i]
    south = batch[(wall + 1) * BATCH + i]
    north = batch[(wall + 7) * BATCH + i]
    if gouge:
        rise = share * loss / batch[(TOTAL + side) * BATCH + i]
        rise = rise if share > 0.0 else 0.0
        west += rise * fall(here, west, tie_tolerance)
        east += rise * fall(here, east, tie_tolerance)
        south += rise * fall(here, south, tie_tolerance)
        north += rise * fall(here, north, tie_tolerance)
    return curvature_of(
        here - share * loss, west, east, south, north, least_curvature, concave, spacing
    )


@kernel
def ratio_after(batch, i, loss, tie_tolerance, least_curvature, concave, spacing, gouge):
    """Stress ratio of pair i once it has lost a height [m], its gouge on its neighbours.

    The shares are in the loss rows, falls and overlap as measured.
    """
    bend = curvature_after(
        batch, i, UPPER, 0, loss, tie_tolerance, least_curvature, concave, spacing, gouge
    ) + curvature_after(
        batch, i, LOWER, 1, loss, tie_tolerance, least_curvature, concave, spacing, gouge
    )
    strength = batch[BEND * BATCH + i] * bend + batch[STRENGTH * BATCH + i]
    return (batch[OVERLAP * BATCH + i] - loss) * bend * bend / strength


@kernel
def returning_losses(batch, n, band, tie_tolerance, least_curvature, concave, spacing, gouge):
    """Return mapping: both walls lose what brings a pair back to its strength.

    The smallest loss found at which the stress ratio lies between 1 - 3/4 band
    and 1 - 1/4 band, by false position (Illinois); where no loss does that, the
    most that there is: until contact is lost, or a neighbour is level.
    """
    goal, near = 1.0 - 0.5 * band, 0.25 * band
    for i in range(n):
        upper, lower = batch[LOSS * BATCH + i], batch[(LOSS + 1) * BATCH + i]
        overlap = batch[OVERLAP * BATCH + i]
        most = overlap
        if gouge:
            total, least = batch[TOTAL * BATCH + i], batch[LEAST * BATCH + i]
            level = least * total / (upper * (total + least)) if upper > 0.0 else math.inf
            most = level if level < most else most
            total, least = batch[(TOTAL + 1) * BATCH + i], batch[(LEAST + 1) * BATCH + i]
            level = least * total / (lower * (total + least)) if lower > 0.0 else math.inf
            most = level if level < most else most
        ratio = batch[RATIO * BATCH + i]
        # at an unchanged curvature, this would do
        first = overlap * (1.0 - goal / ratio)
        first = first if first < most else most
        batch[MOST * BATCH + i] = most
        batch[LEFT * BATCH + i] = 0.0
        batch[EXCESS * BATCH + i] = ratio - goal
        batch[RIGHT * BATCH + i] = most
        batch[SHORTAGE * BATCH + i] = math.inf
        batch[SIDE * BATCH + i] = 0.0
        batch[TRIAL * BATCH + i] = first
        batch[DONE * BATCH + i] = 1.0 - batch[ACTIVE * BATCH + i]
    for _ in range(60):
        for i in range(n):
            trial = batch[TRIAL * BATCH + i]
            answer = (
                ratio_after(
                    batch, i, trial, tie_tolerance, least_curvature, concave, spacing, gouge
                )
                - goal
            )
            most = batch[MOST * BATCH + i]
            left, right = batch[LEFT * BATCH + i], batch[RIGHT * BATCH + i]
            excess, shortage = batch[EXCESS * BATCH + i], batch[SHORTAGE * BATCH + i]
            side = batch[SIDE * BATCH + i]
            done = batch[DONE * BATCH + i] > 0.0
            found = done or abs(answer) <= near or (answer > 0.0 and trial >= most)
            high = answer > 0.0
            # Illinois: an end that stays twice counts half
            next_excess = answer if high else (0.5 * excess if side < 0.0 else excess)
            next_shortage = (0.5 * shortage if side > 0.0 else shortage) if high else answer
            next_left = trial if high else left
            next_right = right if high else trial
            following = (next_left * next_shortage - next_right * next_excess) / (
                next_shortage - next_excess
            )
            following = following if next_shortage < math.inf else most
            batch[LEFT * BATCH + i] = next_left
            batch[RIGHT * BATCH + i] = next_right
            batch[EXCESS * BATCH + i] = next_excess
            batch[SHORTAGE * BATCH + i] = next_shortage
            batch[SIDE * BATCH + i] = 1.0 if high else -1.0
            batch[TRIAL * BATCH + i] = trial if found else following
            batch[DONE * BATCH + i] = 1.0 if found else 0.0
        left_over = 0
        for i in range(n):
            left_over += batch[DONE * BATCH + i] == 0.0
        if left_over == 0:
            break
    for i in range(n):
        batch[LOSS * BATCH + i] *= batch[TRIAL * BATCH + i]
        batch[(LOSS + 1) * BATCH + i] *= batch[TRIAL * BATCH + i]

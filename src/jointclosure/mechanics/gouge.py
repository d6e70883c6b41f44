"""Distribution of the material of a broken asperity (Section 3 of the paper).

The eight neighbours of a cell are in the order (-1,-1) (-1,0) (-1,1) (0,-1) (0,1) (1,-1) (1,0)
(1,1) of (y, x) offsets. Neighbours outside the grid have infinite height, and receive no gouge.
These functions are for one pair of cells, as the reference solver calls them. The default solver
has the same equations for batches of pairs in `jointclosure.solvers.pair_batch`.
"""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def upper_share(upper_curvature, lower_curvature):
    """Return the upper wall's share of a loss [1], (1/R_t) / (1/R_t + 1/R_b) from curvatures [1/m].

    It is 1/2 if both walls are flat.
    """
    total = upper_curvature + lower_curvature
    if total == 0.0:
        return 0.5
    return upper_curvature / total


@kernel
def passed_share(share, total_upper, total_lower):
    """Return the upper wall's share of a loss, corrected where a cell cannot pass gouge on.

    ``share`` is the upper wall's share by curvature. ``total_upper`` and ``total_lower`` [m] are
    the sums of the drops from the cell of each wall to its lower neighbours (`drops`). The result
    is 0 if the upper sum is 0, also if both are, where the caller lets nothing break. It is 1 if
    only the lower sum is 0.
    """
    if total_upper == 0.0:
        return 0.0
    if total_lower == 0.0:
        return 1.0
    return share


@kernel
def fall(here, there, tie_tolerance):
    """Return the drop [m] from a cell to a neighbour; 0 unless it exceeds the tie tolerance [m]."""
    drop = here - there
    return drop if drop > tie_tolerance else 0.0


@kernel
def is_above_any(height, neighbours, tie_tolerance):
    """Return whether a cell of ``height`` [m] has a lower neighbour, which can receive its gouge.

    A neighbour (8,) [m] counts as lower if it is so by more than the tie tolerance [m].
    """
    deepest = 0.0
    for k in range(8):
        deepest = max(deepest, fall(height, neighbours[k], tie_tolerance))
    return deepest > 0.0


@kernel
def drops(height, neighbours, tie_tolerance, out):
    """Set ``out`` (8,) to the drops [m] from a cell to its neighbours; return their sum and least.

    A drop to a neighbour (8,) [m] that is not lower by more than the tie tolerance [m] is 0. The
    least drop [m] is that of the lower neighbours, infinite if there are none.
    """
    least = math.inf
    for k in range(8):
        out[k] = fall(height, neighbours[k], tie_tolerance)
        least = min(least, out[k] if out[k] > 0.0 else math.inf)
    total = ((out[0] + out[1]) + (out[2] + out[3])) + ((out[4] + out[5]) + (out[6] + out[7]))
    return total, least


@kernel
def shed(neighbours, loss, differences, total, least):
    """Raise the neighbours (8,) [m] of a cell, in place, by the gouge that the cell loses.

    Return the loss [m], by which the caller lowers the cell. It is at most ``loss``, so that no
    neighbour ends above the cell. Each neighbour rises in proportion to its drop below the cell.
    ``differences`` (8,) [m], ``total`` > 0 [m] and ``least`` [m] are the drops, their sum and the
    least one, as `drops` sets and returns them.
    """
    if loss * (total + least) > least * total:
        rate = least / (total + least)
        loss = rate * total
    else:
        rate = loss / total
    for k in range(8):
        neighbours[k] += rate * differences[k]
    return loss

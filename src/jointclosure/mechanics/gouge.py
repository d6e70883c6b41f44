"""Distribution of the material of a broken asperity (Section 3 of the paper).

The eight neighbours of a cell are in the order (-1,-1) (-1,0) (-1,1) (0,-1) (0,1) (1,-1) (1,0)
(1,1) of (y, x) offsets. One outside the grid has infinite height, so that it receives no gouge.
These functions are for one pair of cells, as the reference solver calls them. The default solver
has the same equations for batches of pairs in `jointclosure.solvers.pair_batch`.
"""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def upper_share(upper_curvature, lower_curvature):
    """Compute the upper wall's share of a loss: (1/R_t) / (1/R_t + 1/R_b), 1/2 if both are flat."""
    total = upper_curvature + lower_curvature
    if total == 0.0:
        return 0.5
    return upper_curvature / total


@kernel
def passed_share(share, total_upper, total_lower):
    """Return the upper wall's share, 0 or 1 if one wall's cell has no lower neighbour.

    ``total_upper`` and ``total_lower`` are the sums of the drops of both walls' cells [m].
    """
    if total_upper == 0.0:
        return 0.0
    if total_lower == 0.0:
        return 1.0
    return share


@kernel
def fall(here, there, tie_tolerance):
    """Return the drop [m] to a neighbour if it exceeds the tie tolerance [m], otherwise 0."""
    drop = here - there
    return drop if drop > tie_tolerance else 0.0


@kernel
def is_above_any(height, neighbours, tie_tolerance):
    """Return whether one of the neighbours (8,) [m] is lower, so that it can receive gouge."""
    deepest = 0.0
    for k in range(8):
        deepest = max(deepest, fall(height, neighbours[k], tie_tolerance))
    return deepest > 0.0


@kernel
def drops(height, neighbours, tie_tolerance, out):
    """Set ``out`` (8,) to the drops to lower neighbours [m], 0 for others; return sum and smallest.

    The smallest is that of the lower neighbours, infinite if there are none.
    """
    least = math.inf
    for k in range(8):
        out[k] = fall(height, neighbours[k], tie_tolerance)
        least = min(least, out[k] if out[k] > 0.0 else math.inf)
    total = ((out[0] + out[1]) + (out[2] + out[3])) + ((out[4] + out[5]) + (out[6] + out[7]))
    return total, least


@kernel
def shed(neighbours, loss, differences, total, least):
    """Add the loss [m] of a cell to the heights of its neighbours (8,) [m], in place.

    Each receives a part in proportion to its drop in ``differences`` (8,) [m], whose sum is
    ``total`` and whose smallest is ``least``. Return the loss, limited so that no neighbour is
    raised above the lowered cell.
    """
    if loss * (total + least) > least * total:
        rate = least / (total + least)
        loss = rate * total
    else:
        rate = loss / total
    for k in range(8):
        neighbours[k] += rate * differences[k]
    return loss

"""Distribution of the material of a broken asperity (Section 3 of the paper).

The eight neighbours of a cell are in the order (-1,-1) (-1,0) (-1,1) (0,-1) (0,1) (1,-1) (1,0)
(1,1) of (y, x) offsets. One outside the grid has infinite height, so that it receives no gouge.
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
    """Return the upper wall's share if a wall without lower neighbours passes its share on."""
    if total_upper == 0.0:
        return 0.0
    if total_lower == 0.0:
        return 1.0
    return share


@kernel
def fall(here, there, tie_tolerance):
    """Return the height difference to a neighbour if it is lower, otherwise 0 [m]."""
    drop = here - there
    return drop if drop > tie_tolerance else 0.0


@kernel
def drops(height, neighbours, tie_tolerance, out):
    """Compute height differences (8,) [m] to lower neighbours, 0 for others: sum and smallest."""
    least = math.inf
    for k in range(8):
        out[k] = fall(height, neighbours[k], tie_tolerance)
        least = min(least, out[k] if out[k] > 0.0 else math.inf)
    total = ((out[0] + out[1]) + (out[2] + out[3])) + ((out[4] + out[5]) + (out[6] + out[7]))
    return total, least


@kernel
def shed(neighbours, loss, differences, total, least):
    """Distribute the loss [m] of a cell on its lower neighbours (8,), in proportion to the drop.

    Return the loss, limited so that no neighbour is raised above the lowered cell.
    """
    if loss * (total + least) > least * total:
        rate = least / (total + least)
        loss = rate * total
    else:
        rate = loss / total
    for k in range(8):
        neighbours[k] += rate * differences[k]
    return loss

"""Where the material of a broken asperity goes (Section 3 of the paper).

All kernels work on one wall's cell and its eight neighbours in the order
(-1,-1) (-1,0) (-1,1) (0,-1) (0,1) (1,-1) (1,0) (1,1) of (y, x) offsets; a
neighbour outside the grid has infinite height, so that nothing flows there.
"""

import math

from jointclosure.compilation import kernel


@kernel
def upper_share(upper_curvature, lower_curvature):
    """Share of the upper wall in a height reduction.

    The sharper asperity loses more: (1/R_t) / (1/R_t + 1/R_b), a half where
    both are flat.
    """
    total = upper_curvature + lower_curvature
    if total == 0.0:
        return 0.5
    return upper_curvature / total


@kernel
def drops(height, neighbours, tie_tolerance, out):
    """Height differences to the lower neighbours, and what may be shed to them.

    Parameters
    ----------
    height : float
        Height of the cell [m].
    neighbours : array (8,)
        Heights of its neighbours [m].
    tie_tolerance : float
        Differences up to this do not count as lower [m].
    out : array (8,)
        Receives the differences [m], 0 for neighbours that are not lower.

    Returns
    -------
    total, largest_loss : float
        Sum of the differences [m], and the largest loss of the cell that
        lifts no neighbour above it [m]; both 0 for a confined cell.
    """
    least = math.inf
    for k in range(8):
        drop = height - neighbours[k]
        drop = drop if drop > tie_tolerance else 0.0
        out[k] = drop
        least = min(least, drop if drop > 0.0 else math.inf)
    total = ((out[0] + out[1]) + (out[2] + out[3])) + ((out[4] + out[5]) + (out[6] + out[7]))
    if total == 0.0:
        return 0.0, 0.0
    return total, least * total / (total + least)


@kernel
def spread(neighbours, loss, differences, total):
    """Lay the loss of a cell on its lower neighbours, in proportion to the drop.

    Parameters
    ----------
    neighbours : array (8,)
        Heights [m], lifted in place.
    loss : float
        Height that the cell lost [m].
    differences, total
        As from `drops`.
    """
    rate = loss / total
    for k in range(8):
        neighbours[k] += rate * differences[k]

"""Where the material of a broken asperity goes (Section 3 of the paper).

All kernels work on one wall's cell and its eight neighbours in the order
(-1,-1) (-1,0) (-1,1) (0,-1) (0,1) (1,-1) (1,0) (1,1) of (y, x) offsets; a
neighbour outside the grid has infinite height, so that nothing flows there.
"""

import math

from jointclosure.compilation.kernels import kernel


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
def passed_share(share, total_upper, total_lower):
    """Share of the upper wall where a wall without lower neighbours passes its on.

    Parameters
    ----------
    share : float
        As from `upper_share`.
    total_upper, total_lower : float
        As from `drops`; a pair with both 0 is locked and does not break.
    """
    if total_upper == 0.0:
        return 0.0
    if total_lower == 0.0:
        return 1.0
    return share


@kernel
def fall(here, there, tie_tolerance):
    """Height difference to a neighbour if it is lower, else 0 [m]."""
    drop = here - there
    return drop if drop > tie_tolerance else 0.0


@kernel
def drops(height, neighbours, tie_tolerance, out):
    """Height differences to the lower neighbours.

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
    total, least : float
        Sum of the differences and the smallest of them [m]; 0 and infinite
        for a cell without a lower neighbour.
    """
    least = math.inf
    for k in range(8):
        out[k] = fall(height, neighbours[k], tie_tolerance)
        least = min(least, out[k] if out[k] > 0.0 else math.inf)
    total = ((out[0] + out[1]) + (out[2] + out[3])) + ((out[4] + out[5]) + (out[6] + out[7]))
    return total, least


@kernel
def shed(neighbours, loss, differences, total, least):
    """Lay the loss of a cell on its lower neighbours, in proportion to the drop.

    Parameters
    ----------
    neighbours : array (8,)
        Heights [m], lifted in place.
    loss : float
        Height that the cell is to lose [m], positive.
    differences, total, least
        As from `drops`, total positive.

    Returns
    -------
    float
        The loss, cut so that no neighbour is lifted above the lowered cell:
        the closest one, ``least`` below, then ends level with it [m].
    """
    if loss * (total + least) > least * total:
        rate = least / (total + least)
        loss = rate * total
    else:
        rate = loss / total
    for k in range(8):
        neighbours[k] += rate * differences[k]
    return loss

"""Distribution of the material of a broken asperity (Section 3 of the paper).

All kernels work on a cell of one wall and its eight neighbours in the order (-1,-1) (-1,0) (-1,1)
(0,-1) (0,1) (1,-1) (1,0) (1,1) of (y, x) offsets. A neighbour outside the grid has infinite height,
so that it receives no gouge.
"""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def upper_share(upper_curvature, lower_curvature):
    """Compute the share of the upper wall in a height reduction.

    The sharper asperity loses more: (1/R_t) / (1/R_t + 1/R_b), a half if both are flat.
    """
    total = upper_curvature + lower_curvature
    if total == 0.0:
        return 0.5
    return upper_curvature / total


@kernel
def passed_share(share, total_upper, total_lower):
    """Return the upper wall's share if a wall without lower neighbours passes its share on.

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
    """Return the height difference to a neighbour if it is lower, otherwise 0 [m]."""
    drop = here - there
    return drop if drop > tie_tolerance else 0.0


@kernel
def drops(height, neighbours, tie_tolerance, out):
    """Compute height differences to the lower neighbours.

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
    """Distribute the loss of a cell on its lower neighbours, in proportion to the drop.

    Parameters
    ----------
    neighbours : array (8,)
        Heights [m], raised in place.
    loss : float
        Height that the cell should lose [m], positive.
    differences, total, least
        As from `drops`, total positive.

    Returns
    -------
    float
        The loss [m], limited so that no neighbour is raised above the lowered cell:
        at the limit the closest one, ``least`` below, is level with it.
    """
    if loss * (total + least) > least * total:
        rate = least / (total + least)
        loss = rate * total
    else:
        rate = loss / total
    for k in range(8):
        neighbours[k] += rate * differences[k]
    return loss

"""Curvature of an asperity, from the heights of a cell and its neighbours."""

import math

from jointclosure.compilation import kernel


@kernel
def gaussian_curvature(west, east, south, north, here, spacing):
    """Inverse of the Gaussian radius of an asperity, 1/R = sqrt(1/(Rx Ry)).

    Parameters
    ----------
    west, east, south, north, here : float
        Heights of the four edge neighbours and of the cell [m].
    spacing : float
        Grid spacing h [m].

    Returns
    -------
    float
        1/R_at or 1/R_ab [1/m]; 0 where either profile is straight.

    Notes
    -----
    Eqs. (1) and (2) in curvatures: those of the circles through three points in x
    and y by Menger's formula, 4 area / (product of the sides), under one root, as
    this is the innermost operation of the breakage loop. The size of a curvature
    counts and not its side: a valley is treated as the peak that mirrors it (choice
    ``concave: magnitude``, docs/decisions/0002-curvature.md).
    """
    area = spacing * spacing
    second_differences = abs((west - here) + (east - here)) * abs((south - here) + (north - here))
    x_sides = (
        (area + (here - west) ** 2)
        * (area + (east - here) ** 2)
        * (area + 0.25 * (east - west) ** 2)
    )
    y_sides = (
        (area + (here - south) ** 2)
        * (area + (north - here) ** 2)
        * (area + 0.25 * (north - south) ** 2)
    )
    return math.sqrt(area * second_differences / math.sqrt(x_sides * y_sides))

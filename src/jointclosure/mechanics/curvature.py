"""Curvature of an asperity, from the heights of a cell and its neighbours."""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def gaussian_curvature(west, east, south, north, here, concave, spacing):
    """Compute the inverse of the Gaussian radius of an asperity [1/m], 1/R = sqrt(1/(Rx Ry)).

    Heights are those of the four edge neighbours and of the cell [m]. ``concave`` is the weight of
    a concave profile: 1 as a convex one of the same size, 0 as a straight one. The result is 0 if
    either profile is straight, or counts as straight.

    Eqs. (1) and (2) in curvatures: those of the circles through three points in x
    and y by Menger's formula, 4 area / (product of the sides). Both are under one root,
    because this is the innermost operation of the breakage loop. A valley has the
    curvature of the mirrored peak, times the weight of the choice ``concave``:
    "magnitude" is 1 and "flat" 0 (docs/decisions.md#0002-curvature).
    """
    area = spacing * spacing
    second_x = (west - here) + (east - here)
    second_y = (south - here) + (north - here)
    weight = (concave if second_x > 0.0 else 1.0) * (concave if second_y > 0.0 else 1.0)
    second_differences = abs(second_x) * abs(second_y) * weight
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

"""Curvature of an asperity, from the heights of a cell and its neighbours."""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def gaussian_curvature(west, east, south, north, here, concave, spacing):
    """Compute the inverse of the Gaussian radius of an asperity [1/m], 1/R = sqrt(1/(Rx Ry)).

    The heights [m] of a cell (``here``) and of its four edge neighbours make two profiles, along x
    and along y, at a ``spacing`` [m]. ``concave`` is the weight of a concave profile: with 1 a
    valley has the curvature of the mirrored peak (the choice "magnitude"), with 0 it counts as
    straight ("flat"). The result is 0 if either profile is straight, or counts as straight.

    These are Eqs. (1) and (2), written with curvatures instead of radii. The curvature of a profile
    is that of the circle through its three points by Menger's formula, 4 area / (product of the
    sides). Both curvatures are under one root, because this is the innermost operation of the
    breakage loop. See docs/decisions.md#0002-curvature.
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

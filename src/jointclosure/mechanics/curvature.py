"""Curvature of an asperity, from the heights of a cell and its neighbours."""

import math

from jointclosure.compilation import kernel


@kernel
def profile_curvature(before, here, after, spacing):
    """Size of the curvature of the circle through three neighbouring points.

    Parameters
    ----------
    before, here, after : float
        Heights at ``-spacing``, 0 and ``+spacing`` [m].
    spacing : float
        Grid spacing h [m].

    Returns
    -------
    float
        Curvature [1/m]; 0 for collinear points.

    Notes
    -----
    Menger's formula, 4 area / (product of the sides). A valley has the curvature of the
    peak that mirrors it; what it counts is a choice, see `gaussian_curvature`.
    """
    bend = abs((before - here) + (after - here))
    sides = (
        math.sqrt(spacing**2 + (here - before) ** 2)
        * math.sqrt(spacing**2 + (after - here) ** 2)
        * math.sqrt(4.0 * spacing**2 + (after - before) ** 2)
    )
    return 2.0 * spacing * bend / sides


@kernel
def gaussian_curvature(west, east, south, north, here, concave, spacing):
    """Inverse of the Gaussian radius of an asperity, 1/R = sqrt(1/(Rx Ry)).

    Parameters
    ----------
    west, east, south, north, here : float
        Heights of the four edge neighbours and of the cell [m].
    concave : float
        What a concave profile counts: 1 as a convex one of its size, 0 as a straight one.
    spacing : float
        Grid spacing h [m].

    Returns
    -------
    float
        1/R_at or 1/R_ab [1/m]; 0 where either profile is straight, or counts as such.

    Notes
    -----
    Eqs. (1) and (2) in curvatures, with `profile_curvature` in x and y under
    one root: this is the innermost operation of the breakage loop. Choice ``concave``:
    "magnitude" is 1 and "flat" 0 (docs/decisions/0002-curvature.md).
    """
    area = spacing * spacing
    x_bend, y_bend = (west - here) + (east - here), (south - here) + (north - here)
    weight = (concave if x_bend > 0.0 else 1.0) * (concave if y_bend > 0.0 else 1.0)
    bend = abs(x_bend) * abs(y_bend) * weight
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
    return math.sqrt(area * bend / math.sqrt(x_sides * y_sides))

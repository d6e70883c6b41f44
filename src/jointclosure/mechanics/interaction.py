"""Displacement of neighbours by a loaded asperity, Eqs. (17) to (20)."""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def far_field_factor(ratio):
    """Compute the displacement by a Hertz pressure over that by a point force, E* pi zeta u / F.

    ``ratio`` is r/zeta, the base radius over the distance, from 0 to 1. The result is 1 far away,
    and 3 pi/8 at the rim of the loaded base.

    Eqs. (17) and (18) (Johnson 1985, Eq. 3.42b) with Eqs. (19) and (20) are the hypergeometric
    series 2F1(1/2, 1/2; 5/2; (r/zeta)^2). The series is used up to r/zeta = 0.9, because all its
    terms are positive, while the printed form subtracts nearly equal numbers far away. Beyond 0.9
    the printed form is used, in which 1 - (r/zeta)^2 is written as a product, because near the rim
    its rounding would cost three digits.
    """
    square = ratio * ratio
    if ratio > 0.9:
        beyond = math.sqrt((1.0 - ratio) * (1.0 + ratio))
        bracket = (2.0 * square - 1.0) * math.asin(ratio) + ratio * beyond
        return 0.75 * bracket / (square * ratio)
    term = 1.0
    total = 1.0
    n = 0.0
    while term > 1e-17 * total:
        term *= (n + 0.5) ** 2 / ((n + 2.5) * (n + 1.0)) * square
        total += term
        n += 1.0
    return total


@kernel
def interaction_displacement(distance, base_radius, equivalent_modulus):
    """Compute the sum of both half-spaces' displacements per unit force [m/N], Eqs. (17) to (20).

    It is the displacement at a distance zeta [m], at least the base radius r [m], from the centre
    of the loaded base. ``equivalent_modulus`` is 1/(1/E_t* + 1/E_b*) [Pa] of the rock of both
    walls.
    """
    return far_field_factor(base_radius / distance) / (math.pi * equivalent_modulus * distance)

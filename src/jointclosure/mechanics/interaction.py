"""Displacement of neighbours by a loaded asperity, Eqs. (17) to (20)."""

import math

from jointclosure.compilation.kernels import kernel


@kernel
def far_field_factor(ratio):
    """Compute the displacement by a Hertz pressure over that by a point force, E* pi zeta u / F.

    The ratio is r/zeta, base radius over distance; the result 1 far away, 3 pi/8 at the rim.

    Eqs. (17) and (18) (Johnson 1985, Eq. 3.42b) with Eqs. (19) and (20) are
    the hypergeometric series 2F1(1/2, 1/2; 5/2; (r/zeta)^2). The printed form
    subtracts nearly equal numbers far away, and the series has positive terms only.
    Therefore the series is used up to r/zeta = 0.9 and the printed form above. There
    1 - (r/zeta)^2 is written as a product, because near the rim its rounding would
    cost three digits.
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
    """Compute the approach of both half-spaces per unit force [m/N], Eqs. (17) to (20).

    The distance zeta [m] is at least the base radius r [m]; the modulus [Pa] is that of the rock.
    """
    return far_field_factor(base_radius / distance) / (math.pi * equivalent_modulus * distance)

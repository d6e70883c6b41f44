"""One pair of asperities on its substrates: Hertz contact, Eqs. (3) to (12).

The paper solves for the asperity deformation delta_a and prints a cubic,
Eq. (13), with the wrong sign under its root. Here the force is the unknown,

    A F + B F^(2/3) = delta_S,

with the compliance A of the substrates (0 without) and B of the asperities.
It has one positive root for every delta_S > 0 and stays regular for flat
contacts (B = 0) and without substrate (A = 0). See
docs/decisions/0001-contact-cubic.md.
"""

import math

import numpy as np

from jointclosure.compilation import kernel


@kernel
def cube_root(value):
    """Cube root that scales exactly: that of 8 x is twice that of x, to the last bit.

    Numba's own is a power of 1/3, which does not; so a joint whose lengths or
    moduli are multiplied by a power of 64 would not have the same history.
    """
    mantissa, exponent = math.frexp(value)
    third = exponent // 3
    return math.ldexp(np.cbrt(mantissa * float(1 << (exponent - 3 * third))), third)


@kernel
def plane_strain_modulus(youngs_modulus, poisson_ratio):
    """E* = E / (1 - nu^2) of one wall [Pa], as used in Eqs. (6) and (7)."""
    return youngs_modulus / (1.0 - poisson_ratio**2)


@kernel
def equivalent_modulus(upper_modulus, lower_modulus):
    """E_a* [Pa] of two walls from their plane-strain moduli [Pa], Eq. (4)."""
    return 1.0 / (1.0 / upper_modulus + 1.0 / lower_modulus)


@kernel
def substrate_compliance(base_radius, equivalent_modulus):
    """A = (delta_t + delta_b) / F [m/N] of both substrates, Eqs. (6) and (7).

    Parameters
    ----------
    base_radius : float
        Radius r of the asperities' bases [m].
    equivalent_modulus : float
        1 / (1/E_t* + 1/E_b*) of the rock, not of its peaks [Pa].
    """
    return 0.75 / (base_radius * equivalent_modulus)


@kernel
def asperity_compliance(curvature, asperity_modulus):
    """B = delta_a / F^(2/3) [m N^(-2/3)] of the asperities, Eq. (5) inverted.

    Parameters
    ----------
    curvature : float
        kappa_a = 1/R_a = 1/R_at + 1/R_ab [1/m], Eq. (3).
    asperity_modulus : float
        E_a* of Eq. (4) [Pa].
    """
    return cube_root(9.0 * curvature / (16.0 * asperity_modulus * asperity_modulus))


@kernel
def overlap_of_force(force, substrate, asperity):
    """delta_S [m] under a force F >= 0 [N], Eqs. (5) to (10)."""
    root = cube_root(force)
    return substrate * force + asperity * root * root


@kernel
def force_of_overlap(overlap, substrate, asperity):
    """Force of one contact and its slope at a given overlap, Eqs. (10) to (12).

    Parameters
    ----------
    overlap : float
        delta_S [m]; no contact where it is not positive.
    substrate, asperity : float
        Compliances A [m/N] and B [m N^(-2/3)].

    Returns
    -------
    force, slope : float
        F [N] and dF/d(delta_S) [N/m]. Both are infinite for a rigid contact
        (A = B = 0), which the callers refuse.

    Notes
    -----
    With t = F^(1/3), f(t) = A t^3 + B t^2 - delta_S is convex for t > 0 and
    has one root, bounded from above by the root without either term: Newton
    from there falls onto it monotonically, in five steps at most.
    """
    if not overlap > 0.0:
        return 0.0, 0.0
    if substrate == 0.0:
        if asperity == 0.0:
            return math.inf, math.inf
        t = math.sqrt(overlap / asperity)
        return t * t * t, 1.5 * t / asperity
    t = cube_root(overlap / substrate)
    if asperity > 0.0:
        t = min(t, math.sqrt(overlap / asperity))
        for _ in range(20):
            excess = (substrate * t + asperity) * t * t - overlap
            shorter = t - excess / ((3.0 * substrate * t + 2.0 * asperity) * t)
            if not shorter < t:
                break
            t = shorter
    return t * t * t, 3.0 * t / (3.0 * substrate * t + 2.0 * asperity)

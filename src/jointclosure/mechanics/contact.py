"""Hertz contact of one pair of asperities on their substrates, Eqs. (3) to (12).

The paper prints a cubic, Eq. (13), with the wrong sign under its root. Here the force F is the
unknown of A F + B F^(2/3) = delta_S, with the compliance A of the substrates and B of the
asperities. This equation has one positive root for every delta_S > 0, also if either A or B is 0.
See docs/decisions.md#0001-contact-cubic. In the functions below ``substrate`` is A [m/N],
``asperity`` is B [m N^(-2/3)], and ``overlap`` is delta_S [m].
"""

import math

import numpy as np

from jointclosure.compilation.kernels import kernel

_MANTISSA = (1 << 52) - 1
"""Bits of the mantissa of a double."""
MOST_ROOT_STEPS = 20
"""Number of Newton steps after which F^(1/3) is taken as it is; at most five are needed."""
_ROOT_OF_2 = 1.2599210498948732
"""Cube root of 2."""
_ROOT_OF_4 = 1.5874010519681996
"""Cube root of 4."""
_LEAST_NORMAL = 2.0**-1022
"""Smallest number with a full mantissa; smaller ones are scaled by `_UP`, and their root back."""
_UP = 2.0**54
_DOWN = 2.0**-18
"""Inverse of the cube root of `_UP`."""


@kernel
def cube_root(x):
    """Compute x^(1/3), x >= 0, so that the result for 8^k x is exactly 2^k times as large.

    A joint scaled by a power of 64 therefore breaks identically. For the mantissa m, from 1/2 to 1,
    the start u(m) and the step of third order u (u^3 + 2 m) / (2 u^3 + m) are those of the GNU C
    library (s_cbrt.c, version 2.36). The result is correct to one unit in the last place; 0,
    infinity and NaN are returned as they are. The operations are written out here, without a call
    of a library, so that the result has the same bits on every machine.
    """
    # without a branch or a call, so that loops over many numbers become vector code
    small = x < _LEAST_NORMAL
    bits = np.float64(x * _UP if small else x).view(np.int64)
    exponent = ((bits >> 52) & 2047) - 1022
    m = np.int64((bits & _MANTISSA) | (1022 << 52)).view(np.float64)
    u = 1.508191937815849 - (2.114994941673713 - (2.4469312256353444 - (
        1.8346927748361308 - (0.7849323449766392 - 0.14526389938548637 * m) * m
    ) * m) * m) * m  # fmt: skip
    u = 0.35489576504391984 + u * m
    cube = u * u * u
    third = (((exponent + 1074) * 21846) >> 16) - 358  # a third, rounded down
    part = exponent - 3 * third
    factor = 1.0 if part == 0 else (_ROOT_OF_2 if part == 1 else _ROOT_OF_4)
    root = u * (cube + 2.0 * m) / (2.0 * cube + m) * factor
    root *= np.int64((third + 1023) << 52).view(np.float64)
    root = root * _DOWN if small else root
    return root if 0.0 < x < math.inf else x


@kernel
def plane_strain_modulus(youngs_modulus, poisson_ratio):
    """Compute E* = E / (1 - nu^2) [Pa] of one wall from its E [Pa], as used in Eqs. (6) and (7)."""
    return youngs_modulus / (1.0 - poisson_ratio**2)


@kernel
def equivalent_modulus(upper_modulus, lower_modulus):
    """Compute the modulus E_a* [Pa] of two walls from their plane-strain moduli [Pa], Eq. (4)."""
    return 1.0 / (1.0 / upper_modulus + 1.0 / lower_modulus)


@kernel
def substrate_compliance(base_radius, equivalent_modulus):
    """Compute the compliance A = (delta_t + delta_b) / F [m/N] of both substrates, Eqs. (6), (7).

    ``base_radius`` is r [m], ``equivalent_modulus`` is 1/(1/E_t* + 1/E_b*) [Pa].
    """
    return 0.75 / (base_radius * equivalent_modulus)


@kernel
def asperity_compliance(curvature, asperity_modulus):
    """Compute the compliance B = delta_a / F^(2/3) [m N^(-2/3)] of asperities, Eqs. (3) and (5).

    ``curvature`` is kappa_a = 1/R_a [1/m], ``asperity_modulus`` is E_a* [Pa].
    """
    return cube_root(9.0 * curvature / (16.0 * asperity_modulus * asperity_modulus))


@kernel
def overlap_of_force(force, substrate, asperity):
    """Compute the overlap delta_S [m] of a contact under a force F >= 0 [N], Eqs. (5) to (10)."""
    root = cube_root(force)
    return substrate * force + asperity * root * root


@kernel
def force_of_overlap(overlap, substrate, asperity):
    """Compute the force F [N] of one contact and dF/d(delta_S) [N/m], Eqs. (10) to (12).

    Both are 0 unless the overlap delta_S [m] is positive. Both are infinite for a rigid contact,
    with compliances A = B = 0, which callers refuse. With t = F^(1/3), the function f(t) = A t^3 +
    B t^2 - delta_S is convex for t > 0 and has one root. The roots without one of the two terms are
    upper bounds. Newton's method converges monotonically from the smaller one, in at most five
    steps.
    """
    t, exact = bound_by_terms(overlap, substrate, asperity)
    for _ in range(MOST_ROOT_STEPS):
        if exact:
            break
        t, exact = shorter_root(overlap, substrate, asperity, t)
    return force_of_root(t, substrate, asperity)


@kernel
def bound_by_terms(overlap, substrate, asperity):
    """Return an upper bound of the root F^(1/3), and whether the bound is the root itself.

    The equation is that of `force_of_overlap`. The bound is the smaller root of A t^3 = delta_S and
    B t^2 = delta_S. It is the root if A or B is 0; it is infinite if both are 0. Unless the overlap
    is positive, the root is 0.
    """
    if not overlap > 0.0:
        return 0.0, True
    if asperity == 0.0:
        return (cube_root(overlap / substrate) if substrate > 0.0 else math.inf), True
    t = math.sqrt(overlap / asperity)
    if substrate * t * t * t > overlap:
        t = cube_root(overlap / substrate)  # the smaller of both bounds
    return t, substrate == 0.0


@kernel
def bound_by_guess(overlap, substrate, asperity, guess):
    """Return F^(1/3) after one Newton step from ``guess``, and whether it is an upper bound.

    The equation is that of `force_of_overlap`, which is convex: a step from any positive t ends at
    or above the root. The result counts as an upper bound only if the ``guess`` is positive (0
    stands for no guess), if B > 0, and if the result is between 3/4 of the guess and twice the
    guess.
    """
    t = newton_root(overlap, substrate, asperity, guess)
    is_bound = (guess > 0.0) & (asperity > 0.0) & (0.75 * guess < t) & (t < 2.0 * guess)
    return t, is_bound


@kernel
def newton_root(overlap, substrate, asperity, t):
    """Return F^(1/3) after one Newton step from ``t`` > 0, see `force_of_overlap`."""
    excess = (substrate * t + asperity) * t * t - overlap
    return t - excess / ((3.0 * substrate * t + 2.0 * asperity) * t)


@kernel
def shorter_root(overlap, substrate, asperity, t):
    """Return a bound of F^(1/3) one Newton step below a bound ``t``, and whether it is the root.

    ``t`` is an upper bound of the root of `force_of_overlap`, and so is the result. Where the step
    would not lower the bound, because of rounding, ``t`` itself is returned as the root.
    """
    shorter = newton_root(overlap, substrate, asperity, t)
    falls = shorter < t
    # after so small a step the next step would change at most the last digit
    return (shorter if falls else t), (not falls) | (t - shorter < 1e-9 * t)


@kernel
def force_of_root(t, substrate, asperity):
    """Return the force F = t^3 [N] and its slope dF/d(delta_S) [N/m] for a root t = F^(1/3).

    Force and slope are both 0 for t = 0, and both infinite for t = infinity.
    """
    # selections and not branches, so that loops over many contacts become vector code
    force = t * t * t
    slope = 3.0 * t / (3.0 * substrate * t + 2.0 * asperity)
    zero_or_infinite = (t == 0.0) | (t == math.inf)
    return (t if zero_or_infinite else force), (t if zero_or_infinite else slope)

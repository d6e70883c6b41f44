"""Strength of one pair of asperities, Eqs. (21) to (23).

These functions are for one pair, as the reference solver calls them. The default solver has the
same equations for batches of pairs in `jointclosure.solvers.pair_batch`.
"""

import math

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import cube_root


@kernel
def von_mises_on_axis(depth, poisson_ratio):
    """Compute the equivalent stress over p0 at a depth z/a under a Hertz pressure, Eq. (21)."""
    angle = math.atan2(1.0, depth)
    return 1.5 / (1.0 + depth**2) - (1.0 + poisson_ratio) * (1.0 - depth * angle)


@kernel
def strength_factor(poisson_ratio):
    """Compute c(nu) = sigma_V,max / p0 by Eq. (23), the paper's fit to Eq. (21)."""
    return 0.1251 * poisson_ratio**2 - 0.536 * poisson_ratio + 0.7695


@kernel
def critical_indentation(pressure_limit, asperity_modulus):
    """Compute the indentation ratio q = delta_break / R_a at which p0_a reaches its limit [Pa].

    From Eq. (22), p0_a = 2/pi E_a* sqrt(delta_a / R_a). The limit is the smaller sigma_c / c(nu) of
    the two walls.
    """
    return (0.5 * math.pi * pressure_limit / asperity_modulus) ** 2


@kernel
def bounded_strength(curvature, critical, filling):
    """Return the curvature [1/m] and q with which the strength of a contact is computed.

    They are ``curvature`` and ``critical`` unless the curvature is below ``filling`` [1/m], at
    which the contact fills its base when it breaks. The force at breakage is then bounded by that
    at the curvature ``filling``: delta_break = q/filling (kappa/filling)^(1/3), as the indentation
    by a given force goes with kappa^(1/3). ``filling`` is 0 without a bound.
    """
    part = cube_root(curvature / (filling if filling > 0.0 else 1.0))
    whole = curvature >= filling
    return curvature if whole else filling, critical if whole else critical * part


@kernel
def is_overstressed(overlap, curvature, critical, breaking_force, substrate, filling):
    """Return whether a pair at overlap delta_S [m] exceeds its strength, Eqs. (5), (10), (22).

    ``critical`` is q of `critical_indentation`, ``breaking_force`` 4/3 E_a* q^(3/2) [Pa].
    delta_break = q/kappa and F_break = 4/3 E_a* q^(3/2)/kappa^2 give the overlap at breakage.
    Multiplied by kappa^2 the condition needs neither root nor division, and a flat contact (kappa =
    0) never breaks, unless strength is bounded.
    """
    kappa, indentation = bounded_strength(curvature, critical, filling)
    return overlap * kappa * kappa > indentation * kappa + substrate * breaking_force

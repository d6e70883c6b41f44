"""Strength of one pair of asperities, Eqs. (21) to (23).

These functions are for one pair, as the reference solver calls them. The default solver has the
same equations for batches of pairs in `jointclosure.solvers.pair_batch`.
"""

import math

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import cube_root


@kernel
def von_mises_on_axis(depth, poisson_ratio):
    """Compute the equivalent stress under a Hertz pressure over its maximum p0 [1], Eq. (21).

    ``depth`` is z/a, the depth on the axis over the radius a of the contact.
    """
    angle = math.atan2(1.0, depth)
    return 1.5 / (1.0 + depth**2) - (1.0 + poisson_ratio) * (1.0 - depth * angle)


@kernel
def strength_factor(poisson_ratio):
    """Compute c(nu) = sigma_V,max / p0 by Eq. (23), the paper's fit to Eq. (21)."""
    return 0.1251 * poisson_ratio**2 - 0.536 * poisson_ratio + 0.7695


@kernel
def critical_indentation(pressure_limit, asperity_modulus):
    """Compute q = delta_break / R_a [1], the indentation ratio at which an asperity breaks.

    It breaks where the largest pressure p0_a = 2/pi E_a* sqrt(delta_a / R_a), Eq. (22), reaches
    ``pressure_limit`` [Pa], the smaller sigma_c / c(nu) of the two walls. ``asperity_modulus`` is
    E_a* [Pa].
    """
    return (0.5 * math.pi * pressure_limit / asperity_modulus) ** 2


@kernel
def bounded_strength(curvature, critical, filling):
    """Return the curvature [1/m] and the ratio q with which the strength of a contact is computed.

    They are ``curvature`` kappa and ``critical`` q (`critical_indentation`), unless kappa is below
    ``filling`` [1/m]. At the curvature ``filling`` a contact fills its base when it breaks, and the
    force at breakage is bounded by the force of such a contact. For a smaller kappa the returned
    curvature is therefore ``filling``, and the returned q is q (kappa/filling)^(1/3), because the
    indentation by a given force goes with kappa^(1/3). ``filling`` is 0 without a bound.
    """
    part = cube_root(curvature / (filling if filling > 0.0 else 1.0))
    whole = curvature >= filling
    return curvature if whole else filling, critical if whole else critical * part


@kernel
def is_overstressed(overlap, curvature, critical, breaking_force, substrate, filling):
    """Return whether a contact with overlap delta_S [m] exceeds its strength, Eqs. (5), (10), (22).

    ``curvature`` is kappa [1/m], ``critical`` q of `critical_indentation`, ``breaking_force`` 4/3
    E_a* q^(3/2) [Pa], ``substrate`` the compliance A [m/N], and ``filling`` as in
    `bounded_strength`. The overlap at breakage is delta_break + A F_break, with delta_break =
    q/kappa and F_break = 4/3 E_a* q^(3/2)/kappa^2. The condition is multiplied by kappa^2, so that
    it needs neither root nor division. A flat contact, with kappa = 0, then never breaks, unless
    its strength is bounded.
    """
    kappa, indentation = bounded_strength(curvature, critical, filling)
    return overlap * kappa * kappa > indentation * kappa + substrate * breaking_force

"""Contact law of two rocks on a grid, from the equations of the model."""

from typing import NamedTuple

import numpy as np

from jointclosure.mechanics.contact import (
    equivalent_modulus,
    plane_strain_modulus,
    substrate_compliance,
)
from jointclosure.mechanics.strength import critical_indentation, strength_factor
from jointclosure.parameters import Choices, Effects, Rock


class ContactLaw(NamedTuple):
    """Constants of the contacts of all pairs of cells, derived from rock, choices and grid.

    The arrays have eight entries, one for each state of a pair of cells. The index of a state is 4
    x (its rock was crushed before this loading) + 2 x (the upper cell is a peak) + (the lower cell
    is a peak).
    """

    spacing: float  # h [m]
    base_radius: float  # r [m]
    least_curvature: float  # lower bound for a wall's cells [1/m]: 1 / largest radius, or 0
    concave: float  # weight of a concave profile's curvature: 1 as for a convex one, or 0
    substrate_modulus: float  # 1/(1/E_t* + 1/E_b*) [Pa]
    substrate: float  # compliance A [m/N], 0 without substrate
    asperity_modulus: np.ndarray  # E_a* [Pa], Eq. (4)
    critical_indentation: np.ndarray  # q = delta_break/R_a, Eq. (22)
    breaking_force: np.ndarray  # 4/3 E_a* q^(3/2) [Pa]
    filling: np.ndarray  # curvature [1/m] below which the base bounds the strength; 0: no bound


def contact_law(
    spacing: float, rock: tuple[Rock, Rock], effects: Effects, choices: Choices
) -> ContactLaw:
    """Compute the contact law of the rocks (upper, lower) on a grid of a spacing [m].

    The strength is that of the weaker wall.
    """
    moduli = [plane_strain_modulus(wall.youngs_modulus, wall.poisson_ratio) for wall in rock]
    ratio = choices.peak_modulus_ratio if effects.soft_peaks else 1.0
    softness = [(1.0, 1.0), (1.0, ratio), (ratio, 1.0), (ratio, ratio)]
    asperity_modulus = np.array(
        [equivalent_modulus(moduli[0] * upper, moduli[1] * lower) for upper, lower in softness]
    )
    limit = min(wall.compressive_strength / strength_factor(wall.poisson_ratio) for wall in rock)
    asperity_modulus = np.tile(asperity_modulus, 2)
    limits = np.repeat([limit, limit * choices.crushed_strength_ratio], 4)
    critical = np.array(list(map(critical_indentation, limits, asperity_modulus)))
    substrate_modulus = equivalent_modulus(*moduli)
    base_radius = choices.base_radius_in_cells * spacing
    bounded = choices.strength_bound == "base" and limit < np.inf
    return ContactLaw(
        spacing=float(spacing),
        base_radius=float(base_radius),
        least_curvature=1.0 / choices.largest_radius if choices.largest_radius else 0.0,
        concave=1.0 if choices.concave == "magnitude" else 0.0,
        substrate_modulus=float(substrate_modulus),
        substrate=float(substrate_compliance(base_radius, substrate_modulus))
        if effects.substrate
        else 0.0,
        asperity_modulus=asperity_modulus,
        critical_indentation=critical,
        breaking_force=4.0 / 3.0 * asperity_modulus * critical * np.sqrt(critical),
        filling=np.sqrt(critical) / base_radius if bounded else np.zeros(8),
    )

"""Elastic joints beside the exact solutions of smooth indenters on a half-space.

A sphere (Hertz 1882), a cone (Sneddon 1965) and a flat cylinder (Boussinesq 1885) are pressed
against a flat wall, in the scene with substrates and interaction, without breakage. Each cell of
the model has an asperity on a base of half a cell. What these add vanishes with the spacing, so
that the force converges to that of the continuum.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from jointclosure.joint.simulation import equilibrium
from jointclosure.parameters import Effects, Rock

ELASTIC = Effects(substrate=True, interaction=True, breakage=False, gouge=False, soft_peaks=False)
ROCK = Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
RADIUS = 1e-3
"""Radius a of the contact [m]."""
MODULUS = 0.5 * ROCK.youngs_modulus / (1.0 - ROCK.poisson_ratio**2)
"""Effective modulus E* of two such walls [Pa]."""
_CURVATURE, _SLOPE, _APPROACH, _DEPTH = 50.0, 0.05, 1e-6, 1e-3


class Solution(NamedTuple):
    """Heights [m] by the distance [m], and closure [m] and force [N] of a contact of `RADIUS`."""

    heights: Callable[[np.ndarray], np.ndarray]
    closure: float
    force: float


_CONE = 0.5 * np.pi * _SLOPE * RADIUS
SOLUTIONS = {
    "sphere": Solution(
        lambda r: -0.5 * _CURVATURE * r**2,
        _CURVATURE * RADIUS**2,
        4.0 / 3.0 * MODULUS * _CURVATURE * RADIUS**3,
    ),
    "cone": Solution(lambda r: -_SLOPE * r, _CONE, 2.0 * MODULUS * _CONE**2 / (np.pi * _SLOPE)),
    "flat punch": Solution(
        lambda r: np.where(r <= RADIUS, 0.0, -_DEPTH),
        _APPROACH,
        2.0 * MODULUS * RADIUS * _APPROACH,
    ),
}
"""Johnson 1985, Eqs. (4.22) to (4.24), (5.10), (3.34) to (3.36)."""


def error_of(solution: Solution, cells: int) -> float:
    """Relative error of the force on a grid of so many cells in `RADIUS`."""
    spacing, reach = RADIUS / cells, cells + cells // 2 + 2
    x = spacing * np.arange(-reach, reach + 1)
    distance = np.hypot(x, x[:, None])
    walls = solution.heights(distance), np.zeros(distance.shape)
    about = {"closure": solution.closure, "effects": ELASTIC, "unusual_values": True}
    result = equilibrium(*walls, spacing=spacing, rock=ROCK, **about)
    assert int(result.status) == 0
    return float(result.force.sum()) / solution.force - 1.0


@pytest.mark.parametrize("name", SOLUTIONS)
def test_elastic_joints_converge_to_the_continuum_with_the_first_power_of_the_spacing(name):
    errors = np.abs([error_of(SOLUTIONS[name], cells) for cells in (8, 16, 32)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert ((orders > 0.9) & (orders < 1.3)).all()
    assert errors[-1] < 0.03

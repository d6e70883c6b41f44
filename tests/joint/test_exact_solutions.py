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
    """Exact solution for a contact of radius a = `RADIUS`; functions of the distance [m] of it."""

    heights: Callable[[np.ndarray], np.ndarray]
    pressure: Callable[[np.ndarray], np.ndarray]  # within a
    closure: float
    force: float


_HERTZ, _CONE = 2.0 * MODULUS * RADIUS * _CURVATURE / np.pi, 0.5 * np.pi * _SLOPE * RADIUS
SOLUTIONS = {
    "sphere": Solution(
        lambda r: -0.5 * _CURVATURE * r**2,
        lambda r: _HERTZ * np.sqrt(1.0 - (r / RADIUS) ** 2),
        _CURVATURE * RADIUS**2,
        4.0 / 3.0 * MODULUS * _CURVATURE * RADIUS**3,
    ),
    "cone": Solution(
        lambda r: -_SLOPE * r,
        lambda r: 0.5 * MODULUS * _SLOPE * np.arccosh(RADIUS / np.maximum(r, 1e-12 * RADIUS)),
        _CONE,
        2.0 * MODULUS * _CONE**2 / (np.pi * _SLOPE),
    ),
    "flat punch": Solution(
        lambda r: np.where(r <= RADIUS, 0.0, -_DEPTH),
        lambda r: MODULUS * _APPROACH / (np.pi * np.sqrt(RADIUS**2 - r**2)),
        _APPROACH,
        2.0 * MODULUS * RADIUS * _APPROACH,
    ),
}
"""Johnson 1985, Eqs. (4.22) to (4.24), (5.10), (3.34) to (3.36)."""


def errors_of(name: str, cells: int) -> tuple[float, float]:
    """Relative errors of force, and of pressures in the middles of cells."""
    solution, spacing = SOLUTIONS[name], RADIUS / cells
    x = spacing * np.arange(-(cells + cells // 2 + 2), cells + cells // 2 + 3)
    distance = np.hypot(x, x[:, None])
    walls = solution.heights(distance), np.zeros(distance.shape)
    result = equilibrium(
        *walls, spacing=spacing, rock=ROCK, closure=solution.closure, effects=ELASTIC,
        unusual_values=True,
    )  # fmt: skip
    assert int(result.status) == 0
    force, inside = result.force.values, distance < RADIUS
    exact = np.zeros(force.shape)
    exact[inside] = spacing**2 * solution.pressure(distance[inside])
    total = float(force.sum())
    return total / solution.force - 1.0, float(np.abs(force - exact).sum()) / solution.force


@pytest.mark.parametrize("name", SOLUTIONS)
def test_elastic_joints_converge_with_the_first_power_of_the_spacing(name):
    force, pressure = zip(*(errors_of(name, cells) for cells in (8, 16, 32)), strict=True)
    orders = np.log2(np.abs(force[:-1]) / np.abs(force[1:]))
    assert ((orders > 0.9) & (orders < 1.3)).all()
    assert (np.diff(pressure) < 0.0).all()
    assert abs(force[-1]) < 0.03

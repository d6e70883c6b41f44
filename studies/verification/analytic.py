"""Elastic joints beside the exact solutions of smooth indenters on a half-space.

A sphere (Hertz 1882), a cone (Sneddon 1965) and a flat cylinder (Boussinesq 1885) are pressed
against a flat wall, in the scene with substrates and interaction, without breakage. Each cell of
the model has an asperity on a base of half a cell. What these add vanishes with the spacing, so
that the force converges to that of the continuum.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from jointclosure.joint.simulation import equilibrium
from jointclosure.parameters import Effects, Rock
from jointclosure.solvers.joint import CONVERGED

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


def errors_of(name: str, cells: int) -> dict[str, float]:
    """Compare force, pressures in the middles of cells, and area with the exact ones, relative."""
    solution, spacing = SOLUTIONS[name], RADIUS / cells
    x = spacing * np.arange(-(cells + cells // 2 + 2), cells + cells // 2 + 3)
    distance = np.hypot(x, x[:, None])
    walls = solution.heights(distance), np.zeros(distance.shape)
    result = equilibrium(
        *walls, spacing=spacing, rock=ROCK, closure=solution.closure, effects=ELASTIC,
        unusual_values=True,
    )  # fmt: skip
    if int(result.status) != CONVERGED:
        raise RuntimeError(f"{name}, {cells} cells: not converged")
    force, inside = result.force.values, distance < RADIUS
    exact = np.zeros(force.shape)
    exact[inside] = spacing**2 * solution.pressure(distance[inside])
    area = np.count_nonzero(force) * spacing**2 / (np.pi * RADIUS**2)
    return {
        "force_error": float(force.sum()) / solution.force - 1.0,
        "pressure_error": float(np.abs(force - exact).sum()) / solution.force,
        "area_error": area - 1.0,
    }


def analytic_table(cells: Sequence[int] = (4, 8, 16, 32)) -> pd.DataFrame:
    """Tabulate the errors of all indenters by grid, and the observed order of the force."""
    rows: list[dict] = []
    for name in SOLUTIONS:
        for place, number in enumerate(cells):
            row = {"indenter": name, "cells": number, **errors_of(name, number), "order": np.nan}
            if place:
                fell = abs(rows[-1]["force_error"] / row["force_error"])
                row["order"] = float(np.log(fell) / np.log(number / cells[place - 1]))
            rows.append(row)
    return pd.DataFrame(rows)


PUBLISHED_FLUXES = {256: 0.0277323297674, 512: 0.0029641494720, 1024: 0.0545516245121}
"""Flux through a unit square by number of cells along a side, for a pressure difference of 1 and a
transmissivity h^3. Its direct and iterative solvers agree to about 1e-10."""
_SEED = 23_349
_CORRELATION = 1 / 48
_MEAN = 0.35


def published_gap(cells: int) -> np.ndarray:
    """Make the gap (cells, cells) of the published fluxes.

    White Gaussian noise, smoothed by a Gaussian whose standard deviation is 1/48 of a side (at
    least a cell) with mirrored ends along the flow (y) and periodic sides, is scaled to a mean of
    0.35 and a standard deviation of 1. Negative gaps are contacts. Unit of the gap: 1.
    """
    noise = np.random.default_rng(_SEED).standard_normal((cells, cells))
    width = max(1.0, _CORRELATION * cells)
    smooth = scipy.ndimage.gaussian_filter(noise, width, mode=("reflect", "wrap"))
    return np.maximum((smooth - smooth.mean()) / smooth.std() + _MEAN, 0.0)

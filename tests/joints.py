"""Joints that several tests close."""

import os
from pathlib import Path

import numpy as np

import jointclosure as jc
from jointclosure.joint.conditions import RESOLVED

DOLERITE = jc.Rock(78e9, 0.2, 165e6)
SPACING = 0.25e-3
ELASTIC = jc.Effects(breakage=False, gouge=False)
COARSE = RESOLVED._replace(tolerance=0.1)
"""Few steps of resolved breakage, for what is not about their error."""
TWO_WALLS = Path(
    os.environ.get("JOINTCLOSURE_TWO_WALLS") or Path(__file__).parents[2] / "shared/data/two_walls"
)
"""Scans of both walls of a fracture, where they are at hand."""


def pair(cells=24, seed=3):
    """Two walls of JRC 8, square or of a shape."""
    shape = (cells, cells) if isinstance(cells, int) else cells
    return jc.wall_pair(8.0, shape, SPACING, seed, roll_off=None)


def _stated(stated):
    """Arguments of `simulate` or `equilibrium`, fields of numerics and choices taken by name."""
    for key, settings in (("numerics", jc.Numerics), ("choices", jc.Choices)):
        fields = {name: stated.pop(name) for name in settings._fields if name in stated}
        stated.setdefault(key, settings(**fields))
    return {"spacing": SPACING, "rock": DOLERITE} | stated


def closed(walls, stress=4e6, **stated):
    """Walls of dolerite closed by `simulate`."""
    return jc.simulate(*walls, **_stated({"max_normal_stress": stress} | stated))


def balanced(walls, closure, **stated):
    """Forces between walls of dolerite by `equilibrium`."""
    return jc.equilibrium(*walls, closure=closure, **_stated(stated))


def on_softer_half_spaces(history, compliance=2e-12):
    """The same joint where half-spaces give way by more, in proportion to the stress [m/Pa]."""
    more = compliance * history.normal_stress
    return history.assign(
        closure=history.closure + more, bulk_indentation=history.bulk_indentation + more
    )


def bump(shape, radius, spacing=SPACING, centre=None):
    """A wall with one parabolic cap of a radius [m] at its centre cell."""
    y, x = np.indices(shape)
    v, w = centre or (shape[0] // 2, shape[1] // 2)
    return -0.5 * spacing**2 * ((y - v) ** 2 + (x - w) ** 2) / radius

"""Joints that several tests simulate."""

import os
from pathlib import Path

import numpy as np

import jointclosure as jc
from jointclosure.joint.conditions import RESOLVED

DOLERITE = jc.Rock(78e9, 0.2, 165e6)
SPACING = 0.25e-3
ELASTIC = jc.Effects(breakage=False, gouge=False)
COARSE = RESOLVED._replace(tolerance=0.1)
"""Resolved breakage with few steps, for tests that do not concern its error."""
TWO_WALLS = Path(
    os.environ.get("JOINTCLOSURE_TWO_WALLS") or Path(__file__).parents[2] / "shared/data/two_walls"
)
"""Folder with scans of both walls of a fracture; it need not exist."""


def pair(cells=24, seed=3):
    """Make two walls of JRC 8, with ``cells`` along each side or of a shape (ny, nx)."""
    shape = (cells, cells) if isinstance(cells, int) else cells
    return jc.wall_pair(8.0, shape, SPACING, seed, roll_off=None)


def _stated(stated):
    """Return arguments of `simulate` or `equilibrium`; numerics and choices take their fields."""
    for key, settings in (("numerics", jc.Numerics), ("choices", jc.Choices)):
        fields = {name: stated.pop(name) for name in settings._fields if name in stated}
        stated.setdefault(key, settings(**fields))
    return {"spacing": SPACING, "rock": DOLERITE} | stated


def closed(walls, stress=4e6, **stated):
    """Close walls of dolerite by `simulate`, to a stress [Pa]."""
    return jc.simulate(*walls, **_stated({"max_normal_stress": stress} | stated))


def balanced(walls, closure, **stated):
    """Find the forces between walls of dolerite at a closure [m] by `equilibrium`."""
    return jc.equilibrium(*walls, closure=closure, **_stated(stated))


def on_softer_half_spaces(history, compliance=2e-12):
    """Return a history with a larger bulk indentation, by ``compliance`` [m/Pa] times stress."""
    more = compliance * history.normal_stress
    return history.assign(
        closure=history.closure + more, bulk_indentation=history.bulk_indentation + more
    )


def bump(shape, radius, spacing=SPACING, centre=None):
    """Make a wall (y, x) [m] with one parabolic cap of a radius [m] at its ``centre`` cell."""
    y, x = np.indices(shape)
    v, w = centre or (shape[0] // 2, shape[1] // 2)
    return -0.5 * spacing**2 * ((y - v) ** 2 + (x - w) ** 2) / radius

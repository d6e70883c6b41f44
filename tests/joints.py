"""Joints that several tests close."""

import os
from pathlib import Path

import numpy as np

import jointclosure as jc

DOLERITE = jc.Rock(78e9, 0.2, 165e6)
SPACING = 0.25e-3
TWO_WALLS = Path(
    os.environ.get("JOINTCLOSURE_TWO_WALLS") or Path(__file__).parents[2] / "shared/data/two_walls"
)
"""Scans of both walls of a fracture, where they are at hand."""


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

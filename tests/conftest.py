"""What all tests share: a rock, a small joint, and fast property testing."""

import hypothesis
import numpy as np
import pytest

import jointclosure as jc

hypothesis.settings.register_profile("default", deadline=None, max_examples=60)
hypothesis.settings.load_profile("default")

DOLERITE = jc.Rock(78e9, 0.2, 165e6)
SPACING = 0.25e-3


@pytest.fixture
def rock():
    return DOLERITE


@pytest.fixture
def small_joint():
    """Two walls of 20 x 24 cells, JRC 8."""
    return jc.wall_pair(8.0, (20, 24), SPACING, seed=3)


def bump(shape, radius, spacing=SPACING, centre=None):
    """A wall with one parabolic cap of a radius [m] at its centre cell."""
    y, x = np.indices(shape)
    v, w = centre or (shape[0] // 2, shape[1] // 2)
    return -0.5 * spacing**2 * ((y - v) ** 2 + (x - w) ** 2) / radius

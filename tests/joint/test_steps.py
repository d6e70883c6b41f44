"""Steps of resolved breakage: stiffnesses do not depend on them."""

import itertools

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.engine.uncertainty import coarser
from jointclosure.joint.curves import branch_of, net_responses
from tests.joints import SPACING

STRESS, SEATING = 10.27e6, 0.257e6
USUAL = jc.Numerics(breakage="resolved")
FINER = coarser(USUAL, 1.0 / 4.0)


def closed(wavelength, strength, seed, numerics):
    shape = (24, 24)
    walls = jc.wall_pair(8.0, shape, SPACING, seed, mismatch_wavelength=wavelength, roll_off=None)
    rock = jc.Rock(11e9, 0.25, strength)
    load = {"max_normal_stress": STRESS, "seating_stress": SEATING}
    return jc.simulate(*walls, spacing=SPACING, rock=rock, numerics=numerics, **load)


@pytest.fixture(scope="module")
def pairs():
    joints = itertools.product((1.6e-3, 6e-3), (60e6, 173e6), (1,))
    return [[closed(*joint, numerics) for numerics in (USUAL, FINER)] for joint in joints]


def test_stiffness_and_closure_of_stiff_joints_are_those_of_finer_steps(pairs):
    for name, mean in (("stiffness_net", 0.03), ("max_closure_seated_net", 0.03)):
        read = np.array([[net_responses(one)[name] for one in pair] for pair in pairs])
        ratios = read[:, 0] / read[:, 1]
        np.testing.assert_allclose(ratios.mean(axis=0), 1.0, atol=mean)
        assert ratios.std(axis=0).max() < 0.05


def test_every_branch_has_steps_enough_for_a_chord(pairs):
    for usual, _ in pairs:
        for cycle in (1, 2):
            for branch in ("loading", "unloading"):
                stress = usual.normal_stress.values[branch_of(usual, cycle, branch)]
                assert (stress > 0.5 * STRESS).sum() >= 5

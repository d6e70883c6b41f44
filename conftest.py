"""What all tests share: a small joint, and fast property testing."""

import dataclasses
import faulthandler

import hypothesis
import pytest

import jointclosure as jc
from jointclosure.assessment import effect_selection
from tests.joints import SPACING

hypothesis.settings.register_profile("default", deadline=None, max_examples=60)
hypothesis.settings.load_profile("default")

TEST_SECONDS = 1800
"""A test that takes longer loops: its worker is ended, and the traceback says where."""


@pytest.fixture(autouse=True)
def _no_test_loops():
    faulthandler.dump_traceback_later(TEST_SECONDS, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


@pytest.fixture
def small_joint():
    """Two walls of 20 x 24 cells, JRC 8."""
    return jc.wall_pair(8.0, (20, 24), SPACING, seed=3, roll_off=None)


@pytest.fixture
def times_by_effects(monkeypatch):
    """Times of joints that a selection measures, whatever else the machine does meanwhile."""

    def closed_in(walls, conditions):
        joint = measured(walls, conditions)
        return dataclasses.replace(joint, seconds=1.0 + sum(conditions.effects))

    measured = effect_selection.simulated_joint
    monkeypatch.setattr(effect_selection, "simulated_joint", closed_in)

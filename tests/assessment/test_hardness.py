"""Hardness of joints: verdicts from their features, and the hard case that is most like one."""

import numpy as np
import pytest

from jointclosure.assessment.assessed_results import ASSESSED
from jointclosure.assessment.assessment import Assessment
from jointclosure.assessment.hardness import FEATURES, HARD_CASES, nearest_hard_case
from jointclosure.storage.files import read_csv
from tests.assessment.known_closures import LADDER, closures


def test_the_verdict_on_a_joint_says_what_it_means():
    easy = Assessment(closures(scatter=1e-4), LADDER, "middle", 0.05)
    words = "is easy (net closures of its copies agree, its closure hardly jumps and its contacts"
    assert words in easy.sentences[-1]


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({"scatter": 1e-4}, "easy"),
        ({"scatter": 0.1}, "hard"),
        ({"scatter": 1e-4, "largest_jump": 0.06}, "hard"),
        ({"scatter": 1e-4, "joints": 1, "unbreakable_share": [*[0.0] * 5, 0.2, 0.0, 0.0]}, "hard"),
        ({"scatter": 1e-4, "oracle_ratio": 1.5}, "not stable"),
        ({"scatter": 1e-4, "status": 16}, "not stable"),
        ({"scatter": 1e-4, "error": "refused", "status": np.nan}, "not stable"),
    ],
)
def test_hardness_has_its_defined_verdict(changes, verdict):
    closed = closures(**changes)
    hardness = Assessment(closed, LADDER, "middle", 0.05).hardness
    assert hardness.verdict[0] == verdict
    assert "hard case" not in hardness.reason[0]  # `distance` has a scale only in its column
    assert hardness.unbreakable_share[0] == closed.unbreakable_share.max()  # what gave the verdict


def test_the_nearest_hard_case_of_a_hard_case_is_one_with_its_features():
    cases = read_csv(HARD_CASES).set_index("name")
    known = cases[[*FEATURES]]
    for name, features in known.iterrows():
        nearest, distance = nearest_hard_case(features)
        assert distance == 0.0
        assert nearest == name or known.loc[nearest].equals(features)
    assert nearest_hard_case(dict.fromkeys(FEATURES, np.nan))[0] == ""


@pytest.mark.parametrize(("apart", "verdict"), [(0.14, "hard"), (0.15, "not stable")])
def test_a_joint_whose_copies_scatter_beyond_a_fifth_is_not_stable(apart, verdict):
    """Two copies that are 2 x apart have a standard deviation of x sqrt(2)."""
    closed = closures(scatter=0.0, joints=1)
    copies = closed.copy_of_walls == "mirrored"
    closed.loc[copies, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    hardness = Assessment(closed, LADDER, "middle", 0.05).hardness
    assert hardness.verdict[0] == verdict
    assert ("not stable: more than 20 %" in hardness.reason[0]) == (verdict == "not stable")


def hardness_of_copies(apart, share):
    """Verdict on two copies that are 2 x apart: their standard deviation is x sqrt(2)."""
    closed = closures(scatter=0.0, joints=1, unbreakable_share=share)
    copies = closed.copy_of_walls == "mirrored"
    closed.loc[copies, list(ASSESSED)] *= (1.0 + apart) / (1.0 - apart)
    return Assessment(closed, LADDER, "middle", 0.05).hardness.verdict[0]


@pytest.mark.parametrize(("apart", "verdict"), [(0.017, "easy"), (0.018, "hard")])
def test_joints_are_easy_up_to_half_of_the_request(apart, verdict):
    """A deviation of 0.025 is the limit."""
    assert hardness_of_copies(apart, 0.1) == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.1, "easy"), (0.101, "hard")])
def test_joints_are_easy_up_to_a_tenth_of_force_that_cannot_break(share, verdict):
    assert hardness_of_copies(0.017, share) == verdict


@pytest.mark.parametrize(("jump", "verdict"), [(0.05, "easy"), (0.051, "hard")])
def test_joints_are_easy_up_to_a_jump_of_the_request(jump, verdict):
    closed = closures(scatter=1e-4, largest_jump=jump)
    assert Assessment(closed, LADDER, "middle", 0.05).hardness.verdict[0] == verdict


def test_the_scatter_of_finer_settings_counts_too():
    """Copies may break in the same order by the stated setting, and in another by a finer one."""
    closed = closures(scatter=0.0, joints=1, middle=0.001)
    copies = (closed.copy_of_walls == "mirrored") & (closed.variant == "fine")
    assert Assessment(closed, LADDER, "middle", 0.05).hardness.verdict[0] == "easy"
    closed.loc[copies, list(ASSESSED)] *= 1.1
    hardness = Assessment(closed, LADDER, "middle", 0.05).hardness
    assert hardness.verdict[0] == "hard"
    assert "scatter by 6.7 % on cycle 1" in hardness.reason[0]
    assert Assessment(closed, LADDER, "coarse", 0.05).hardness.verdict[0] == "hard"

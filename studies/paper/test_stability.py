"""What a report says of the numerical stability of joints."""

import pandas as pd
import pytest

from studies.paper.report.stability import UNTESTED, stability

HARDNESS = pd.DataFrame({
    "verdict": ["not stable: failed", "hard: closure jumps", ""],
    "verdict_joints": [1, 2, 17], "ranked": 20,
})  # fmt: skip
SETTINGS = pd.DataFrame({
    "kind": "setting", "variant": ["the paper's steps", "tolerance 0.004"], "cycle": 1,
    "joints": [4, 3], "failed": [0, 1],
})  # fmt: skip
DONE = {"state": "done"}


@pytest.fixture
def known():
    return {"study_hardness": HARDNESS, "study_assessment": SETTINGS}


def test_joints_that_failed_or_are_hard_are_counted(known):
    first = stability(known, DONE)[0]
    assert "Of 20 joints of this study" in first
    assert "1 failed and so are not numerically stable; 2 are hard: closure jumps." in first


def test_no_joint_is_called_not_stable_where_none_failed(known):
    whole = known | {"study_hardness": HARDNESS[1:]}
    assert (
        "by its own numerics, none failed; 2 are hard: closure jumps."
        in (stability(whole, DONE)[0])
    )


def test_the_settings_by_which_joints_failed_are_named(known):
    assert "by tolerance 0.004 1 failed. They are not stable." in stability(known, DONE)[1]
    whole = known | {"study_assessment": SETTINGS.assign(joints=4, failed=0)}
    assert stability(whole, DONE)[1].endswith("tolerance 0.004.")
    assert stability(whole, DONE)[1].startswith("None of ")


def test_what_was_not_tested_is_said(known):
    assert stability(known, DONE)[-1].startswith(UNTESTED)
    copies = pd.DataFrame({"verdict": ["easy", "easy", "hard"]})
    last = stability(known | {"hardness": copies}, DONE)[-1]
    assert last.endswith("3 joints are: 0 not stable, 1 hard, 2 easy.")


def test_nothing_is_said_where_nothing_is_known():
    assert stability({}, {"state": "off"}) == []

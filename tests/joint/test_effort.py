"""A slowdown is seen without a clock: counts of what joints take are held against a stored budget.

`python -m tests.joint.test_effort` measures them and rewrites ``effort.csv``; do so when a change
is meant to cost or to save something, and let the difference be read.
"""

from pathlib import Path

import pandas as pd
import pytest

import jointclosure as jc
from tests.joints import ELASTIC, closed, pair

BUDGET = Path(__file__).with_name("effort.csv")
COUNTS = ("settled_states", "equilibria", "newton_steps", "solver_iterations", "breakage_steps")
NONE = jc.Choices(strength_bound="none")
LARGEST = NONE._replace(largest_radius=20e-3)

JOINTS: dict[str, dict] = {
    # name: cells, stress [MPa], and what differs from the default
    "fixed_step": {"cells": 32, "stress": 8.0, "choices": NONE},
    "fixed_step_bounded": {},
    "fixed_step_current_peaks": {"cells": 32, "choices": NONE._replace(peaks="current")},
    "fixed_step_without_interaction": {"effects": jc.Effects(interaction=False), "choices": NONE},
    "resolved": {"breakage": "resolved", "choices": LARGEST},
    "resolved_bounded": {"breakage": "resolved"},
    "elastic": {"cells": 40, "stress": 30.0, "effects": ELASTIC},
    "reference": {"cells": 16, "stress": 2.0, "solver": "reference", "choices": NONE},
}


def counts(name: str) -> dict[str, int]:
    """What closing a joint of `JOINTS` takes, two cycles on two surfaces."""
    stated = dict(JOINTS[name])
    cells, stress = stated.pop("cells", 24), stated.pop("stress", 4.0)
    both = [
        closed(pair(cells, seed), stress * 1e6, seating_stress=0.0, **stated) for seed in (1, 2)
    ]
    return {count: sum(int(each[count]) for each in both) for count in COUNTS}


@pytest.mark.parametrize("name", JOINTS)
def test_closing_a_joint_takes_no_more_than_its_budget(name):
    """But for 5 % and a few: a sum in another order may lead a joint another course."""
    found, stored = counts(name), pd.read_csv(BUDGET, index_col="joint").loc[name]
    assert [count for count in COUNTS if found[count] > 1.05 * stored[count] + 5] == [], found


if __name__ == "__main__":
    pd.DataFrame.from_dict({name: counts(name) for name in JOINTS}, orient="index").rename_axis(
        "joint"
    ).to_csv(BUDGET)

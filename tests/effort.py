"""The budget of counts: what closing some joints takes, in numbers that no machine changes.

`python -m tests.effort` measures them and rewrites ``tests/effort.csv``; do so when a
change is meant to cost or to save something, and let the difference be read.
"""

from pathlib import Path

import pandas as pd

import jointclosure as jc
from tests.joints import DOLERITE, SPACING

BUDGET = Path(__file__).with_suffix(".csv")
COUNTS = ("settled_states", "equilibria", "newton_steps", "solver_iterations", "breakage_steps")
ELASTIC = {"breakage": False, "gouge": False}
NONE = jc.Choices(strength_bound="none")
LARGEST = NONE._replace(largest_radius=20e-3)

JOINTS: dict[str, dict] = {
    # name: cells, stress [MPa], and what differs from the default
    "fixed_step": {"cells": 40, "stress": 8.0, "choices": NONE},
    "fixed_step_bounded": {},
    "fixed_step_current_peaks": {"cells": 32, "choices": NONE._replace(peaks="current")},
    "fixed_step_without_interaction": {
        "cells": 40,
        "effects": jc.Effects(interaction=False),
        "choices": NONE,
    },
    "fixed_step_interpolated": {"numerics": jc.Numerics(target="interpolate"), "choices": NONE},
    "resolved": {"numerics": jc.Numerics(breakage="resolved"), "choices": LARGEST},
    "resolved_unbounded": {"numerics": jc.Numerics(breakage="resolved"), "choices": NONE},
    "resolved_bounded": {"numerics": jc.Numerics(breakage="resolved")},
    "elastic": {"cells": 60, "stress": 30.0, "effects": jc.Effects(**ELASTIC)},
    "reference": {
        "cells": 16,
        "stress": 2.0,
        "numerics": jc.Numerics(solver="reference"),
        "choices": NONE,
    },
}


def counts(name: str) -> dict[str, int]:
    """What closing a joint of `JOINTS` takes, two cycles on two surfaces."""
    stated = dict(JOINTS[name])
    cells, stress = stated.pop("cells", 24), stated.pop("stress", 4.0)
    closed = [
        jc.simulate(
            *jc.wall_pair(8.0, (cells, cells), SPACING, seed=seed, roll_off=None),
            spacing=SPACING,
            rock=DOLERITE,
            max_normal_stress=stress * 1e6,
            seating_stress=0.0,
            **stated,
        )
        for seed in (1, 2)
    ]
    return {count: sum(int(each[count]) for each in closed) for count in COUNTS}


def budget() -> pd.DataFrame:
    """The stored counts by joint."""
    return pd.read_csv(BUDGET, index_col="joint")


if __name__ == "__main__":
    pd.DataFrame.from_dict({name: counts(name) for name in JOINTS}, orient="index").rename_axis(
        "joint"
    ).to_csv(BUDGET)

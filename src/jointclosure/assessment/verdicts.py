"""Verdicts on effects: whether they can be left out within a request."""

import pandas as pd

from jointclosure.assessment.assessed_results import ASSESSED, JUDGED
from jointclosure.joint.status import BREAKAGE_NOT_AT_REST, FAILURE
from jointclosure.statistics.two_level import Interval

CAN_BE_LEFT_OUT = "can be left out"
"""Verdict on effects without which results change within the request."""
NEEDED_AS_FAILS = "needed: fails"
"""Verdict on effects without which a joint fails."""
GIVEN_UP = "kept: takes longer"
"""Verdict on effects without which a joint exceeds `MOST_BREAKAGE_STEPS`.

To leave them out would save no time, so that the change of its results was not tested."""
KEPT_UNTESTED = "the joint takes longer without it, and the change was not tested"
"""What this verdict means, in words."""


def is_given_up(statuses: pd.Series) -> pd.Series:
    """Return which statuses (n,) of joints without an effect are of joints that were given up."""
    known = statuses.fillna(0.0).astype(int)
    return (known >= FAILURE) & (known & BREAKAGE_NOT_AT_REST > 0)


def verdict_on_effects(differences: pd.DataFrame, within: float) -> str:
    """Return whether effects can be left out within a request, by `JUDGED` of all cycles.

    ``differences`` are rows of `Assessment.differences` of the variant without them. They can be
    left out if all intervals lie inside the request, and are needed if one lies outside.
    """
    ends = differences.loc[differences.quantity.isin(JUDGED), list(Interval._fields)].dropna()
    inside = {Interval(*row).within(within) for row in ends.to_numpy()}
    if False in inside:
        return "needed"
    if None in inside or not inside:
        return "not decided"
    return CAN_BE_LEFT_OUT


def results_beyond(differences: pd.DataFrame, within: float) -> str:
    """Name the judged results of a variant whose intervals lie outside of a request.

    ``differences`` are rows of `Assessment.differences`. The names have their cycles, such as
    "gross closure (cycles 1, 2)"; "" if no interval lies outside.
    """
    words = []
    for quantity in JUDGED:
        rows = differences[differences.quantity == quantity]
        limits = rows[list(Interval._fields)].to_numpy()
        cycles = [
            f"{cycle:.0f}"
            for cycle, row in zip(rows.cycle, limits, strict=True)
            if Interval(*row).within(within) is False
        ]
        if cycles:
            plural = "s" if len(cycles) > 1 else ""
            words.append(f"{ASSESSED[quantity]} (cycle{plural} {', '.join(cycles)})")
    return ", ".join(words)

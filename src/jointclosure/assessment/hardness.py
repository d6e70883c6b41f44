"""Features of a joint by which its hardness is judged, and the hard case that is most like it."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from jointclosure.assessment.assessed_results import CLOSURE
from jointclosure.storage.files import read_csv

FEATURES = ("unbreakable_share", "largest_jump", "broken_share", "contacts_at_max",
            "stress_over_strength", "spread")  # fmt: skip
"""Quantities by which a joint is compared with the hard cases, and the spread of its copies [1]."""
HARD_CASES = Path(__file__).with_name("hard_cases.csv")
"""Names, difficulties and `FEATURES` of the hard cases that the study verification simulated."""

MEANINGS = {
    "not stable": "no closure of it can be stated",
    "hard": "the order of breakage changes its closure, its closure jumps, or contacts that cannot "
    "break carry it",
    "easy": "net closures of its copies agree, its closure hardly jumps and its contacts can break",
}
"""Verdicts on a joint, the worst first, in words."""


def worst_first(hardness: pd.DataFrame) -> pd.DataFrame:
    """Return joints in the order of their verdicts, and of the spread of their copies."""
    order = np.lexsort((-hardness.spread, hardness.verdict.map(list(MEANINGS).index)))
    return hardness.iloc[order].reset_index(drop=True)


def spread_of(copies: pd.DataFrame, quantity: str = CLOSURE) -> pd.Series:
    """Return the relative standard deviation of a closure of a joint's copies [1], by cycle."""
    values = copies.pivot_table(index="cycle", columns="copy_of_walls", values=quantity)
    return values.std(axis=1) / values.mean(axis=1)


def features_of(closures: pd.DataFrame, stated: str, finest: str) -> dict[str, float]:
    """Return `FEATURES` of a joint by the finest setting, and the spread of the stated variant."""
    fine = closures[(closures.variant == finest) & (closures.copy_of_walls == "as it is")]
    spread = spread_of(closures[closures.variant == stated]).max()
    return {name: float(fine[name].max()) for name in FEATURES[:-1]} | {"spread": float(spread)}


def nearest_hard_case(features: Mapping[str, float]) -> tuple[str, float]:
    """Return the name of the hard case with the most similar features, and its distance.

    Each feature is replaced by the share of hard cases in which it is less. The distance is the rms
    difference of these shares over the features.
    """
    cases = read_csv(HARD_CASES)
    apart = []
    for name in FEATURES:
        known = np.sort(cases[name].dropna())
        both = np.append(cases[name], features[name])
        below = np.searchsorted(known, both)
        upto = np.searchsorted(known, both, "right")
        less = np.where(np.isnan(both), np.nan, 0.5 * (below + upto))
        apart.append((less[:-1] - less[-1]) / known.size)
    comparable = np.isfinite(apart).any(axis=0)
    if not comparable.any():
        return "", math.nan
    distances = np.sqrt(np.nanmean(np.square(apart)[:, comparable], axis=0))
    return cases[comparable].iloc[distances.argmin()]["name"], float(distances.min())

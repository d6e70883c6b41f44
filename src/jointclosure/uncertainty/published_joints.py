"""Measured values of three granodiorite joints (docs/measured.md), read off publications.

``published_joints.csv`` has the source, the way of reading and the range of each value.
"""

import math
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from jointclosure.storage.files import read_csv

_TABLE = Path(__file__).with_name("published_joints.csv")
JOINTS = ("1", "2", "3")
ALL = "all"  # in the column ``joint``: a value that holds for all joints, or for their range


class Measured(NamedTuple):
    """Measured value of a published joint with its range, in the unit of `published_joints.csv`.

    A value is NaN where only its range is known.
    """

    value: float
    low: float
    high: float


@cache
def _table() -> pd.DataFrame:
    """Return the table of published values (joint, quantity, value, low, high).

    Ratios of the stiffness of later loadings to that of the first are added as the quantity
    ``stiffness_ratio``. Only their ranges are known, because the publications do not say which
    joint has which stiffness on the first loading.
    """
    table = read_csv(_TABLE).astype({"joint": str})
    first = table[table.quantity == "first_stiffness"].iloc[0]
    later = table[table.quantity == "later_stiffness"]
    ends = {"low": (later.value / first.high).round(1), "high": (later.value / first.low).round(1)}
    ratios = later.assign(quantity="stiffness_ratio", value=float("nan"), **ends)
    return pd.concat([table, ratios], ignore_index=True)


def measured(quantity: str, joint: str = ALL) -> Measured:
    """Return a measured value of one of the published joints, with its range.

    If the quantity is not recorded for this ``joint``, it is the value that holds for all joints.
    The ends of the range of a value without one are the value itself.
    """
    table = _table()
    rows = table[(table.quantity == quantity) & table.joint.isin([joint, ALL])]
    row = rows.sort_values("joint").iloc[0]  # that of the joint before that of all
    value, low, high = row[list(Measured._fields)].astype(float)
    return Measured(value, value if pd.isna(low) else low, value if pd.isna(high) else high)


def measured_range(quantity: str) -> tuple[float, float]:
    """Return the smallest and the largest value of a quantity over the three published joints.

    If no value is known, they are the ends of the recorded ranges.
    """
    values = pd.DataFrame([measured(quantity, joint) for joint in JOINTS])
    known = values.value.dropna()
    return (known.min(), known.max()) if len(known) else (values.low.min(), values.high.max())


def beyond_measured(ratio: float) -> bool:
    """Return whether a stiffness ratio is finite and outside of the range of the published joints.

    ``ratio`` is the stiffness of a later loading over the stiffness of the first one [1].
    """
    low, high = measured_range("stiffness_ratio")
    return math.isfinite(ratio) and not low <= ratio <= high

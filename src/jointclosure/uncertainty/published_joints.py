"""Measured values of three granodiorite joints (docs/measured.md), read off publications.

``published_joints.csv`` has the source, the way of reading and the range of each value.
"""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from jointclosure.storage.files import read_csv

_TABLE = Path(__file__).with_name("published_joints.csv")
JOINTS = ("1", "2", "3")
ALL = "all"  # in the column ``joint``: a value that holds for all joints, or for their range


class Measured(NamedTuple):
    """Measured value with its range, in the unit of the table; NaN where it is not known."""

    value: float
    low: float
    high: float


@cache
def _table() -> pd.DataFrame:
    """Return the table of values (joint, quantity, value, low, high).

    Ratios of later stiffness to the first are added. Their ends are those of all joints, because it
    is not recorded which joint has which stiffness.
    """
    table = read_csv(_TABLE).astype({"joint": str})
    first = table[table.quantity == "first_stiffness"].iloc[0]
    later = table[table.quantity == "later_stiffness"]
    ends = {"low": (later.value / first.high).round(1), "high": (later.value / first.low).round(1)}
    ratios = later.assign(quantity="stiffness_ratio", value=float("nan"), **ends)
    return pd.concat([table, ratios], ignore_index=True)


def measured(quantity: str, joint: str = ALL) -> Measured:
    """Return a measured value of a joint; a value without a range is its own range."""
    table = _table()
    rows = table[(table.quantity == quantity) & table.joint.isin([joint, ALL])]
    row = rows.sort_values("joint").iloc[0]  # that of the joint before that of all
    value, low, high = row[list(Measured._fields)].astype(float)
    return Measured(value, value if pd.isna(low) else low, value if pd.isna(high) else high)


def measured_range(quantity: str) -> tuple[float, float]:
    """Return the smallest and the largest measured value of a quantity over the joints."""
    values = pd.DataFrame([measured(quantity, joint) for joint in JOINTS])
    known = values.value.dropna()
    return (known.min(), known.max()) if len(known) else (values.low.min(), values.high.max())

"""Verdicts of an assessment on the change of a mean closure, by cycle and over all cycles."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

WIDEST = 100.0
"""Largest half-width of an interval [%] about 0 with which a change is shown: beyond, nothing is
known."""
TOO_FEW = "too few joints"
"""In place of a change whose interval is wider."""
REFERENCE = "reference"
"""Verdict on the setting from which the differences of others are taken."""
JUMPS = "hard: closure jumps"
"""Verdict on a joint whose largest closure jump exceeds the request."""
VERDICT_OF = {True: "within", False: "beyond", None: "not determined"}
"""Verdicts on a change of a mean closure: is it shown to be within the request, or beyond it?"""
CHANGE_VERDICTS = tuple(VERDICT_OF.values())
"""Verdicts on a change, see `verdict_of_cycles`."""


def verdict_of_cycles(rows: pd.DataFrame) -> str:
    """Return one verdict on a variant from the rows of its cycles: the worst one of all.

    A change beyond the request in one cycle is one of the variant; it is within the request only if
    it is in all cycles.
    """
    known = set(rows.verdict)
    order = (REFERENCE, *(VERDICT_OF[key] for key in (False, None, True)))
    return next((one for one in order if one in known), VERDICT_OF[None])


def has_interval(row: Mapping[str, Any], name: str) -> bool:
    """Return whether the interval of a change has two ends, which that of one joint has not."""
    ends = [row.get(f"{name}{end}", np.nan) for end in ("_low", "_high")]
    return bool(np.isfinite(ends).all())


def is_unknown(row: Mapping[str, Any], name: str) -> bool:
    """Return whether a change has a value, but no interval or one that is too wide."""
    if pd.isna(row.get(name, np.nan)):
        return False
    return not has_interval(row, name) or is_too_wide(row, name)


def is_too_wide(row: Mapping[str, Any], name: str) -> bool:
    """Return whether the interval of a change contains 0 and is wider than ±`WIDEST`.

    A change without an interval (`has_interval`) is not too wide.
    """
    if not has_interval(row, name):
        return False
    low, high = (row[f"{name}{end}"] for end in ("_low", "_high"))
    return bool(high - low > 2.0 * WIDEST and low <= 0.0 <= high)

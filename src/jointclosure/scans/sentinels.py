"""Numbers that stand for "no height": a file may hold them without declaring them."""

import numpy as np

from jointclosure.inputs.remarks import caution

SENTINELS = (-999.0, -9999.0, 9999.0, -99999.0, 99999.0, -999999.0, 999999.0, -32767.0, -32768.0)
"""Counted as missing only beyond all other values: a scan in micrometres may be 9.999 mm high."""
LARGEST = 1e20
"""No length in any unit is larger: 1e30, 1.70141e38 and the like."""

LEAST_ZEROS, ZEROS_PER_OTHER = 10, 10
"""From so many heights of exactly 0, and so many times as many as of any other value, they stand
for none: an instrument that rounds its heights gives neighbouring values about as often."""
_MOST_ZEROS = 0.5
"""Of all heights: a wall of which more are 0 may be a flat one."""


def missing_values(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which values stand for none: bool as their shape, and the sentinels that were found."""
    with np.errstate(invalid="ignore"):
        missing = np.abs(values) >= LARGEST
    found = list(np.unique(values[missing]))
    others = values[np.isfinite(values) & ~missing & ~np.isin(values, SENTINELS)]
    if others.size:
        low, high = others.min(), others.max()
        for sentinel in SENTINELS:
            alike = values == sentinel
            if alike.any() and not low <= sentinel <= high:
                missing |= alike
                found.append(sentinel)
    return missing, np.array(found)


def said(count: int, sentinels: np.ndarray, what: str) -> str:
    """The sentence on values that were taken as missing."""
    words = ", ".join(f"{value:g}" for value in sentinels)
    return f"{count} {what} of {words} were taken as missing"


def missing_heights(heights: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Which heights stand for none, bool as their shape, and the sentences on them.

    Those of `missing_values`, and heights of exactly 0 where they are far more than of any other
    value, as programs write them that know no missing height.
    """
    missing, found = missing_values(heights)
    remarks = (said(int(missing.sum()), found, "heights"),) if missing.any() else ()
    known = heights[np.isfinite(heights) & ~missing]
    zeros = int((known == 0.0).sum())
    if zeros < LEAST_ZEROS or zeros == known.size:
        return missing, remarks
    if zeros < ZEROS_PER_OTHER * np.unique(known[known != 0.0], return_counts=True)[1].max():
        return missing, remarks
    about = f"{zeros} of {known.size} heights are exactly 0, far more than of any other"
    if zeros > _MOST_ZEROS * known.size:
        return missing, (*remarks, caution(f"{about}; they were taken as heights"))
    return missing | (heights == 0.0), (*remarks, caution(f"{about}; they were taken as missing"))

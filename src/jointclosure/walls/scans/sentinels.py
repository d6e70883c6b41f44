"""Numbers that mean "no height" and that a file may contain without declaring them."""

import numpy as np

from jointclosure.inputs.remarks import caution

SENTINELS = (-999.0, -9999.0, 9999.0, -99999.0, 99999.0, -999999.0, 999999.0, -32767.0, -32768.0)
"""Values that count as missing only if they are beyond all other values: a scan in micrometres may
be 9.999 mm high."""
LARGEST = 1e20
"""Larger values are missing in any unit, such as 1e30 and 1.70141e38."""

LEAST_ZEROS, ZEROS_PER_OTHER = 10, 10
"""Smallest number of heights of exactly 0, and smallest ratio to the most frequent other value, for
which zeros count as missing. An instrument that rounds its heights gives neighbouring values about
equally often."""
_MOST_ZEROS = 0.5
"""Largest share of zeros that count as missing; a wall with more may be flat."""


def missing_values(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which values are missing, bool of their shape, and the sentinels that occur."""
    with np.errstate(invalid="ignore"):
        missing = np.abs(values) >= LARGEST
    sentinels = list(np.unique(values[missing]))
    others = values[np.isfinite(values) & ~missing & ~np.isin(values, SENTINELS)]
    if others.size:
        low, high = others.min(), others.max()
        for sentinel in SENTINELS:
            alike = values == sentinel
            if alike.any() and not low <= sentinel <= high:
                missing |= alike
                sentinels.append(sentinel)
    return missing, np.array(sentinels)


def missing_sentence(count: int, sentinels: np.ndarray, what: str) -> str:
    """Return the sentence on values that were treated as missing."""
    words = ", ".join(f"{value:g}" for value in sentinels)
    return f"{count} {what} of {words} were treated as missing"


def missing_heights(heights: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return which heights are missing, bool of their shape, and sentences on them.

    These are `missing_values`, and heights of exactly 0 if they are far more frequent than any
    other value, as written by programs without a missing value.
    """
    missing, sentinels = missing_values(heights)
    remarks = (missing_sentence(int(missing.sum()), sentinels, "heights"),) if missing.any() else ()
    known = heights[np.isfinite(heights) & ~missing]
    zeros = int((known == 0.0).sum())
    if zeros < LEAST_ZEROS or zeros == known.size:
        return missing, remarks
    if zeros < ZEROS_PER_OTHER * np.unique(known[known != 0.0], return_counts=True)[1].max():
        return missing, remarks
    about = f"{zeros} of {known.size} heights are exactly 0, far more than of any other"
    if zeros > _MOST_ZEROS * known.size:
        return missing, (*remarks, caution(f"{about}; they were used as heights"))
    return missing | (heights == 0.0), (*remarks, caution(f"{about}; they were treated as missing"))

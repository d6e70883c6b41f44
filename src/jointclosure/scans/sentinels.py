"""Numbers that stand for "no height": a file may hold them without declaring them."""

import numpy as np

SENTINELS = (-999.0, -9999.0, 9999.0, -99999.0, 99999.0, -999999.0, 999999.0, -32767.0, -32768.0)
"""Counted as missing only beyond all other values: a scan in micrometres may be 9.999 mm high."""
LARGEST = 1e20
"""No length in any unit is larger: 1e30, 1.70141e38 and the like."""


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

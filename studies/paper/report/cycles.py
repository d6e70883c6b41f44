"""Verdicts of an assessment on the change of a mean closure, by cycle and over all cycles."""

import pandas as pd

REFERENCE = "reference"
"""Verdict on the setting from which the differences of others are taken."""
VERDICT_OF = {True: "within", False: "beyond", None: "not determined"}
"""Verdicts on a change of a mean closure: is it shown to be within the request, or beyond it?"""
VERDICTS = tuple(VERDICT_OF.values())
"""Verdicts on a change, see `verdict_of_cycles`."""


def verdict_of_cycles(rows: pd.DataFrame) -> str:
    """Return one verdict on a variant from the rows of its cycles: the worst one of all.

    A change beyond the request in one cycle is one of the variant; it is within the request only if
    it is in all cycles.
    """
    known = set(rows.verdict)
    order = (REFERENCE, *(VERDICT_OF[key] for key in (False, None, True)))
    return next((one for one in order if one in known), VERDICT_OF[None])

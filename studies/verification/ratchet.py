"""Errors of hard cases against the oracle, stored, so that none can grow unnoticed.

A limit set by hand is met with some margin, and what uses the margin up is not seen. Here the
present error of every case is the limit of the next one, up to a factor and to rounding.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

ERRORS: dict[str, tuple[str, ...]] = {
    "forces": ("residual", "without_overlap", "without_force"),
    "load": ("load",),
    "volume": ("volume",),
    "strength": ("strength",),
}
"""Errors of a case, all relative: the largest of these fields of `oracle.Verdict`."""
GROWTH = 4.0
"""Allowed ratio of an error to the stored one."""
FLOOR = 64.0 * np.finfo(float).eps
"""Error below which nothing is judged: rounding of sums."""


def error_table(cases: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """Tabulate the errors of the judged cases, with what gave them.

    Parameters
    ----------
    cases : DataFrame
        Rows of `studies.verification.hard_cases.row_of`.
    origin : mapping
        ``processor``, ``versions`` and ``commit``.
    """
    judged = cases[cases.states_judged > 0]
    table = pd.DataFrame({"name": judged.name, "group": judged.group})
    for error, fields in ERRORS.items():
        largest = judged[[f"oracle_{field}" for field in fields]].max(axis=1)
        table[error] = [float(f"{value:.3g}") for value in largest]
    return table.assign(**origin)


def grown_errors(stored: Mapping, worst: Mapping[str, float]) -> list[str]:
    """List the errors that have grown beyond `GROWTH`, one line each.

    Parameters
    ----------
    stored : mapping
        Row of `error_table` of the case.
    worst : mapping
        Present fields of `oracle.Verdict` (`studies.verification.hard_cases.Judge`).
    """
    grown = []
    for error, fields in ERRORS.items():
        for field in fields:
            if not worst[field] <= GROWTH * max(float(stored[error]), FLOOR):
                grown.append(
                    f"{field} is {worst[field]:.3g}, {stored[error]:.3g} is stored for {error} "
                    f"({stored['processor']}, {stored['versions']})"
                )
    return grown

"""Formulas and sweeps as hard cases, in rows like those of joints.

The numbers are those of `printed` and `sweeps`, compared with exact values in fifty or more digits.
"""

import numpy as np
import pandas as pd

FORMULAS = {
    "cubic": ("contact law over 24 decades of g", 1e-14),
    "far field": ("interaction up to zeta/r = 1e9", 1e-13),
    "quartic": ("indifference interval of levels 1e-9 apart, relative", 1e-13),
}
"""Difficulty of each formula, and the largest allowed relative error."""
OURS = "jointclosure"
_SOLVED = 1.01e-10


def formula_rows(errors: pd.DataFrame, loads: pd.DataFrame) -> list[dict]:
    """Return rows for the table of hard cases.

    Parameters
    ----------
    errors : DataFrame
        ``subject``, ``series``, ``at`` and ``error``, as measured by
        `studies.verification.printed`.
    loads : DataFrame
        As from `studies.verification.sweeps.load_table`.

    Returns
    -------
    list of dict
        With the columns of rows of joints, and ``largest_error``.
    """
    rows = []
    for subject, (hard, limit) in FORMULAS.items():
        ours = errors[(errors.subject == subject) & errors.series.str.startswith(OURS)]
        worst = float(np.max(ours.error.to_numpy())) if len(ours) else np.inf
        rows.append(
            _row(subject.replace(" ", "_"), hard, f"relative error at most {limit:g}", worst, limit)
        )
    for joint, part in loads.groupby("joint", sort=False):
        beyond = part[part.spectral_radius >= 1.0]
        name = joint.replace("'s", "").replace(" ", "_")
        rows.append(
            _row(
                f"interaction_{name}",
                f"{len(part)} loads, on {len(beyond)} of which the sweep of the paper, read as "
                "simultaneous, does not converge",
                f"the fast solver's residual is at most {_SOLVED:g}, by a dense matrix",
                float(np.max(part.fast_residual.to_numpy())),
                _SOLVED,
            )
        )
    return rows


def _row(name: str, hard: str, must_hold: str, worst: float, limit: float) -> dict:
    holds = bool(worst <= limit)
    return {
        "name": name,
        "group": "numerics",
        "hard": hard,
        "must_hold": must_hold,
        "expected": "answer",
        "status": "success" if np.isfinite(worst) else "not found",
        "holds": holds,
        "failed": "" if holds else f"error {worst:.3g}, at most {limit:g}",
        "largest_error": worst,
    }

"""The curves of a closed joint as a table, one row a step."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.history import branch_of, first_crossing
from jointclosure.protocol import LOADING


def curve_table(history: xr.Dataset) -> pd.DataFrame:
    """Closure against stress by cycle and branch, as laboratories tell it.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.

    Returns
    -------
    DataFrame
        ``cycle``, ``branch``, ``normal_stress_MPa``, ``closure_mm`` from first touch,
        ``closure_since_seating_mm`` from the point of the cycle's loading at the seating stress
        (negative before it, NaN where it was not reached) and ``contact_fraction``. A branch
        begins with the last step of the one before.
    """
    cycle, branch = history.cycle.values, history.branch.values
    rows = []
    for number in np.unique(cycle):
        loading = branch_of(cycle, branch, number, LOADING)
        stress, closure = history.normal_stress.values, history.closure.values
        seat = first_crossing(
            stress[loading], closure[loading], float(history.attrs["seating_stress_Pa"])
        )
        for name in dict.fromkeys(branch[cycle == number].tolist()):
            here = branch_of(cycle, branch, number, name)
            rows.append(
                pd.DataFrame(
                    {
                        "cycle": number,
                        "branch": name,
                        "normal_stress_MPa": 1e-6 * stress[here],
                        "closure_mm": 1e3 * closure[here],
                        "closure_since_seating_mm": 1e3 * (closure[here] - seat),
                        "contact_fraction": history.contact_fraction.values[here],
                    }
                )
            )
    return pd.concat(rows, ignore_index=True)

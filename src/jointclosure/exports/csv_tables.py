"""Tables of a simulated joint as CSV."""

import pandas as pd
import xarray as xr

from jointclosure.joint.history import history_of
from jointclosure.joint.laws import JointLaws, fitted_laws
from jointclosure.joint.result_tables import curve_table, cycle_table
from jointclosure.joint.status import LOADING

FIGURES = 7
"""Significant digits of numbers in tables: more than their accuracy, but enough to distinguish
neighbouring steps."""


def with_law(joint: xr.Dataset, curves: pd.DataFrame, laws: JointLaws) -> pd.DataFrame:
    """Return a copy of a `stress_table` with the closures [mm] by the law of Barton and Bandis.

    They count from the seating stress and are in the column ``barton_bandis_mm``, which is NaN on
    unloadings and in cycles without a law. If no cycle has a law, there is no such column.
    """
    curves = curves.copy()
    for number, law in laws.by_cycle.items():
        above = 1e6 * curves.normal_stress_MPa - history_of(joint).seating_stress
        here = (curves.cycle == number) & (curves.branch == LOADING)
        curves.loc[here, "barton_bandis_mm"] = 1e3 * law.closure(above[here])
    return curves


def csv_files(joint: xr.Dataset, curves: pd.DataFrame) -> dict[str, str]:
    """Return the tables of a simulated joint as texts of CSV by file name.

    `curves.csv` is by step, `cycles.csv` by cycle, and `laws.csv` has the fitted laws.
    `answer.csv` is the table ``curves`` over stress, as from `stress_table` or `with_law`.
    """
    tables = {
        "curves": curve_table(joint),
        "cycles": cycle_table(joint),
        "answer": curves,
        "laws": fitted_laws(joint),
    }
    return {
        f"{name}.csv": table.to_csv(index=False, float_format=f"%.{FIGURES}g")
        for name, table in tables.items()
    }

"""Tables and numbers of docs/continuum.md."""

import pandas as pd
from stored import stored

from content.markdown import first_row, grouped, rows_of, titled
from jointclosure.statistics.standard_errors import rounded

CLOSURES = {
    "closure_1_um": "closure, cycle 1 (µm)",
    "residual_um": "residual closure (µm)",
    "closure_2_um": "closure, cycle 2 (µm)",
    "contact_1_percent": "cells in contact at 30 MPa (%)",
    "contact_half_unloaded_percent": "the same unloaded to 15 MPa (%)",
}
STIFFNESSES = {
    f"stiffness_{branch}_MPa_per_mm": f"{branch} (MPa/mm)"
    for branch in ("loading", "unloading", "reloading")
}
HARDNESS = {"at breakage": "continuum, hardness at breakage (own)",
            "2.8": "continuum, hardness 2.8 sigma_c (own)"}  # fmt: skip
"""Models whose pressure is limited, by the limit."""
LEAST_SHOWN = 1e-3
"""Difference [%] below which none is shown."""


def ratio(hardness: str, reading: str) -> str:
    """Give the ratio of a continuum's reading to the asperity model's."""
    table = rows_of(stored("continuum", "continuum"), model=HARDNESS[hardness], reading=reading)
    row = first_row(table)
    return rounded(row.ratio, row.ratio_error)


def closures() -> str:
    """Tabulate closures and contact with errors, and ratios to the asperity model's."""
    return _readings(CLOSURES)


def stiffnesses() -> str:
    """Tabulate stiffness with errors, and ratios to the asperity model's."""
    return _readings(STIFFNESSES)


def _readings(titles: dict[str, str]) -> str:
    table = stored("continuum", "continuum")
    joints = table.groupby("model").realizations.min()
    table = titled(table, {(reading,): title for reading, title in titles.items()}, "reading")
    table = table.assign(
        joints=table.model.map(joints),
        name=table.model.str.replace("sigma_c", "σc").str.replace("contact_m", "ContactM"),
    )
    reference = table.model.iloc[0]

    def cell(part: pd.DataFrame) -> str:
        row = first_row(part)
        if pd.isna(row.mean):
            return ""
        text = rounded(row.mean, row.error)
        beside = row.model != reference and not pd.isna(row.ratio) and row.mean != 0.0
        return f"{text} (x {rounded(row.ratio, row.ratio_error)})" if beside else text

    return grouped(table, {"model": "name", "joints": "joints"}, across="title", cell=cell)


def codes() -> str:
    """State how far ContactMechanics and the project's solution of the same law differ."""
    rows = stored("continuum", "continuum_codes").itertuples()
    return "; by ".join(
        f"{_off(row.at_largest_stress)} at 30 MPa and {_off(row.anywhere)} at any stress of first "
        f"loading (hardness {row.hardness.replace('sigma_c', 'σc')}, {row.joints} joints)"
        for row in rows
    )


def _off(percent: float) -> str:
    """Write a largest difference in words."""
    return "less than 0.001 %" if percent < LEAST_SHOWN else f"at most {percent:.2g} %"


def read_to() -> str:
    """Give the stress [MPa] to which the stiffness of loading is read."""
    row = first_row(rows_of(stored("continuum", "continuum"), reading="loading_read_to_MPa"))
    return rounded(row.mean, row.error)

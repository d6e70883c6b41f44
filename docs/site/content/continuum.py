"""Tables and numbers of docs/continuum.md."""

import pandas as pd
from stored import stored

from content.markdown import Group, Table, titled, value_of, written

CLOSURES = {
    ("closure_1_mm",): "closure, cycle 1 (mm)",
    ("residual_mm",): "residual closure (mm)",
    ("closure_2_mm",): "closure, cycle 2 (mm)",
    ("contact_1_percent",): "cells in contact at 30 MPa (%)",
    ("contact_half_unloaded_percent",): "the same unloaded to 15 MPa (%)",
}
STIFFNESSES = {
    (f"stiffness_{branch}_MPa_per_mm",): f"{branch} (MPa/mm)"
    for branch in ("loading", "unloading", "reloading")
}
HARDNESS = {
    "at breakage": "continuum, hardness at breakage (own)",
    "2.8": "continuum, hardness 2.8 sigma_c (own)",
}
"""Models whose pressure is limited, by the limit."""
LEAST_SHOWN = 1e-3
"""Difference [%] below which none is shown."""


def _readings(titles: dict[tuple, str]) -> Table:
    """Table of readings with errors, and their ratios to the asperity model's."""

    def cell(group: Group) -> str:
        beside = group["model"] != "asperity model" and group["mean"] != 0.0
        return written("{mean±error} (x {ratio±ratio_error})" if beside else "{mean±error}", group)

    return Table(
        "continuum/continuum",
        rows={"model": "{name}", "joints": "{joints}"},
        across="{title}",
        cell=cell,
        prepare=lambda table: titled(table, titles, "reading").assign(
            joints=table.groupby("model").realizations.transform("min"), name=_named(table.model)
        ),
    )


def _named(models: pd.Series) -> pd.Series:
    names = models.str.replace("sigma_c", "σc").str.replace("contact_m", "ContactM")
    return names.str.replace("(own)", "(this project)")


closures, stiffnesses = _readings(CLOSURES), _readings(STIFFNESSES)


def ratio(hardness: str, reading: str) -> str:
    """Give the ratio of a continuum's reading to the asperity model's."""
    rows = {"model": HARDNESS[hardness], "reading": reading}
    return value_of("continuum/continuum", "{ratio±ratio_error}", **rows)


def read_to() -> str:
    """Give the stress [MPa] to which the stiffness of loading is read."""
    return value_of("continuum/continuum", "{mean±error}", reading="loading_read_to_MPa")


def codes() -> str:
    """State how far ContactMechanics and the project's solution of the same law differ."""
    return "; by ".join(
        f"{_off(row.at_largest_stress)} at 30 MPa and {_off(row.anywhere)} at any stress of first "
        f"loading (hardness {row.hardness.replace('sigma_c', 'σc')}, {row.joints} joints)"
        for row in stored("continuum", "continuum_codes").itertuples()
    )


def _off(percent: float) -> str:
    """Write a largest difference in words."""
    return "less than 0.001 %" if percent < LEAST_SHOWN else f"at most {percent:.2g} %"

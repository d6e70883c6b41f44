"""Loading of one cycle and the limits of its bands, as other programs receive them."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.ensembles.quantities import CURVES
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.history import history_of
from jointclosure.joint.result_tables import columns_of, has_bands, wider_columns_of
from jointclosure.joint.status import LOADING
from jointclosure.uncertainty.published_joints import beyond_measured, measured_range
from jointclosure.uncertainty.ranges import MEANT

_EXPORTED = "constants for other programs (barton_bandis.dat, porepy*.json) and tables for GEOS"


class Exported(NamedTuple):
    """Contents of exported files by file name; remarks on these files and on those left out."""

    files: dict[str, Any]
    remarks: list[str]


class BandLimit(NamedTuple):
    """The joint, or a limit of its bands, in the names of exported quantities.

    ``title`` is appended to the titles of curves. ``suffix`` is appended to the names of constants
    of the hyperbola that is fitted to this limit of the band of closure, and ``joint`` describes
    a joint that closes like this limit. Its constants are not the ends of the ranges of kni and Vm:
    a joint that closes less may have a larger or a smaller kni.
    """

    title: str
    suffix: str
    joint: str


_CHOICES = " with other choices of the model"
CHOICES = "_with_choices"
"""End of the suffixes of limits of bands with other choices of the model."""
BAND_LIMITS = {
    "": BandLimit("", "", "the joint"),
    "_low": BandLimit(", low end of its band", "_closes_less", "a joint that closes less"),
    "_high": BandLimit(", high end of its band", "_closes_more", "a joint that closes more"),
    "_low_with_choices": BandLimit(
        f", low end of its band{_CHOICES}",
        "_closes_less_with_choices",
        f"a joint that closes less,{_CHOICES}",
    ),
    "_high_with_choices": BandLimit(
        f", high end of its band{_CHOICES}",
        "_closes_more_with_choices",
        f"a joint that closes more,{_CHOICES}",
    ),
}
"""The joint (suffix "") and the limits of its bands, by the suffix of columns of a `stress_table`.

The suffix of the names of constants is another one (`BandLimit.suffix`)."""


def loading_remark(joint: xr.Dataset, cycle: int) -> str:
    """Return the remark that names the loading to which the constants for other programs belong.

    It is a warning if the ratio of the stiffness of this loading to the stiffness of the first one
    is outside of the range of the measured joints (`beyond_measured`).
    """
    remark = f"{_EXPORTED} are of {loading_text(joint, cycle)}"
    later = joint.sizes["cycle"]
    if cycle == 1 and later > 1:
        remark += f"; --export-cycle {later} gives those of {loading_text(joint, later)}"
    beyond = beyond_measured(stiffness_ratio(joint, cycle))
    return caution(remark) if beyond else remark


def stiffness_ratio(joint: xr.Dataset, cycle: int) -> float:
    """Return the net chord stiffness of a later cycle over that of cycle 1 [1]; NaN for cycle 1."""
    if cycle == 1:
        return np.nan
    stiffness = net_responses(joint)["stiffness_net"]
    return float(stiffness[cycle - 1] / stiffness[0])


def known_loadings(joint: xr.Dataset, curves: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of loadings in a `stress_table` whose closure, and its band, are known.

    Rows at stresses that a user named are left out.
    """
    usual = curves.normal_stress_MPa.isin(history_of(joint).table_levels() / 1e6)
    loading = curves[usual & (curves.branch == LOADING)]
    return loading.dropna(subset=columns_of(curves, "closure_net_since_seating_mm"))


def loading_text(joint: xr.Dataset, cycle: int) -> str:
    """Describe the loading of a cycle that is exported, and its stiffness relative to cycle 1."""
    if cycle == 1:
        return "cycle 1, the first loading"
    about = f"cycle {cycle}"
    ratio = stiffness_ratio(joint, cycle)
    if np.isfinite(ratio):
        about += f", which is {ratio:.3g} times as stiff as cycle 1 (chord stiffness)"
    if beyond_measured(ratio):
        low, high = measured_range("stiffness_ratio")
        about += (
            f", while later loadings of measured joints were {low:.2g} to {high:.2g} times as "
            "stiff as the first"
        )
    return about


def loading_by_suffix(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int
) -> dict[str, pd.DataFrame]:
    """Return the rows of the loading of a cycle for the joint and for each limit of its bands.

    The tables are by suffix of columns, as in `BAND_LIMITS`: "" for the joint, and the limits that
    ``curves``, a `stress_table`, has. The columns of every table have the names of `CURVES` without
    a suffix. Raise `InputError` if the loading does not begin at or below the seating stress, or
    has no known closure.
    """
    history = history_of(joint)
    loading = history.cycles[cycle - 1].loading
    known = known_loadings(joint, curves)
    rows = known[known.cycle == cycle]
    begins = loading.has_steps and history.stress[loading.steps].min() <= history.seating_stress
    if rows.empty or not begins:
        raise InputError(
            f"the loading of cycle {cycle} does not begin at or below the seating stress, "
            f"{history.seating_stress:g} Pa"
        )
    tables = {}
    shown = [name for name in CURVES if name in rows]
    for suffix in BAND_LIMITS:
        if f"{shown[0]}{suffix}" in rows:
            of_limit = {name: rows[f"{name}{suffix}"] for name in shown}
            about = rows[["cycle", "normal_stress_MPa"]]
            tables[suffix] = pd.DataFrame(of_limit | dict(about))
    return tables


def suffix_legend(curves: pd.DataFrame, low: str, high: str, choices: str) -> list[str]:
    """Explain the suffixes of constants in exported files: one sentence for each range.

    The suffixes ``low`` and ``high`` stand for the limits of the range of the joint. With
    ``choices`` appended they stand for the limits of the wider range with other choices of the
    model. ``curves`` is a `stress_table`; without bands in it nothing is returned.
    """
    lines: list[str] = []
    if has_bands(curves):
        lines.append(f"{low} and {high} are of the ends of the range, which is {MEANT}")
    if wider_columns_of(curves, "closure_net_since_seating_mm"):
        lines.append(
            f"{low}{choices} and {high}{choices} are of the ends of the range with other choices "
            "of the model too"
        )
    return lines

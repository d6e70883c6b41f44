"""Loading of one cycle, and the ends of its bands, as other programs receive them."""

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
from jointclosure.uncertainty.published_joints import measured_range
from jointclosure.uncertainty.ranges import MEANT

_EXPORTED = "constants for other programs (barton_bandis.dat, porepy*.json) and tables for GEOS"


class Exported(NamedTuple):
    """Contents of files by their names, and remarks on them and on files that are not written."""

    files: dict[str, Any]
    remarks: list[str]


class End(NamedTuple):
    """The joint, or an end of its bands: addition to titles, ending of constants, and their joint.

    The constants are fitted to this end of the band of closure. They are not the ends of ranges: a
    joint that closes less may have a larger or a smaller kni.
    """

    title: str
    ending: str
    joint: str


_CHOICES = " with other choices of the model"
CHOICES = "_with_choices"
"""Ending of names of ends of bands with other choices of the model."""
ENDS = {
    "": End("", "", "the joint"),
    "_low": End(", low end of its band", "_closes_less", "a joint that closes less"),
    "_high": End(", high end of its band", "_closes_more", "a joint that closes more"),
    "_low_with_choices": End(
        f", low end of its band{_CHOICES}",
        "_closes_less_with_choices",
        f"a joint that closes less,{_CHOICES}",
    ),
    "_high_with_choices": End(
        f", high end of its band{_CHOICES}",
        "_closes_more_with_choices",
        f"a joint that closes more,{_CHOICES}",
    ),
}
"""The joint and the ends of its bands, by endings of columns of a `stress_table`."""


def loading_remark(joint: xr.Dataset, cycle: int) -> str:
    """State of which loading the constants for other programs are.

    It is a warning if that loading is stiffer or softer, against the first, than measured ones.
    """
    remark = f"{_EXPORTED} are of {loading_text(joint, cycle)}"
    later = joint.sizes["cycle"]
    if cycle == 1 and later > 1:
        remark += f"; --export-cycle {later} gives those of {loading_text(joint, later)}"
    beyond = beyond_measured(stiffness_ratio(joint, cycle))
    return caution(remark) if beyond else remark


def stiffness_ratio(joint: xr.Dataset, cycle: int) -> float:
    """Return the chord stiffness of a later cycle over that of the first, NaN for the first."""
    if cycle == 1:
        return np.nan
    stiffness = net_responses(joint)["stiffness_net"]
    return float(stiffness[cycle - 1] / stiffness[0])


def beyond_measured(ratio: float) -> bool:
    """Return whether a `stiffness_ratio` is known, and outside of measured ones."""
    low, high = measured_range("stiffness_ratio")
    return bool(np.isfinite(ratio)) and not low <= ratio <= high


def known_loadings(joint: xr.Dataset, curves: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of loadings where closure is known, without stresses that a user named."""
    usual = curves.normal_stress_MPa.isin(history_of(joint).table_levels() / 1e6)
    loading = curves[usual & (curves.branch == LOADING)]
    return loading.dropna(subset=columns_of(curves, "closure_net_since_seating_mm"))


def loading_text(joint: xr.Dataset, cycle: int) -> str:
    """Describe the loading of input of other programs, and how stiff it is against the first."""
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


def loading_by_ending(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int
) -> dict[str, pd.DataFrame]:
    """Return the rows of the loading of a cycle, by endings of files.

    The ending "" is that of the joint, the others of `ENDS` are those of ends of bands that are
    known. Raise `InputError` if the loading does not begin at or below the seating stress.
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
    of_ends = {}
    shown = [name for name in CURVES if name in rows]
    for ending in ENDS:
        if f"{shown[0]}{ending}" in rows:
            of_end = {name: rows[f"{name}{ending}"] for name in shown}
            about = rows[["cycle", "normal_stress_MPa"]]
            of_ends[ending] = pd.DataFrame(of_end | dict(about))
    return of_ends


def range_texts(curves: pd.DataFrame, low: str, high: str, choices: str) -> list[str]:
    """Explain the endings of names.

    These are ``low`` and ``high`` for ends of the range, with ``choices`` appended for the wider
    range.
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

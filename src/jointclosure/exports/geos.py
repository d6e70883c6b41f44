"""Tables of apertures and the BartonBandis element of GEOS."""

from itertools import product

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.ensembles.quantities import CURVES
from jointclosure.exports.hyperbola import LARGEST_DIFFERENCE
from jointclosure.exports.loading import (
    BAND_LIMITS,
    CHOICES,
    Exported,
    loading_by_suffix,
    loading_text,
    suffix_legend,
)
from jointclosure.inputs import InputError, naming
from jointclosure.inputs.remarks import caution
from jointclosure.joint.history import history_of
from jointclosure.joint.status import FLOW_STATUSES
from jointclosure.statistics.number_texts import percent
from jointclosure.uncertainty.ranges import RANGE_FLOW_STATUS

OPENING_SLOPE = 0.95
"""Largest slope at the end of a GEOS table. GEOS extrapolates the table to open walls, up to where
the aperture equals the gap, and therefore needs a slope below 1. The mean aperture of a joint has
a slope of nearly 1, because each wall keeps its volume."""
_END = 0.01
"""Share of the last interval that has this slope."""
_GEOS = """<!-- for <Functions>; its contact model has apertureTableName="joint_aperture".
     Gap and {aperture} in m,
     of the loading of {loading}.{ranges} -->
<TableFunction
  name="joint_aperture"
  coordinateFiles="{{ geos_gap.csv }}"
  voxelFile="{file}"
  interpolation="linear"/>
"""


def geos_files(joint: xr.Dataset, curves: pd.DataFrame, cycle: int = 1) -> Exported:
    """Return GEOS tables of the aperture [m] of a loading over its gap [m].

    The aperture is the hydraulic one for a joint with flow, with a table of its upper bound, else
    the mean aperture. There is a table for the joint and for each limit of the band. `geos.xml`
    names the first table that can be written. Remarks name the tables that are not written, and say
    so if the table in `geos.xml` is of a bound or of a limit of the band. Raise `InputError` if no
    table can be written, or if the loading does not close monotonically from a seating stress
    above 0.
    """
    if history_of(joint).seating_stress == 0.0:
        raise InputError("GEOS: the table begins at seating; seating_stress must be above 0")
    with naming("GEOS"):
        parts = loading_by_suffix(joint, curves, cycle)
    closure = 1e-3 * parts[""].closure_net_since_seating_mm.to_numpy()
    if not (closure.size > 1 and (np.diff(closure) > 0.0).all()):
        must = "must close monotonically from seating to its maximum"
        raise InputError(f"GEOS: the loading of cycle {cycle} {must}")
    columns = {"": "mean_aperture_mm"}  # by what follows "aperture" in the names of files
    if history_of(joint).has_flow:
        columns = {"": "hydraulic_aperture_mm", "_bound": "largest_hydraulic_mm"}
    apertures: dict[str, np.ndarray] = {}
    titles: dict[str, str] = {}
    reasons: dict[str, str] = {}
    for (word, column), (suffix, rows) in product(columns.items(), parts.items()):
        aperture = 1e-3 * rows[column].to_numpy()
        name = f"geos_aperture{word}{suffix}.csv"
        missing = ~(aperture > 0.0)
        if not missing.any():
            # falls with stress, so that no aperture exceeds those before
            apertures[name] = np.minimum.accumulate(aperture)
            titles[name] = CURVES[column][0].removesuffix(" (mm)") + BAND_LIMITS[suffix].title
            continue
        what = CURVES[column][0].removesuffix(" (mm)") + BAND_LIMITS[suffix].title
        place = rows.index[int(np.argmax(missing))]
        stress, value = rows.normal_stress_MPa[place], rows[column][place]
        reason = f"the {what}, is" if BAND_LIMITS[suffix].title else f"the {what} is"
        reason += f" {'not known' if np.isnan(value) else '0'} at {stress:.3g} MPa"
        name_of_status = RANGE_FLOW_STATUS if suffix else "flow_status"
        if name_of_status in curves and curves[name_of_status][place] != FLOW_STATUSES[0]:
            reason += f" ({name_of_status}: {curves[name_of_status][place]})"
        reasons[name] = f"{reason}, and GEOS needs a positive one at every stress"
    if not apertures:
        raise InputError(f"GEOS: {next(iter(reasons.values()))}")
    remarks = [f"not written: {name}: {reason}" for name, reason in reasons.items()]
    gap, tables = _with_opening(closure, np.stack(list(apertures.values())))
    written = {"geos_gap.csv": gap} | dict(zip(apertures, tables, strict=True))
    lines = {name: [f"{value:.9e}\n" for value in values] for name, values in written.items()}
    named = next(iter(apertures))
    if named != "geos_aperture.csv":
        remarks.append(
            f"geos.xml: its table, {named}, is the {titles[named]}, not the aperture itself"
        )
    title = titles[named].replace("upper bound", "UPPER BOUND")
    of_loading = loading_text(joint, cycle)
    about = suffix_legend(curves, "_low", "_high", "_with_choices")
    ranges = "".join(f"\n     {line}." for line in about)
    form = _GEOS.format(aperture=title, loading=of_loading, file=named, ranges=ranges)
    return Exported({name: "".join(lines[name]) for name in lines} | {"geos.xml": form}, remarks)


_COMPLIANCE_FACTOR = 9.0
"""Factor 9 of GEOS' BartonBandis, a0/(1 + 9 s/s_ref): at s_ref a tenth of a0 is left."""


def geos_barton_bandis(joint: xr.Dataset, curves: pd.DataFrame, cycle: int = 1) -> Exported:
    """Return the BartonBandis element of GEOS, fitted to the aperture of the loading of a cycle.

    The aperture is the hydraulic one for a joint with flow, else the mean one. The law
    a0/(1 + 9 s/s_ref) falls with the stress s from a0 at zero stress to a tenth at the reference
    stress s_ref (`BartonBandis.hpp` of GEOS). Remarks state its largest error, and name the limits
    of the band to which it cannot be fitted. Raise `InputError` if it cannot be fitted to the joint
    itself: fewer than three apertures are known, or they do not fall with stress.
    """
    remarks: list[str] = []
    column = "hydraulic_aperture_mm" if history_of(joint).has_flow else "mean_aperture_mm"
    title = CURVES[column][0].removesuffix(" (mm)")
    with naming("GEOS"):
        parts = loading_by_suffix(joint, curves, cycle)
    lines = [f"  <!-- of the loading of {loading_text(joint, cycle)} -->"]
    about = suffix_legend(curves, "_low", "_high", "_with_choices")
    lines += [f"  <!-- {line} -->" for line in about]
    errors: dict[str, tuple[float, float]] = {}  # largest [mm], and largest over the aperture
    for suffix, rows in parts.items():
        known = rows[rows[column] > 0.0]
        name = f"joint_aperture{suffix}"
        must = f"the {title} must be known, and fall with stress"
        stress = known.normal_stress_MPa.to_numpy()
        aperture = known[column].to_numpy()
        # 1/a = 1/a0 + 9 s/(a0 s_ref) is a straight line; by the weights errors are those of a
        slope = 0.0
        start = 0.0
        if stress.size > 2:
            slope, start = np.polyfit(stress, 1.0 / aperture, 1, w=aperture**2)
        if not (slope > 0.0 and start > 0.0):
            if not suffix:
                raise InputError(f"GEOS: BartonBandis: {must}")
            remarks.append(f"not written: {name} of geos_barton_bandis.xml: {must}")
            continue
        reference = _COMPLIANCE_FACTOR * start / slope
        error = np.abs(1.0 / (start + slope * stress) - aperture)
        errors[suffix] = float(error.max()), float((error / aperture).max())
        off = _error_text(*errors[suffix])
        lines += [
            f"  <!-- {title}, {stress[0]:g} to {stress[-1]:g} MPa: {off} -->",
            f'  <BartonBandis name="{name}" referenceAperture="{1e-3 / start:.6e}" '
            f'referenceNormalStress="{1e6 * reference:.6e}"/>',
        ]
    remark = f"geos_barton_bandis.xml, of cycle {cycle}: its {title} is {_error_text(*errors[''])}"
    if of_choices := [error for suffix, error in errors.items() if suffix.endswith(CHOICES)]:
        largest = _error_text(*map(max, *of_choices, (0, 0)))
        remark += f"; with other choices of the model it is {largest}"
    if max(share for _, share in errors.values()) > LARGEST_DIFFERENCE:
        tables = "the tables of geos.xml have the apertures themselves"
        remark = caution(f"{remark}; this law does not describe the joint: {tables}")
    remarks.insert(0, remark)
    body = ["<Constitutive>", *lines, "</Constitutive>"]
    return Exported({"geos_barton_bandis.xml": "\n".join(body) + "\n"}, remarks)


def _error_text(error: float, share: float) -> str:
    """Format the largest error [mm] of a fitted aperture, and the largest over the aperture [1]."""
    return f"off by up to {1e3 * error:.2g} um, {percent(share)}"


def _with_opening(closure: np.ndarray, apertures: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the gaps (k,) and the apertures (tables, k) [m] of GEOS tables, ascending in the gap.

    They are made of closures (n,) and apertures (tables, n) [m] on loading: the gap is minus the
    closure since the first value, so that it ends at 0. If a table is steeper than `OPENING_SLOPE`
    at its end, a point is inserted (k = n + 1) before which the table keeps its values, and after
    which no table is steeper.
    """
    gap = -(closure - closure[0])[::-1]
    gap[-1] = 0.0  # not -0.0
    values = apertures[:, ::-1]
    slopes = (values[:, -1] - values[:, -2]) / (gap[-1] - gap[-2])
    if slopes.max() > OPENING_SLOPE:
        before = _END * gap[-2]
        opened = values[:, -1] + np.minimum(slopes, OPENING_SLOPE) * before
        gap = np.insert(gap, -1, before)
        values = np.insert(values, -1, opened, axis=1)
    return gap, values

"""Files of a simulated joint: tables, figures, and inputs of other programs (docs/export.md)."""

from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.results import FIGURES
from jointclosure.ensembles.quantities import CURVES
from jointclosure.inputs import InputError, naming
from jointclosure.inputs.remarks import caution
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.history import history_of
from jointclosure.joint.interpolation import cubic_over
from jointclosure.joint.laws import (
    BENDS,
    LAWS,
    JointLaws,
    fit_law,
    fitted_laws,
    law_curves,
    loading_hyperbolas,
)
from jointclosure.joint.status import LOADING, ONLY_BOUNDS, failed
from jointclosure.joint.tables import (
    columns_of,
    curve_table,
    cycle_table,
    has_bands,
    wider_columns_of,
)
from jointclosure.statistics.number_texts import percent
from jointclosure.uncertainty.published_joints import measured_range
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
_EXPORTED = "constants for other programs (barton_bandis.dat, porepy*.json) and tables for GEOS"
_FITTED = "PorePy, UDEC, 3DEC"
"""Programs that receive constants of fitted hyperbolas."""
_NET = (
    "stiffness, laws and inputs of other programs are net, without the elastic indentation of "
    "the half-spaces; answer.csv, curves.csv and cycles.csv have gross values too"
)


def export_files(
    joint: xr.Dataset,
    title: str,
    curves: pd.DataFrame,
    laws: JointLaws,
    cycle: int = 1,
) -> dict[str, Any]:
    """Return the files of a joint by name, and print which ones are not written.

    ``curves`` is its `stress_table`, with bands if they are known, and ``cycle`` is the cycle whose
    loading the constants for other programs describe. A joint that failed has no files.
    """
    if failed(joint):
        return {}
    from jointclosure.plotting.joint import engineering_figure

    curves = curves.copy()
    for number, law in laws.by_cycle.items():
        above = 1e6 * curves.normal_stress_MPa - history_of(joint).seating_stress
        here = (curves.cycle == number) & (curves.branch == LOADING)
        curves.loc[here, "barton_bandis_mm"] = 1e3 * law.closure(above[here])
    tables = {
        "curves": curve_table(joint),
        "cycles": cycle_table(joint),
        "answer": curves,
        "laws": fitted_laws(joint),
    }
    form: dict[str, Any] = {"index": False, "float_format": f"%.{FIGURES}g"}
    files: dict[str, Any] = {f"{name}.csv": tables[name].to_csv(**form) for name in tables}
    print(f"\nFiles\n- {_NET}")
    for remark in export_remarks(joint, cycle):
        print(f"- {remark}")
    fitted = fitted_loading(joint, curves, cycle)
    for export in (
        itasca_tables,
        partial(barton_bandis_commands, laws=laws, cycle=cycle, fitted=fitted),
        partial(porepy_files, cycle=cycle, fitted=fitted),
        partial(geos_files, cycle=cycle),
        partial(geos_barton_bandis, cycle=cycle),
        fracture_mesh,
    ):
        try:
            files |= export(joint, curves)
        except InputError as error:  # the files of other programs are still written
            print(f"- not written: {error}")
    return files | {"engineering.png": engineering_figure(joint, title, curves, laws.by_cycle)}


def exported_loading(joint: xr.Dataset, cycle: int) -> str:
    """Describe the loading of constants for other programs; "" for a joint that failed."""
    return "" if failed(joint) else _of_loading(joint, cycle)


def export_remarks(joint: xr.Dataset, cycle: int) -> list[str]:
    """State of which loading the constants for other programs are.

    It is a warning if that loading is stiffer or softer, against the first, than measured ones.
    """
    if failed(joint):
        return []
    remark = f"{_EXPORTED} are of {_of_loading(joint, cycle)}"
    later = joint.sizes["cycle"]
    if cycle == 1 and later > 1:
        remark += f"; --export-cycle {later} gives those of {_of_loading(joint, later)}"
    beyond = _beyond_measured(_stiffness_ratio(joint, cycle))
    return [caution(remark) if beyond else remark]


def _stiffness_ratio(joint: xr.Dataset, cycle: int) -> float:
    """Return the chord stiffness of a later cycle over that of the first, NaN for the first."""
    if cycle == 1:
        return np.nan
    stiffness = net_responses(joint)["stiffness_net"]
    return float(stiffness[cycle - 1] / stiffness[0])


def _beyond_measured(ratio: float) -> bool:
    """Return whether a `_stiffness_ratio` is known, and outside of measured ones."""
    low, high = measured_range("stiffness_ratio")
    return bool(np.isfinite(ratio)) and not low <= ratio <= high


def _known_loadings(joint: xr.Dataset, curves: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of loadings where closure is known, without stresses that a user named."""
    usual = curves.normal_stress_MPa.isin(history_of(joint).table_levels() / 1e6)
    loading = curves[usual & (curves.branch == LOADING)]
    return loading.dropna(subset=columns_of(curves, "closure_net_since_seating_mm"))


def _of_loading(joint: xr.Dataset, cycle: int) -> str:
    """Describe the loading of input of other programs, and how stiff it is against the first."""
    if cycle == 1:
        return "cycle 1, the first loading"
    about = f"cycle {cycle}"
    ratio = _stiffness_ratio(joint, cycle)
    if np.isfinite(ratio):
        about += f", which is {ratio:.3g} times as stiff as cycle 1 (chord stiffness)"
    if _beyond_measured(ratio):
        low, high = measured_range("stiffness_ratio")
        about += (
            f", while later loadings of measured joints were {low:.2g} to {high:.2g} times as "
            "stiff as the first"
        )
    return about


def _loading_by_ending(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int
) -> dict[str, pd.DataFrame]:
    """Return the rows of the loading of a cycle, by endings of files.

    The ending "" is that of the joint, the others of `_ENDS` are those of ends of bands that are
    known. Raise `InputError` if the loading does not begin at or below the seating stress.
    """
    history = history_of(joint)
    loading = history.cycles[cycle - 1].loading
    known = _known_loadings(joint, curves)
    rows = known[known.cycle == cycle]
    begins = loading.has_steps and history.stress[loading.steps].min() <= history.seating_stress
    if rows.empty or not begins:
        raise InputError(
            f"the loading of cycle {cycle} does not begin at or below the seating stress, "
            f"{history.seating_stress:g} Pa"
        )
    of_ends = {}
    shown = [name for name in CURVES if name in rows]
    for ending in _ENDS:
        if f"{shown[0]}{ending}" in rows:
            of_end = {name: rows[f"{name}{ending}"] for name in shown}
            about = rows[["cycle", "normal_stress_MPa"]]
            of_ends[ending] = pd.DataFrame(of_end | dict(about))
    return of_ends


class _End(NamedTuple):
    """The joint, or an end of its bands: addition to titles, ending of constants, and their joint.

    The constants are fitted to this end of the band of closure. They are not the ends of ranges: a
    joint that closes less may have a larger or a smaller kni.
    """

    title: str
    ending: str
    joint: str


_CHOICES = " with other choices of the model"
_ENDS = {
    "": _End("", "", "the joint"),
    "_low": _End(", low end of its band", "_closes_less", "a joint that closes less"),
    "_high": _End(", high end of its band", "_closes_more", "a joint that closes more"),
    "_low_with_choices": _End(
        f", low end of its band{_CHOICES}",
        "_closes_less_with_choices",
        f"a joint that closes less,{_CHOICES}",
    ),
    "_high_with_choices": _End(
        f", high end of its band{_CHOICES}",
        "_closes_more_with_choices",
        f"a joint that closes more,{_CHOICES}",
    ),
}
"""The joint and the ends of its bands, by endings of columns of a `stress_table`."""


def _about_ranges(curves: pd.DataFrame, low: str, high: str, choices: str) -> list[str]:
    """Explain the endings of names.

    These are ``low`` and ``high`` for ends of the range, with ``choices`` appended for the wider
    range.
    """
    lines: list[str] = []
    if has_bands(curves):
        lines.append(
            f"{low} and {high} are of the ends of the range of 9 in 10 joints that have these "
            "scans and the stated properties"
        )
    if wider_columns_of(curves, "closure_net_since_seating_mm"):
        lines.append(
            f"{low}{choices} and {high}{choices} are of the ends of the range with other choices "
            "of the model too"
        )
    return lines


class Hyperbola(NamedTuple):
    """Hyperbola of a loading: kni [Pa/m], Vm [m] and mean aperture at seating [m]."""

    stiffness: float
    largest_closure: float
    aperture: float


def _hyperbolas(joint: xr.Dataset, curves: pd.DataFrame, cycle: int) -> dict[str, Hyperbola]:
    """Return the hyperbolas of a loading by endings of constants; print which ends have none.

    They are net, because programs deform the rock themselves, and count from the seating stress,
    at which all have the aperture of the joint. That of the joint is the one of `fitted_laws`;
    those of a band are fitted at the same stresses. Raise `InputError` if the joint has none.
    """
    history = history_of(joint)
    seating = 1e-6 * history.seating_stress
    law = LAWS["hyperbolic"]
    loadings = _loading_by_ending(joint, curves, cycle)
    former = history.former_maxima[cycle - 1]
    if former:
        raise InputError(
            f"the loading of cycle {cycle} goes beyond its former maximum, "
            f"{1e-6 * former:.3g} MPa, which is no hyperbola"
        )
    aperture = 1e3 * history.curve("mean_aperture").seat(cycle, LOADING)
    stress, closure = law_curves(joint)[cycle, LOADING]
    found = {}

    def leave_out(end: _End, reason: str) -> None:
        """Print why an end of the band has no constants; without those of the joint raise this."""
        if not end.ending:
            raise InputError(reason)
        print(f"- {_FITTED}: not written: {end.joint} (end of the band of closure): {reason}")

    for of_band, rows in loadings.items():
        end = _ENDS[of_band]
        if rows.closure_net_since_seating_mm.isna().any():  # with other choices of the model
            leave_out(end, "its closure is not known at every stress")
            continue
        more = _difference_at(stress, rows, loadings[""], seating)
        (stiffness, largest), _, _ = fit_law(law, stress, closure + more, seating)
        if not np.isfinite([stiffness, largest]).all():
            reason = (
                f"the loading of cycle {cycle} hardly bends: Vm is undetermined, more than "
                f"{BENDS:g} times its largest closure or less than its standard error"
            )
            if np.isnan(stiffness):
                reason = (
                    f"the loading of cycle {cycle} does not determine kni, which is less than its "
                    "standard error"
                )
            leave_out(end, reason)
            continue
        if not (stiffness > 0.0 and largest > 0.0 and aperture > 0.0):
            leave_out(
                end,
                f"the hyperbola of cycle {cycle} has kni = {stiffness:g} MPa/mm and Vm "
                f"= {largest:g} mm at a mean aperture of {aperture:g} mm: all must be positive",
            )
            continue
        found[end.ending] = Hyperbola(1e9 * stiffness, 1e-3 * largest, 1e-3 * aperture)
    return found


class FittedLoading(NamedTuple):
    """Hyperbolas of a loading by endings of constants, or the ``reason`` why the joint has none."""

    hyperbolas: dict[str, Hyperbola]
    reason: str = ""

    def required_by(self, programs: str) -> dict[str, Hyperbola]:
        """Return the hyperbolas; raise `InputError`, which names programs, if there are none."""
        if self.reason:
            raise InputError(f"{programs}: {self.reason}")
        return self.hyperbolas


def fitted_loading(joint: xr.Dataset, curves: pd.DataFrame, cycle: int) -> FittedLoading:
    """Fit hyperbolas to a loading, and to the ends of its band of closure (`_hyperbolas`)."""
    try:
        return FittedLoading(_hyperbolas(joint, curves, cycle))
    except InputError as error:
        return FittedLoading({}, str(error))


def _difference_at(
    stress: np.ndarray, rows: pd.DataFrame, of_joint: pd.DataFrame, seating: float
) -> np.ndarray:
    """Return how much more an end of a band closes than the joint (n,) [mm] at stresses [MPa]."""
    column = "closure_net_since_seating_mm"
    known = rows.normal_stress_MPa.to_numpy()
    more = (rows[column] - of_joint[column]).to_numpy()
    if seating == 0.0:  # the first known stress is above seating, from which closures count
        known = np.insert(known, 0, 0.0)
        more = np.insert(more, 0, 0.0)
    return cubic_over(known, more - more[0])(np.clip(stress, known[0], known[-1]))


def porepy_files(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int = 1, fitted: FittedLoading | None = None
) -> dict[str, dict[str, float]]:
    """Return PorePy's Barton-Bandis constants [Pa/m, m, m] of the loading of a cycle.

    They are those of its hyperbolas, which are ``fitted`` unless they are given. Their aperture is
    the mean aperture; for a joint with flow the ratio of the hydraulic aperture to it is printed.
    """
    hyperbolas = (fitted or fitted_loading(joint, curves, cycle)).required_by("PorePy")
    if history_of(joint).has_flow:
        top = _loading_by_ending(joint, curves, cycle)[""].iloc[-1]
        ratio = top.hydraulic_aperture_mm / top.mean_aperture_mm
        text = f"{ratio:.2g} times it" if np.isfinite(ratio) else "not known"
        text = "0 (blocked)" if ratio == 0.0 else text
        print(
            "- PorePy: residual_aperture is of the mean aperture; the hydraulic aperture is "
            f"{text} at {top.normal_stress_MPa:g} MPa"
        )
    return {
        f"porepy{ending}.json": {
            "fracture_normal_stiffness": law.stiffness,
            "maximum_elastic_fracture_opening": law.largest_closure,
            "residual_aperture": max(law.aperture - law.largest_closure, 0.0),
        }
        for ending, law in hyperbolas.items()
    }


_STIFFNESS_FUNCTION = """
; tangent normal stiffness (Pa/m) at a normal stress (Pa, compression positive) from seating on,
; by constants such as bb_kni and bb_vm
fish define bb_stiffness(stress, kni, vm)
    bb_stiffness = kni * (1.0 + (stress - bb_seating) / (kni * vm))^2
end
"""


def barton_bandis_commands(
    joint: xr.Dataset,
    curves: pd.DataFrame,
    laws: JointLaws,
    cycle: int = 1,
    fitted: FittedLoading | None = None,
) -> dict[str, str]:
    """Return Barton-Bandis constants [SI] as FISH variables, for UDEC and 3DEC.

    Those fitted to the loading of a cycle count from seating, and are given for joints at the ends
    of the bands of closure too; its hyperbolas are ``fitted`` unless they are given. Those fitted
    to the other loadings have the number of their cycle in their names. Those of the empirical law,
    of JRC and JCS at both lengths, are named so, and count from zero stress. If only these exist,
    the reason is printed.
    """
    seating = float(joint.attrs["seating_stress_Pa"])
    values: dict[str, tuple[float, str]] = {}
    if laws.by_cycle:
        jrc, wall_strength = laws.scaled
        length = laws.joint_length or laws.lab_length
        values |= {
            "bb_lab_length": (laws.lab_length, "length of the laboratory joint L0 (m)"),
            "bb_lab_jrc": (laws.jrc, "JRC0, at the length of the laboratory joint"),
            "bb_lab_jcs": (laws.strength, "JCS0 (Pa), at the length of the laboratory joint"),
            "bb_sigma_c": (laws.strength, "compressive strength of the rock (Pa)"),
            "bb_length": (length, "length of the joint Ln (m)"),
            "bb_jrc": (jrc, "JRCn, at the length of the joint"),
            "bb_jcs": (wall_strength, "JCSn (Pa), at the length of the joint"),
            "bb_empirical_aperture": (
                laws.from_zero(1).aperture,
                "aperture aj (m) of the empirical law at zero stress",
            ),
        }
    for number in laws.by_cycle:
        law = laws.from_zero(number)
        where = f"of the empirical law (JRC, JCS), cycle {number}, from zero stress"
        values[f"bb_empirical_kni_cycle_{number}"] = law.initial_stiffness, f"kni (Pa/m) {where}"
        values[f"bb_empirical_vm_cycle_{number}"] = law.largest_closure, f"Vm (m) {where}"
    fitted = fitted or fitted_loading(joint, curves, cycle)
    function = _STIFFNESS_FUNCTION
    if fitted.reason and values:
        function = f"; no constants of the simulated joint: UDEC, 3DEC: {fitted.reason}\n"
        print(f"- not written: constants of the simulated joint: UDEC, 3DEC: {fitted.reason}")
    hyperbolas = fitted.hyperbolas if values else fitted.required_by("UDEC, 3DEC")
    joints = {end.ending: end.joint for end in _ENDS.values()}
    for ending, known in hyperbolas.items():
        end = f": {joints[ending]}, an end of the band of closure" if ending else ""
        where = f"of the hyperbola fitted from {1e-6 * seating:g} MPa to cycle {cycle}{end}"
        values[f"bb_kni{ending}"] = known.stiffness, f"kni (Pa/m) {where}"
        values[f"bb_vm{ending}"] = known.largest_closure, f"Vm (m) {where}"
    others = [number for number in joint.cycle.values if hyperbolas and number != cycle]
    for number, constants in loading_hyperbolas(joint, others).iterrows():
        if np.isfinite(constants).all():
            where = f"of the hyperbola fitted from {1e-6 * seating:g} MPa to cycle {number}"
            values[f"bb_kni_cycle_{number}"] = 1e9 * constants.kni_MPa_per_mm, f"kni (Pa/m) {where}"
            values[f"bb_vm_cycle_{number}"] = 1e-3 * constants.vm_mm, f"Vm (m) {where}"
    if hyperbolas:
        values["bb_seating"] = seating, "seating stress (Pa)"
    lines = [f"[global {name} = {value:.6e}] ; {about}" for name, (value, about) in values.items()]
    head = ["; Barton-Bandis constants in SI, net of the deformation of the rock"]
    if hyperbolas:
        head.append(
            "; bb_kni and bb_vm are of the simulated joint (names with empirical are not): of "
            f"{_of_loading(joint, cycle)}"
        )
        loadings = _known_loadings(joint, curves)
        of_cycle = loadings[loadings.cycle == cycle]
        head.append(f"; {_about_tangent(hyperbolas[''], of_cycle, seating)}")
        ranges = _about_ranges(curves, "_closes_less", "_closes_more", "_with_choices")
        head += [f"; {line}" for line in ranges]
    return {"barton_bandis.dat": "\n".join([*head, *lines]) + "\n" + function}


def geos_files(joint: xr.Dataset, curves: pd.DataFrame, cycle: int = 1) -> dict[str, str]:
    """Return gaps and apertures [m], hydraulic or mean, of a loading as GEOS reads them.

    `geos.xml` names the first table that can be written. Printed are the tables that are not
    written, and a note if the named one is a bound or an end of a band.
    """
    if history_of(joint).seating_stress == 0.0:
        raise InputError("GEOS: the table begins at seating; seating_stress must be above 0")
    with naming("GEOS"):
        parts = _loading_by_ending(joint, curves, cycle)
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
    for (word, column), (ending, rows) in product(columns.items(), parts.items()):
        aperture = 1e-3 * rows[column].to_numpy()
        name = f"geos_aperture{word}{ending}.csv"
        missing = ~(aperture > 0.0)
        if not missing.any():
            # falls with stress, so that no aperture exceeds those before
            apertures[name] = np.minimum.accumulate(aperture)
            titles[name] = CURVES[column][0].removesuffix(" (mm)") + _ENDS[ending].title
            continue
        first = rows.normal_stress_MPa.iloc[int(np.argmax(missing))]
        reason = f"the {CURVES[column][0].removesuffix(' (mm)')} must be known and positive, and "
        reason += f"is not at {first:.3g} MPa"
        if history_of(joint).has_flow:
            name_of_status = RANGE_FLOW_STATUS if ending else "flow_status"
            status = curves[name_of_status][rows.index[int(np.argmax(missing))]]
            reason += f" ({name_of_status}: {status})"
        reasons[name] = reason
    if not apertures:
        raise InputError(f"GEOS: {next(iter(reasons.values()))}")
    for name, reason in reasons.items():
        print(f"- not written: {name}: {reason}")
    gap, tables = _with_opening(closure, np.stack(list(apertures.values())))
    written = {"geos_gap.csv": gap} | dict(zip(apertures, tables, strict=True))
    lines = {name: [f"{value:.9e}\n" for value in values] for name, values in written.items()}
    named = next(iter(apertures))
    if named != "geos_aperture.csv":
        print(f"- geos.xml: its table, {named}, is the {titles[named]}, not the aperture itself")
    title = titles[named].replace("upper bound", "UPPER BOUND")
    of_loading = _of_loading(joint, cycle)
    about = _about_ranges(curves, "_low", "_high", "_with_choices")
    ranges = "".join(f"\n     {line}." for line in about)
    form = _GEOS.format(aperture=title, loading=of_loading, file=named, ranges=ranges)
    return {name: "".join(lines[name]) for name in lines} | {"geos.xml": form}


_COMPLIANCE_FACTOR = 9.0
"""Factor 9 of GEOS' BartonBandis, a0/(1 + 9 s/s_ref): at s_ref a tenth of a0 is left."""


def _about_tangent(law: Hyperbola, loading: pd.DataFrame, seating: float) -> str:
    """Say how far the stiffness of a hyperbola is from that of its loading, above seating [Pa]."""
    rows = loading[1e6 * loading.normal_stress_MPa > seating]
    rows = rows.dropna(subset="normal_stiffness_net_MPa_per_mm")
    if rows.empty:
        return "the stiffness of the loading is not known"
    stress = rows.normal_stress_MPa.to_numpy()
    above = 1e6 * stress - seating
    tangent = law.stiffness * (1.0 + above / (law.stiffness * law.largest_closure)) ** 2
    apart = 1e-9 * tangent / rows.normal_stiffness_net_MPa_per_mm.to_numpy() - 1.0
    return (
        f"the stiffness of the hyperbola of bb_kni and bb_vm differs from that of the joint "
        f"(answer.csv) by {percent(apart.min())} to {percent(apart.max())} at {stress.min():.3g} "
        f"to {stress.max():.3g} MPa"
    )


def geos_barton_bandis(joint: xr.Dataset, curves: pd.DataFrame, cycle: int = 1) -> dict[str, str]:
    """Return GEOS' BartonBandis, fitted to apertures of a loading, hydraulic or mean.

    Its aperture a0/(1 + 9 s/s_ref) falls with the stress s from a0 at zero stress to a tenth at the
    reference stress s_ref (`BartonBandis.hpp` of GEOS).
    """
    column = "hydraulic_aperture_mm" if history_of(joint).has_flow else "mean_aperture_mm"
    title = CURVES[column][0].removesuffix(" (mm)")
    with naming("GEOS"):
        parts = _loading_by_ending(joint, curves, cycle)
    lines = [f"  <!-- of the loading of {_of_loading(joint, cycle)} -->"]
    about = _about_ranges(curves, "_low", "_high", "_with_choices")
    lines += [f"  <!-- {line} -->" for line in about]
    for ending, rows in parts.items():
        known = rows[rows[column] > 0.0]
        name = f"joint_aperture{ending}"
        must = f"the {title} must be known, and fall with stress"
        stress = known.normal_stress_MPa.to_numpy()
        aperture = known[column].to_numpy()
        # 1/a = 1/a0 + 9 s/(a0 s_ref) is a straight line; by the weights errors are those of a
        slope = 0.0
        start = 0.0
        if stress.size > 2:
            slope, start = np.polyfit(stress, 1.0 / aperture, 1, w=aperture**2)
        if not (slope > 0.0 and start > 0.0):
            if not ending:
                raise InputError(f"GEOS: BartonBandis: {must}")
            print(f"- not written: {name} of geos_barton_bandis.xml: {must}")
            continue
        reference = _COMPLIANCE_FACTOR * start / slope
        miss = np.abs(1.0 / (start + slope * stress) - aperture)
        lines += [
            f"  <!-- {title}, {stress[0]:g} to {stress[-1]:g} MPa: off by up to "
            f"{1e3 * miss.max():.2g} um, {percent((miss / aperture).max())} -->",
            f'  <BartonBandis name="{name}" referenceAperture="{1e-3 / start:.6e}" '
            f'referenceNormalStress="{1e6 * reference:.6e}"/>',
        ]
    body = ["<Constitutive>", *lines, "</Constitutive>"]
    return {"geos_barton_bandis.xml": "\n".join(body) + "\n"}


def _with_opening(closure: np.ndarray, apertures: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return gaps and apertures (tables, n) [m], with a last slope of at most `OPENING_SLOPE`."""
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


_TABLES = (
    ("tangent stiffness (Pa/m) against normal stress (Pa) by cycle and branch", "kn",
     "normal_stiffness_net_MPa_per_mm", 1e9),
    ("hydraulic aperture (m) against normal stress (Pa) by cycle and branch", "aperture",
     "hydraulic_aperture_mm", 1e-3),
    ("its upper bound (m), as if the open cells of lines across the flow were connected",
     "aperture-bound", "largest_hydraulic_mm", 1e-3),
)  # fmt: skip
"""Comment, name, column and unit of the tables for 3DEC; the last two are of flow."""


def itasca_tables(joint: xr.Dataset, curves: pd.DataFrame) -> dict[str, str]:
    """Return commands of 3DEC 7 that define tables by cycle, branch and end of a band."""
    lines = [f"; {line}" for line in _about_ranges(curves, "-low", "-high", "-with-choices")]
    last = joint.sizes["cycle"]
    if _beyond_measured(_stiffness_ratio(joint, last)):
        lines.append(
            f"; tables of all cycles follow; among them are those of {_of_loading(joint, last)}"
        )
    tables = _TABLES if history_of(joint).has_flow else _TABLES[:1]
    for comment, name, column, scale in tables:
        lines.append(f"; {comment}")
        for member in [*columns_of(curves, column), *wider_columns_of(curves, column)]:
            ending = member.removeprefix(column).replace("_", "-")
            for (cycle, branch), part in curves.dropna(subset=member).groupby(["cycle", "branch"]):
                pairs = zip(1e6 * part.normal_stress_MPa, scale * part[member], strict=True)
                text = " ".join(f"({stress:.6e},{value:.6e})" for stress, value in pairs)
                lines.append(f"table '{name}-cycle-{cycle}-{branch}{ending}' add {text}")
        if column == "hydraulic_aperture_mm":
            lines += _unknown_apertures(curves)
    return {"joint_stiffness.dat": "\n".join(lines) + "\n"}


def _unknown_apertures(curves: pd.DataFrame) -> list[str]:
    """Return comments on the stresses at which only bounds of the aperture or its range are known.

    The range is not known if the flow of one of the variants of the joint is not.
    """
    lines = []
    for status, tables in (("flow_status", ""), (RANGE_FLOW_STATUS, ", tables of the range")):
        if status not in curves:
            continue
        unknown = curves[curves[status].isin(ONLY_BOUNDS)]
        lines += [
            f"; aperture-cycle-{cycle}-{branch}{tables}: not known, and no point of the table, at "
            f"{', '.join(f'{stress:.3g}' for stress in rows.normal_stress_MPa)} MPa ({status}: "
            f"{', '.join(rows[status].unique())}); aperture-bound has the upper bound"
            for (cycle, branch), rows in unknown.groupby(["cycle", "branch"])
        ]
    return lines


def fracture_mesh(joint: xr.Dataset, curves: pd.DataFrame) -> dict[str, tuple]:
    """Triangulate the midplane of the joint at its end, where the walls just touch.

    Fields of triangles, two between four cells: ``aperture`` [m], the mean of the corners,
    ``contact``, 1 if one of them is in contact, and ``MaterialIDs``, 0.
    """
    upper = joint.upper_final.values
    lower = joint.lower_final.values
    together = upper + lower
    aperture = together.max() - together  # exactly 0 at first touch
    midplane = lower + 0.5 * aperture
    ny, nx = upper.shape
    y, x = np.indices(upper.shape) * history_of(joint).spacing
    points = np.column_stack([x.ravel(), y.ravel(), midplane.ravel()])
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    halves = (corner, corner + 1, corner + nx), (corner + 1, corner + nx + 1, corner + nx)
    triangles = np.concatenate([np.stack(corners, axis=1) for corners in halves])
    of_corners = aperture.ravel()[triangles]
    fields = {
        "aperture": of_corners.mean(axis=1),
        "contact": (of_corners == 0.0).any(axis=1).astype(np.int32),
        "MaterialIDs": np.zeros(len(triangles), np.int32),
    }
    return {"fracture.vtu": (points, triangles, fields)}

"""Commands of UDEC and 3DEC: constants of Barton and Bandis, and tables of stiffness."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.exports.hyperbola import FittedLoading, fitted_loading
from jointclosure.exports.loading import (
    BAND_LIMITS,
    Exported,
    loading_text,
    stiffness_ratio,
    suffix_legend,
)
from jointclosure.joint.history import history_of
from jointclosure.joint.laws import JointLaws, loading_hyperbolas
from jointclosure.joint.result_tables import columns_of, wider_columns_of
from jointclosure.joint.status import ONLY_BOUNDS
from jointclosure.uncertainty.published_joints import beyond_measured
from jointclosure.uncertainty.ranges import RANGE_FLOW_STATUS

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
) -> Exported:
    """Return Barton-Bandis constants [SI] as FISH variables, for UDEC and 3DEC.

    The constants ``bb_kni`` and ``bb_vm`` of the hyperbola fitted to the loading of a cycle count
    from the seating stress, and exist for the limits of its band of closure too. ``fitted`` are
    these hyperbolas, which are computed if they are not given. Constants fitted to the other
    loadings have the number of their cycle in their names. Constants of the empirical law, for JRC
    and JCS at the lengths of the laboratory joint and of the joint, have the word empirical in
    their names, and count from zero stress. If only the empirical ones exist, a remark has the
    reason. Raise `InputError` if there are no constants at all.
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
    remarks = list(fitted.remarks)
    function = _STIFFNESS_FUNCTION
    if fitted.reason and values:
        without = f"constants of the simulated joint: UDEC, 3DEC: {fitted.reason}"
        function = f"; no {without}\n"
        remarks.append(f"not written: {without}")
    hyperbolas = fitted.hyperbolas if values else fitted.required_by("UDEC, 3DEC")
    joints = {limit.suffix: limit.joint for limit in BAND_LIMITS.values()}
    for suffix, known in hyperbolas.items():
        of_limit = f": {joints[suffix]}, an end of the band of closure" if suffix else ""
        where = f"of the hyperbola fitted from {1e-6 * seating:g} MPa to cycle {cycle}{of_limit}"
        values[f"bb_kni{suffix}"] = known.stiffness, f"kni (Pa/m) {where}"
        values[f"bb_vm{suffix}"] = known.largest_closure, f"Vm (m) {where}"
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
            f"{loading_text(joint, cycle)}"
        )
        words = fitted.stiffness_difference
        head.append(f"; the stiffness of the hyperbola of bb_kni and bb_vm {words}")
        ranges = suffix_legend(curves, "_closes_less", "_closes_more", "_with_choices")
        head += [f"; {line}" for line in ranges]
    text = "\n".join([*head, *lines]) + "\n" + function
    return Exported({"barton_bandis.dat": text}, remarks)


_TABLES = (
    ("tangent stiffness (Pa/m) against normal stress (Pa) by cycle and branch", "kn",
     "normal_stiffness_net_MPa_per_mm", 1e9),
    ("hydraulic aperture (m) against normal stress (Pa) by cycle and branch", "aperture",
     "hydraulic_aperture_mm", 1e-3),
    ("its upper bound (m), as if the open cells of lines across the flow were connected",
     "aperture-bound", "largest_hydraulic_mm", 1e-3),
)  # fmt: skip
"""Comment, name, column and unit of the tables for 3DEC; the last two are of flow."""


def itasca_tables(joint: xr.Dataset, curves: pd.DataFrame) -> Exported:
    """Return commands of 3DEC 7 that define tables of stiffness and aperture over stress [SI].

    There is a table for each cycle, branch, and limit of a band. ``curves`` is the `stress_table`
    of the joint, whose unknown values are no points of the tables.
    """
    lines = [f"; {line}" for line in suffix_legend(curves, "-low", "-high", "-with-choices")]
    last = joint.sizes["cycle"]
    if beyond_measured(stiffness_ratio(joint, last)):
        lines.append(
            f"; tables of all cycles follow; among them are those of {loading_text(joint, last)}"
        )
    tables = _TABLES if history_of(joint).has_flow else _TABLES[:1]
    for comment, name, column, scale in tables:
        lines.append(f"; {comment}")
        for member in [*columns_of(curves, column), *wider_columns_of(curves, column)]:
            suffix = member.removeprefix(column).replace("_", "-")
            for (cycle, branch), part in curves.dropna(subset=member).groupby(["cycle", "branch"]):
                pairs = zip(1e6 * part.normal_stress_MPa, scale * part[member], strict=True)
                text = " ".join(f"({stress:.6e},{value:.6e})" for stress, value in pairs)
                lines.append(f"table '{name}-cycle-{cycle}-{branch}{suffix}' add {text}")
        if column == "hydraulic_aperture_mm":
            lines += _unknown_apertures(curves)
    return Exported({"joint_stiffness.dat": "\n".join(lines) + "\n"}, [])


def _unknown_apertures(curves: pd.DataFrame) -> list[str]:
    """Return comments on the stresses at which the hydraulic aperture, or its range, is unknown.

    Only the bounds of the aperture are known there. Its range is unknown if the flow of one of the
    variants of the joint is unknown.
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

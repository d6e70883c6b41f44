"""Barton-Bandis constants of PorePy."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.exports.hyperbola import FittedLoading, fitted_loading
from jointclosure.exports.loading import Exported, loading_by_suffix
from jointclosure.joint.history import history_of


def porepy_files(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int = 1, fitted: FittedLoading | None = None
) -> Exported:
    """Return PorePy's Barton-Bandis constants [Pa/m, m, m] of the loading of a cycle.

    There is a file for the joint and for each limit of its band of closure that has a hyperbola.
    ``fitted`` are the hyperbolas of the loading, which are computed if they are not given, and
    which begin at the ``seating_stress`` [Pa] beside them. The residual aperture is the mean
    aperture at seating less Vm, at least 0; for a joint with flow a remark has the ratio of the
    hydraulic to the mean aperture at the largest stress. Raise `InputError` if no hyperbola can be
    fitted to the joint.
    """
    fitted = fitted or fitted_loading(joint, curves, cycle)
    hyperbolas = fitted.required_by("PorePy")
    remarks = list(fitted.remarks)
    if history_of(joint).has_flow:
        top = loading_by_suffix(joint, curves, cycle)[""].iloc[-1]
        ratio = top.hydraulic_aperture_mm / top.mean_aperture_mm
        text = f"{ratio:.2g} times it" if np.isfinite(ratio) else "not known"
        text = "0 (blocked)" if ratio == 0.0 else text
        remarks.append(
            "PorePy: residual_aperture is of the mean aperture; the hydraulic aperture is "
            f"{text} at {top.normal_stress_MPa:g} MPa"
        )
    seating = float(history_of(joint).seating_stress)
    constants = {
        f"porepy{suffix}.json": {
            "fracture_normal_stiffness": law.stiffness,
            "maximum_elastic_fracture_opening": law.largest_closure,
            "residual_aperture": max(law.aperture - law.largest_closure, 0.0),
            "seating_stress": seating,
        }
        for suffix, law in hyperbolas.items()
    }
    return Exported(constants, remarks)

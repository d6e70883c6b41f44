"""Curves and stiffness of many joints for engineering: medians and quantile bands over stress."""

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.aggregation import since_seating, succeeded
from jointclosure.joint.curves import KINDS
from jointclosure.joint.protocol import LOADING

QUANTILES = (0.05, 0.5, 0.95)


def band_table(
    case: xr.Dataset,
    quantiles: tuple[float, ...] = QUANTILES,
) -> pd.DataFrame:
    """Tabulate closure, stiffness and apertures over stress for all successful joints.

    Parameters
    ----------
    case : Dataset
        Over (realization, cycle, branch, stress): a case of a study, or an ensemble as from
        `jointclosure.simulate_ensemble`.
    quantiles : tuple of float
        In (0, 1); columns are named ``q05`` and so on.

    Returns
    -------
    DataFrame
        For each cycle, branch and stress: ``stress_MPa``, and for the net and the gross closure
        (`jointclosure.joint.curves.KINDS`) ``closure_<kind>_since_seating_mm``,
        ``closure_<kind>_mm`` (from first touch) and ``normal_stiffness_<kind>_MPa_per_mm`` (the
        chord of each joint to the next stress, in the row of the lower one); for joints with flow
        also ``mean_aperture_mm`` and ``hydraulic_aperture_x_mm``, ``..._y_mm``. Mean and
        quantiles are columns ``<name>_<statistic>``; ``samples`` is the number of joints that
        reach the stress. Statistics are NaN if no joint reaches it. The stiffness of a joint is
        NaN where closure does not change, and beyond the landing
        (`engineering.stiffness.landing_stress`).
    """
    good = case.where(succeeded(case))
    upper = good.stress.shift(stress=-1)
    landing = (good.branch == LOADING) & (upper > good.landing_stress)
    fields: dict[str, Any] = {}
    for kind in KINDS:
        net = kind == "net"
        closure = good.closure - good.bulk_indentation if net else good.closure
        fields[f"closure_{kind}_since_seating_mm"] = 1e3 * since_seating(good, net)
        fields[f"closure_{kind}_mm"] = 1e3 * closure
        fields[f"normal_stiffness_{kind}_MPa_per_mm"] = _stiffness(closure).where(~landing)
    if "hydraulic_aperture" in good:
        fields["mean_aperture_mm"] = 1e3 * good.mean_aperture
        for direction in good.direction.values:
            along = 1e3 * good.hydraulic_aperture.sel(direction=direction, drop=True)
            fields[f"hydraulic_aperture_{direction}_mm"] = along
    keys = ["cycle", "branch", "stress_MPa"]
    columns = {"samples": np.isfinite(good.closure).sum("realization")}
    for name, values in fields.items():
        axis = values.get_axis_num("realization")
        known = np.isfinite(values).any("realization")
        filled = values.where(known, 0.0)  # a quantile of no numbers would warn
        columns[f"{name}_mean"] = filled.mean("realization").where(known)
        bounds = np.nanquantile(filled.values, quantiles, axis=axis)
        for quantile, part in zip(quantiles, bounds, strict=True):
            label = f"{name}_q{round(100.0 * quantile):02d}"
            columns[label] = known.copy(data=part).where(known)
    table = xr.Dataset(columns).assign_coords(stress_MPa=("stress", 1e-6 * case.stress.values))
    table = table.swap_dims(stress="stress_MPa").drop_vars("stress")
    return table.to_dataframe(dim_order=keys).reset_index()[[*keys, *columns]]


def _stiffness(closure: xr.DataArray) -> xr.DataArray:
    """Return chords between neighbouring stresses [MPa/mm], NaN at the last one."""
    rise = closure.stress.diff("stress", label="lower")
    run = closure.diff("stress", label="lower")
    chords = 1e-9 * rise / run.where(run > 0.0)
    return chords.reindex(stress=closure.stress).transpose(*closure.dims)

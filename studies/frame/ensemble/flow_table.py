"""Table of the hydraulic apertures of a study's cases."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.aggregation import succeeded


def flow_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate apertures of every case over stress, for the successful realisations.

    Parameters
    ----------
    study : Dataset
        As from `jointclosure.engine.aggregation.join_cases`, of a study with flow.

    Returns
    -------
    DataFrame
        For each case, cycle, branch, direction and stress: ``samples``, the number of
        realisations that reach the stress, ``blocked``, the number of these without any flow,
        and ``mean`` and ``standard_deviation`` of the ``mean_aperture``, of the
        ``hydraulic_aperture`` [mm], and of the ``ratio`` of the latter to the former. NaN if no
        realisation reaches the stress.
    """
    good = study.where(succeeded(study))
    apertures = xr.Dataset(
        {
            "mean_aperture": 1e3 * good.mean_aperture.broadcast_like(good.hydraulic_aperture),
            "hydraulic_aperture": 1e3 * good.hydraulic_aperture,
            "ratio": good.hydraulic_aperture / good.mean_aperture,
        }
    )
    known = np.isfinite(apertures.hydraulic_aperture) & np.isfinite(apertures.mean_aperture)
    columns = {
        "samples": known.sum("realization"),
        "blocked": (apertures.hydraulic_aperture == 0.0).sum("realization"),
    }
    for name, values in apertures.where(known).data_vars.items():
        unit = "" if name == "ratio" else "_mm"
        columns[f"{name}_mean{unit}"] = values.mean("realization")
        columns[f"{name}_standard_deviation{unit}"] = values.std("realization", ddof=1)
    table = xr.Dataset(columns).assign_coords(stress_MPa=("stress", 1e-6 * study.stress.values))
    keys = ["case", "cycle", "branch", "direction", "stress_MPa"]
    frame = table.swap_dims(stress="stress_MPa").drop_vars("stress").to_dataframe(dim_order=keys)
    about = ["rock", "parameter", "level"]
    return frame.reset_index()[[*about, *keys, *columns]]

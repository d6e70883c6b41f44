"""Table of the mechanical (mean) and hydraulic apertures of the joints of an ensemble."""

import numpy as np
import pandas as pd
import xarray as xr

from studies.frame.joint_tables import over_stress, succeeded


def flow_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate means and standard deviations of apertures [mm] over the joints of an ensemble.

    Rows are case, cycle, branch, direction of flow and stress. ``samples`` is the number of joints
    in the means; ``blocked`` of these have no flow. Joints of which only bounds of the flow are
    known are left out of the means; ``unknown`` is their number.
    """
    good = study.where(succeeded(study))
    apertures = xr.Dataset(
        {
            "mean_aperture": 1e3 * good.mean_aperture.broadcast_like(good.hydraulic_aperture),
            "hydraulic_aperture": 1e3 * good.hydraulic_aperture,
            "ratio": good.hydraulic_aperture / good.mean_aperture,
        }
    )
    reached = np.isfinite(apertures.mean_aperture)
    known = np.isfinite(apertures.hydraulic_aperture) & reached
    columns = {
        "samples": known.sum("realization"),
        "blocked": (apertures.hydraulic_aperture == 0.0).sum("realization"),
        "unknown": (reached & ~known).sum("realization"),
    }
    for name, values in apertures.where(known).data_vars.items():
        unit = "" if name == "ratio" else "_mm"
        columns[f"{name}_mean{unit}"] = values.mean("realization")
        columns[f"{name}_standard_deviation{unit}"] = values.std("realization", ddof=1)
    return over_stress(columns, study.stress, ["case", "cycle", "branch", "direction"])

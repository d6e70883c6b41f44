"""Checks of the results of an ensemble, and the table of its apertures."""

import json

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.protocol import FLAGS
from jointclosure.parameters import Numerics, scene_of
from studies.frame.tables import over_stress, succeeded

VOLUME_TOLERANCE = 1e-12
FEWEST = 2
"""Smallest number of realisations of a case for which a standard deviation exists."""


def flow_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate apertures [mm] over all coordinates of joints; ``blocked`` have no flow."""
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
    return over_stress(columns, study.stress, ["case", "cycle", "branch", "direction"])


def check_results(
    study: xr.Dataset, numerics: Numerics, realizations: int, ensemble: str = "cases"
) -> pd.DataFrame:
    """Check what must hold for every successful simulation of an ensemble."""
    good = succeeded(study)
    rows = []

    def add(check: str, required: str, value, passed: object = True) -> None:
        row = {"check": check, "required": required, "found": value, "passed": bool(passed)}
        rows.append({"ensemble": ensemble} | row)

    def bounded(check: str, value: float, limit: float, shown: str = "g") -> None:
        add(check, f"at most {limit:{shown}}", f"{value:.3g}", value <= limit)

    total, successes = good.size, int(good.sum())
    add("simulations in a status of success", f"{total}", f"{successes}", successes == total)
    least = int(good.sum("realization").min())
    used = "realisations that statistics use, of the case with the fewest"
    add(used, f"at least {FEWEST} of {realizations}", f"{least}", least >= FEWEST)
    force = float(study.least_force.where(good).min())
    add("least force on a cell [N]", "not negative", f"{force:.3g}", force >= 0.0)
    scenes = [scene_of(name) for name in study.scene.values.tolist()]
    keeps = np.array([not scene.breakage or scene.gouge for scene in scenes])
    if keeps.any():
        volume = float(study.volume_error.where(good)[keeps].max())
        bounded("largest change of a wall's volume, relative", volume, VOLUME_TOLERANCE)
    residual = float(study.largest_residual.where(good).max())
    check = "largest residual of equilibrium, relative"
    fast = numerics.solver == "fast"
    if fast:
        bounded(check, residual, 1.01 * numerics.force_tolerance, ".3g")
    else:
        stops = f"reported only: the reference stops at a change of {numerics.sweep_tolerance:g}"
        add(check, stops, f"{residual:.3g}", np.isfinite(residual))
    if "largest_flow_imbalance" in study:
        from jointclosure.joint.flow import LARGEST_IMBALANCE

        imbalance = float(study.largest_flow_imbalance.where(good).max())
        balance = "largest sum of the cells' mass balances in a flow, relative"
        bounded(balance, imbalance, LARGEST_IMBALANCE)
    excess = float(
        (study.unloading_excess.max("cycle").where(good) / study.max_normal_stress).max()
    )
    exact = fast and not any(scene.breakage for scene in scenes)
    add(
        "largest excess of unloading over loading stress at equal closure, over the maximum",
        "0" if exact else "reported only",
        f"{excess:.3g}",
        excess == 0.0 if exact else np.isfinite(excess),
    )
    closures = study.max_closure.where(good)
    read = int(np.isfinite(closures.values[good.values]).all(axis=-1).sum())
    whole = "successful simulations with all closures read"
    add(whole, f"{successes}", f"{read}", read == successes)
    smallest = float(closures.min())
    add("maximum closures", "positive", f"{smallest:.3g} m at least", smallest > 0.0)
    for rock, walls in json.loads(study.attrs.get("walls", "{}")).items():
        apart = min(walls["windows_side_by_side"], realizations)
        sharing = f"at most {apart} of {realizations}"
        add(f"realisations of {rock} that share no part of a scan", "reported only", sharing)
    for mask, name in FLAGS.items():
        count = int(((study.status.values & mask) > 0).sum())
        add(f"simulations flagged {name}", "reported only", f"{count} of {total}")
    return pd.DataFrame(rows)

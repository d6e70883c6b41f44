"""Checks of a study's results, run as a rule of the workflow."""

import json

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.aggregation import succeeded
from jointclosure.parameters import Numerics, scene_of

VOLUME_TOLERANCE = 1e-12
FEWEST = 2
"""Smallest number of realisations of a case for which a standard deviation exists."""


def check_results(
    study: xr.Dataset, numerics: Numerics, realizations: int, ensemble: str = "cases"
) -> pd.DataFrame:
    """Check what must hold for every successful simulation.

    Parameters
    ----------
    study : Dataset
        Closures of an ensemble of the study: its cases, or its pool.
    numerics : Numerics
    realizations : int
        Number of realisations of each case.
    ensemble : str
        Name of the ensemble in the table.

    Returns
    -------
    DataFrame
        Columns ensemble, check, required, found (the value in the results), passed.
    """
    good = succeeded(study)
    rows = []

    def add(check: str, required: str, value, passed: bool) -> None:
        row = {"check": check, "required": required, "found": value, "passed": bool(passed)}
        rows.append({"ensemble": ensemble} | row)

    total = good.size
    successes = int(good.sum())
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
        add(
            "largest change of a wall's volume, relative",
            f"at most {VOLUME_TOLERANCE:g}",
            f"{volume:.3g}",
            volume <= VOLUME_TOLERANCE,
        )
    residual = float(study.largest_residual.where(good).max())
    if numerics.solver == "fast":
        limit = 1.01 * numerics.force_tolerance
        add(
            "largest residual of equilibrium, relative",
            f"at most {limit:.3g}",
            f"{residual:.3g}",
            residual <= limit,
        )
    else:
        change = numerics.sweep_tolerance
        add(
            "largest residual of equilibrium, relative",
            f"reported only: the reference stops at a change of {change:g}",
            f"{residual:.3g}",
            np.isfinite(residual),
        )
    if "largest_flow_imbalance" in study:
        from jointclosure.joint.flow import LARGEST_IMBALANCE

        imbalance = float(study.largest_flow_imbalance.where(good).max())
        add(
            "largest sum of the cells' mass balances in a flow, relative",
            f"at most {LARGEST_IMBALANCE:g}",
            f"{imbalance:.3g}",
            imbalance <= LARGEST_IMBALANCE,
        )
    share = study.unloading_excess.max("cycle").where(good) / study.max_normal_stress
    excess = float(share.max())
    exact = not any(scene.breakage for scene in scenes) and numerics.solver == "fast"
    add(
        "largest excess of unloading over loading stress at equal closure, over the maximum",
        "0" if exact else "reported only",
        f"{excess:.3g}",
        excess == 0.0 if exact else np.isfinite(excess),
    )
    closures = study.max_closure.where(good)
    read = int(np.isfinite(closures.values[good.values]).all(axis=-1).sum())
    add(
        "successful simulations with all closures read",
        f"{successes}",
        f"{read}",
        read == successes,
    )
    add(
        "maximum closures",
        "positive",
        f"{float(closures.min()):.3g} m at least",
        float(closures.min()) > 0.0,
    )
    for rock, walls in json.loads(study.attrs.get("walls", "{}")).items():
        apart = walls["windows_side_by_side"]
        sharing = f"at most {min(apart, realizations)} of {realizations}"
        add(f"realisations of {rock} that share no part of a scan", "reported only", sharing, True)
    for value, meaning in zip(
        study.status.attrs["flag_masks"], study.status.attrs["flag_meanings"].split(), strict=True
    ):
        count = int(((study.status.values & int(value)) > 0).sum())
        add(f"simulations flagged {meaning}", "reported only", f"{count} of {total}", True)
    return pd.DataFrame(rows)

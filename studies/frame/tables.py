"""Joined results of all cases of a study, and tables of an ensemble: bands, apertures, checks."""

import json
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.quantities import QUANTITIES
from jointclosure.joint.curves import KINDS, rising_slopes
from jointclosure.joint.protocol import FAILURE, FLAGS, LOADING
from jointclosure.parameters import PROPERTIES, Numerics, Rock, scene_of
from studies.frame.settings import Case

CURVES = tuple(name for name, about in QUANTITIES.items() if "stress" in about.dims)
"""Curves over stress: nine tenths of the numbers of a study."""


_ABOUT = (
    {"value": {"long_name": "value of the varied parameter in SI, NaN for base cases"}}
    | {
        name: {"long_name": PROPERTIES[name].long_name, "units": PROPERTIES[name].si_unit}
        for name in Rock._fields
    }
    | {
        "jrc": {
            "long_name": "joint roughness coefficient, NaN where walls are measured ones",
            "units": "1",
        },
        "max_normal_stress": {"long_name": "maximum nominal normal stress", "units": "Pa"},
    }
)
"""Numeric coordinates of a study's cases."""


def join_cases(cases: list[Case], closed: list[xr.Dataset]) -> xr.Dataset:
    """Join all cases of a study along ``case``, with rock, parameter, level and value."""
    study = xr.concat(closed, "case", join="exact", coords="minimal", compat="override")
    columns = {
        name: np.array([getattr(case, name) for case in cases], dtype=object)
        for name in ("label", "rock", "parameter", "level")
    }
    coordinates = {"case": ("case", columns["label"], {"long_name": "name of the case"})}
    for name in ("rock", "parameter", "level"):
        coordinates[name] = ("case", columns[name], {"long_name": f"{name} of the case"})
    for name, about in _ABOUT.items():
        values = [case.number(name) for case in cases]
        coordinates[name] = ("case", np.array(values, dtype=float), about)
    # with independent draws seeds differ between cases
    seeds = np.stack([part.seed.values for part in closed])
    return study.drop_vars("seed").assign_coords(
        coordinates | {"seed": (("case", "realization"), seeds, {"long_name": "seed of the walls"})}
    )


def succeeded(study: xr.Dataset) -> xr.DataArray:
    """Return which simulations succeeded: those with a status below `FAILURE`."""
    return study.status < FAILURE


def seats(study: xr.Dataset, net: bool = False) -> xr.DataArray:
    """Return net or gross closures (..., cycle) [m] from first touch to the seating stress."""
    start = study.residual_closure.shift(cycle=1, fill_value=0.0)
    kind = "_net" if net else ""
    return start + study[f"max_closure{kind}"] - study[f"max_closure_seated{kind}"]


def since_start(study: xr.Dataset) -> xr.DataArray:
    """Return gross closures (..., cycle, branch, stress) [m] since the start of the cycle."""
    return study.closure - study.residual_closure.shift(cycle=1, fill_value=0.0)


def since_seating(study: xr.Dataset, net: bool = True) -> xr.DataArray:
    """Return net or gross closures (..., cycle, branch, stress) [m] since seating of the cycle."""
    closure = study.closure - study.bulk_indentation if net else study.closure
    return closure - seats(study, net)


QUANTILES = (0.05, 0.5, 0.95)
VOLUME_TOLERANCE = 1e-12
FEWEST = 2
"""Smallest number of realisations of a case for which a standard deviation exists."""


def band_table(case: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure, stiffness, apertures of the joints of a case by cycle, branch, stress.

    Each has a mean, that of stiffnesses harmonic, and quantiles (``<name>_mean``, ``<name>_q05``)
    of ``samples`` joints. Stiffnesses are those of `stress_table`, NaN beyond ``landing_stress``.
    """
    good = case.where(succeeded(case))
    landing = good.landing_stress.where(good.branch == LOADING, np.inf)
    fields: dict[str, Any] = {}
    for kind in KINDS:
        net = kind == "net"
        closure = good.closure - good.bulk_indentation if net else good.closure
        fields[f"closure_{kind}_since_seating_mm"] = 1e3 * since_seating(good, net)
        fields[f"closure_{kind}_mm"] = 1e3 * closure
        fields[f"normal_stiffness_{kind}_MPa_per_mm"] = _stiffness(closure, landing)
    if "hydraulic_aperture" in good:
        fields["mean_aperture_mm"] = 1e3 * good.mean_aperture
        for direction in good.direction.values:
            along = 1e3 * good.hydraulic_aperture.sel(direction=direction, drop=True)
            fields[f"hydraulic_aperture_{direction}_mm"] = along
    columns = {"samples": np.isfinite(good.closure).sum("realization")}
    for name, values in fields.items():
        known = np.isfinite(values).any("realization")
        filled = values.where(known, 0.0)  # a quantile of no numbers would warn
        if name.startswith("normal_stiffness"):  # that of the mean curve
            mean = 1.0 / (1.0 / values).mean("realization")
        else:
            mean = filled.mean("realization")
        columns[f"{name}_mean"] = mean.where(known)
        bounds = np.nanquantile(filled.values, QUANTILES, axis=values.get_axis_num("realization"))
        for quantile, part in zip(QUANTILES, bounds, strict=True):
            label = f"{name}_q{round(100.0 * quantile):02d}"
            columns[label] = known.copy(data=part).where(known)
    return _over_stress(columns, case.stress, ["cycle", "branch"])


def _stiffness(closure: xr.DataArray, end: xr.DataArray) -> xr.DataArray:
    """Return the stiffness [MPa/mm] of curves of closure [m] over stress, up to an end [Pa]."""
    stress = closure.stress.values

    def slopes(curve: np.ndarray, end: float) -> np.ndarray:
        known, found = np.isfinite(curve) & (stress <= end), np.full(stress.size, np.nan)
        if known.sum() > 2:
            found[known] = 1e-9 * rising_slopes(stress[known], curve[known], stress[known])
        return found

    return xr.apply_ufunc(
        slopes, closure, end, input_core_dims=[["stress"], []], output_core_dims=[["stress"]],
        vectorize=True,
    ).transpose(*closure.dims)  # fmt: skip


def _over_stress(columns: dict, stress: xr.DataArray, keys: list[str]) -> pd.DataFrame:
    """Return columns over keys and the stress as a table with a row for each."""
    table = xr.Dataset(columns).assign_coords(stress_MPa=("stress", 1e-6 * stress.values))
    keys = [*keys, "stress_MPa"]
    table = table.swap_dims(stress="stress_MPa").drop_vars("stress")
    about = [name for name in ("rock", "parameter", "level") if name in table and "case" in keys]
    return table.to_dataframe(dim_order=keys).reset_index()[[*about, *keys, *columns]]


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
    return _over_stress(columns, study.stress, ["case", "cycle", "branch", "direction"])


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

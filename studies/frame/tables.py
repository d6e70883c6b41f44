"""Joined results of all cases of a study, and what is computed of them."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import PROPERTIES, Rock
from studies.frame.settings import Case

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


def since_seating(study: xr.Dataset, net: bool = True) -> xr.DataArray:
    """Return net or gross closures (..., cycle, branch, stress) [m] since seating of the cycle."""
    kind, closure = ("_net", study.closure - study.bulk_indentation) if net else ("", study.closure)
    start = study.residual_closure.shift(cycle=1, fill_value=0.0)
    return closure - (start + study[f"max_closure{kind}"] - study[f"max_closure_seated{kind}"])


def over_stress(columns: dict, stress: xr.DataArray, keys: list[str]) -> pd.DataFrame:
    """Return columns over keys and the stress as a table with a row for each."""
    table = xr.Dataset(columns).assign_coords(stress=1e-6 * stress).rename(stress="stress_MPa")
    keys = [*keys, "stress_MPa"]
    about = [name for name in ("rock", "parameter", "level") if name in table and "case" in keys]
    return table.to_dataframe(dim_order=keys).reset_index()[[*about, *keys, *columns]]

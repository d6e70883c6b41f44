"""The cases of a study put together, and what is read of them."""

import numpy as np
import xarray as xr

from jointclosure.ensemble.cases import Case
from jointclosure.parameters import Rock
from jointclosure.protocol import FAILURE

CURVES = ("closure", "bulk_indentation")
"""Variables over stress: nine tenths of a study's numbers."""


def join_cases(cases: list[Case], closed: list[xr.Dataset]) -> xr.Dataset:
    """All cases of a study along ``case``, with rock, parameter, level and value."""
    study = xr.concat(closed, "case", join="exact", coords="minimal", compat="override")
    columns = {
        name: np.array([getattr(case, name) for case in cases], dtype=object)
        for name in ("label", "rock", "parameter", "level")
    }
    numbers = {
        "value": "value of the varied parameter in SI, NaN for base cases",
        "youngs_modulus": "Young's modulus",
        "poisson_ratio": "Poisson's ratio",
        "compressive_strength": "compressive strength",
        "jrc": "joint roughness coefficient, NaN where walls are measured ones",
        "max_normal_stress": "maximum nominal normal stress",
    }
    units = {"youngs_modulus": "Pa", "compressive_strength": "Pa", "max_normal_stress": "Pa"}
    coordinates = {"case": ("case", columns["label"], {"long_name": "name of the case"})}
    for name in ("rock", "parameter", "level"):
        coordinates[name] = ("case", columns[name], {"long_name": f"{name} of the case"})
    for name, text in numbers.items():
        of_rock = name in Rock._fields
        values = np.array(
            [case.property(name) if of_rock else getattr(case, name) for case in cases], dtype=float
        )
        about = {"long_name": text}
        if name != "value":
            about["units"] = units.get(name, "1")
        coordinates[name] = ("case", values, about)
    # seeds differ between cases with independent draws
    seeds = np.stack([part.seed.values for part in closed])
    return study.drop_vars("seed").assign_coords(
        coordinates | {"seed": (("case", "realization"), seeds, {"long_name": "seed of the walls"})}
    )


def succeeded(study: xr.Dataset) -> xr.DataArray:
    """Whether a simulation's numbers may be used: a status below `FAILURE`."""
    return study.status < FAILURE


def seats(study: xr.Dataset) -> xr.DataArray:
    """Closures (..., cycle) from first touch at which cycles' loadings seat [m]."""
    start = study.residual_closure.shift(cycle=1, fill_value=0.0)
    return start + study.max_closure - study.max_closure_seated

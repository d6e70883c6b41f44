"""The cases of a study put together, and what is read of them."""

import numpy as np
import xarray as xr

from jointclosure.config.properties import PROPERTIES
from jointclosure.ensemble.settings import Case
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import Rock

FLOW_CURVES = ("mean_aperture", "hydraulic_aperture")
"""Variables over stress that only a study with flow has."""
CURVES = ("closure", "bulk_indentation", *FLOW_CURVES)
"""Variables over stress: nine tenths of a study's numbers."""


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
"""Numbers of a case among the coordinates of a study."""


def join_cases(cases: list[Case], closed: list[xr.Dataset]) -> xr.Dataset:
    """All cases of a study along ``case``, with rock, parameter, level and value."""
    study = xr.concat(closed, "case", join="exact", coords="minimal", compat="override")
    columns = {
        name: np.array([getattr(case, name) for case in cases], dtype=object)
        for name in ("label", "rock", "parameter", "level")
    }
    coordinates = {"case": ("case", columns["label"], {"long_name": "name of the case"})}
    for name in ("rock", "parameter", "level"):
        coordinates[name] = ("case", columns[name], {"long_name": f"{name} of the case"})
    for name, about in _ABOUT.items():
        values = [
            case.property(name) if name in PROPERTIES else getattr(case, name) for case in cases
        ]
        coordinates[name] = ("case", np.array(values, dtype=float), about)
    # seeds differ between cases with independent draws
    seeds = np.stack([part.seed.values for part in closed])
    return study.drop_vars("seed").assign_coords(
        coordinates | {"seed": (("case", "realization"), seeds, {"long_name": "seed of the walls"})}
    )


def succeeded(study: xr.Dataset) -> xr.DataArray:
    """Whether a simulation's numbers may be used: a status below `FAILURE`."""
    return study.status < FAILURE


def seats(study: xr.Dataset, net: bool = False) -> xr.DataArray:
    """Find the gross or net closures (..., cycle) at which cycles' loadings seat [m].

    They count from first touch; cycles start from no stress, where both are the same.
    """
    start = study.residual_closure.shift(cycle=1, fill_value=0.0)
    kind = "_net" if net else ""
    return start + study[f"max_closure{kind}"] - study[f"max_closure_seated{kind}"]

"""Joined results of all cases of a study."""

import numpy as np
import xarray as xr

from jointclosure.engine.quantities import QUANTITIES
from jointclosure.engine.settings import Case
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import PROPERTIES, Rock

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
        values = [
            case.property(name) if name in PROPERTIES else getattr(case, name) for case in cases
        ]
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
    """Return gross or net closures (..., cycle) [m] where loading reaches the seating stress.

    They count from first touch. Cycles start without stress, where both closures are equal.
    """
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

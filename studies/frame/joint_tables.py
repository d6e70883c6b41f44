"""Joints of all cases of a study in one dataset, and tables of the joints of an experiment."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.ensembles.quantities import COLUMNS, COORDINATES, QUANTITIES, shown_as
from jointclosure.joint.status import FAILURE
from jointclosure.parameters import PROPERTIES, Rock
from jointclosure.statistics.standard_errors import Estimate, harmonic_mean, ratio_of_means
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
"""Attributes of the numeric coordinates of a study's cases, by the name of the coordinate."""


def join_cases(cases: list[Case], closed: list[xr.Dataset]) -> xr.Dataset:
    """Join ``closed``, one dataset over ``realization`` for each of ``cases``, along ``case``.

    Both lists have the same order. Coordinates of a case are its label, rock, parameter and level,
    and in SI its value, JRC, maximum stress and the properties of its rock. ``seed`` is over case
    and realisation. Indexes of all datasets must be equal, otherwise xarray raises `ValueError`.
    Other coordinates are those of the first dataset.
    """
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


def changes_of_cases(study: xr.Dataset) -> dict[str, str]:
    """Return what each case changes, as text such as "JRC 12", by label; "" for base cases."""
    texts = {}
    columns = (study[name].values.tolist() for name in ("case", "parameter", "value"))
    for label, parameter, value in zip(*columns, strict=True):
        if np.isnan(value):
            texts[label] = ""
            continue
        about = PROPERTIES[parameter]
        unit = "" if about.unit == "1" else f" {about.unit}"
        texts[label] = f"{about.title} {value / about.size:.4g}{unit}"
    return texts


def succeeded(study: xr.Dataset) -> xr.DataArray:
    """Return which simulations succeeded: their status is below `FAILURE`."""
    return study.status < FAILURE


_IN_WORDS = {
    "outside_model_range": "Outside of the model's range",
    "target_jumped": "Jumped over the target",
    "breakage_not_at_rest": "Breakage did not come to rest",
    "rigid_contact": "Contact without compliance",
}


def in_words(name: str) -> str:
    """Return words for a flag of a status, such as "Rigid contact" for "rigid_contact"."""
    return _IN_WORDS.get(name, name.replace("_", " ").capitalize())


def since_seating(study: xr.Dataset, net: bool = True) -> xr.DataArray:
    """Return the curves of closure [m] since seating in each cycle, net or gross.

    They are (..., cycle, branch, stress) like ``closure`` of the study's dataset.
    """
    kind, closure = ("_net", study.closure - study.bulk_indentation) if net else ("", study.closure)
    start = study.residual_closure.shift(cycle=1, fill_value=0.0)
    return closure - (start + study[f"max_closure{kind}"] - study[f"max_closure_seated{kind}"])


def over_stress(columns: dict, stress: xr.DataArray, keys: list[str]) -> pd.DataFrame:
    """Return a table of ``columns`` with a row for each combination of ``keys`` and stress.

    ``columns`` are arrays by name over the dimensions ``keys`` and "stress". The coordinate
    ``stress`` [Pa] becomes the column ``stress_MPa``. If "case" is a key, rock, parameter and level
    are columns too.
    """
    table = xr.Dataset(columns).assign_coords(stress=1e-6 * stress).rename(stress="stress_MPa")
    keys = [*keys, "stress_MPa"]
    about = [name for name in ("rock", "parameter", "level") if name in table and "case" in keys]
    return table.to_dataframe(dim_order=keys).reset_index()[[*about, *keys, *columns]]


# Tables of the joints of an experiment


def as_table(files: Iterable[xr.Dataset]) -> pd.DataFrame:
    """Return a table of the joints in datasets, with a row for each load cycle of each joint.

    Curves and results by direction of flow are left out; ``timing_simulation`` becomes ``seconds``.
    """
    parts = (file.drop_dims(("branch", "stress", "direction"), errors="ignore") for file in files)
    tables = [
        part.to_dataframe(dim_order=["joint", "cycle"]).reset_index("cycle") for part in parts
    ]
    table = pd.concat(tables, ignore_index=True).rename(columns={"timing_simulation": "seconds"})
    return table[table.cycle <= table.cycles].reset_index(drop=True)


def gridded(joints: pd.DataFrame, over: Sequence[str], quantities: Sequence[str]) -> xr.Dataset:
    """Return a table of joints (`as_table`) as a dataset over the columns ``over`` and the cycle.

    The columns ``over`` must identify a joint. The dataset has the ``quantities``, and ``status``
    and ``seconds``, which are not over the cycle.
    """
    grid = joints.set_index([*over, "cycle"])[["status", "seconds", *quantities]].to_xarray()
    for name in ("status", "seconds"):
        grid[name] = grid[name].isel(cycle=0, drop=True)
    return grid


def grouped(joints: pd.DataFrame, *by: str) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Generate groups of joints with the same values in the columns ``by``.

    Before the rows of each group stand these values, by the names and in the units of published
    tables. The rows keep the names and SI units of the table of joints.
    """
    for values, part in joints.groupby(list(by), sort=False, dropna=False):
        at = {}
        for name, value in zip(by, values, strict=True):
            column, scale = shown_as(name, COORDINATES.get(name, ("", "1"))[1])
            at[column] = value if scale == 1.0 else scale * value
        yield at, part


def mean_shown(name: str, values: np.ndarray) -> Estimate:
    """Return the mean of values (n,) [SI] of a quantity, in the unit in which tables show it.

    It has its standard error. The mean of stiffnesses is harmonic.
    """
    shown = COLUMNS[name][1] * np.asarray(values, dtype=float)
    if QUANTITIES[name].has_harmonic_mean:
        return harmonic_mean(shown)
    return ratio_of_means(shown, np.ones(shown.size))

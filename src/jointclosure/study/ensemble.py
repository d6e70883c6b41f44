"""Ensembles of random surfaces: made, closed, and put together."""

import time
from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr

from jointclosure.parameters import Choices, Effects, InputError, Numerics, Rock, to_si
from jointclosure.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.randomness import seed_of
from jointclosure.readings import branch_of, closure_at_stresses, first_crossing
from jointclosure.simulation import ATTRIBUTES, simulate
from jointclosure.study.cases import Case
from jointclosure.surface.synthesis import wall_pair

PER_CYCLE = (
    "max_closure",
    "residual_closure",
    "max_closure_seated",
    "residual_closure_seated",
    "max_bulk_indentation",
    "locked_share",
    "flat_share",
    "unloading_excess",
)
PER_REALIZATION = (
    "status",
    "least_force",
    "breakage_steps",
    "locked_contacts",
    "solver_iterations",
)

CURVES = ("closure", "bulk_indentation")
"""Variables over stress: nine tenths of a study's numbers."""

_TOGETHER = 100
"""Realisations that are put together before they are written."""


def make_surfaces(
    seeds: list[int],
    jrc: float,
    shape: tuple[int, int],
    spacing: float,
    surface: dict,
    first: int = 0,
) -> Iterator[xr.Dataset]:
    """Surface pairs (realization, y, x) of a case, one by one: each has one realisation.

    Parameters
    ----------
    seeds : list of int
        One for each realisation, see `jointclosure.study.cases.wall_seed`.
    jrc, shape, spacing
        As for `jointclosure.wall_pair`, spacing in [m].
    surface : dict
        Its other arguments.
    first : int
        Number of the first realisation.
    """
    for realization, seed in enumerate(seeds, start=first):
        pair = wall_pair(jrc, shape, spacing, seed, **surface)
        yield surface_pair(pair, realization, seed, {"spacing_m": spacing, "jrc": jrc})


def surface_pair(pair: tuple, realization: int, seed: int, attributes: dict) -> xr.Dataset:
    """Upper and lower wall (y, x) [m] of one realisation, as `close_surfaces` takes them."""
    return xr.Dataset(
        {
            name: (
                ("realization", "y", "x"),
                wall[np.newaxis],
                {"units": "m", "long_name": f"height of the {name} wall towards the other"},
            )
            for name, wall in zip(("upper", "lower"), pair, strict=True)
        },
        coords={
            "realization": [realization],
            "seed": ("realization", np.array([f"{seed:032x}"], dtype=object)),
        },
        attrs=attributes,
    )


def seeds_of(settings: dict) -> list[int]:
    """Seeds of the surface pairs of `jointclosure.study.settings.surface_settings`."""
    first = settings["first_realization"]
    return [
        seed_of(settings["root_seed"], *settings["seeds_named_by"], realization)
        for realization in range(first, first + settings["realizations"])
    ]


def surfaces_of(settings: dict) -> Iterator[xr.Dataset]:
    """Surface pairs of `jointclosure.study.settings.surface_settings`, one by one."""
    if settings.get("walls"):
        raise InputError(
            "surfaces of measured walls are not made from a seed: run the study again, which cuts "
            "them out of their scans"
        )
    first = settings["first_realization"]
    seeds = seeds_of(settings)
    grid = to_si(settings["grid"])
    shape = (grid["cells_y"], grid["cells_x"])
    return make_surfaces(seeds, settings["jrc"], shape, grid["spacing"], settings["surface"], first)


def closing_arguments(settings: dict) -> dict:
    """Arguments of `close_surfaces` from `jointclosure.study.settings.closure_settings`, in SI."""
    end = 1e6 * settings["largest_stress_MPa"]
    return {
        "cycles": settings["cycles"],
        "seating_stress": 1e6 * settings["seating_stress_MPa"],
        "effects": Effects(**settings["effects"]),
        "choices": Choices(**to_si(settings["choices"])),
        "numerics": Numerics(**to_si(settings["numerics"])),
        "stresses": np.linspace(0.0, end, settings["stress_points"]),
    }


def close_surfaces(
    surfaces: xr.Dataset,
    case: Case,
    *,
    cycles: int,
    seating_stress: float,
    effects: Effects,
    choices: Choices,
    numerics: Numerics,
    stresses: np.ndarray,
    report: Callable[[str], None] = lambda line: None,
    repeated_by: str = "",
) -> Iterator[xr.Dataset]:
    """Close all surface pairs of a case, a few in memory at a time.

    Parameters
    ----------
    surfaces : Dataset
        Those of `make_surfaces`, put together or read one at a time from a file.
    case : Case
        Gives rock and maximum stress.
    cycles, seating_stress, effects, choices, numerics
        As for `jointclosure.simulate`.
    stresses : array (s,)
        Common stress axis of the closure curves [Pa].
    report : callable
        Receives a line for each realisation.
    repeated_by : str
        Command that repeats a realisation, but for its number, for those lines
        that tell of a failure.

    Yields
    ------
    Dataset
        Over (realization, cycle, branch, stress), up to a hundred realisations
        each; one that failed has a status of 16 or more, and NaN where it was not read.
    """
    rock = Rock(case.youngs_modulus, case.poisson_ratio, case.compressive_strength)
    common = {"spacing": float(surfaces.attrs["spacing_m"]), "rock": rock}
    common |= {"max_normal_stress": case.max_normal_stress, "cycles": cycles}
    common |= {"seating_stress": seating_stress, "effects": effects, "choices": choices}
    realizations, seeds = surfaces.realization.values, surfaces.seed.values
    for first in range(0, realizations.size, _TOGETHER):
        few = slice(first, first + _TOGETHER)
        rows = []
        for number, realization in enumerate(realizations[few], start=first):
            walls = [surfaces[name][number].values for name in ("upper", "lower")]
            again = f"; to repeat it: {repeated_by} {realization}" if repeated_by else ""
            try:
                row = close_pair(*walls, stresses, numerics=numerics, **common)
            except Exception as error:
                report(f"realisation {realization}: {type(error).__name__}: {error}{again}")
                raise
            failed = f", failed{again}" if row["status"][1] >= FAILURE else ""
            report(f"realisation {realization}: {_said(row)}{failed}")
            rows.append(row)
        yield _labelled(rows, realizations[few], seeds[few], cycles, stresses)


def close_pair(upper: np.ndarray, lower: np.ndarray, stresses: np.ndarray, **told) -> dict:
    """Close one surface pair (y, x), and read it: (dimensions, values) by name."""
    start = time.perf_counter()
    closed = simulate(upper, lower, **told)
    seconds = time.perf_counter() - start
    tolerance = told["numerics"].stress_tolerance
    row = _row(closed, stresses, told["cycles"], told["seating_stress"], tolerance)
    row["volume_error"] = ((), _volume_error(upper, lower, closed))
    row["timing_simulation"] = ((), seconds)
    return row


def _said(row: dict) -> str:
    closures = ", ".join(f"{1e3 * value:.5f}" for value in row["max_closure"][1])
    seconds = row["timing_simulation"][1]
    return f"status {int(row['status'][1])}, maximum closure {closures} mm, {seconds:.2f} s"


def _labelled(rows: list[dict], realizations, seeds, cycles: int, stresses) -> xr.Dataset:
    """Realisations' results put together, with their coordinates and attributes."""
    return xr.Dataset(
        {
            name: (
                ("realization", *dimensions),
                np.stack([row[name][1] for row in rows]),
                _attributes(name),
            )
            for name, (dimensions, _) in rows[0].items()
        },
        coords={
            "realization": realizations,
            "seed": ("realization", seeds),
            "cycle": np.arange(1, cycles + 1),
            "branch": np.array([LOADING, UNLOADING], dtype=object),
            "stress": ("stress", stresses, {"long_name": "nominal normal stress", "units": "Pa"}),
        },
    )


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
        values = np.array([getattr(case, name) for case in cases], dtype=float)
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


def _row(
    closed: xr.Dataset,
    stresses: np.ndarray,
    cycles: int,
    seating_stress: float,
    stress_tolerance: float,
) -> dict:
    history = (closed.normal_stress.values, closed.cycle.values, closed.branch.values)
    stress, cycle, branch = history
    row: dict = {name: (("cycle",), closed[name].values) for name in PER_CYCLE}
    row |= {name: ((), closed[name].values) for name in PER_REALIZATION}
    for name in ("closure", "bulk_indentation"):
        curves = closure_at_stresses(
            closed[name].values, *history, cycles, stresses, stress_tolerance
        )
        row[name] = (("cycle", "branch", "stress"), curves)
    at_seat = []
    for number in range(1, cycles + 1):
        here = branch_of(cycle, branch, number, LOADING)
        at_seat.append(
            first_crossing(stress[here], closed.bulk_indentation.values[here], seating_stress)
        )
    bulk = closed.max_bulk_indentation.values
    row["max_closure_net"] = (("cycle",), closed.max_closure.values - bulk)
    row["max_closure_seated_net"] = (
        ("cycle",),
        closed.max_closure_seated.values - (bulk - np.array(at_seat)),
    )
    row["largest_residual"] = ((), float(closed.equilibrium_residual.max()))
    return row


def _volume_error(upper: np.ndarray, lower: np.ndarray, closed: xr.Dataset) -> float:
    """Largest |sum z - sum z0| / sum |z0 - min z0| of both walls."""
    errors = []
    for before, after in ((upper, closed.upper_final.values), (lower, closed.lower_final.values)):
        scale = float(np.sum(before - before.min()))
        change = abs(float(np.sum(after - before)))
        errors.append(change / scale if scale > 0.0 else change)
    return max(errors)


_EXTRA_ATTRIBUTES = {
    "max_closure_net": ("closure at the cycle's maximum less bulk indentation", "m"),
    "max_closure_seated_net": ("the same, counted from seating", "m"),
    "largest_residual": ("largest equilibrium residual of all steps", "1"),
    "volume_error": ("change of a wall's volume over the volume above its lowest point", "1"),
    "timing_simulation": ("wall-clock time of the simulation", "s"),
}


def _attributes(name: str) -> dict:
    if name in _EXTRA_ATTRIBUTES:
        text, unit = _EXTRA_ATTRIBUTES[name]
        return {"long_name": text, "units": unit}
    return dict(ATTRIBUTES[name])

"""Closure of the surface pairs of a case, and the results that are stored."""

import time
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import xarray as xr

from jointclosure.engineering.curves import net_responses
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.history import closure_at_stresses
from jointclosure.joint.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.joint.simulation import ATTRIBUTES, close_walls

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
    "replayed_cycles",
    "idle_steps",
    "idle_displacement",
)


_TOGETHER = 100
"""Number of realisations that are joined before they are written."""


def close_surfaces(
    surfaces: xr.Dataset,
    settings: ClosureSettings,
    *,
    report: Callable[[str], None] = lambda line: None,
    repeated_by: str = "",
    before: xr.Dataset | None = None,
) -> Iterator[xr.Dataset]:
    """Close all surface pairs of a case, a few in memory at a time.

    Parameters
    ----------
    surfaces : Dataset
        As from `make_surfaces`, joined or read one at a time from a file.
    settings : ClosureSettings
    report : callable
        Receives a line for each realisation.
    repeated_by : str
        Command that repeats a realisation, without its number, to be shown in the lines
        that report a failure.
    before : Dataset
        Results closed with these settings before, as from `closed_before`; their surfaces are
        not closed again.

    Yields
    ------
    Dataset
        Over (realization, cycle, branch, stress), with up to a hundred realisations.
        A failed realisation has a status of 16 or more, and NaN for missing results.
    """
    conditions = settings.conditions()
    stresses = np.linspace(0.0, settings.largest_stress, settings.stress_points)
    realizations, seeds = surfaces.realization.values, surfaces.seed.values
    known = {} if before is None else {seed: i for i, seed in enumerate(before.seed.values)}
    for first in range(0, realizations.size, _TOGETHER):
        few = slice(first, first + _TOGETHER)
        rows = []
        for number, realization in enumerate(realizations[few], start=first):
            upper, lower = (surfaces[name][number].values for name in ("upper", "lower"))
            again = f"; to repeat it: {repeated_by} {realization}" if repeated_by else ""
            try:
                if before is not None and seeds[number] in known:
                    row = _row_of(before.isel(realization=known[seeds[number]]))
                else:
                    row = close_pair(upper, lower, stresses, conditions)
            except Exception as error:
                report(f"realisation {realization}: {type(error).__name__}: {error}{again}")
                raise
            failed = f", failed{again}" if row["status"][1] >= FAILURE else ""
            report(f"realisation {realization}: {_described(row)}{failed}")
            rows.append(row)
        yield labelled(rows, realizations[few], seeds[few], conditions.cycle_count, stresses)


def close_pair(
    upper: np.ndarray, lower: np.ndarray, stresses: np.ndarray, conditions: Conditions
) -> dict:
    """Close one surface pair (y, x) and return (dimensions, values) of its results by name."""
    start = time.process_time()
    closed = close_walls(upper, lower, conditions)
    return _read(upper, lower, closed, time.process_time() - start, stresses, conditions)


def closed_before(
    surfaces: Iterable[xr.Dataset],
    closed: Iterable[tuple[xr.Dataset, float]],
    settings: ClosureSettings,
) -> xr.Dataset:
    """Join results that were closed for another purpose, in the form of `close_surfaces`.

    Parameters
    ----------
    surfaces : iterable of Dataset
        As from `jointclosure.ensemble.surfaces.make_surfaces`, from the first on.
    closed : iterable of (Dataset, float)
        Results of `close_walls` and processor time [s] for each of these surfaces, in order.
    settings : ClosureSettings
        Settings with which they were closed.
    """
    conditions = settings.conditions()
    stresses = np.linspace(0.0, settings.largest_stress, settings.stress_points)
    rows, realizations, seeds = [], [], []
    for (dataset, seconds), pair in zip(closed, surfaces, strict=False):
        upper, lower = pair.upper.values[0], pair.lower.values[0]
        rows.append(_read(upper, lower, dataset, seconds, stresses, conditions))
        realizations.append(int(pair.realization[0]))
        seeds.append(str(pair.seed.values[0]))
    named = np.array(seeds, dtype=object)
    return labelled(rows, np.array(realizations), named, conditions.cycle_count, stresses)


def _read(upper, lower, closed: xr.Dataset, seconds: float, stresses, conditions) -> dict:
    row = _row(closed, stresses, conditions)
    row["volume_error"] = ((), _volume_error(upper, lower, closed))
    row["timing_simulation"] = ((), seconds)
    return row


def _row_of(realization: xr.Dataset) -> dict:
    """Convert a realisation of a labelled dataset back to a row."""
    return {name: (array.dims, array.values) for name, array in realization.data_vars.items()}


def _described(row: dict) -> str:
    closures = ", ".join(f"{1e3 * value:.5f}" for value in row["max_closure"][1])
    seconds = row["timing_simulation"][1]
    return f"status {int(row['status'][1])}, maximum closure {closures} mm, {seconds:.2f} s"


def labelled(rows: list[dict], realizations, seeds, cycles: int, stresses) -> xr.Dataset:
    """Join the results of realisations, with coordinates and attributes."""
    labelled = xr.Dataset(
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
    if "direction" in labelled.dims:
        from jointclosure.joint.flow import COORDINATE

        labelled = labelled.assign_coords(COORDINATE)
    return labelled


def _row(closed: xr.Dataset, stresses: np.ndarray, conditions: Conditions) -> dict:
    cycles = conditions.cycle_count
    history = (closed.normal_stress.values, closed.cycle.values, closed.branch.values)
    row: dict = {name: (("cycle",), closed[name].values) for name in PER_CYCLE}
    row |= {name: ((), closed[name].values) for name in PER_REALIZATION}
    for name in ("closure", "bulk_indentation"):
        curves = closure_at_stresses(
            closed[name].values, *history, cycles, stresses, conditions.numerics.stress_tolerance
        )
        row[name] = (("cycle", "branch", "stress"), curves)
    largest = float(np.max(conditions.max_normal_stress))
    responses = net_responses(closed, largest)
    row |= {name: (("cycle",), values) for name, values in responses.items()}
    row["largest_residual"] = ((), float(closed.equilibrium_residual.max()))
    return row | _flow_row(closed, stresses, conditions) if conditions.flow else row


def _flow_row(closed: xr.Dataset, stresses: np.ndarray, conditions: Conditions) -> dict:
    """Return apertures at stresses, the hydraulic ones by direction, and the flow imbalance."""
    history = (closed.normal_stress.values, closed.cycle.values, closed.branch.values)

    def curves(values: np.ndarray) -> np.ndarray:
        tolerance = conditions.numerics.stress_tolerance
        return closure_at_stresses(values, *history, conditions.cycle_count, stresses, tolerance)

    over = ("cycle", "branch", "stress")
    hydraulic = [curves(values) for values in closed.hydraulic_aperture.values.T]
    return {
        "mean_aperture": (over, curves(closed.mean_aperture.values)),
        "hydraulic_aperture": (("direction", *over), np.stack(hydraulic)),
        "largest_flow_imbalance": ((), float(closed.flow_imbalance.max())),
    }


def _volume_error(upper: np.ndarray, lower: np.ndarray, closed: xr.Dataset) -> float:
    """Return the largest |sum z - sum z0| / sum |z0 - min z0| of both walls."""
    errors = []
    for before, after in ((upper, closed.upper_final.values), (lower, closed.lower_final.values)):
        scale = float(np.sum(before - before.min()))
        change = abs(float(np.sum(after - before)))
        errors.append(change / scale if scale > 0.0 else change)
    return max(errors)


_EXTRA_ATTRIBUTES = {
    "max_closure_net": ("closure at the cycle's maximum less bulk indentation", "m"),
    "max_closure_seated_net": ("the same, counted from seating", "m"),
    "residual_closure_seated_net": ("residual closure at seating less bulk indentation", "m"),
    "stiffness_net": (
        "net normal stiffness of loading from half of the maximum stress to the landing on it",
        "Pa/m",
    ),
    "landing_stress": (
        "stress from which loading lands on its maximum by smaller steps, infinite without",
        "Pa",
    ),
    "largest_residual": ("largest equilibrium residual of all steps", "1"),
    "largest_flow_imbalance": (
        "largest sum of the cells' mass balances over the inflow, of all steps",
        "1",
    ),
    "volume_error": ("change of a wall's volume over the volume above its lowest point", "1"),
    "timing_simulation": ("processor time of the simulation", "s"),
}


def _attributes(name: str) -> dict:
    if name in _EXTRA_ATTRIBUTES:
        text, unit = _EXTRA_ATTRIBUTES[name]
        return {"long_name": text, "units": unit}
    if name in ATTRIBUTES:
        return dict(ATTRIBUTES[name])
    from jointclosure.joint.flow import ATTRIBUTES as OF_FLOW

    return dict(OF_FLOW[name])

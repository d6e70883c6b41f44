"""What commands print and write of a closed joint: closures, status, snapshots and files."""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.budget import NOT_MODELLED, ROUNDING, Budget, results_of, table_of
from jointclosure.engine.budget import QUANTITIES as BUDGETED
from jointclosure.engine.quantities import CURVES, QUANTITIES, shown_as
from jointclosure.inputs.remarks import caution
from jointclosure.joint.curves import (
    branch_of,
    cycle_table,
    has_flow,
    members,
    stress_table,
    with_snapshots,
)
from jointclosure.joint.laws import JointLaws
from jointclosure.joint.protocol import FAILURE, LOADING, UNLOADING
from jointclosure.statistics.standard_errors import number_text, significant
from jointclosure.storage.files import replace_files, write
from jointclosure.storage.provenance import origin, to_plain

FIGURES = 7
"""Significant digits of numbers in tables: more than their accuracy, but enough to distinguish
neighbouring steps."""
_BLOCKED = (
    "flow is blocked where no open cells connect both sides: a cell in contact is shut whole, "
    "although contacts are smaller than cells; at most: as if the open cells of every line across "
    "the flow were connected"
)
_FLOW = "hydraulic_aperture_mm", "largest_hydraulic_mm", "transmissivity_m2_per_s"
"""Curves of flow whose value at the maximum is one of the first results."""


def summary(
    closed: xr.Dataset, laws: JointLaws, budget: Budget | None = None
) -> tuple[str, dict[str, Any]]:
    """Format the results of each cycle with remarks on them; return them for JSON too."""
    remarks = [*(budget.sentences() if budget else []), laws.sentence()]
    for cycle, aperture in cycle_table(closed)[["cycle", "mean_aperture_at_max_mm"]].to_numpy():
        overlap = (
            f"the mean aperture is {aperture:.2g} mm at the maximum of cycle {cycle:g}: the walls "
            "overlap by more than the void that is left, and the model does not hold there"
        )
        remarks += [caution(overlap)] if aperture <= 0.0 else []
    remarks += _flow_remarks(closed) if has_flow(closed) else []
    table = result_table(closed, laws, budget)
    about = "gross closure contains the elastic indentation of the half-spaces, net does not"
    head = f"{about}; closures since {1e-6 * closed.attrs['seating_stress_Pa']:g} MPa"
    if budget is not None:
        head += "; in brackets the range of 9 in 10 random sets of the inputs that are not known"
    lines = [head, table.to_string(), *(f"- {remark}" for remark in remarks)]
    return "\n".join(lines), {"table": table.to_dict(), "remarks": remarks}


def result_table(closed: xr.Dataset, laws: JointLaws, budget: Budget | None = None) -> pd.DataFrame:
    """Return results over cycles as text, with their ranges if known, beside Barton and Bandis."""
    results = results_of(closed).set_index("cycle")

    def text(cycle: int, name: str) -> str:
        value = float(results.loc[cycle, name])
        return NOT_MODELLED if abs(value) <= ROUNDING else number_text(value)

    table = budget.table() if budget else table_of(results.index, text)
    for title, values in law_values(closed, laws).items():
        table[title] = [significant(values[n], 2) if n in values else "" for n in BUDGETED]
    curves = stress_table(closed) if budget is None else budget.curves
    highest = curves[curves.branch == LOADING].groupby("cycle").tail(1)
    for name in _FLOW if has_flow(closed) else ():
        title = CURVES[name][0].replace(" (", ", at the maximum stress (")
        table.loc[title] = [
            *with_bands(highest, name, 2 if budget else 4),
            *[""] * len(laws.by_cycle),
        ]
    return table


def with_bands(curves: pd.DataFrame, name: str, figures: int) -> pd.Series:
    """Return a quantity of `stress_table` as text, each value with its band if that is known."""
    columns = members(curves, name)
    values = curves[columns].map(lambda value: number_text(value, figures))
    middle, *ends = (values[column] for column in columns)
    return middle + " (" + ends[0] + " to " + ends[1] + ")" if ends else middle


def law_values(closed: xr.Dataset, laws: JointLaws) -> dict[str, dict[str, float]]:
    """Return what the laws of Barton and Bandis give for the results of a joint, by its columns."""
    largest, values = closed.normal_stress.groupby(closed.load_cycle).max(), {}
    for cycle, law in laws.by_cycle.items():
        results = law.results(float(largest.sel(load_cycle=cycle)), laws.seating)
        shown = {name: shown_as(name, QUANTITIES[name].unit) for name in results}
        values[f"Barton-Bandis, cycle {cycle}"] = {
            column: scale * results[name] for name, (column, scale) in shown.items()
        }
    return values


def _flow_remarks(closed: xr.Dataset) -> list[str]:
    """Describe the hydraulic apertures at the maximum of each cycle, with their status."""
    words, remarks, blocked = closed.flow_status.attrs["flag_meanings"].split(), [], False
    for cycle in cycle_table(closed).cycle:
        parts = []
        for step in branch_of(closed, cycle, UNLOADING)[:1]:
            for direction in closed.direction.values:
                at = closed.isel(step=step).sel(direction=direction)
                status, value = words[int(at.flow_status)], 1e3 * float(at.hydraulic_aperture)
                most = f", upper bound {1e3 * float(at.largest_hydraulic):.2g}"
                flows = status == "flows"
                blocked |= not flows
                parts.append(f"along {direction} {value:.3g} ({status}){'' if flows else most}")
        about_cycle = f"cycle {cycle}: {'; '.join(parts)}"
        remarks.append(f"hydraulic aperture at the maximum (mm) and flow_status, {about_cycle}")
    return [*remarks, _BLOCKED] if blocked else remarks


def failed(closed: xr.Dataset) -> bool:
    """Return whether a simulation failed."""
    return int(closed.status) >= FAILURE


def status_text(closed: xr.Dataset) -> str:
    """Return success or failure, with the remarks of the status in words."""
    about, status = closed.status.attrs, int(closed.status)
    named = zip(about["flag_masks"], about["flag_meanings"].split(), strict=True)
    remarks = ", ".join(name for mask, name in named if status & int(mask))
    word = "failed" if failed(closed) else "success"
    return f"{word}: {remarks}" if remarks else word


def attributes(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return code, versions and machine, and the keywords of a command's functions as JSON."""
    return origin() | {"settings": json.dumps(to_plain(settings), default=str)}


def scaled(values: Any, scale: float = 1.0) -> Any:
    """Return scaled numbers, or fields of a named tuple, for JSON: null if they are not finite."""
    known = [scale * float(value) if np.isfinite(value) else None for value in values]
    return dict(zip(values._fields, known, strict=True)) if hasattr(values, "_fields") else known


def kept_stresses(
    snapshots: tuple[float, ...], animation: Path | None, stress: Any
) -> tuple[float, ...]:
    """Return the stresses [Pa] of the requested snapshots and of the frames of an animation."""
    if animation is None:
        return snapshots
    from jointclosure.plotting.snapshots import animated_stresses

    return (*snapshots, *animated_stresses(np.max(stress)))


def write_animation(closed: xr.Dataset, arguments: argparse.Namespace, title: str) -> xr.Dataset:
    """Write the animation, if requested; return the joint with only the requested snapshots."""
    if arguments.animation is None:
        return closed
    from jointclosure.plotting.snapshots import crushing_animation

    if closed.sizes["snapshot"]:
        write(crushing_animation(closed, title), arguments.animation)
        print(f"wrote {arguments.animation}")
    return with_snapshots(closed, arguments.snapshots)


def write_folder(folder: Path, command: str, files: Mapping[str, Any]) -> str:
    """Replace the files of a command's earlier run, and return the line that names them."""
    replace_files(folder, command, files)
    return f"wrote {folder}: {', '.join(sorted(files)) or 'no file'}"

"""What commands print and write of a closed joint: closures, status, snapshots and files."""

import argparse
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.budget import Budget, results_of, table_of
from jointclosure.joint.barton_bandis import JointLaws
from jointclosure.joint.conditions import largest_stress
from jointclosure.joint.curves import cycle_table, has_flow
from jointclosure.joint.history import branch_of, with_snapshots
from jointclosure.joint.protocol import FAILURE, UNLOADING
from jointclosure.statistics.standard_errors import significant
from jointclosure.storage.files import (
    replace_files,
    save_animation,
    save_figure,
    write_csv,
    write_text,
    write_vtu,
)
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.provenance import origin, to_plain

FIGURES = 7
"""Significant digits of numbers in tables: more than their accuracy, but enough to distinguish
neighbouring steps."""
_BLOCKED = (
    "a cell in contact is shut whole, although contacts are smaller than cells; at most: as if the "
    "open cells of every line across the flow were connected"
)


def summary(closed: xr.Dataset, laws: JointLaws, budget: Budget | None = None) -> str:
    """Format the results of each cycle as lines of text, with their range if it is known."""
    cycles = cycle_table(closed)
    since = f"closures since {1e-6 * closed.attrs['seating_stress_Pa']:g} MPa"
    about = "gross closure contains the elastic indentation of the half-spaces, net does not"
    lines, beside = [f"{about}; {since}"], law_texts(closed, laws)
    if budget is None:
        lines.append(plain_table(closed, beside).to_string())
    else:
        lines[0] += (
            "; in brackets the range of 9 in 10 random sets of the inputs that are not known"
        )
        lines.append(budget.table(beside).to_string())
        lines += [f"- {line}" for line in budget.sentences()]
    lines.append(f"- {laws.sentence()}")
    full = cycles[cycles.mean_aperture_at_max_mm <= 0.0]
    for cycle, aperture in zip(full.cycle, full.mean_aperture_at_max_mm, strict=True):
        lines.append(
            f"warning: the mean aperture is {aperture:.2g} mm at the maximum of cycle {cycle}: the "
            "walls overlap by more than the void that is left, and the model does not hold there"
        )
    return "\n".join(lines + (_flow_lines(closed) if has_flow(closed) else []))


def plain_table(closed: xr.Dataset, beside: Mapping[str, Mapping[str, str]]) -> pd.DataFrame:
    """Return the results of a joint without ranges as text, and texts beside them."""
    results = results_of(closed, float(closed.normal_stress.max())).set_index("cycle")
    return table_of(results.index, lambda cycle, name: f"{results.loc[cycle, name]:.4g}", beside)


def law_texts(closed: xr.Dataset, laws: JointLaws) -> dict[str, dict[str, str]]:
    """Return what the laws of Barton and Bandis give for the results of a joint, as text."""
    largest = float(closed.normal_stress.max())
    texts = {}
    for cycle, law in laws.by_cycle.items():
        half, whole = law.closure(np.array([0.5, 1.0]) * largest - laws.seating)
        values = {
            "max_closure_seated_net_mm": 1e3 * whole,
            "stiffness_net_MPa_per_mm": 0.5e-9 * largest / (whole - half),
            "kni_net_MPa_per_mm": 1e-9 * law.initial_stiffness,
            "vm_net_mm": 1e3 * law.largest_closure,
        }
        texts[f"Barton-Bandis, cycle {cycle}"] = {k: significant(v, 2) for k, v in values.items()}
    return texts


def _flow_lines(closed: xr.Dataset) -> list[str]:
    """Describe the hydraulic apertures at the maximum of each cycle, with their status."""
    about = closed.flow_status.attrs
    words = dict(zip(about["flag_values"], about["flag_meanings"].split(), strict=True))
    lines, blocked = ["hydraulic aperture at the maximum (mm), and flow_status"], False
    for cycle in cycle_table(closed).cycle:
        step = branch_of(closed, cycle, UNLOADING)[:1]
        parts = []
        for direction in closed.direction.values if step.size else ():
            value, bound, status = (
                closed[name].sel(direction=direction).values[step[0]]
                for name in ("hydraulic_aperture", "largest_hydraulic", "flow_status")
            )
            status = words[int(status)]
            parts.append(f"along {direction} {1e3 * value:.3g} ({status})")
            if status != "flows":
                parts[-1] += f", at most {1e3 * bound:.2g}"
                blocked = True
        lines.append(f"cycle {cycle}: {'; '.join(parts)}")
    return [*lines, f"({_BLOCKED})"] if blocked else lines


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


def finite(values: Iterable[float], scale: float = 1.0) -> list[float | None]:
    """Return scaled numbers for JSON, with null for numbers that are not finite."""
    return [scale * float(value) if np.isfinite(value) else None for value in values]


def scaled(values: Any, scale: float) -> dict[str, float | None]:
    """Return the scaled fields of a named tuple for JSON, with null for infinity."""
    return dict(zip(values._fields, finite(values, scale), strict=True))


def kept_stresses(arguments: argparse.Namespace, stress: Any) -> tuple[float, ...]:
    """Return the stresses [Pa] of the requested snapshots and of the frames of an animation."""
    asked = getattr(arguments, "snapshots", ())
    if arguments.animation is None:
        return asked
    from jointclosure.plotting.snapshots import animated_stresses

    return (*asked, *animated_stresses(largest_stress(stress)))


def write_animation(closed: xr.Dataset, arguments: argparse.Namespace, title: str) -> xr.Dataset:
    """Write the animation, if requested; return the joint with only the requested snapshots."""
    if arguments.animation is None:
        return closed
    from jointclosure.plotting.snapshots import crushing_animation

    if closed.sizes["snapshot"]:
        save_animation(crushing_animation(closed, title), arguments.animation)
        print(f"wrote {arguments.animation}")
    return with_snapshots(closed, getattr(arguments, "snapshots", ()))


def write(content: Any, path: Path) -> None:
    """Write a dataset, table, figure, mesh, text or record for JSON in the form of its type."""
    if path.suffix == ".vtu":
        points, triangles, fields = content
        write_vtu(points, triangles, fields, path)
    elif isinstance(content, xr.Dataset):
        write_netcdf(content, path)
    elif isinstance(content, pd.DataFrame):
        write_csv(content, path)
    elif hasattr(content, "savefig"):
        save_figure(content, path)
    else:
        text = content if isinstance(content, str) else json.dumps(content, indent=1) + "\n"
        write_text(text, path)


def write_folder(folder: Path, command: str, files: Mapping[str, Any]) -> str:
    """Replace the files of a command's earlier run, and return the line that names them."""

    def fill(place: Path) -> None:
        for name, content in files.items():
            write(content, place / name)

    names = replace_files(folder, command, fill)
    return f"wrote {folder}: {', '.join(names) or 'no file'}"

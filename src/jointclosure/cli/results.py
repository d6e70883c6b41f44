"""What commands print and write of a closed joint: closures, status, snapshots and files."""

import argparse
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.conditions import largest_stress
from jointclosure.joint.curves import curve_table, cycle_table, has_flow
from jointclosure.joint.history import with_snapshots
from jointclosure.joint.protocol import FAILURE
from jointclosure.storage.figures import save_animation, save_figure, write_vtu
from jointclosure.storage.folders import replace_files
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.provenance import origin, to_plain
from jointclosure.storage.text import write_csv, write_text

if TYPE_CHECKING:
    from jointclosure.engine.budget import Budget

FIGURES = 7
"""Significant digits of numbers in tables: more than their accuracy, but enough to distinguish
neighbouring steps."""
_SHOWN = {
    "max_closure_seated_net_mm": "net {since}",
    "residual_closure_seated_net_mm": "residual net",
    "max_closure_seated_mm": "gross {since}",
    "max_closure_mm": "gross from its start",
}
_APERTURES = {
    "mean_aperture_mm": "mean aperture",
    "hydraulic_aperture_x_mm": "hydraulic along x",
    "hydraulic_aperture_y_mm": "along y",
}


def summary(closed: xr.Dataset, budget: "Budget | None" = None) -> str:
    """Format the results of each cycle as lines of text, with their range if it is known."""
    since = f"since {1e-6 * closed.attrs['seating_stress_Pa']:g} MPa"
    cycles = cycle_table(closed)
    if budget is None:
        titles = {name: title.format(since=since) for name, title in _SHOWN.items()}
        about = "gross contains the elastic indentation of the half-spaces, net does not"
        lines = [f"closure (mm); {about}", _table(cycles, titles)]
    else:
        about = "gross closure contains the elastic indentation of the half-spaces, net does not"
        ranges = "in brackets the range of 9 in 10 random sets of the inputs that are not known"
        lines = [f"{about}; closures {since}; {ranges}", str(budget)]
    full = cycles[cycles.mean_aperture_at_max_mm <= 0.0]
    for cycle, aperture in zip(full.cycle, full.mean_aperture_at_max_mm, strict=True):
        lines.append(
            f"warning: the mean aperture is {aperture:.2g} mm at the maximum of cycle {cycle}: the "
            "walls overlap by more than the void that is left, and the model does not hold there"
        )
    if has_flow(closed):
        curves = curve_table(closed)
        at_maximum = curves.loc[curves.groupby("cycle").normal_stress_MPa.idxmax()]
        lines += ["at the maximum (mm)", _table(at_maximum, _APERTURES)]
    return "\n".join(lines)


def _table(frame: pd.DataFrame, titles: Mapping[str, str]) -> str:
    """Format columns [mm] of a frame with a row per cycle under other names."""
    shown = frame[list(titles)].rename(columns=titles)
    shown.index = [f"cycle {number}" for number in frame.cycle]
    return shown.to_string(float_format="{:.5f}".format)


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


def write(content: Any, path: Path, figures: int | None = None) -> None:
    """Write a dataset, table, figure, mesh, text or record for JSON in the form of its type."""
    if path.suffix == ".vtu":
        points, triangles, fields = content
        write_vtu(points, triangles, fields, path)
    elif isinstance(content, xr.Dataset):
        write_netcdf(content, path)
    elif isinstance(content, pd.DataFrame):
        write_csv(content, path, figures)
    elif hasattr(content, "savefig"):
        save_figure(content, path)
    else:
        text = content if isinstance(content, str) else json.dumps(content, indent=1) + "\n"
        write_text(text, path)


def write_folder(
    folder: Path,
    command: str,
    files: Mapping[str, Any],
    further: Callable[[Path], None] = lambda folder: None,
) -> str:
    """Replace the files of a command's earlier run, and return the line that names them."""

    def fill(place: Path) -> None:
        for name, content in files.items():
            write(content, place / name)
        further(place)

    names = replace_files(folder, command, fill)
    return f"wrote {folder}: {', '.join(names) or 'no file'}"

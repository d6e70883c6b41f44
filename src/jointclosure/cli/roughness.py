"""Roughness of a wall from a file (npy, npz, netCDF, csv, xyz; with the extra
jointclosure[walls] also STL, TIFF and files of surface scanners), without its mean plane.
Every measure has a 95 % confidence interval.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from jointclosure.cli import options, results
from jointclosure.inputs import InputError, check_length
from jointclosure.inputs.remarks import caution, cautions
from jointclosure.walls.gridding import (
    LARGEST_FILLED_SHARE,
    MISSING,
    filled,
    point_distance,
    wall_on_grid,
)
from jointclosure.walls.levelling import levelled
from jointclosure.walls.measures import Measure, measure_wall
from jointclosure.walls.outliers import without_spikes
from jointclosure.walls.plausibility import slope_doubts, smoothing_of, unit_doubts
from jointclosure.walls.registration import registered
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_quality import resolution_remarks
from jointclosure.walls.scans import read_scan

_MISSING = "cells without a height: an error (refuse), left out (avoid, the default), or filled"


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("file", type=Path, help="the scanned wall")
    options.add_keywords(command, read_scan, *options.SCANS)
    grid = {"help": "interpolate to this spacing first"}
    options.add_keywords(command, registered, spacing=grid, spikes={"default": "keep"})
    command.add_argument("--missing", choices=MISSING, default="avoid", help=_MISSING)
    text = "draw the wall (png, pdf or svg)"
    options.add_file(command, "--picture", text, *options.PICTURES)
    options.add_file(command, "--table", "write the measures", ".csv")


def run(arguments: argparse.Namespace) -> int:
    """Print the measures, and draw the wall if requested."""
    if getattr(arguments, "spacing", None) is not None:
        check_length("spacing", arguments.spacing)
    if arguments.picture:  # drawing takes a second to load, and needs an extra
        from jointclosure.plotting.walls import roughness_figure
    scan = read_scan(arguments.file, **options.given(arguments, options.SCANS))
    try:
        scan = inspected(scan)
        kept, spikes = without_spikes(scan)
        if arguments.spikes == "cut":
            scan = kept
        measured = scan  # levelling interpolates the heights of grids
        scan, _ = levelled(scan)
        step = getattr(arguments, "spacing", None) or point_distance(scan)
        wall = wall_on_grid(scan, step)
        smoothed = [
            *smoothing_of(scan, wall, step),
            *resolution_remarks(measured, wall, step, scan),
        ]
        wall = filled(wall, arguments.missing, LARGEST_FILLED_SHARE)
        measures = measure_wall(wall, step)
    except InputError as error:
        reasons = [str(error), *cautions(scan.remarks)]
        raise InputError(f"{arguments.file}: {'; '.join(reasons)}") from None
    print(_text(measures, str(arguments.file), wall, step))
    doubts = slope_doubts({"wall": wall}, step) or unit_doubts({"wall": wall}, step)[1]
    remarks = [*scan.remarks, *smoothed, *map(caution, doubts)]
    if spikes:
        done = "they were cut" if arguments.spikes == "cut" else "they were kept (see --spikes)"
        remarks.append(f"{spikes}; {done}")
    print("".join(f"\nNote: {remark}." for remark in remarks), end="\n" if remarks else "")
    if arguments.table:
        columns = ["measure", *Measure._fields[1:]]
        results.write(pd.DataFrame(measures, columns=columns), arguments.table)
    if arguments.picture:
        figure = roughness_figure(wall, step, arguments.file.name)
        results.write(figure, arguments.picture)
    return 0


def _text(measures: list[Measure], title: str, wall: np.ndarray, spacing: float) -> str:
    """Format measures of a wall (y, x) [m] for reading, with its size and missing cells."""
    ny, nx = wall.shape
    gaps = int(np.isnan(wall).sum())
    missing = f", {gaps} of them without a height" if gaps else ""
    size = f"{ny} x {nx} cells (y, x) of {1e3 * spacing:.4g} mm{missing}; mean plane removed"
    lines = [title, size, "", f"{'':32s} {'value':>9s}   {'95 % interval':20s}"]
    for m in measures:
        unit = "" if m.unit == "1" else m.unit
        interval = f"{m.low:.4g} to {m.high:.4g}"
        remark = f"  ({m.remark})" if m.remark else ""
        lines.append(f"{m.name:32s} {m.value:9.4g}   {interval:20s} {unit}{remark}".rstrip())
    return "\n".join(lines)

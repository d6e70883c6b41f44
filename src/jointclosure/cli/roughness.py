"""Compute the roughness of a scanned wall after removing its mean plane, or of a profile.
A profile has heights along a line. Every measure has a 95 % confidence interval. Files are npy,
npz, netCDF, csv and xyz, and with the extra jointclosure[walls] also STL, TIFF and files of surface
scanners.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from jointclosure.cli import command_results, options
from jointclosure.inputs import InputError, check_length, naming
from jointclosure.inputs.remarks import caution, cautions, noted
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.gridding import point_distance, wall_on_grid
from jointclosure.walls.interpolation_remarks import interpolation_remarks
from jointclosure.walls.jrc import DEFAULT_RELATION, RELATIONS
from jointclosure.walls.levelling import levelled
from jointclosure.walls.missing_heights import LARGEST_FILLED_SHARE, MISSING, fill_missing
from jointclosure.walls.plausibility import unit_doubts
from jointclosure.walls.profile_roughness import levelled_profile, measure_profile, read_profile
from jointclosure.walls.registration import registered
from jointclosure.walls.scan_defects import inspected
from jointclosure.walls.scan_quality import quality_of, quality_remarks
from jointclosure.walls.scans import read_scan
from jointclosure.walls.spikes import remove_spikes
from jointclosure.walls.wall_roughness import Measure, measure_wall

_WHICH_JRC = (
    f"Of the relations for JRC, that of {RELATIONS[DEFAULT_RELATION].title} is the default of "
    "close and of generated walls, because its interval is the spacing of the walls of the paper. "
    "Quote a JRC together with its relation, as the others give other values."
)
_MISSING = "cells without a height: an error (refuse), left out (avoid, the default), or filled"


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("file", type=Path, help="the scanned wall, or the profile")
    text = "the file is a profile, with a position and a height in each line (columns x and z)"
    command.add_argument("--profile", action="store_true", help=text)
    options.add_keywords(command, read_scan, *options.SCANS)
    grid = {"help": "interpolate to this spacing first"}
    options.add_keywords(command, registered, spacing=grid, spikes={"default": "keep"})
    command.add_argument("--missing", choices=MISSING, default="avoid", help=_MISSING)
    text = "draw the wall (png, pdf or svg)"
    options.add_file_option(command, "--picture", text, *options.PICTURES)
    options.add_file_option(command, "--table", "write the measures", ".csv")


def run(arguments: argparse.Namespace) -> int:
    """Print the measures of a wall or a profile; write its table and figure if requested."""
    if arguments.profile:
        return _run_profile(arguments)
    if getattr(arguments, "spacing", None) is not None:
        check_length("spacing", arguments.spacing)
    if arguments.picture:  # drawing takes a second to load, and needs an extra
        from jointclosure.plotting.walls import roughness_figure
    scan = read_scan(arguments.file, **options.given(arguments, options.SCANS))
    try:
        scan = inspected(scan)
        kept, spikes = remove_spikes(scan)
        if arguments.spikes == "cut":
            scan = kept
        measured = scan  # levelling interpolates the heights of grids
        scan, _ = levelled(scan)
        step = getattr(arguments, "spacing", None) or point_distance(scan)
        wall = wall_on_grid(scan, step)
        smoothed = [
            *interpolation_remarks(scan, wall, step),
            *quality_remarks(quality_of(measured, scan), wall, step),
        ]
        wall = fill_missing(wall, arguments.missing, LARGEST_FILLED_SHARE)
        measures = measure_wall(wall, step)
    except InputError as error:
        reasons = [str(error), *cautions(scan.remarks)]
        raise InputError(f"{arguments.file}: {'; '.join(reasons)}") from None
    units = unit_doubts({"wall": wall}, step)
    doubts = units.impossible or units.unlike_rock
    remarks = [*scan.remarks, *smoothed, *map(caution, doubts)]
    if spikes:
        done = "they were cut" if arguments.spikes == "cut" else "they were kept (see --spikes)"
        remarks.append(f"{spikes}; {done}")
    gaps = _words_on_missing(wall)
    size = f"{grid_text(wall.shape, step)} (x, y){gaps}; mean plane removed"
    _show(measures, size, remarks, arguments)
    if arguments.picture:
        figure = roughness_figure(wall, step, arguments.file.name)
        command_results.write(figure, arguments.picture)
    return 0


def _run_profile(arguments: argparse.Namespace) -> int:
    """Print the measures of a profile; write its table and figure if requested.

    Raise `InputError` for options that are for walls only.
    """
    for option, stands in (
        ("--spacing", getattr(arguments, "spacing", None) is not None),
        ("--scan-spacing", getattr(arguments, "scan_spacing", None) is not None),
        ("--spikes", arguments.spikes != "keep"),
        ("--missing", arguments.missing != "avoid"),
    ):
        if stands:
            raise InputError(f"{option}: must be left out with --profile, it is for walls")
    if arguments.picture:  # drawing takes a second to load, and needs an extra
        from jointclosure.plotting.walls import profile_figure
    given = options.given(arguments, ("units", "variable"))
    profile = read_profile(arguments.file, **given)
    with naming(str(arguments.file)):
        heights, step, inclination = levelled_profile(profile)
        measures = measure_profile(heights, step)
    gaps = _words_on_missing(heights)
    size = f"{heights.size} places {1e3 * step:.4g} mm apart{gaps}; mean line removed"
    size += f", which is inclined by {inclination:.3g} degrees"
    _show(measures, size, [*profile.remarks, *_smooth(measures)], arguments)
    if arguments.picture:
        command_results.write(profile_figure(heights, step, arguments.file.name), arguments.picture)
    return 0


def _smooth(measures: Sequence[Measure]) -> list[str]:
    """Return a list with a caution if the Hurst exponent H of a profile is above 1; else empty."""
    (hurst,) = (measure.value for measure in measures if measure.name == "H")
    if hurst <= 1.0:
        return []
    about = (
        f"H is {hurst:.3g}, and self-affine surfaces have at most 1: the profile is too short to "
        "show it, or smooth at short distances, as after filtering or with a wide stylus; Z2 is "
        "carried to other distances by H = 1"
    )
    return [caution(about)]


def _words_on_missing(heights: np.ndarray) -> str:
    """Return words on the number of missing heights (NaN), to follow a size; "" without any."""
    missing = int(np.isnan(heights).sum())
    return f", {missing} of them without a height" if missing else ""


def _show(
    measures: list[Measure], size: str, remarks: Sequence[str], arguments: argparse.Namespace
) -> None:
    """Print measures and remarks; write them to the table that the command line names, if any."""
    print(_text(measures, str(arguments.file), size))
    print("".join(f"\n{noted(remark)}." for remark in remarks), end="\n" if remarks else "")
    if arguments.table:
        columns = ["measure", *Measure._fields[1:]]
        command_results.write(pd.DataFrame(measures, columns=columns), arguments.table)


def _text(measures: list[Measure], title: str, size: str) -> str:
    """Return the measures of a wall or a profile as text: title, size, and a line for each."""
    names = {f"JRC, {name}": f"JRC, {one.title}" for name, one in RELATIONS.items()}
    names["JRC, stigsson_mas_ivars"] = "JRC, Stigsson & Mas Ivars 2019, with H"
    lines = [title, size, "", f"{'':46s} {'value':>9s}   {'95 % interval':20s}"]
    for m in measures:
        unit = "" if m.unit == "1" else m.unit
        interval = f"{m.low:.4g} to {m.high:.4g}"
        remark = f"  ({m.remark})" if m.remark else ""
        name = names.get(m.name, m.name)
        line = f"{name:46s} {m.value:9.4g}   {interval:20s} {unit}{remark}"
        lines.append(line.rstrip())
    if any(m.name == f"JRC, {DEFAULT_RELATION}" for m in measures):
        lines += ["", _WHICH_JRC]
    return "\n".join(lines)

"""Experiment on walls that are tilted, or rotated about the normal of the joint.

Independent walls, and walls whose longer waves mate, are closed at every tilt and at every
rotation, on the same surfaces.
"""

from collections.abc import Iterator
from textwrap import fill

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jointclosure.config.configuration import Configured, refuse
from jointclosure.config.keys.misalignment import MisalignmentKeys
from jointclosure.config.units import to_si
from jointclosure.engine.points import Point
from jointclosure.engine.quantities import COLUMNS, titles_of_cycles
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.wavelengths import labelled_wavelengths
from jointclosure.experiments import Design, Experiment, grouped, settings_of
from jointclosure.plotting.style import key, legend_below, point_key, styled, subplots, ticks_at
from jointclosure.statistics.ratios import harmonic_mean, ratio_of_means

READ = ("max_closure", "max_closure_seated_net", "residual_closure_seated_net", "stiffness_net")
"""Quantities of the column ``response``."""
_PANELS = titles_of_cycles(
    ("max_closure", 1),
    ("max_closure", 2),
    ("residual_closure_seated_net", 1),
    ("stiffness_net", 1),
    ("stiffness_net", 2),
)
"""Title of each row, by response and cycle."""


def misalignment_design(configured: Configured) -> Design:
    """Make a job for each rock and mismatch wavelength: aligned walls, all tilts, all rotations.

    Raises
    ------
    ConfigurationError
        If the study sets walls that the experiment sets, or walls that cannot be rotated.
    """
    keys, configuration = configured.keys, configured.typed
    section = MisalignmentKeys.model_validate(keys["misalignment"])
    refuse(_problems(keys, section))
    tilts, rotations = sorted(section.tilt_degrees), sorted(section.rotation_degrees)
    angles = [{"tilt": tilt, "rotation": 0.0} for tilt in tilts]
    angles += [{"tilt": 0.0, "rotation": rotation} for rotation in rotations[1:]]
    wavelengths = labelled_wavelengths(sorted(to_si(section.model_dump())["mismatch_wavelength"]))
    jobs = {}
    for rock, of_rock in configuration.rocks.items():
        case = base_case(rock, of_rock)
        for label, wavelength in wavelengths.items():
            settings = settings_of(configuration, case, mismatch_wavelength=wavelength)
            walls = {"rock": rock, "wavelength": np.inf if wavelength is None else wavelength}
            jobs[f"{rock}.{label}"] = [
                Point(walls | angle, settings, "misaligned", angle) for angle in angles
            ]
    return Design(jobs, ("misalignment",), ("misalignment",), {})


def _problems(keys: dict, section: MisalignmentKeys) -> Iterator[str]:
    """Generate the reasons why the walls of a configuration cannot be tilted and rotated."""
    grid, surface = keys["grid"], keys["surface"]
    if grid["cells_x"] != grid["cells_y"]:
        yield (
            f"grid.cells_x = {grid['cells_x']}: must be cells_y ({grid['cells_y']}) where walls "
            "are rotated (misalignment)"
        )
    given = (surface["mismatch_wavelength_mm"], surface["correlation"], surface["shift_in_cells"])
    if given != (None, 0.0, 0):
        yield (
            "misalignment: the study sets surface.mismatch_wavelength_mm; it, correlation and "
            "shift_in_cells must be null, 0 and 0"
        )
    if surface["normalise"] != "wall":
        yield f"surface.normalise = {surface['normalise']!r}: must be 'wall' (misalignment)"
    for name in ("tilt_degrees", "rotation_degrees"):
        if 0.0 not in getattr(section, name):
            yield f"misalignment.{name}: must have 0 among them"


def misalignment_table(joints: pd.DataFrame) -> pd.DataFrame:
    """Compute means over surfaces, and their changes from aligned walls, at tilts and rotations.

    Parameters
    ----------
    joints : DataFrame
        As from `jointclosure.engine.points.close_points`.

    Returns
    -------
    DataFrame
        ``rock``, ``wavelength_mm`` (infinite: independent walls), ``tilt_degrees``,
        ``rotation_degrees``, ``cycle``, ``response`` (of `READ`), ``value`` in the unit of
        tables (`jointclosure.engine.quantities.COLUMNS`) with its ``error``;
        ``change_percent`` of the mean from that of aligned walls with its paired
        ``change_error``; ``samples`` of both. The residual closure is that of the first cycle.

    Notes
    -----
    The mean stiffness is the harmonic mean, that of the mean curve.
    """
    rows = []
    walls = ["rock", "wavelength", "cycle"]
    aligned = dict(list(joints[(joints.tilt == 0.0) & (joints.rotation == 0.0)].groupby(walls)))
    for at, part in grouped(joints, "rock", "wavelength", "tilt", "rotation", "cycle"):
        before = aligned[tuple(part[walls].iloc[0])]
        for response in READ:
            if response == "residual_closure_seated_net" and at["cycle"] > 1:
                continue
            change = _change(response, part[response].to_numpy(), before[response].to_numpy())
            rows.append(at | {"response": response} | change)
    return pd.DataFrame(rows)


def _change(response: str, values: np.ndarray, aligned: np.ndarray) -> dict:
    """Compute the mean of a response, and its change from aligned walls on the same surfaces."""
    both = np.isfinite(values) & np.isfinite(aligned)
    values, aligned = values[both], aligned[both]
    shown = COLUMNS[response][1] * values
    if response == "stiffness_net":
        mean = harmonic_mean(shown)
        ratio = ratio_of_means(1.0 / aligned, 1.0 / values)
    else:
        mean = ratio_of_means(shown, np.ones(values.size))
        ratio = ratio_of_means(values, aligned)
    return {
        "value": mean.value,
        "error": mean.standard_error,
        "change_percent": 100.0 * (ratio.value - 1.0),
        "change_error": 100.0 * ratio.standard_error,
        "samples": int(both.sum()),
    }


@styled
def misalignment_figure(table: pd.DataFrame) -> Figure:
    """Draw changes from aligned walls over tilt (left) and rotation (right), by rock.

    Parameters
    ----------
    table : DataFrame
        As from `misalignment_table`.

    Notes
    -----
    Filled: independent walls; hollow and dashed: walls whose longer waves mate. Bars are 95 %
    intervals.
    """
    figure, panels = subplots(
        len(_PANELS), 2, figsize=(9.0, 11.0), layout="constrained", sharex="col"
    )
    rocks, wavelengths = list(dict.fromkeys(table.rock)), np.sort(table.wavelength_mm.unique())
    moved = {"tilt_degrees": "rotation_degrees", "rotation_degrees": "tilt_degrees"}
    for row, ((response, cycle), title) in zip(panels, _PANELS.items(), strict=True):
        shown = table[(table.response == response) & (table.cycle == cycle)]
        for axes, (along, other) in zip(row, moved.items(), strict=True):
            _changes(axes, shown[shown[other] == 0.0], along, rocks, wavelengths)
        row[0].set_ylabel(fill(f"change of {title} (%)", 28), fontsize=9)
    for axes, along in zip(panels[-1], moved, strict=True):
        axes.set_xlabel(along.replace("_degrees", " (degrees)"))
    _spread_rotations(panels[-1][1], table.rotation_degrees)
    keys = [point_key(rock.capitalize(), color=f"C{place}") for place, rock in enumerate(rocks)]
    keys += [key(_named(length), color="0.3", **_style(length)) for length in wavelengths]
    legend_below(figure, keys)
    return figure


def _changes(axes: Axes, table: pd.DataFrame, along: str, rocks: list[str], wavelengths) -> None:
    for place, rock in enumerate(rocks):
        for wavelength in wavelengths:
            line = table[(table.rock == rock) & (table.wavelength_mm == wavelength)]
            line = line.sort_values(along)
            axes.errorbar(
                line[along], line.change_percent, yerr=1.96 * line.change_error, ms=3.5, lw=1.0,
                capsize=1.5, color=f"C{place}", **_style(wavelength),
            )  # fmt: skip
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=0)


def _style(wavelength: float) -> dict:
    if np.isinf(wavelength):
        return {"marker": "o", "ls": "-"}
    return {"marker": "o", "ls": "--", "markerfacecolor": "white"}


def _named(wavelength: float) -> str:
    return "independent" if np.isinf(wavelength) else f"waves beyond {wavelength:g} mm mate"


def _spread_rotations(axes: Axes, rotations: pd.Series) -> None:
    """Scale the axis so that small rotations are as far apart as large ones."""
    values = np.sort(rotations.unique())
    if values.size > 1:
        axes.set_xscale("symlog", linthresh=values[1], linscale=0.4)
        axes.set_xlim(-0.3 * values[1], 1.2 * values[-1])
        ticks_at(axes.xaxis, values)


EXPERIMENT = Experiment(
    title="effects of a tilt and a rotation of the walls",
    quantities=READ,
    design=misalignment_design,
    tabulate=lambda joints, parameters: {"misalignment": misalignment_table(joints)},
    draw=lambda name, tables, parameters: misalignment_figure(tables[name]),
)

"""Walls that are tilted against each other, or rotated about the joint's normal.

Independent walls, and walls whose longer waves mate, are closed at every tilt and at every
rotation, on the same surfaces.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from jointclosure.config.configuration import Configured, refuse
from jointclosure.config.keys.misalignment import MisalignmentKeys
from jointclosure.config.units import to_si
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.points import Point
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.ensemble.wavelengths import labelled_wavelengths
from jointclosure.experiments import Design, Experiment
from jointclosure.plotting.style import styled, subplots
from jointclosure.statistics.ratios import harmonic_mean, ratio_of_means

READ = {
    "closure": "maximum closure (mm)",
    "closure_seated_net": "net closure since seating (mm)",
    "residual_seated_net": "net residual closure at seating (mm)",
    "stiffness_net": "net normal stiffness (MPa/mm)",
}
"""Quantities of the column ``response``, with their names and units there."""
_PANELS = (
    ("closure", 1, "maximum closure,\ncycle 1"),
    ("closure", 2, "maximum closure,\ncycle 2"),
    ("residual_seated_net", 1, "residual closure"),
    ("stiffness_net", 1, "net normal stiffness,\ncycle 1"),
    ("stiffness_net", 2, "net normal stiffness,\ncycle 2"),
)
"""Response, cycle and title of each row."""


def misalignment_design(configured: Configured) -> Design:
    """A job for each rock and mismatch wavelength: aligned walls, all tilts, all rotations.

    Raises
    ------
    ConfigurationError
        Walls that are not those of the study to set, or cannot be rotated.
    """
    keys, configuration = configured.keys, configured.typed
    section = MisalignmentKeys.model_validate(keys["misalignment"])
    refuse(_problems(keys, section))
    tilts, rotations = sorted(section.tilt_degrees), sorted(section.rotation_degrees)
    angles = [(tilt, 0.0) for tilt in tilts] + [(0.0, rotation) for rotation in rotations[1:]]
    wavelengths = labelled_wavelengths(sorted(to_si(section.model_dump())["mismatch_wavelength"]))
    jobs = {}
    for rock, of_rock in configuration.rocks.items():
        case = base_case(rock, of_rock)
        for label, wavelength in wavelengths.items():
            mated = configuration.surface._replace(mismatch_wavelength=wavelength)
            surfaces = surface_settings(
                configuration._replace(surface=mated), case, range(configuration.study.realizations)
            )
            settings = closure_settings(configuration, case, surfaces)
            length = np.inf if wavelength is None else wavelength
            jobs[f"{rock}.{label}"] = [
                Point(
                    {"rock": rock, "wavelength": length, "tilt": tilt, "rotation": rotation},
                    settings,
                    "misaligned",
                    {"tilt": tilt, "rotation": rotation},
                )
                for tilt, rotation in angles
            ]
    return Design(jobs, ("misalignment",), ("misalignment",), {})


def _problems(keys: dict, section: MisalignmentKeys) -> Iterator[str]:
    """Why walls of a configuration cannot be tilted and rotated."""
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
    """Means over surfaces, and their changes from aligned walls, at every tilt and rotation.

    Parameters
    ----------
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`.

    Returns
    -------
    DataFrame
        ``rock``, ``wavelength_mm`` (infinite: independent walls), ``tilt_degrees``,
        ``rotation_degrees``, ``cycle``, ``response`` (of `READ`), ``value`` with its ``error``;
        ``change_percent`` of the mean from that of aligned walls with its paired
        ``change_error``; ``samples`` of both. The residual closure is that of the first cycle.

    Notes
    -----
    The mean stiffness is the harmonic one, that of the mean curve.
    """
    rows = []
    of_walls = ["rock", "wavelength", "cycle"]
    aligned = dict(list(joints[(joints.tilt == 0.0) & (joints.rotation == 0.0)].groupby(of_walls)))
    for at, part in joints.groupby([*of_walls[:2], "tilt", "rotation", "cycle"], sort=False):
        rock, wavelength, tilt, rotation, cycle = at
        about = {
            "rock": rock,
            "wavelength_mm": 1e3 * wavelength,
            "tilt_degrees": tilt,
            "rotation_degrees": rotation,
            "cycle": cycle,
        }
        before = aligned[rock, wavelength, cycle]
        for response in READ:
            if response == "residual_seated_net" and cycle > 1:
                continue
            pair = (each[response].to_numpy() for each in (part, before))
            rows.append(about | {"response": response} | _row(response, *pair))
    return pd.DataFrame(rows)


def _row(response: str, values: np.ndarray, aligned: np.ndarray) -> dict:
    """Mean of a response, and its change from aligned walls on the same surfaces."""
    both = np.isfinite(values) & np.isfinite(aligned)
    values, aligned = values[both], aligned[both]
    if response == "stiffness_net":
        mean = harmonic_mean(1e-9 * values)
        ratio = ratio_of_means(1.0 / aligned, 1.0 / values)
    else:
        mean = ratio_of_means(1e3 * values, np.ones(values.size))
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
    """Changes from aligned walls against tilt (left) and rotation (right), by rock.

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
    for row, (response, cycle, title) in zip(panels, _PANELS, strict=True):
        shown = table[(table.response == response) & (table.cycle == cycle)]
        for axes, (along, other) in zip(row, moved.items(), strict=True):
            _changes(axes, shown[shown[other] == 0.0], along, rocks, wavelengths)
        row[0].set_ylabel(f"change of {title} (%)", fontsize=9)
    for axes, along in zip(panels[-1], moved, strict=True):
        axes.set_xlabel(along.replace("_degrees", " (degrees)"))
    _spread_rotations(panels[-1][1], table.rotation_degrees)
    marks = [
        Line2D([], [], color=f"C{place}", marker="o", ls="", label=rock.capitalize())
        for place, rock in enumerate(rocks)
    ]
    marks += [
        Line2D([], [], color="0.3", label=_named(wavelength), **_style(wavelength))
        for wavelength in wavelengths
    ]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), frameon=False)
    return figure


def _changes(axes: Axes, table: pd.DataFrame, along: str, rocks: list[str], wavelengths) -> None:
    for place, rock in enumerate(rocks):
        for wavelength in wavelengths:
            own = table[(table.rock == rock) & (table.wavelength_mm == wavelength)]
            own = own.sort_values(along)
            axes.errorbar(
                own[along], own.change_percent, yerr=1.96 * own.change_error, ms=3.5, lw=1.0,
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
    """Small rotations as far apart as large ones."""
    values = np.sort(rotations.unique())
    if values.size > 1:
        axes.set_xscale("symlog", linthresh=values[1], linscale=0.4)
        axes.set_xlim(-0.3 * values[1], 1.2 * values[-1])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks(values, [f"{value:g}" for value in values])


EXPERIMENT = Experiment(
    title="what a tilt and a rotation of the walls change",
    quantities=tuple(READ),
    design=misalignment_design,
    tabulate=lambda joints, parameters: {"misalignment": misalignment_table(joints)},
    draw=lambda name, tables, parameters: misalignment_figure(tables[name]),
)

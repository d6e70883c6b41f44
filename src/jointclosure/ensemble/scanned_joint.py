"""Closure of a joint whose two walls were scanned: registration and simulation."""

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import xarray as xr

from jointclosure.config.rocks import named_rock, rock_text
from jointclosure.engineering.curves import cycle_table
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import Conditions
from jointclosure.inputs import InputError
from jointclosure.joint.loading import SEATING_STRESS, describe_load
from jointclosure.joint.protocol import FAILURE, Report
from jointclosure.joint.simulation import checked_conditions
from jointclosure.parameters import Choices, Effects, Numerics, Rock
from jointclosure.scans import read_scan
from jointclosure.surface.measured import Cloud, Scan
from jointclosure.surface.registration import RegisteredPair, registered


class ClosedJoint(NamedTuple):
    """Two scanned walls after registration and closure.

    Attributes
    ----------
    pair : RegisteredPair
        The walls that were closed; its ``report`` describes the registration.
    history : Dataset
        As from `jointclosure.simulate`.
    conditions : Conditions
        Rock, load and model.
    rock_name : str
        Name for `rock_text`; "rock" if the rock is given only by its properties.
    """

    pair: RegisteredPair
    history: xr.Dataset
    conditions: Conditions
    rock_name: str = "rock"

    def __repr__(self) -> str:
        ny, nx = self.pair.upper.shape
        step = 1e3 * self.pair.spacing
        seating = 1e-6 * self.conditions.seating_stress
        table = cycle_table(self.history)
        net, gross = (
            ", ".join(f"{value:.4g}" for value in table[f"closure_{kind}_since_seating_mm"])
            for kind in ("net", "gross")
        )
        failed = ", failed" if int(self.history.status) >= FAILURE else ""
        return (
            f"<ClosedJoint: {rock_text(self.conditions.rock, self.rock_name)}, {nx} x {ny} cells "
            f"of {step:.4g} mm ({nx * step:.3g} x {ny * step:.3g} mm), closes {net} mm net "
            f"({gross} mm gross) since {seating:g} MPa "
            f"({describe_load(self.conditions.max_normal_stress, self.conditions.cycles)}){failed}>"
        )


def close(
    upper: str | Path | Scan | Cloud,
    lower: str | Path | Scan | Cloud,
    *,
    rock: str | Rock | tuple[Rock, Rock],
    max_normal_stress: float | Sequence[float],
    cycles: int | None = None,
    seating_stress: float = SEATING_STRESS,
    units: str | None = None,
    grid_spacing: float | None = None,
    orientation: str | None = None,
    shift: str | None = None,
    cut_spikes: bool = True,
    effects: Effects = Effects(),
    choices: Choices = Choices(),
    numerics: Numerics = Numerics(),
    unusual_values: bool = False,
    report: Report | None = None,
    flow: bool = False,
    snapshots: Sequence[float] = (),
) -> ClosedJoint:
    """Register two scanned walls of a joint, press them together and release them.

    Parameters
    ----------
    upper, lower : path, Scan or Cloud
        Files for `jointclosure.read_scan`, or what it returned. Use it directly if a scan has no
        spacing, which is an argument of `read_scan`.
    rock : str, Rock or (Rock, Rock)
        Name of a rock of the package, such as "granite"
        (`jointclosure.config.rocks.named_rock`); or the rock of both walls, or the rocks of
        the upper and the lower wall.
    max_normal_stress, cycles
        As for `jointclosure.simulate`: a maximum [Pa] and number of cycles, or a load history.
    seating_stress : float
        Stress from which the ``_seated`` closures count [Pa].
    units : {"m", "mm", "um", "nm"}, optional
        Units of both files, if the files do not state them.
    grid_spacing : float, optional
        Spacing of the joint's grid [m], by default the larger point distance of the scans. It is
        a parameter of the model, because a cell is an asperity.
    orientation, shift, cut_spikes
        As for `jointclosure.surface.registration.registered`.
    unusual_values : bool
        As for `jointclosure.simulate`, and for `jointclosure.surface.registration.registered`.
    effects, choices, numerics, report, flow, snapshots
        As for `jointclosure.simulate`.

    Returns
    -------
    ClosedJoint

    Raises
    ------
    InputError
        If a file cannot be read, units are not stated, no orientation of the walls fits clearly
        best, the walls do not overlap, `registered` refuses the pair, or a number is out of its
        range.
    """
    intact, load = checked_conditions(
        named_rock(rock) if isinstance(rock, str) else rock, None, max_normal_stress, cycles,
        seating_stress, effects, choices, numerics, unusual_values,
    )  # fmt: skip
    above, below = read_wall(upper, units), read_wall(lower, units)
    pair = registered(
        above, below, grid_spacing, orientation=orientation, shift=shift, cut_spikes=cut_spikes,
        unusual_values=unusual_values,
    )  # fmt: skip
    if not unusual_values:
        for doubt in pair.warnings:
            warnings.warn(doubt, stacklevel=2)
    name = rock if isinstance(rock, str) else "rock"
    conditions = Conditions(
        pair.spacing,
        intact,
        max_normal_stress,
        len(load),
        seating_stress,
        effects,
        choices,
        numerics,
        flow,
    )
    return closed_pair(pair, conditions, report, snapshots, rock_name=name)


def closed_pair(
    pair: RegisteredPair,
    conditions: Conditions,
    report: Report | None = None,
    snapshots: Sequence[float] = (),
    rock_name: str = "rock",
) -> ClosedJoint:
    """Close registered walls on their grid."""
    conditions = conditions._replace(spacing=pair.spacing)
    history = close_walls(pair.upper, pair.lower, conditions, report, snapshots)
    return ClosedJoint(pair, history, conditions, rock_name)


def read_wall(
    wall: str | Path | Scan | Cloud,
    units: str | None = None,
    spacing: float | None = None,
    variable: str | None = None,
) -> Scan | Cloud:
    """Return a scan, read from its file if needed; arguments as for `jointclosure.read_scan`."""
    if isinstance(wall, Scan | Cloud):
        return wall
    if not isinstance(wall, str | Path):
        raise InputError(
            f"a wall of type {type(wall).__name__}: must be a file, or a Scan or Cloud of it; "
            "walls that are arrays, with heights towards each other, are closed by simulate"
        )
    return read_scan(wall, units=units, spacing=spacing, variable=variable)

"""The joint whose two walls were scanned: brought together, closed, and described in a line."""

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
from jointclosure.joint.loading import SEATING_STRESS, load_said
from jointclosure.joint.protocol import FAILURE, Report
from jointclosure.joint.simulation import checked_conditions
from jointclosure.parameters import Choices, Effects, Numerics, Rock
from jointclosure.scans import read_scan
from jointclosure.surface.measured import Cloud, Scan
from jointclosure.surface.registration import RegisteredPair, registered


class ClosedJoint(NamedTuple):
    """Two scanned walls, brought together and closed.

    Attributes
    ----------
    pair : RegisteredPair
        The walls as they were closed, and in its ``report`` what was found and done.
    history : Dataset
        As from `jointclosure.simulate`.
    conditions : Conditions
        Rock, load and model.
    rock_name : str
        Of `rock_text`; "rock" where it is given by its properties alone.
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
            f"({load_said(self.conditions.max_normal_stress, self.conditions.cycles)}){failed}>"
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
    """Bring two scanned walls of a joint together, press them together and release them.

    Parameters
    ----------
    upper, lower : path, Scan or Cloud
        Files that `jointclosure.read_scan` reads, or what it gave (which takes the spacing of a
        scan that has none, too).
    rock : str, Rock or (Rock, Rock)
        "granite" or another that comes with the package
        (`jointclosure.config.rocks.named_rock`); or of both walls, or of upper and lower.
    max_normal_stress, cycles
        As for `jointclosure.simulate`: a maximum [Pa] and how often, or a load history.
    seating_stress : float
        Where the ``_seated`` closures start to count [Pa].
    units : {"m", "mm", "um", "nm"}, optional
        Of both files, where these do not say them.
    grid_spacing : float, optional
        Of the joint's grid [m]; by default the larger point distance of the scans. It is a
        parameter of the model: a cell is an asperity.
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
        A file that cannot be read, units that nobody says, walls of which no orientation is
        clear or that do not overlap, a pair that is refused as `registered` does, a number out of
        its range.
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
    """Close walls that were brought together, on their own grid, as any other walls."""
    conditions = conditions._replace(spacing=pair.spacing)
    history = close_walls(pair.upper, pair.lower, conditions, report, snapshots)
    return ClosedJoint(pair, history, conditions, rock_name)


def read_wall(
    wall: str | Path | Scan | Cloud,
    units: str | None = None,
    spacing: float | None = None,
    variable: str | None = None,
) -> Scan | Cloud:
    """A scan, read where it is a file; arguments as for `jointclosure.read_scan`."""
    if isinstance(wall, Scan | Cloud):
        return wall
    if not isinstance(wall, str | Path):
        raise InputError(
            f"a wall of type {type(wall).__name__}: must be a file, or a Scan or Cloud of it; "
            "walls that are arrays, with heights towards each other, are closed by simulate"
        )
    return read_scan(wall, units=units, spacing=spacing, variable=variable)

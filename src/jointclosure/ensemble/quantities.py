"""The quantities that are read of a closed joint: one definition, unit, title and symbol each."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.engineering.curves import hysteresis, seat_of
from jointclosure.ensemble.responses import responses_of
from jointclosure.ensemble.settings import Conditions
from jointclosure.ensemble.timing import pair_seconds
from jointclosure.protocol import LOADING


class ClosedJoint:
    """A joint that was closed: its pristine walls, its history, and the conditions.

    Attributes
    ----------
    walls : (array (y, x), array (y, x))
        Upper and lower wall before loading [m].
    closed : Dataset
        As from `jointclosure.simulate`.
    conditions : Conditions
    """

    def __init__(
        self, walls: tuple[np.ndarray, np.ndarray], closed: xr.Dataset, conditions: Conditions
    ) -> None:
        self.walls, self.closed, self.conditions = walls, closed, conditions

    @cached_property
    def responses(self) -> dict[str, np.ndarray]:
        """Closures and stiffness of each cycle (`responses_of`)."""
        return responses_of(self.closed, self.conditions)

    @property
    def initial_aperture(self) -> float:
        """Mean distance of the pristine walls at first touch [m]."""
        upper, lower = self.walls
        together = upper + lower
        return float((together.max() - together).mean())


class Quantity(NamedTuple):
    """A quantity of a closed joint.

    Attributes
    ----------
    title : str
        As it stands in tables and at axes, without unit.
    unit : str
        SI unit; "1" of a ratio.
    symbol : str
        In mathematical notation of matplotlib.
    rule : callable
        Of a `ClosedJoint`: an array (cycles,), or a number where it does not depend on the cycle.
    """

    title: str
    unit: str
    symbol: str
    rule: Callable[[ClosedJoint], np.ndarray | float]


def _response(name: str) -> Callable[[ClosedJoint], np.ndarray]:
    return lambda joint: joint.responses[name]


def _of_history(name: str) -> Callable[[ClosedJoint], np.ndarray]:
    return lambda joint: joint.closed[name].values


def _aperture_at_seating(joint: ClosedJoint) -> np.ndarray:
    cycles = range(1, joint.conditions.cycles + 1)
    return np.array([seat_of(joint.closed, each, LOADING, "mean_aperture") for each in cycles])


QUANTITIES: dict[str, Quantity] = {
    "closure": Quantity(
        "maximum closure, from the cycle's start",
        "m",
        r"x_\mathrm{max}",
        _of_history("max_closure"),
    ),
    "closure_net": Quantity(
        "net closure, from the cycle's start", "m", r"x_\mathrm{net}", _response("closure_net")
    ),
    "closure_seated_net": Quantity(
        "net closure since seating", "m", r"x_\mathrm{net,s}", _response("closure_seated_net")
    ),
    "residual": Quantity(
        "residual closure, from first touch",
        "m",
        r"x_\mathrm{res}",
        _of_history("residual_closure"),
    ),
    "residual_seated_net": Quantity(
        "net residual closure at seating",
        "m",
        r"x_\mathrm{res,s}",
        _response("residual_seated_net"),
    ),
    "stiffness_net": Quantity(
        "net normal stiffness of loading, from half of the maximum stress to the landing on it",
        "Pa/m",
        r"k_\mathrm{n}",
        _response("stiffness_net"),
    ),
    "initial_aperture": Quantity(
        "mean aperture at first touch", "m", r"a_0", lambda joint: joint.initial_aperture
    ),
    "aperture_at_seating": Quantity(
        "mean aperture at seating", "m", r"a_\mathrm{s}", _aperture_at_seating
    ),
    "hysteresis": Quantity(
        "share of the work of loading that unloading does not give back",
        "1",
        r"\eta",
        lambda joint: hysteresis(joint.closed),
    ),
    "fft_pair": Quantity(
        "processor time of an FFT pair of 200 x 200 cells, measured beside the closure",
        "s",
        r"t_\mathrm{FFT}",
        lambda joint: pair_seconds(),
    ),
}
"""All quantities by name, which is their column in tables of points."""

"""The quantities that are read of a closed joint: one definition, unit, title and symbol each."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.ensemble.responses import responses_of
from jointclosure.ensemble.settings import Conditions


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


QUANTITIES: dict[str, Quantity] = {
    "closure": Quantity(
        "maximum closure, from first touch", "m", r"x_\mathrm{max}", _response("closure")
    ),
    "closure_seated": Quantity(
        "maximum closure since seating", "m", r"x_\mathrm{max,s}", _response("closure_seated")
    ),
    "residual": Quantity("residual closure", "m", r"x_\mathrm{res}", _response("residual")),
    "closure_above_half": Quantity(
        "half of the maximum stress over the stiffness of loading there",
        "m",
        r"\Delta x_{1/2}",
        _response("closure_above_half"),
    ),
}
"""All quantities by name, which is their column in tables of points."""

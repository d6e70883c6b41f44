"""Quantities of a closed joint, with definition, unit, title and symbol."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engineering.curves import cycle_table, hysteresis, seat_of
from jointclosure.engineering.laws import fitted_laws, parameter
from jointclosure.ensemble.responses import responses_of
from jointclosure.ensemble.timing import pair_seconds
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.history import closure_at_stresses, loop_between
from jointclosure.joint.protocol import LOADING
from jointclosure.surface.bearing import bearing_depths
from jointclosure.surface.roughness import rms_slope


class ClosedJoint:
    """A closed joint: its pristine walls, its history, and the conditions.

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
    def summed(self) -> np.ndarray:
        """Summed heights (y, x) of the pristine walls [m]."""
        upper, lower = self.walls
        return upper + lower

    @property
    def initial_aperture(self) -> float:
        """Mean distance of the pristine walls at first touch [m]."""
        return float((self.summed.max() - self.summed).mean())

    def hyperbola(self, name: str) -> np.ndarray:
        """Return a parameter (cycles,) of the hyperbolic law of each loading (`fitted_laws`)."""
        cycles = range(1, self.closed.max_closure.size + 1)
        return np.array([parameter(self._laws, cycle, LOADING, name) for cycle in cycles])

    @cached_property
    def _laws(self) -> pd.DataFrame:
        return fitted_laws(self.closed)


class Quantity(NamedTuple):
    """A quantity of a closed joint.

    Attributes
    ----------
    title : str
        Title in tables and at axes, without unit.
    unit : str
        SI unit; "1" for a ratio.
    symbol : str
        Symbol in the mathematical notation of matplotlib.
    rule : callable
        Function of a `ClosedJoint` that returns an array (cycles,), or a number if the quantity
        does not depend on the cycle.
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
    cycles = range(1, joint.conditions.cycle_count + 1)
    return np.array([seat_of(joint.closed, cycle, LOADING, "mean_aperture") for cycle in cycles])


def _loop(joint: ClosedJoint) -> np.ndarray:
    closed, given = joint.closed, joint.conditions
    loading, unloading = closure_at_stresses(
        closed.closure.values,
        closed.normal_stress.values,
        closed.cycle.values,
        closed.branch.values,
        given.cycle_count,
        np.array([0.5 * np.max(given.max_normal_stress)]),
        given.numerics.stress_tolerance,
    )[:, :, 0].T
    return loop_between(loading, unloading)


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
    "closure_seated": Quantity(
        "maximum closure since seating",
        "m",
        r"x_\mathrm{max,s}",
        _of_history("max_closure_seated"),
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
    "kni_net": Quantity(
        "initial stiffness of the hyperbolic law of net loading since seating",
        "Pa/m",
        r"k_\mathrm{ni}",
        lambda joint: 1e9 * joint.hyperbola("kni_MPa_per_mm"),
    ),
    "vm_net": Quantity(
        "largest closure of the hyperbolic law of net loading since seating",
        "m",
        r"V_\mathrm{m}",
        lambda joint: 1e-3 * joint.hyperbola("vm_mm"),
    ),
    "rms_height": Quantity(
        "rms of the summed heights", "m", r"R_q", lambda joint: float(np.std(joint.summed))
    ),
    "rms_slope": Quantity(
        "rms slope of the summed heights at their spacing",
        "1",
        r"Z_2",
        lambda joint: rms_slope(joint.summed, joint.conditions.grid_spacing),
    ),
    "depth_5": Quantity(
        "depth of the highest 5 % of the summed heights below their top",
        "m",
        r"d_{5}",
        lambda joint: float(bearing_depths(joint.summed, 0.05)),
    ),
    "initial_aperture": Quantity(
        "mean aperture at first touch", "m", r"a_0", lambda joint: joint.initial_aperture
    ),
    "aperture_at_seating": Quantity(
        "mean aperture at seating", "m", r"a_\mathrm{s}", _aperture_at_seating
    ),
    "contact_at_max": Quantity(
        "share of cells in contact at the maximum stress",
        "1",
        r"A_\mathrm{c}",
        lambda joint: cycle_table(joint.closed).contact_at_max.to_numpy(),
    ),
    "loop": Quantity(
        "closure of unloading less that of loading, at half of the maximum stress",
        "m",
        r"x_\mathrm{loop}",
        _loop,
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
"""All quantities by name; the name is the column in tables of points."""

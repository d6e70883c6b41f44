"""A closed joint, of which quantities are read."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.conditions import Conditions
from jointclosure.joint.curves import net_responses
from jointclosure.joint.history import values_at_stresses
from jointclosure.joint.laws import fitted_laws, parameter
from jointclosure.joint.protocol import LOADING


@dataclass(frozen=True)
class ClosedJoint:
    """A closed joint.

    Attributes
    ----------
    walls : (array (y, x), array (y, x))
        Upper and lower wall before loading [m].
    closed : Dataset
        As from `jointclosure.simulate`.
    conditions : Conditions
    seconds : float
        Processor time of the closure [s].
    stresses : array (n,)
        Stresses at which curves are read [Pa].
    """

    walls: tuple[np.ndarray, np.ndarray]
    closed: xr.Dataset
    conditions: Conditions
    seconds: float
    stresses: np.ndarray

    @property
    def summed(self) -> np.ndarray:
        """Summed heights (y, x) of the pristine walls [m]."""
        return self.walls[0] + self.walls[1]

    @cached_property
    def net(self) -> dict[str, np.ndarray]:
        """Net closures and stiffness of each cycle (`net_responses`)."""
        return net_responses(self.closed, float(np.max(self.conditions.max_normal_stress)))

    def curve(self, values: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Read values of steps at stresses, over (cycle, branch, stress)."""
        tolerance = self.conditions.numerics.stress_tolerance
        cycles = self.conditions.cycle_count
        return values_at_stresses(self.closed, values, cycles, stresses, tolerance)

    def hyperbola(self, name: str) -> np.ndarray:
        """Return a parameter (cycles,) of the hyperbolic law of each loading (`fitted_laws`)."""
        cycles = range(1, self.closed.max_closure.size + 1)
        return np.array([parameter(self._laws, cycle, LOADING, name) for cycle in cycles])

    @cached_property
    def _laws(self) -> pd.DataFrame:
        return fitted_laws(self.closed)

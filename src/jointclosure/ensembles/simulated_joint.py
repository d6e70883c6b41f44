"""One simulated joint of an ensemble, with the data from which its quantities are read."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.cycle_results import net_responses
from jointclosure.joint.history import History, history_of
from jointclosure.joint.laws import loading_hyperbolas
from jointclosure.walls import Walls


@dataclass(frozen=True)
class SimulatedJoint:
    """Simulated joint: walls (y, x) [m] before loading, history, conditions, processor time [s].

    Curves are read at ``stresses`` (n,) [Pa].
    """

    walls: Walls
    closed: xr.Dataset
    conditions: CheckedConditions
    seconds: float
    stresses: np.ndarray

    @property
    def final(self) -> Walls:
        """Walls (y, x) [m] at the end."""
        return self.closed.upper_final.values, self.closed.lower_final.values

    @cached_property
    def history(self) -> History:
        """Cycles and branches of the joint."""
        return history_of(self.closed)

    @cached_property
    def summed(self) -> np.ndarray:
        """Summed heights (y, x) of the pristine walls [m]."""
        return self.walls[0] + self.walls[1]

    @cached_property
    def net(self) -> dict[str, np.ndarray]:
        """Net closures and stiffness of each cycle (`net_responses`)."""
        return net_responses(self.closed)

    def read_at_stresses(self, values: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Return values of steps (steps,) at stresses [Pa], over (cycle, branch, stress)."""
        tolerance = self.conditions.numerics.stress_tolerance
        cycles = self.conditions.cycle_count
        return self.history.curve(values).where_reached(stresses, cycles, tolerance)

    def hyperbola(self, name: str) -> np.ndarray:
        """Return a parameter (cycles,) of the hyperbolic law of each loading."""
        return self._hyperbolas[name].to_numpy()

    @cached_property
    def _hyperbolas(self) -> pd.DataFrame:
        return loading_hyperbolas(self.closed, range(1, self.closed.max_closure.size + 1))

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
    """Simulated joint of an ensemble, from which its quantities are read.

    ``walls`` (y, x) [m] are those before loading, ``closed`` is the history. ``seconds`` is the
    processor time of the simulation [s]. Curves are read at ``stresses`` (n,) [Pa].
    """

    walls: Walls
    closed: xr.Dataset
    conditions: CheckedConditions
    seconds: float
    stresses: np.ndarray

    @property
    def final(self) -> Walls:
        """Walls (y, x) [m] at the end of the last cycle."""
        return self.closed.upper_final.values, self.closed.lower_final.values

    @cached_property
    def history(self) -> History:
        """Cycles and branches of the joint."""
        return history_of(self.closed)

    @cached_property
    def summed(self) -> np.ndarray:
        """Sum of the heights (y, x) [m] of both walls before loading."""
        return self.walls[0] + self.walls[1]

    @cached_property
    def net(self) -> dict[str, np.ndarray]:
        """Net closures and stiffness of each cycle (`net_responses`)."""
        return net_responses(self.closed)

    def read_at_stresses(self, values: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Read values of steps (steps,) at stresses (n,) [Pa] on each branch.

        The result is (cycle, branch, n), and NaN at stresses that a branch does not have.
        """
        tolerance = self.conditions.numerics.stress_tolerance
        cycles = self.conditions.cycle_count
        return self.history.curve(values).where_reached(stresses, cycles, tolerance)

    def hyperbola(self, name: str) -> np.ndarray:
        """Return a parameter (cycles,) of the hyperbola that is fitted to each loading.

        ``name`` is "kni_MPa_per_mm" or "vm_mm". NaN where no hyperbola was fitted.
        """
        return self._hyperbolas[name].to_numpy()

    @cached_property
    def _hyperbolas(self) -> pd.DataFrame:
        """Parameters of the hyperbolas of all loadings, by cycle."""
        return loading_hyperbolas(self.closed, range(1, self.closed.max_closure.size + 1))

"""Load history of a joint, read once from its Dataset: cycles, branches, turning points, closures.

`history_of(joint)` is a view of a Dataset of `simulate` or `close`. It is an accessor of xarray,
which makes it once for each Dataset. All values are in SI units.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
import xarray as xr

from jointclosure.joint.interpolation import crossing, cubic_over
from jointclosure.joint.status import LOADING, UNLOADING

NET = "closure_net"
"""Net closure, as laboratories report it: without the displacement of the half-spaces under the
loaded patch as a whole (docs/model.md, "Interaction")."""
GROSS = "closure"
"""Gross closure, with that displacement."""
KINDS = {"net": NET, "gross": GROSS}
"""Variables of closures, by the words for them in names of columns."""
_ACCESSOR = "load_history"  # name of the accessor of xarray by which a history is cached
_WHOLE_STEP = 0.999
"""Rise of closure over the displacement step from which a step is a whole one, not of a landing."""
_LANDING_TOLERANCES = 3.0
"""Number of stress tolerances within which two maxima count as equal: each of the two is reached
to within one tolerance, and one is added for rounding."""


@dataclass(frozen=True)
class Branch:
    """Loading or unloading of one cycle: indices (n,) of its steps, its start included."""

    cycle: int
    name: str
    steps: np.ndarray

    @property
    def exists(self) -> bool:
        """Whether the branch has a step besides its start."""
        return self.steps.size > 1


@dataclass(frozen=True)
class Cycle:
    """One load cycle that was begun."""

    number: int
    loading: Branch
    unloading: Branch

    @property
    def branches(self) -> tuple[Branch, Branch]:
        """Loading and unloading."""
        return self.loading, self.unloading

    def branch(self, name: str) -> Branch:
        """Return loading or unloading by its name."""
        return self.loading if name == LOADING else self.unloading


@xr.register_dataset_accessor(_ACCESSOR)
class History:
    """Cycles, branches and closures of a simulated joint, from its Dataset."""

    def __init__(self, joint: xr.Dataset) -> None:
        self.joint = joint

    @cached_property
    def stress(self) -> np.ndarray:
        """Nominal normal stress (steps,) [Pa]."""
        return self.joint.normal_stress.values

    @cached_property
    def gross(self) -> np.ndarray:
        """Gross closure (steps,) from first touch [m]."""
        return self.joint.closure.values

    @cached_property
    def net(self) -> np.ndarray:
        """Net closure (steps,) from first touch [m]."""
        return self.joint.closure.values - self.joint.bulk_indentation.values

    @cached_property
    def load_cycle(self) -> np.ndarray:
        """Number of the load cycle of each step (steps,)."""
        return self.joint.load_cycle.values

    @cached_property
    def seating_stress(self) -> float:
        """Seating stress [Pa]."""
        return float(self.joint.attrs["seating_stress_Pa"])

    @cached_property
    def begun(self) -> int:
        """Number of cycles that were begun."""
        return int(self.load_cycle.max())

    @cached_property
    def cycles(self) -> tuple[Cycle, ...]:
        """The cycles that were begun."""
        loading = self.joint.branch.values == LOADING
        unloading = self.joint.branch.values == UNLOADING
        cycles = []
        for number in range(1, self.begun + 1):
            here = self.load_cycle == number
            up = Branch(number, LOADING, _with_start(np.flatnonzero(here & loading)))
            down = Branch(number, UNLOADING, _with_start(np.flatnonzero(here & unloading)))
            cycles.append(Cycle(number, up, down))
        return tuple(cycles)

    @cached_property
    def maxima(self) -> np.ndarray:
        """Stated maximum stress (cycles,) [Pa] of each cycle that was begun."""
        # the turning points of all cycles, or one maximum of all
        stated = np.atleast_1d(self.joint.attrs["max_normal_stress_Pa"])[::2]
        return stated[: self.begun] if stated.size > 1 else np.broadcast_to(stated, self.begun)

    @cached_property
    def former_maxima(self) -> np.ndarray:
        """Largest stated maximum (cycles,) [Pa] of the cycles before each one.

        Beyond it the loading of the cycle crushes asperities again. It is 0 if the cycle does not
        exceed it.
        """
        before = np.maximum.accumulate(np.append(0.0, self.maxima[:-1]))
        return np.where(self.maxima > before, before, 0.0)

    @cached_property
    def numerics(self) -> dict[str, Any]:
        """Values of `Numerics` with which the joint was simulated."""
        return json.loads(self.joint.attrs.get("numerics", "{}"))

    @cached_property
    def effects(self) -> dict[str, bool]:
        """Values of `Effects` with which the joint was simulated."""
        return json.loads(self.joint.attrs["effects"])

    @property
    def by_fixed_steps(self) -> bool:
        """Whether the joint was simulated by the paper's fixed steps."""
        return self.numerics.get("breakage") == "fixed_step"

    @property
    def has_flow(self) -> bool:
        """Whether the joint has hydraulic apertures."""
        return "hydraulic_aperture" in self.joint

    @cached_property
    def spacing(self) -> float:
        """Spacing of the cells [m]."""
        axes = (self.joint[name].values for name in ("y", "x"))
        return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)

    @cached_property
    def area(self) -> float:
        """Nominal area [m2]."""
        return self.spacing**2 * self.joint.sizes["y"] * self.joint.sizes["x"]

    def along(self, of: str | np.ndarray = NET) -> np.ndarray:
        """Return a variable by name, or values that are given, at each step (steps,)."""
        if isinstance(of, np.ndarray):
            return of
        if of == NET:
            return self.net
        return self.joint[of].values

    def branch(self, cycle: int, name: str) -> Branch:
        """Return a branch of a cycle by its number and name; without steps if it was not begun."""
        if cycle > self.begun:
            return Branch(cycle, name, np.empty(0, dtype=np.intp))
        return self.cycles[cycle - 1].branch(name)

    def existing_branches(self) -> Iterator[tuple[tuple[int, int], Branch]]:
        """Generate the branches that have steps, with their place (cycle, branch) in arrays."""
        for index, cycle in enumerate(self.cycles):
            for side, branch in enumerate(cycle.branches):
                if branch.exists:
                    yield (index, side), branch

    def unloaded_cycles(self, minima: np.ndarray) -> Iterator[tuple[int, Cycle]]:
        """Generate index and cycle of the cycles that were unloaded to their minimum.

        ``minima`` (cycles,) [Pa] are these stresses.
        """
        for index, (cycle, minimum) in enumerate(zip(self.cycles, minima, strict=False)):
            whole = cycle.loading.exists and cycle.unloading.exists
            if whole and self.stress[cycle.unloading.steps[-1]] <= minimum:
                yield index, cycle

    def read(self, branch: Branch, values: np.ndarray, levels: np.ndarray) -> np.ndarray:
        """Read values (steps,) where the stress of a branch first reaches levels (n,) [Pa], or NaN.

        They are linear between the paper's fixed steps, else a monotone cubic.
        """
        stress = self.stress[branch.steps]
        known = values[branch.steps]
        if self.by_fixed_steps:
            return np.array([crossing(stress, known, level, branch.name) for level in levels])
        if branch.name == UNLOADING:
            stress = stress[::-1]
            known = known[::-1]
        return cubic_over(stress, known)(levels)

    def seat(self, cycle: int, name: str, of: str | np.ndarray = NET) -> float:
        """Read the net closure [m], or the variable ``of``, at the seating stress of a branch.

        It is NaN where the branch does not reach down to the seating stress.
        """
        branch = self.branch(cycle, name)
        if not branch.steps.size or self.stress[branch.steps].min() > self.seating_stress:
            return float("nan")
        return float(self.read(branch, self.along(of), np.array([self.seating_stress]))[0])

    def seats(self, name: str = LOADING, of: str | np.ndarray = NET) -> np.ndarray:
        """Read the net closure [m], or the variable ``of``, at seating of each cycle (cycles,)."""
        return np.array([self.seat(cycle.number, name, of) for cycle in self.cycles])

    def at_maxima(self, of: str | np.ndarray) -> np.ndarray:
        """Return a variable, or values of steps, at the maximum of each cycle (cycles,).

        It is NaN in a cycle that was not unloaded.
        """
        values = self.along(of)
        steps = [next(iter(cycle.unloading.steps), -1) for cycle in self.cycles]
        return np.where(np.array(steps) < 0, np.nan, values[steps])

    @cached_property
    def landing_stresses(self) -> np.ndarray:
        """Stress (cycles,) [Pa] at the end of the last whole step of each loading.

        From there smaller steps land on the maximum. It is infinite without such steps: for
        elastic, resolved or interpolated loadings, and where the maximum is no new one.

        The paper's steps pass the maximum, and smaller steps then land on it. Closures beyond the
        landing stress come from these smaller steps.
        """
        return np.array([self._landing_stress(cycle) for cycle in self.cycles])

    def _landing_stress(self, cycle: Cycle) -> float:
        lands = self.by_fixed_steps and self.effects["breakage"]
        if not lands or self.numerics["target"] == "interpolate":
            return np.inf
        loading = cycle.loading
        former = self.stress[self.load_cycle < cycle.number].max(initial=0.0)
        within = 1.0 + _LANDING_TOLERANCES * self.numerics["stress_tolerance"]
        if not loading.exists or self.stress[loading.steps].max() <= former * within:
            return np.inf
        step = "displacement_step" if cycle.number == 1 else "later_displacement_step"
        rises = np.diff(self.gross[loading.steps])
        whole = np.flatnonzero(rises >= _WHOLE_STEP * self.numerics[step])
        after = whole[-1] + 1 if whole.size else 0
        return float(self.stress[loading.steps][after])


def history_of(joint: xr.Dataset) -> History:
    """Return the load history of a Dataset of `simulate` or `close`, made once for each Dataset."""
    return cast(History, getattr(joint, _ACCESSOR))


def with_snapshots(joint: xr.Dataset, stresses: Any) -> xr.Dataset:
    """Return a joint with the snapshots at some stresses [Pa] only, as if simulated with these."""
    if len(stresses):
        return joint.isel(snapshot=joint.snapshot_stress.isin(stresses))
    states = [name for name in joint.variables if str(name).startswith("snapshot_")]
    return joint.drop_vars([*states, "upper_first", "lower_first"], errors="ignore")


def _with_start(steps: np.ndarray) -> np.ndarray:
    """Return indices (n,) of consecutive steps with the one before them, if there is one."""
    if steps.size and steps[0] > 0:
        return np.concatenate([[steps[0] - 1], steps])
    return steps

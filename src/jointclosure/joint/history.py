"""Load history of a joint, read once from its Dataset: cycles, branches, curves over stress.

`history_of(joint)` is a view of a Dataset of `simulate` or `close`. It is an accessor of xarray,
which makes it once for each Dataset. Tables, laws, figures and files read a joint by it alone: by
its cycles and branches, and by its curves, such as ``history.net.at(stresses)``. All values are in
SI units.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
import xarray as xr

from jointclosure.joint.interpolation import crossing, cubic_over, rising_slopes
from jointclosure.joint.status import FLOW_STATUSES, LOADING, UNLOADING

NET = "closure_net"
"""Variable of net closure, as laboratories report it: without the displacement of the half-spaces
under the loaded patch as a whole (docs/model.md, "Interaction")."""
GROSS = "closure"
"""Variable of gross closure, with that displacement."""
KINDS = {"net": NET, "gross": GROSS}
"""Variables of closures, by the words for them in names of columns."""
_ACCESSOR = "load_history"  # name of the accessor of xarray by which a history is cached
_WHOLE_STEP = 0.999
"""Rise of closure over the displacement step from which a step is a whole one, not of a landing."""
_LANDING_TOLERANCES = 3.0
"""Number of stress tolerances within which two maxima count as equal: each of the two is reached
to within one tolerance, and one is added for rounding."""
LEVELS = 20
"""Largest number of stress intervals in a table, from seating to the maximum."""
_ROUND_DIGITS = 1.0, 2.0, 2.5, 5.0, 10.0  # first digits of a round interval of stress
_APART = 0.25  # least distance of a round stress from the two ends of a table, over the interval
POINTS = 60
"""Intervals of stress by which the slope of a curve is computed."""
_NEARLY = 1.01
"""A branch counts as reaching stresses up to this times its largest stress, because that may be
below the stated maximum by its tolerance."""


@dataclass(frozen=True)
class Branch:
    """Loading or unloading of one cycle, with the indices (n,) of its steps in the history.

    The first of them is the step from which the branch starts, the last of the branch before it.
    They are empty if the branch was not begun.
    """

    cycle: int
    name: str
    steps: np.ndarray

    @property
    def has_steps(self) -> bool:
        """Whether the branch has a step besides the one from which it starts."""
        return self.steps.size > 1


@dataclass(frozen=True)
class Cycle:
    """One load cycle of a joint that was begun, with its loading and unloading."""

    number: int
    loading: Branch
    unloading: Branch

    @property
    def branches(self) -> tuple[Branch, Branch]:
        """Loading and unloading of the cycle, in this order."""
        return self.loading, self.unloading

    def branch(self, name: str) -> Branch:
        """Return the branch of the cycle with a name, "loading" or "unloading"."""
        return self.loading if name == LOADING else self.unloading


@xr.register_dataset_accessor(_ACCESSOR)  # type: ignore[no-untyped-call]
class History:
    """Load history of a simulated joint, from its Dataset: cycles, branches and closures.

    Arrays (steps,) have a value for each step of the simulation.
    """

    def __init__(self, joint: xr.Dataset) -> None:
        self.joint = joint

    @cached_property
    def stress(self) -> np.ndarray:
        """Nominal normal stress of each step (steps,) [Pa]."""
        return self.joint.normal_stress.values

    @cached_property
    def gross(self) -> "Curve":
        """Curve of the gross closure from first touch [m]."""
        return Curve(self, self.joint.closure.values)

    @cached_property
    def net(self) -> "Curve":
        """Curve of the net closure from first touch [m]."""
        return Curve(self, self.joint.closure.values - self.joint.bulk_indentation.values)

    @property
    def closures(self) -> dict[str, "Curve"]:
        """Curves of the net and the gross closure, by the keys of `KINDS`, "net" and "gross"."""
        return {kind: self.curve(of) for kind, of in KINDS.items()}

    def curve(self, of: str | np.ndarray) -> "Curve":
        """Return the curve of a variable by its name, or of values (steps,).

        The name is that of a variable of the Dataset along ``step``, or `NET`.
        """
        if isinstance(of, np.ndarray):
            return Curve(self, of)
        if of == NET:
            return self.net
        return self.gross if of == GROSS else Curve(self, self.joint[of].values)

    @cached_property
    def load_cycle(self) -> np.ndarray:
        """Number of the load cycle of each step (steps,)."""
        return self.joint.load_cycle.values

    @cached_property
    def seating_stress(self) -> float:
        """Stress [Pa] from which closures since seating count."""
        return float(self.joint.attrs["seating_stress_Pa"])

    @cached_property
    def begun(self) -> int:
        """Number of load cycles that were begun."""
        return int(self.load_cycle.max())

    @cached_property
    def cycles(self) -> tuple[Cycle, ...]:
        """Load cycles that were begun, in order."""
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
        # the attribute has the turning points of all cycles, or one maximum for all cycles
        stated = np.atleast_1d(self.joint.attrs["max_normal_stress_Pa"])[::2]
        return stated[: self.begun] if stated.size > 1 else np.broadcast_to(stated, self.begun)

    @cached_property
    def former_maxima(self) -> np.ndarray:
        """Largest stated maximum (cycles,) [Pa] of the cycles before each cycle that exceeds it.

        Beyond it the loading of the cycle crushes asperities again. It is 0 for a cycle that does
        not exceed all maxima before it, and for the first cycle.
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
        """Whether the rock of the joint was broken in the paper's fixed steps."""
        return self.numerics.get("breakage") == "fixed_step"

    @property
    def has_flow(self) -> bool:
        """Whether the joint was simulated with flow, and has hydraulic apertures."""
        return "hydraulic_aperture" in self.joint

    @cached_property
    def spacing(self) -> float:
        """Spacing of the cells of the joint [m]."""
        axes = (self.joint[name].values for name in ("y", "x"))
        return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)

    @cached_property
    def area(self) -> float:
        """Nominal area of the joint [m2]."""
        return self.spacing**2 * self.joint.sizes["y"] * self.joint.sizes["x"]

    @cached_property
    def flow_statuses(self) -> np.ndarray:
        """Status of the flow in words (steps, directions); only for a joint that `has_flow`."""
        words = np.array(self.joint.flow_status.attrs["flag_meanings"].split(), dtype=object)
        return words[self.joint.flow_status.values.astype(int)]

    def flow_status_at(self, levels: np.ndarray) -> np.ndarray:
        """Return the status of the flow in words (cycles, branches, levels) at stresses [Pa].

        ``levels`` (levels,) are the stresses. Of the statuses along x and along y, at the steps on
        both sides of a stress, it is the worst, the one farthest back in `FLOW_STATUSES`. It is ""
        where the branch does not reach the stress.
        """
        rank = np.vectorize(FLOW_STATUSES.index)(self.flow_statuses).max(axis=1)
        ranks = np.zeros((self.begun, 2, levels.size), dtype=int)
        for least in range(1, len(FLOW_STATUSES)):
            ranks += self.curve((rank >= least).astype(float)).at(levels) > 0.0
        reached = np.isfinite(self.curve(np.zeros(rank.size)).at(levels))
        return np.where(reached, np.array(FLOW_STATUSES, dtype=object)[ranks], "")

    def branch(self, cycle: int, name: str) -> Branch:
        """Return a branch of a cycle by the cycle's number and the branch's name.

        It has no steps if the cycle was not begun.
        """
        if cycle > self.begun:
            return Branch(cycle, name, np.empty(0, dtype=np.intp))
        return self.cycles[cycle - 1].branch(name)

    def existing_branches(self) -> Iterator[tuple[tuple[int, int], Branch]]:
        """Generate the branches that have steps, each with its place (cycle, branch) in arrays.

        The place is of indices from 0, and 0 for loading or 1 for unloading.
        """
        for index, cycle in enumerate(self.cycles):
            for side, branch in enumerate(cycle.branches):
                if branch.has_steps:
                    yield (index, side), branch

    def unloaded_cycles(self, minima: np.ndarray) -> Iterator[tuple[int, Cycle]]:
        """Generate index and cycle of the cycles that were unloaded to their minimum.

        ``minima`` (cycles,) [Pa] are the stresses that must be reached, at most, at the end of
        unloading.
        """
        for index, (cycle, minimum) in enumerate(zip(self.cycles, minima, strict=False)):
            whole = cycle.loading.has_steps and cycle.unloading.has_steps
            if whole and self.stress[cycle.unloading.steps[-1]] <= minimum:
                yield index, cycle

    @cached_property
    def landing_stresses(self) -> np.ndarray:
        """Stress (cycles,) [Pa] at the end of the last step of full size of each loading.

        The paper's steps of full size pass the maximum, and the last one is then repeated in
        smaller steps that land on the maximum. Closures above this stress come from the smaller
        steps. The stress is infinite where no smaller steps are taken: in elastic loadings, with
        resolved breakage or with interpolation to the maximum, and where an earlier maximum is not
        exceeded.
        """
        return np.array([self._landing_stress(cycle) for cycle in self.cycles])

    def _landing_stress(self, cycle: Cycle) -> float:
        lands = self.by_fixed_steps and self.effects["breakage"]
        if not lands or self.numerics["target"] == "interpolate":
            return np.inf
        loading = cycle.loading
        former = self.stress[self.load_cycle < cycle.number].max(initial=0.0)
        within = 1.0 + _LANDING_TOLERANCES * self.numerics["stress_tolerance"]
        if not loading.has_steps or self.stress[loading.steps].max() <= former * within:
            return np.inf
        step = "displacement_step" if cycle.number == 1 else "later_displacement_step"
        rises = np.diff(self.gross.values[loading.steps])
        whole = np.flatnonzero(rises >= _WHOLE_STEP * self.numerics[step])
        after = whole[-1] + 1 if whole.size else 0
        return float(self.stress[loading.steps][after])

    def stress_levels(self, count: int = LEVELS, cycle: int | None = None) -> np.ndarray:
        """Return ``count`` evenly spaced stresses [Pa] from the seating to the largest stress.

        The largest stress is that of the joint, or that of a ``cycle`` if this is clearly smaller.
        A seating stress of 0 is not among them: the first of them is then one interval above 0.
        """
        seating = self.seating_stress
        largest = float(self.stress.max())
        if cycle is not None:
            reached = float(self.stress[self.load_cycle == cycle].max())
            largest = largest if largest <= _NEARLY * reached else reached
        if seating == 0.0:  # no result is read at zero stress
            return np.linspace(seating, largest, count + 1)[1:]
        return np.linspace(seating, largest, count)

    def table_levels(self, at: Sequence[float] = ()) -> np.ndarray:
        """Return the stresses (levels,) [Pa] of `stress_table`, ascending.

        They are round stresses from the seating stress to the stated maximum, the maximum of every
        cycle, and the stresses ``at`` [Pa]. If the joint did not reach the stated maximum, its
        largest stress stands in place of it.
        """
        reached = float(self.stress.max())
        stated = float(self.maxima.max())
        largest = stated if stated <= _NEARLY * reached else reached
        if not largest > self.seating_stress:
            return np.union1d([largest], at)
        maxima = self.maxima[self.maxima <= largest]
        levels = np.union1d(round_levels(self.seating_stress, largest), maxima)
        return np.union1d(levels, at)


@dataclass(frozen=True, eq=False)
class Curve:
    """Variable of a history over stress, such as a closure [m], for each of its branches.

    ``values`` (steps,) are those at the steps of the history.
    """

    history: History
    values: np.ndarray

    def read(self, branch: Branch, levels: np.ndarray) -> np.ndarray:
        """Read the values (n,) where the stress of a branch first reaches levels (n,) [Pa].

        They are NaN at levels that the branch does not reach. Between the paper's fixed steps they
        are linear, otherwise on a monotone cubic.
        """
        stress = self.history.stress[branch.steps]
        known = self.values[branch.steps]
        if self.history.by_fixed_steps:
            return np.array([crossing(stress, known, level, branch.name) for level in levels])
        if branch.name == UNLOADING:
            stress = stress[::-1]
            known = known[::-1]
        return cubic_over(stress, known)(levels)

    def seat(self, cycle: int, name: str) -> float:
        """Read the value at the seating stress on a branch, by its cycle and name.

        It is NaN where the branch does not reach down to the seating stress, or was not begun.
        """
        history = self.history
        branch = history.branch(cycle, name)
        if not branch.steps.size or history.stress[branch.steps].min() > history.seating_stress:
            return float("nan")
        return float(self.read(branch, np.array([history.seating_stress]))[0])

    @property
    def seats(self) -> np.ndarray:
        """Values (cycles,) at the seating stress on the loading of each cycle, NaN as in `seat`."""
        return np.array([self.seat(cycle.number, LOADING) for cycle in self.history.cycles])

    @property
    def at_maxima(self) -> np.ndarray:
        """Values (cycles,) at the maximum of each cycle, NaN where unloading was not begun."""
        steps = [next(iter(cycle.unloading.steps), -1) for cycle in self.history.cycles]
        return np.where(np.array(steps) < 0, np.nan, self.values[steps])

    def where_reached(self, levels: np.ndarray, cycles: int, tolerance: float = 0.0) -> np.ndarray:
        """Read the values (cycles, 2, levels) where branches first reach stresses (levels,) [Pa].

        They are as from `read`, and NaN at stresses that a branch does not have. A stress beyond
        either end of a branch by at most the relative ``tolerance`` is read at that end.
        """
        answer = np.full((cycles, 2, levels.size), np.nan)
        near = 1.0 + 1.01 * tolerance
        for place, branch in self.history.existing_branches():
            stress = self.history.stress[branch.steps]
            maximum = stress.max()
            minimum = stress.min()
            read = np.where((levels < minimum) & (minimum <= levels * near), minimum, levels)
            read = np.where((maximum < read) & (read <= maximum * near), maximum, read)
            asked = read >= minimum
            answer[(*place, asked)] = self.read(branch, read[asked])
        return answer

    def at(self, levels: np.ndarray) -> np.ndarray:
        """Read the values (cycles, 2, levels) on loading and unloading at stresses (levels,) [Pa].

        They are read on a monotone cubic. A loading with a landing has two, below and above its
        landing stress. They are NaN at stresses that a branch does not reach; up to `_NEARLY` times
        its largest stress they are read at the latter.
        """
        history = self.history
        read = np.full((history.begun, 2, levels.size), np.nan)
        for (index, side), branch in history.existing_branches():
            loads = branch.name == LOADING
            steps = branch.steps if loads else branch.steps[::-1]
            stress = history.stress[steps]
            values = self.values[steps]
            largest = float(stress.max())
            reached = np.where((levels > largest) & (levels <= _NEARLY * largest), largest, levels)
            end = history.landing_stresses[index] if loads else np.inf
            for known, asked in ((stress <= end, reached <= end), (stress >= end, reached > end)):
                if known.any():
                    cubic = cubic_over(stress[known], values[known])
                    read[index, side, asked] = cubic(reached[asked])
        return read

    def secant_stiffness(self, cycle: int, low: float, high: float) -> float:
        """Compute the normal stiffness [Pa/m] of the loading of a cycle, by a chord.

        The curve must be that of a closure. The chord leads from the stress ``low`` [Pa] to
        ``high`` [Pa], but at most to the largest stress of the loading and to its landing stress.
        The stiffness is NaN if nothing is left of the chord, or if the closure does not rise.
        """
        history = self.history
        loading = history.branch(cycle, LOADING)
        if not loading.has_steps:
            return np.nan
        reached = float(history.stress[loading.steps].max())
        levels = np.array([low, min(high, reached, history.landing_stresses[cycle - 1])])
        rise = float(np.diff(self.at(levels)[cycle - 1, 0])[0])
        return float(np.diff(levels)[0]) / rise if levels[1] > low and rise > 0.0 else np.nan

    def normal_stiffness(self, levels: np.ndarray) -> np.ndarray:
        """Compute the normal stiffness (cycles, 2, levels) [Pa/m] at stresses (levels,) [Pa].

        The curve must be that of a closure, whose slope itself goes up and down where contacts
        break. The stiffness is therefore that of the concave curve nearest to the closure over
        stress, and rises with stress. There is one such curve below the former maximum of a cycle,
        and another above it. The stiffness is NaN at stresses that a branch does not reach, and
        above the landing stress.
        """
        history = self.history
        fine = self._slope_levels(levels)
        closures = self.at(fine)
        stiffness = np.full((*closures.shape[:2], levels.size), np.nan)
        for (index, side), branch in history.existing_branches():
            closure = closures[index, side]
            loads = branch.name == LOADING
            end = history.landing_stresses[index] if loads else np.inf
            former = history.former_maxima[index] if loads else 0.0
            for part in (fine <= former, fine >= former):
                known = part & np.isfinite(closure) & (fine <= end)
                if known.sum() > 2:
                    inside = (levels >= fine[known][0]) & (levels <= fine[known][-1])
                    slopes = rising_slopes(fine[known], closure[known], levels[inside])
                    stiffness[index, side, inside] = slopes
        return stiffness

    def _slope_levels(self, levels: np.ndarray) -> np.ndarray:
        """Return the stresses [Pa] between which slopes of the curve are computed, ascending.

        They are evenly spaced over the range of the table, with the former maxima, where the slope
        changes, and those of the given ``levels`` [Pa] that lie beyond that range.
        """
        first, last = self.history.table_levels()[[0, -1]]
        formers = self.history.former_maxima
        turns = formers[(formers > first) & (formers < last)]
        fine = np.union1d(np.linspace(first, last, POINTS + 1), turns)
        return np.union1d(fine, levels[(levels < first) | (levels > last)])

    def cycle_closures(self, minima: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """Compute the maximum and residual closures of each cycle (cycles,) [m], by name.

        The curve must be that of a closure. ``max_closure`` is the closure from the start of the
        cycle to its maximum, and ``residual_closure`` the closure from first touch at the end of
        its unloading. ``_seated`` closures count from the seating stress on the loading of the
        cycle, and the residual one is read at the seating stress on its unloading. All are NaN in a
        cycle that was not unloaded to its minimum in ``minima`` (cycles,) [Pa]; by default any
        unloading will do.
        """
        closure = self.values
        minima = np.full(self.history.begun, np.inf) if minima is None else minima
        names = ("max_closure", "residual_closure", "max_closure_seated", "residual_closure_seated")
        closures = {name: np.full(len(minima), np.nan) for name in names}
        for index, cycle in self.history.unloaded_cycles(minima):
            seat = self.seat(cycle.number, LOADING)
            back = self.seat(cycle.number, UNLOADING)
            maximum = closure[cycle.loading.steps[-1]]
            closures["max_closure"][index] = maximum - closure[cycle.loading.steps[0]]
            closures["residual_closure"][index] = closure[cycle.unloading.steps[-1]]
            closures["max_closure_seated"][index] = maximum - seat
            closures["residual_closure_seated"][index] = back - seat
        return closures


def history_of(joint: xr.Dataset) -> History:
    """Return the load history of a Dataset of `simulate` or `close`, made once for each Dataset."""
    return cast(History, getattr(joint, _ACCESSOR))


def round_levels(low: float, high: float) -> np.ndarray:
    """Return the stresses ``low`` and ``high`` [Pa], and round stresses between them.

    The round stresses are the multiples of a round interval that are not close to either of the
    two. There are at most `LEVELS` intervals. If ``low`` is 0, it is left out.
    """
    least = (high - low) / LEVELS
    power = 10.0 ** np.floor(np.log10(least))
    sizes = (digits * power for digits in _ROUND_DIGITS)
    interval = next(size for size in sizes if size >= (1.0 - 1e-9) * least)
    inner = interval * np.arange(np.floor(low / interval) + 1.0, np.ceil(high / interval))
    inner = inner[np.minimum(inner - low, high - inner) > _APART * interval]
    return np.array([low, *inner, high] if low > 0.0 else [*inner, high])


def with_snapshots(joint: xr.Dataset, stresses: Any) -> xr.Dataset:
    """Return a joint with those of its snapshots only that are at some stresses [Pa].

    It is as if simulated with these: without stresses the walls at first touch are left out too.
    """
    if len(stresses):
        return joint.isel(snapshot=joint.snapshot_stress.isin(stresses))
    states = [name for name in joint.variables if str(name).startswith("snapshot_")]
    return joint.drop_vars([*states, "upper_first", "lower_first"], errors="ignore")


def _with_start(steps: np.ndarray) -> np.ndarray:
    """Return indices (n,) of consecutive steps, with the step before them if there is one."""
    if steps.size and steps[0] > 0:
        return np.concatenate([[steps[0] - 1], steps])
    return steps

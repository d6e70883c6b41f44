"""Snapshots: states of a joint at given stresses, with overlap and displacement of its cells."""

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import xarray as xr

from jointclosure.joint.cycling import Step
from jointclosure.joint.status import LOADING
from jointclosure.solvers.interaction_operator import interaction_field
from jointclosure.solvers.joint import Joint


def fields_of(joint: Joint, closure: float) -> tuple[np.ndarray, np.ndarray]:
    """Compute the overlap of each cell and its displacement by all other contacts, (y, x) [m].

    The joint has the forces of the state at ``closure`` [m]. The overlap delta_S is negative where
    the walls are apart. Without interaction the displacement is 0.
    """
    if joint.interaction_acts:
        displacement = interaction_field(joint.influence, joint.force)
    else:
        displacement = np.zeros(joint.upper.shape)
    overlap = joint.upper + joint.lower + (closure - joint.first_touch) - displacement
    return overlap, displacement


_FIELDS = {
    "upper": ("upper wall, towards the lower", "m"),
    "lower": ("lower wall, towards the upper", "m"),
    "force": ("normal force of each contact", "N"),
    "gap": ("distance of the deformed walls, negative where they are pressed together", "m"),
    "broken_volume": ("volume missing where walls are lower than at first touch", "m3"),
}
_STEP = "step that is shown: the nearer one in stress of those before and after"
_PLACES: dict[str, tuple[dict[str, str], type]] = {
    "stress": ({"long_name": "stress that was asked for", "units": "Pa"}, np.float64),
    "cycle": ({"long_name": "load cycle in which it was passed"}, np.int32),
    "branch": ({"long_name": "branch on which it was passed"}, object),
    "step": ({"long_name": _STEP}, np.int32),
}


class _State(NamedTuple):
    """State of a joint at a step: its number, normal stress [Pa], and copies of fields by name."""

    step: int
    normal_stress: float
    fields: dict[str, Any]


class Snapshots:
    """`Observer` of a history that stores the joint where branches first pass given stresses [Pa].

    ``tolerance`` is relative: a stress is passed if it is reached to within it. ``datums`` (upper,
    lower) [m] are added to the heights of the walls that are stored.
    """

    def __init__(self, stresses: Sequence[float], tolerance: float, datums: tuple[float, float]):
        self._stresses = sorted({float(stress) for stress in stresses})
        self._tolerance = tolerance
        self._datums = datums
        self._first: _State | None = None
        self._last: _State | None = None
        self._kept: dict[tuple[float, int, str], _State] = {}

    def __call__(self, joint: Joint, step: Step) -> None:
        """Store the state at a step, or the state before if that is nearer, if it passes a stress.

        The state is kept for the next call in any case.
        """
        state = self._state(joint, step)
        self._first = self._first or state
        before = self._last or state._replace(normal_stress=-np.inf)
        earlier = before.normal_stress
        now = state.normal_stress
        for stress in self._stresses:
            place = (stress, step.cycle, step.branch)
            low, high = ((1.0 + part * self._tolerance) * stress for part in (-1.0, 1.0))
            passed = earlier < low <= now if step.branch == LOADING else now <= high < earlier
            if passed and place not in self._kept:  # breakage can lower the stress on loading
                nearer = min(before, state, key=lambda kept: abs(kept.normal_stress - stress))
                self._kept[place] = nearer
        self._last = state

    def _state(self, joint: Joint, step: Step) -> _State:
        cell = joint.law.spacing**2
        fields = {name: getattr(joint, name).copy() for name in ("upper", "lower", "force")}
        pristine = self._first.fields if self._first else fields
        lowered = (np.maximum(pristine[name] - fields[name], 0.0) for name in ("upper", "lower"))
        lost = sum(cell * float(wall.sum()) for wall in lowered)
        fields |= {"gap": -fields_of(joint, step.settled.closure)[0], "broken_volume": lost}
        stress = step.settled.total_force / (joint.upper.size * cell)
        return _State(self._last.step + 1 if self._last else 0, stress, fields)

    def added_to(self, closed: xr.Dataset) -> xr.Dataset:
        """Return a history with its snapshots along ``snapshot``, in the order they were passed."""
        shape = (closed.sizes["y"], closed.sizes["x"])
        states = list(self._kept.values())
        first = cast(_State, self._first)
        datums = dict(zip(("upper", "lower"), self._datums, strict=True))
        variables: dict[str, Any] = {}
        for name, (text, unit) in _FIELDS.items():
            dimensions = () if name == "broken_volume" else shape
            values = np.array([state.fields[name] for state in states], dtype=np.float64)
            values = values.reshape(len(states), *dimensions)
            if name in datums:
                values += datums[name]
            along = ("snapshot", "y", "x")[: values.ndim]
            variables[f"snapshot_{name}"] = (along, values, {"long_name": text, "units": unit})
        for name, datum in datums.items():
            about = {"long_name": f"{name} wall at first touch", "units": "m"}
            variables[f"{name}_first"] = ("y", "x"), first.fields[name] + datum, about
        rows = [(*place, state.step) for place, state in self._kept.items()]
        coordinates: dict[str, Any] = {
            f"snapshot_{name}": ("snapshot", np.array([row[k] for row in rows], dtype=kind), about)
            for k, (name, (about, kind)) in enumerate(_PLACES.items())
        }
        return closed.assign(variables).assign_coords(coordinates)

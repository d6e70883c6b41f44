"""Hydraulic apertures of a joint at every step of its history."""

from typing import Any

import numpy as np
import xarray as xr

from jointclosure.joint.attributes import ATTRIBUTES as OF_HISTORY
from jointclosure.joint.protocol import Step
from jointclosure.joint.reynolds import DIRECTIONS, STATUSES, Flow, flow_along
from jointclosure.joint.states import fields_of
from jointclosure.solvers.joint import Joint

ATTRIBUTES: dict[str, dict[str, Any]] = {
    "hydraulic_aperture": OF_HISTORY["hydraulic_aperture"],
    "flow_status": {
        "long_name": "status of the flow",
        "flag_values": np.array(list(STATUSES), dtype=np.int8),
        "flag_meanings": " ".join(STATUSES.values()),
    },
    "flow_imbalance": OF_HISTORY["flow_imbalance"],
}
COORDINATE = {
    "direction": (
        "direction",
        np.array(DIRECTIONS, dtype=object),
        {"long_name": "direction of the flow"},
    )
}


class FlowAlongHistory:
    """`Observer` that computes the flow along x and along y at every step."""

    def __init__(self) -> None:
        self._flows: list[tuple[Flow, ...]] = []
        self._walls: tuple[np.ndarray, ...] = ()
        self._of_walls: dict[float, tuple[Flow, ...]] = {}

    def __call__(self, joint: Joint, step: Step) -> None:
        """Compute the flow at a step."""
        walls = joint.upper, joint.lower
        if not (self._walls and all(map(np.array_equal, walls, self._walls))):
            self._walls = joint.upper.copy(), joint.lower.copy()
            self._of_walls.clear()
        closure = step.settled.closure
        flows = self._of_walls.get(closure)
        if flows is None:
            aperture = fields_of(joint, closure).aperture
            flows = tuple(
                flow_along(aperture, direction)._replace(pressure=np.empty(0))
                for direction in DIRECTIONS
            )
            self._of_walls[closure] = flows
        self._flows.append(flows)

    def added_to(self, closed: xr.Dataset) -> xr.Dataset:
        """Return a history with the flow at its steps, along ``step`` and ``direction``."""
        read = {
            "hydraulic_aperture": ("hydraulic_aperture", np.float64),
            "flow_status": ("status", np.int8),
            "flow_imbalance": ("imbalance", np.float64),
        }
        added: dict[str, Any] = {}
        for name, (field, kind) in read.items():
            rows = [[getattr(flow, field) for flow in flows] for flows in self._flows]
            added[name] = (("step", "direction"), np.array(rows, dtype=kind), ATTRIBUTES[name])
        return closed.assign(added).assign_coords(COORDINATE)

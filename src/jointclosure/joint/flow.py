"""Hydraulic apertures of a joint at every step of its history, by Reynolds' equation.

div(h^3/(12 mu) grad p) = 0 with the cubic law in every cell (Witherspoon et al. 1980, Brown 1987,
Zimmerman & Bodvarsson 1996): docs/export.md. Viscosity and cell size cancel.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.joint.attributes import ATTRIBUTES as OF_HISTORY
from jointclosure.joint.cycling import Step
from jointclosure.joint.snapshots import fields_of
from jointclosure.solvers.joint import Joint

DIRECTIONS = ("x", "y")
SIDES = ("closed", "periodic")
"""Conditions at the two sides along the flow: nothing passes them ("closed"), or what leaves at one
side enters at the other ("periodic")."""
FLOWS, BLOCKED, NOT_SOLVED, AT_LEAST = range(4)
STATUSES = ("flows", "blocked", "not_solved", "at_least")
"""Statuses of a flow: it is solved; inlet and outlet are not connected; it could not be solved; or
faces that count as closed (`CLOSED`) may pass more than was computed."""

CLOSED = 1e-14
"""Conductance of a face over the sum of its cell's conductances, up to which it counts as closed,
because the mass balance of the cell would be lost in rounding. The aperture at such a face is about
2e-5 of the apertures beside it. If closed faces may matter, the status is `AT_LEAST`."""
LARGEST_IMBALANCE = 1e-6
"""Largest sum of the cells' mass balances over the inflow for which a flow counts as solved."""


class Flow(NamedTuple):
    """Flow through a joint along one direction, for a pressure difference of 1."""

    hydraulic_aperture: float  # in the unit of the apertures: 0 if blocked, NaN if not solved
    status: int  # index of `STATUSES`; for `AT_LEAST` the aperture is a lower bound
    imbalance: float  # sum of the cells' mass balances over the inflow
    pressure: np.ndarray  # (y, x): 1 at the inlet, 0 at the outlet; NaN where not connected


class _Network(NamedTuple):
    """Network of the flow: conductances (faces,) of faces between nodes ``first`` and ``second``.

    The nodes (n,) are the cells of a grid of ``shape`` (rows, columns) in C order, then the inlet
    and the outlet. ``first`` and ``second`` (faces,) are the two nodes that each face connects.
    """

    first: np.ndarray
    second: np.ndarray
    conductance: np.ndarray
    shape: tuple[int, int]

    @property
    def nodes(self) -> int:
        return self.shape[0] * self.shape[1] + 2

    def part(self, faces: np.ndarray) -> "_Network":
        """Return the network with the faces of a mask (faces,) only, and with all nodes."""
        nodes = self.first[faces], self.second[faces]
        return _Network(*nodes, self.conductance[faces], self.shape)

    def matrix(self) -> scipy.sparse.csr_array:
        """Return the symmetric sparse matrix (n, n) of the conductances between nodes."""
        one = [self.first, self.second]
        other = [self.second, self.first]
        at = np.concatenate(one), np.concatenate(other)
        return scipy.sparse.csr_array((np.tile(self.conductance, 2), at), (self.nodes,) * 2)

    def groups(self) -> np.ndarray:
        """Return for each node (n,) of the network the number of its group of connected nodes."""
        return scipy.sparse.csgraph.connected_components(self.matrix(), directed=False)[1]

    def sums(self) -> np.ndarray:
        """Return for each node (n,) of the network the sum of the conductances of its faces."""
        one, other = (
            np.bincount(ends, self.conductance, self.nodes) for ends in (self.first, self.second)
        )
        return one + other


def flow_along(aperture: np.ndarray, direction: str, sides: str = "closed") -> Flow:
    """Compute the flow from one side of a joint to the opposite one by finite volumes.

    ``aperture`` (y, x) is h, in any unit, at least 0. ``direction`` is that of the flow, and
    ``sides`` the condition at the sides along it. Faces between cells have the harmonic mean of
    their cells' h^3, faces at inlet and outlet the resistance of half a cell. This is exact if
    apertures vary only along the flow, or only across it. Raise `InputError` unless the
    ``direction`` is in `DIRECTIONS` and the ``sides`` are in `SIDES`.
    """
    for name, value, allowed in (("direction", direction, DIRECTIONS), ("sides", sides, SIDES)):
        if value not in allowed:
            raise InputError(f"{name} = {value!r} must be one of {', '.join(allowed)}")
    field = aperture if direction == "x" else aperture.T
    largest = float(field.max())
    nowhere = np.full(aperture.shape, np.nan)
    if not largest > 0.0:
        return Flow(0.0, BLOCKED, 0.0, nowhere)
    whole, is_open = _network((field / largest) ** 3, sides)
    network = whole.part(is_open)
    left_out = whole.part(~is_open)
    joined = _joined(network)
    if joined is None:
        return Flow(0.0, BLOCKED if _joined(whole) is None else AT_LEAST, 0.0, nowhere)
    try:
        pressures = _pressures(network, joined)
    except RuntimeError:  # from SuperLU, if rounding leaves a pivot of 0
        return Flow(np.nan, NOT_SOLVED, np.inf, nowhere)
    outflow, imbalance = _balance(network, pressures)
    if not imbalance <= LARGEST_IMBALANCE:
        return Flow(np.nan, NOT_SOLVED, imbalance, nowhere)
    rows, columns = field.shape
    shown = np.where(joined, pressures[0], np.nan)[:-2].reshape(field.shape)
    hydraulic = largest * float(np.cbrt(outflow * columns / rows))
    added = _left_out_flow(network, left_out, joined, pressures[0])
    status = AT_LEAST if added > LARGEST_IMBALANCE * outflow else FLOWS
    return Flow(hydraulic, status, imbalance, shown if direction == "x" else shown.T)


def largest_hydraulic(aperture: np.ndarray, direction: str) -> float:
    """Return an upper bound of the hydraulic aperture of apertures (y, x), in their unit.

    It is the hydraulic aperture that the joint would have if the pressure were equal along every
    line of cells across the flow. It is 0 if such a line is closed.
    """
    across = np.mean(aperture**3, axis=0 if direction == "x" else 1)
    return float(np.cbrt(1.0 / np.mean(1.0 / across))) if across.all() else 0.0


def _network(transmissivity: np.ndarray, sides: str) -> tuple[_Network, np.ndarray]:
    """Return the network of all faces that conduct, and a mask of those that are open (`CLOSED`).

    ``transmissivity`` (rows, columns) is h^3 over its largest value. The flow is from the first
    column to the last one.
    """
    rows, columns = transmissivity.shape
    cells = np.arange(rows * columns).reshape(rows, columns)
    inlet = cells.size
    outlet = cells.size + 1
    joined_rows = slice(-1, None) if sides == "periodic" and rows > 1 else slice(0)
    first = np.concatenate([cells[:, :-1].ravel(), cells[:-1].ravel(), cells[joined_rows].ravel()])
    across = cells[: cells[joined_rows].shape[0]]
    second = np.concatenate([cells[:, 1:].ravel(), cells[1:].ravel(), across.ravel()])
    through = transmissivity.ravel()
    one = through[first]
    other = through[second]
    both = one + other
    inner = np.divide(2.0 * one * other, both, out=np.zeros(both.shape), where=both > 0.0)
    first = np.concatenate([first, cells[:, 0], cells[:, -1]])
    second = np.concatenate([second, np.full(rows, inlet), np.full(rows, outlet)])
    conductance = np.concatenate([inner, 2.0 * through[cells[:, 0]], 2.0 * through[cells[:, -1]]])
    network = _Network(first, second, conductance, (rows, columns))
    total = network.sums()
    total[-2:] = 0.0  # inlet and outlet are not cells
    is_open = conductance > CLOSED * np.maximum(total[first], total[second])
    conducts = conductance > 0.0
    return network.part(conducts), is_open[conducts]


def _left_out_flow(network: _Network, left_out: _Network, joined, pressure) -> float:
    """Return an upper bound of the flow through closed faces, for a pressure difference of 1.

    ``network`` has the open faces, ``left_out`` the closed ones. ``joined`` (n,) is a mask of the
    nodes that open faces connect to inlet and outlet, with the pressures ``pressure`` (n,).
    """
    first, second, conductance, _ = left_out
    nodes = left_out.nodes
    if not first.size:
        return 0.0
    group = network.groups()
    # a group that is not joined has the mean of the pressures beside it: a dead end adds nothing
    weight = np.zeros(nodes)
    total = np.zeros(nodes)
    for inside, outside in ((first, second), (second, first)):
        at = joined[outside] & ~joined[inside]
        beside = group[inside[at]]
        through = conductance[at]
        weight += np.bincount(beside, through, nodes)
        total += np.bincount(beside, through * pressure[outside[at]], nodes)
    level = np.divide(total, weight, out=np.full(nodes, 0.5), where=weight > 0.0)
    field = np.where(joined, pressure, level[group])
    return float(np.sum(conductance * (field[first] - field[second]) ** 2))


def _joined(network: _Network) -> np.ndarray | None:
    """Return a mask (n,) of the nodes connected to inlet and outlet; None if there are none.

    Inlet and outlet are then not connected to each other.
    """
    label = network.groups()
    return label == label[-1] if label[-1] == label[-2] else None


def _pressures(network: _Network, joined: np.ndarray) -> np.ndarray:
    """Return the pressures of all nodes (2, n), by elimination of every second cell.

    The first row is from 1 at the inlet to 0 at the outlet, the second row from 0 to 1. Nodes that
    are not ``joined`` have 0. Raise `RuntimeError` if rounding leaves no solution.
    """
    black = _black(network, joined)
    white = joined & ~black
    white[-2:] = False
    matrix = network.matrix()
    diagonal = network.sums()
    coupling, among_white = (matrix[white][:, cells] for cells in (black, white))
    sides = network.nodes - 2, network.nodes - 1
    loads = matrix[:, sides].toarray().T
    # symmetric and diagonally dominant: pivoting is not needed; narrow panels suit small supernodes
    share = coupling / diagonal[black]
    reduced = scipy.sparse.diags_array(diagonal[white]) - among_white - share @ coupling.T
    ordering = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "panel_size": 2}
    factors = scipy.sparse.linalg.splu(reduced.tocsc(), **ordering, options={"SymmetricMode": True})
    pressures = np.zeros((2, network.nodes))
    for pressure, load, side in zip(pressures, loads, sides, strict=True):
        pressure[white] = factors.solve(load[white] + share @ load[black])
        pressure[black] = (load[black] + coupling.T @ pressure[white]) / diagonal[black]
        pressure[side] = 1.0
    return pressures


def _black(network: _Network, joined: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of the joined cells of one colour of a chessboard.

    No two of them have a common face. If the number of rows is odd, the last row has none, because
    with periodic sides it would have a common face with the first row.
    """
    rows, columns = network.shape
    odd = (np.add.outer(np.arange(rows), np.arange(columns)) % 2).astype(bool)
    odd ^= odd.flat[np.argmax(joined[:-2])]
    odd[rows - rows % 2 :] = False  # in an odd number of joined rows, the last one meets the first
    return np.append(odd, [False, False]) & joined


def _balance(network: _Network, pressures: np.ndarray) -> tuple[float, float]:
    """Return the outflow, and the sum of all mass imbalances over the outflow.

    The imbalances are those of all cells, and the difference of inflow and outflow. ``pressures``
    (2, n) are those of `_pressures`. The flow through a face is computed from the row of pressures
    that is smaller there, whose rounding is less. The second value is infinite without outflow.
    """
    first, second, conductance, _ = network
    nodes = network.nodes
    fall, rise = pressures[:, second] - pressures[:, first]
    near_outlet = pressures[0][first] < 0.5
    flux = conductance * np.where(near_outlet, fall, -rise)
    gain = np.bincount(first, flux, nodes) - np.bincount(second, flux, nodes)
    outflow = float(gain[-1])
    gain[-2:] = 0.0, float(gain[-2] + outflow)
    return outflow, float(np.abs(gain).sum()) / outflow if outflow > 0.0 else np.inf


ATTRIBUTES: dict[str, dict[str, Any]] = OF_HISTORY | {
    "flow_status": {
        "long_name": "status of the flow",
        "flag_values": np.arange(len(STATUSES), dtype=np.int8),
        "flag_meanings": " ".join(STATUSES),
    }
}
_ABOUT = {"long_name": "direction of the flow"}
COORDINATE = {"direction": ("direction", np.array(DIRECTIONS, dtype=object), _ABOUT)}


class FlowAlongHistory:
    """`Observer` of a history that computes the flow along x and along y at every step.

    Steps at one closure of unchanged walls have one flow, which is computed once.
    """

    def __init__(self) -> None:
        self._flows: list[dict[str, list[float]]] = []
        self._walls: tuple[np.ndarray, ...] = ()
        self._of_walls: dict[float, dict[str, list[float]]] = {}

    def __call__(self, joint: Joint, step: Step) -> None:
        """Compute and keep the flow at a step, from the apertures of the joint in that state."""
        walls = joint.upper, joint.lower
        if not (self._walls and all(map(np.array_equal, walls, self._walls))):
            self._walls = joint.upper.copy(), joint.lower.copy()
            self._of_walls.clear()
        closure = step.settled.closure
        if closure not in self._of_walls:
            aperture = np.maximum(-fields_of(joint, closure)[0], 0.0)
            self._of_walls[closure] = _variables_of(aperture)
        self._flows.append(self._of_walls[closure])

    def added_to(self, closed: xr.Dataset) -> xr.Dataset:
        """Return a history with the flow at its steps, along ``step`` and ``direction``."""
        added: dict[str, Any] = {}
        for name in self._flows[0]:
            kind = np.int8 if name == "flow_status" else np.float64
            values = np.array([of_step[name] for of_step in self._flows], dtype=kind)
            added[name] = ("step", "direction"), values, ATTRIBUTES[name]
        return closed.assign(added).assign_coords(COORDINATE)


def _variables_of(aperture: np.ndarray) -> dict[str, list[float]]:
    """Return the variables of the flow through apertures (y, x) [m], by name (directions,).

    The hydraulic aperture is NaN unless the flow is solved or blocked.
    """
    flows = [flow_along(aperture, direction) for direction in DIRECTIONS]
    apertures = [flow.hydraulic_aperture for flow in flows]
    solved = [flow.status in (FLOWS, BLOCKED) for flow in flows]
    return {
        "hydraulic_aperture": np.where(solved, apertures, np.nan).tolist(),
        "flow_status": [flow.status for flow in flows],
        "flow_imbalance": [flow.imbalance for flow in flows],
        "smallest_hydraulic": np.nan_to_num(apertures).tolist(),
        "largest_hydraulic": [largest_hydraulic(aperture, direction) for direction in DIRECTIONS],
    }

"""Hydraulic aperture of a field of apertures, by Reynolds' equation.

div(h^3/(12 mu) grad p) = 0 with the cubic law in every cell (Witherspoon et al. 1980, Brown 1987,
Zimmerman & Bodvarsson 1996): docs/flow.md. Viscosity and cell size cancel.
"""

from typing import NamedTuple

import numpy as np
import scipy

DIRECTIONS = ("x", "y")
FLOWS, BLOCKED, NOT_SOLVED, AT_LEAST = range(4)
STATUSES = {
    FLOWS: "flows",
    BLOCKED: "blocked",
    NOT_SOLVED: "not_solved",
    AT_LEAST: "at_least",
}
"""Of a flow: it is found; no open cells join inlet and outlet; it was not found; faces that are
`CLOSED` may pass a part of it that counts, so that what is found is a lower bound."""

CLOSED = 1e-14
"""A face passes nothing whose conductance is less than this part of all those of one of its cells:
beyond it a cell's balance cannot be told from rounding. That is an aperture below some 2e-5 of its
neighbours', as nanometres beside tenths of a millimetre. `AT_LEAST` says where that may count."""
LARGEST_IMBALANCE = 1e-6
"""Of the cells' mass balances over the inflow, beyond which a flow counts as not solved."""


class Flow(NamedTuple):
    """Flow along one direction.

    ``hydraulic_aperture`` [as the apertures]: that of parallel plates which pass as much; 0 where
    blocked, NaN where not solved, a lower bound where `AT_LEAST`. ``status``: of `STATUSES`.
    ``imbalance``: sum of what cells gain or lose, over the inflow. ``pressure`` (y, x): 1 at the
    inlet's side, 0 at the outlet's, NaN in cells that no flow reaches.
    """

    hydraulic_aperture: float
    status: int
    imbalance: float
    pressure: np.ndarray


class _Network(NamedTuple):
    """Conductances between nodes: the cells in C order, the inlet, and the outlet last.

    ``first`` and ``second`` (n,) are the nodes of each face. ``left_out`` has those that count as
    closed and are not quite.
    """

    first: np.ndarray
    second: np.ndarray
    conductance: np.ndarray
    nodes: int
    left_out: "_Network | None" = None


def flow_along(aperture: np.ndarray, direction: str) -> Flow:
    """Flow through a joint from one side to the opposite one, no flow through the others.

    Parameters
    ----------
    aperture : array (y, x)
        Distance of the walls, 0 where they touch; not negative. Cells are square.
    direction : {"x", "y"}

    Returns
    -------
    Flow

    Notes
    -----
    Finite volumes: a cell has one aperture, faces have the harmonic mean of their cells' h^3, and
    outer faces half a cell's resistance. Exact where apertures vary along the flow only, or across
    it only. The sparse system is solved directly.
    """
    field = aperture if direction == "x" else aperture.T
    largest = float(field.max())
    nowhere = np.full(aperture.shape, np.nan)
    network = _network((field / largest) ** 3) if largest > 0.0 else None
    joined = _joined(network) if network is not None else None
    if network is None:
        return Flow(0.0, BLOCKED, 0.0, nowhere)
    if joined is None:
        status = BLOCKED if _joined(_whole(network)) is None else AT_LEAST
        return Flow(0.0, status, 0.0, nowhere)
    try:
        pressures = _pressures(network, joined)
    except RuntimeError:  # of SuperLU, where rounding leaves a pivot of 0
        return Flow(np.nan, NOT_SOLVED, np.inf, nowhere)
    outflow, imbalance = _balance(network, pressures)
    if not imbalance <= LARGEST_IMBALANCE:
        return Flow(np.nan, NOT_SOLVED, imbalance, nowhere)
    rows, columns = field.shape
    shown = np.where(joined, pressures[0], np.nan)[:-2].reshape(field.shape)
    hydraulic = largest * float(np.cbrt(outflow * columns / rows))
    counts = _left_out_flow(network, joined, pressures[0]) > LARGEST_IMBALANCE * outflow
    status = AT_LEAST if counts else FLOWS
    return Flow(hydraulic, status, imbalance, shown if direction == "x" else shown.T)


def _network(transmissivity: np.ndarray) -> _Network:
    """Faces between cells (y, x) and to both sides along x; those that are `CLOSED` left out."""
    rows, columns = transmissivity.shape
    cells = np.arange(rows * columns).reshape(rows, columns)
    inlet, outlet = cells.size, cells.size + 1
    first = np.concatenate([cells[:, :-1].ravel(), cells[:-1].ravel()])
    second = np.concatenate([cells[:, 1:].ravel(), cells[1:].ravel()])
    through = transmissivity.ravel()
    one, other = through[first], through[second]
    both = one + other
    inner = np.divide(2.0 * one * other, both, out=np.zeros(both.shape), where=both > 0.0)
    first = np.concatenate([first, cells[:, 0], cells[:, -1]])
    second = np.concatenate([second, np.full(rows, inlet), np.full(rows, outlet)])
    conductance = np.concatenate([inner, 2.0 * through[cells[:, 0]], 2.0 * through[cells[:, -1]]])
    # what a cell has in all, the inlet and the outlet not: they are no cells
    nodes = cells.size + 2
    total = np.bincount(first, conductance, nodes) + np.bincount(second, conductance, nodes)
    total[-2:] = 0.0
    is_open = conductance > CLOSED * np.maximum(total[first], total[second])
    nearly = ~is_open & (conductance > 0.0)
    left_out = _Network(first[nearly], second[nearly], conductance[nearly], nodes)
    return _Network(first[is_open], second[is_open], conductance[is_open], nodes, left_out)


def _whole(network: _Network) -> _Network:
    """A network with the faces that were left out of it."""
    parts = zip(network[:3], network.left_out[:3], strict=True)
    return _Network(*(np.concatenate(pair) for pair in parts), network.nodes)


def _left_out_flow(network: _Network, joined: np.ndarray, pressure: np.ndarray) -> float:
    """Upper bound of the flow that faces left out would add, at a pressure fall of 1.

    By Dirichlet's principle: the flow is at most what any field of pressures dissipates. The field
    is the solved one, and one value in each group of cells that open faces join to neither side.
    """
    first, second, conductance, nodes, _ = network.left_out
    if not first.size:
        return 0.0
    group = _groups(network)
    # of each such group the mean of the pressures next to it, so that a dead end adds nothing
    weight, total = np.zeros(nodes), np.zeros(nodes)
    for inside, outside in ((first, second), (second, first)):
        at = joined[outside] & ~joined[inside]
        beside, through = group[inside[at]], conductance[at]
        weight += np.bincount(beside, through, nodes)
        total += np.bincount(beside, through * pressure[outside[at]], nodes)
    level = np.divide(total, weight, out=np.full(nodes, 0.5), where=weight > 0.0)
    field = np.where(joined, pressure, level[group])
    return float(np.sum(conductance * (field[first] - field[second]) ** 2))


def _joined(network: _Network) -> np.ndarray | None:
    """Nodes (n,) that are joined to inlet and outlet; None where these are not."""
    label = _groups(network)
    return label == label[-1] if label[-1] == label[-2] else None


def _groups(network: _Network) -> np.ndarray:
    """Number (n,) of the group of nodes that each node is joined to."""
    links = (network.conductance, (network.first, network.second))
    graph = scipy.sparse.coo_array(links, shape=(network.nodes, network.nodes))
    return scipy.sparse.csgraph.connected_components(graph, directed=False)[1]


def _pressures(network: _Network, joined: np.ndarray) -> np.ndarray:
    """Pressures of all nodes (2, n): from 1 at the inlet to 0 at the outlet, and from 0 to 1.

    Either has its digits where it is small. 0 in nodes not joined.
    """
    unknown = joined.copy()
    unknown[-2:] = False
    number = np.cumsum(unknown) - 1
    first, second, conductance, nodes, _ = network
    diagonal = np.bincount(first, conductance, nodes) + np.bincount(second, conductance, nodes)
    inner = unknown[first] & unknown[second]
    row, column = number[first[inner]], number[second[inner]]
    beside, own = -conductance[inner], number[unknown]
    matrix = scipy.sparse.csc_array(
        (
            np.concatenate([beside, beside, diagonal[unknown]]),
            (np.concatenate([row, column, own]), np.concatenate([column, row, own])),
        ),
        shape=(own.size, own.size),
    )
    # symmetric, diagonally dominant: no pivoting is needed
    factors = scipy.sparse.linalg.splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    pressures = np.zeros((2, nodes))
    for pressure, side in zip(pressures, (nodes - 2, nodes - 1), strict=True):
        here = second == side
        load = np.bincount(first[here], conductance[here], nodes)
        pressure[unknown] = factors.solve(load[unknown])
        pressure[side] = 1.0
    return pressures


def _balance(network: _Network, pressures: np.ndarray) -> tuple[float, float]:
    """Outflow, and the sum of all cells' imbalances over it; by faces, whatever was solved."""
    first, second, conductance, nodes, _ = network
    fall, rise = pressures[:, second] - pressures[:, first]
    near_outlet = pressures[0][first] < 0.5
    flux = conductance * np.where(near_outlet, fall, -rise)
    gain = np.bincount(first, flux, nodes) - np.bincount(second, flux, nodes)
    outflow = float(gain[-1])
    gain[-2:] = 0.0, float(gain[-2] + outflow)
    return outflow, float(np.abs(gain).sum()) / outflow if outflow > 0.0 else np.inf

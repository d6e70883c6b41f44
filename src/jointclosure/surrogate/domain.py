"""Tested errors of the bearing-area law at other spacings, sizes and JRC than its constants'.

``benchmarks/surrogate_domain.py`` closes joints at nodes of spacing, cells a side and JRC, and
makes the table that is read here. An estimate between nodes has the largest error of those around.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.config.files import SURROGATE_DOMAIN

AXES = ("spacing", "cells", "rms_slope")
"""Quantities along which nodes lie around a joint."""
MEASURES = ("height_over_slope", "slope_ratio", "correlation")
"""Measures of walls that must lie within the bounds of the nodes around."""
_SAME = 1e-6
"""Largest relative difference of equal values."""


class Node(NamedTuple):
    """Tested joints of one spacing, number of cells a side and JRC.

    ``place`` is that along `AXES`, and ``bounds`` the smallest and largest value of each of
    `MEASURES` and of the slope. ``errors`` are rms errors at logarithms of stress over strength.
    """

    roll_off: float | None
    place: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    logs: np.ndarray
    errors: np.ndarray


class Outside(NamedTuple):
    """Quantity that lies outside of the tested range."""

    name: str
    value: float
    least: float
    most: float


def nodes_around(
    given: Mapping[str, tuple[float, float]], roll_off: float | None
) -> list[Node] | Outside:
    """Return the nodes around a joint for walls of one kind, or the quantity that lies outside.

    Parameters
    ----------
    given : mapping
        Smallest and largest value of each of `AXES` and `MEASURES` (SI).
    roll_off : float or None
        Roll-off of the walls [m]; None for waves of all lengths.
    """
    nodes = [node for node in _nodes() if node.roll_off == roll_off]
    for name in AXES:
        low, high = given[name]
        if name == "rms_slope":
            least, most = _bounds(nodes, name)
        else:
            least, most = (end(node.place[name] for node in nodes) for end in (min, max))
        if low < least * (1.0 - _SAME) or high > most * (1.0 + _SAME):
            return Outside(name, low if low < least else high, least, most)
        levels = _around(sorted({_group(node, name) for node in nodes}), name, nodes, low, high)
        nodes = [node for node in nodes if _group(node, name) in levels]
    for name in MEASURES:
        (low, high), (least, most) = given[name], _bounds(nodes, name)
        if low < least or high > most:
            return Outside(name, low if low < least else high, least, most)
    return nodes


def _group(node: Node, name: str) -> float:
    """Return the level of a node along an axis; those of the slope are levels of JRC."""
    return node.place["jrc" if name == "rms_slope" else name]


def _around(
    levels: Sequence[float], name: str, nodes: Sequence[Node], low: float, high: float
) -> set[float]:
    """Return the levels between which the values lie, with the nearest ones at both sides."""
    places = np.array(
        [np.mean([node.place[name] for node in nodes if _group(node, name) == at]) for at in levels]
    )
    first = max(int(np.searchsorted(places, low * (1.0 + _SAME), "right")) - 1, 0)
    last = min(int(np.searchsorted(places, high * (1.0 - _SAME))), len(places) - 1)
    return set(levels[first : last + 1])


def _bounds(nodes: Sequence[Node], name: str) -> tuple[float, float]:
    ends = np.array([node.bounds[name] for node in nodes])
    return float(ends[:, 0].min()), float(ends[:, 1].max())


def errors_at(nodes: Sequence[Node], ratio: np.ndarray) -> np.ndarray:
    """Return the largest rms error of the nodes, linear in the logarithm of stress over strength.

    Stresses must be within `stresses_of` the nodes.
    """
    return np.max([np.interp(np.log(ratio), node.logs, node.errors) for node in nodes], axis=0)


def stresses_of(nodes: Sequence[Node]) -> tuple[float, float]:
    """Return the smallest and largest stress over strength at which all nodes are tested."""
    least, most = max(node.logs[0] for node in nodes), min(node.logs[-1] for node in nodes)
    return float(np.exp(least)), float(np.exp(most))


@lru_cache(maxsize=1)
def _nodes() -> tuple[Node, ...]:
    """Return all tested nodes."""
    table = pd.read_csv(SURROGATE_DOMAIN)
    keys = ["roll_off_mm", "spacing_m", "cells", "jrc"]
    nodes = []
    for (roll_off, spacing, cells, jrc), part in table.groupby(keys, dropna=False):
        row = part.sort_values("stress_over_strength")
        bounds = {
            name: (float(row[f"least_{name}"].iloc[0]), float(row[f"most_{name}"].iloc[0]))
            for name in ("rms_slope", *MEASURES)
        }
        place = {"spacing": spacing, "cells": float(cells), "jrc": jrc}
        place["rms_slope"] = float(np.sqrt(np.prod(bounds["rms_slope"])))
        errors = 0.01 * row.rms_percent.to_numpy()
        length = None if pd.isna(roll_off) else 1e-3 * roll_off
        logs = np.log(row.stress_over_strength.to_numpy())
        nodes.append(Node(length, place, bounds, logs, errors))
    return tuple(nodes)

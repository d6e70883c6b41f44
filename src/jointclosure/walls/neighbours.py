"""Neighbouring points of a scan: pairs of them, and the parts that pairs connect."""

import numpy as np
import scipy

from jointclosure.walls.gridding import Cloud, Scan


def neighbour_pairs(scan: Scan | Cloud) -> np.ndarray:
    """Return pairs (m, 2) of neighbours: along the axes of a grid, or the four nearest points.

    Points are numbered as `jointclosure.walls.gridding.points_of` lists the points with a height.
    """
    if isinstance(scan, Cloud):
        places = scan.points[:, :2]
        near = scipy.spatial.cKDTree(places).query(places, k=min(5, len(places)))[1]
        return np.column_stack([np.repeat(near[:, 0], near.shape[1] - 1), near[:, 1:].ravel()])
    known = np.isfinite(scan.heights)
    number = np.where(known, np.cumsum(known).reshape(known.shape) - 1, -1)
    beside = [(number[1:], number[:-1]), (number[:, 1:], number[:, :-1])]
    pairs = np.concatenate([np.column_stack([one.ravel(), other.ravel()]) for one, other in beside])
    return pairs[(pairs >= 0).all(axis=1)]


def connected_parts(pairs: np.ndarray, count: int) -> np.ndarray:
    """Return the number (count,) of the part to which each item belongs, given pairs (m, 2).

    Items are numbered from 0, and belong to one part if pairs lead from one to the other.
    """
    one, other = pairs.T
    links = scipy.sparse.coo_array((np.ones(len(pairs), bool), (one, other)), shape=(count, count))
    return scipy.sparse.csgraph.connected_components(links, directed=False)[1]

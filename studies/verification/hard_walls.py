"""Walls that are difficult for a solver, by name: pairs (upper, lower) of heights [m]."""

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls.synthesis import wall_pair


def _flat(shape, height):
    return np.zeros(shape), np.zeros(shape)


def _spike(shape, height):
    upper = np.zeros(shape)
    upper[shape[0] // 2, shape[1] // 2] = height
    return upper, np.zeros(shape)


def _tie(shape, height):
    """Return multiples of a height: equal sums everywhere, and equal neighbours."""
    random = np.random.default_rng(7)
    return tuple(height * random.integers(0, 4, shape).astype(float) for _ in range(2))


def _saddles(shape, height):
    """Return two crossed saddles: one curves up where the other curves down."""
    y, x = _unit_coordinates(shape)
    saddle = height * (x**2 - y**2)
    return saddle, saddle.T.copy() if shape[0] == shape[1] else saddle.copy()


def _valleys(shape, height):
    """Return two bowls, concave everywhere, that touch at their corners."""
    y, x = _unit_coordinates(shape)
    return height * (x**2 + y**2), height * (x**2 + y**2)


def _egg_box(shape, height):
    """Return walls where every second cell is a peak and the others valleys, in phase."""
    y, x = np.indices(shape)
    box = height * np.where((y + x) % 2 == 0, 1.0, -1.0)
    return box, box.copy()


def _ridges(shape, height):
    """Return ridges of one cell along y above and along x below, which cross in single cells."""
    y, x = np.indices(shape)
    return height * (x % 3 == 1), height * (y % 3 == 1)


def _parallel_ridges(shape, height):
    """Return opposite one-cell ridges along y on both walls, without curvature along them."""
    _, x = np.indices(shape)
    ridges = height * (x % 4 == 1)
    return ridges, ridges.copy()


def _plateau(shape, height):
    """Return a level table in the middle: flat contacts inside, edges around."""
    upper = np.zeros(shape)
    upper[tuple(slice(n // 4, n - n // 4) for n in shape)] = height
    return upper, np.zeros(shape)


def _unit_coordinates(shape):
    return np.meshgrid(*(np.linspace(-1.0, 1.0, n) for n in shape), indexing="ij")


SHAPES = {
    "flat": _flat,
    "spike": _spike,
    "tie": _tie,
    "saddles": _saddles,
    "valleys": _valleys,
    "egg_box": _egg_box,
    "ridges": _ridges,
    "parallel_ridges": _parallel_ridges,
    "plateau": _plateau,
}


def hard_walls(
    kind: str, cells: tuple[int, int], spacing: float, height: float, jrc: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return upper and lower wall (ny, nx), heights towards the other wall [m].

    Parameters
    ----------
    kind : str
        A key of `SHAPES`; or "self_affine" for independent walls of a JRC, "mated" for
        such a wall and its exact counterpart, which touch everywhere at once.
    cells : (ny, nx)
    spacing : float
        [m].
    height : float
        Scale of the kinds of `SHAPES` [m].
    jrc, seed
        JRC and seed of the random kinds.
    """
    rows, columns = cells
    shape = (rows, columns)
    if kind == "self_affine":
        return wall_pair(jrc, shape, spacing, seed=seed, roll_off=None)
    if kind == "mated":
        upper, _ = wall_pair(jrc, shape, spacing, seed=seed, roll_off=None)
        return upper, -upper
    if kind not in SHAPES:
        raise InputError(f"walls.kind = {kind!r}: must be one of {', '.join(SHAPES)}")
    return SHAPES[kind](shape, height)

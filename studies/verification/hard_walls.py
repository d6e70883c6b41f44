"""Walls that are difficult for a solver."""

from collections.abc import Callable

import numpy as np

from jointclosure.inputs import InputError, did_you_mean
from jointclosure.walls.synthesis import wall_pair


def shapes(shape: tuple[int, int], height: float) -> dict[str, Callable[[], tuple]]:
    """Return functions by kind of walls that make upper and lower wall (ny, nx) of a height [m]."""
    y, x = np.indices(shape)
    v, u = np.meshgrid(*(np.linspace(-1.0, 1.0, n) for n in shape), indexing="ij")
    tie = np.random.default_rng(7)

    def raised(cells: tuple) -> tuple[np.ndarray, np.ndarray]:
        upper = np.zeros(shape)
        upper[cells] = height
        return upper, np.zeros(shape)

    def saddles() -> tuple[np.ndarray, np.ndarray]:
        saddle = height * (u**2 - v**2)
        return saddle, saddle.T.copy() if shape[0] == shape[1] else saddle.copy()

    return {
        "flat": lambda: (np.zeros(shape), np.zeros(shape)),
        "spike": lambda: raised((shape[0] // 2, shape[1] // 2)),
        # equal sums everywhere, and equal neighbours
        "tie": lambda: tuple(height * tie.integers(0, 4, shape).astype(float) for _ in range(2)),
        # crossed: one curves up where the other curves down
        "saddles": saddles,
        # concave everywhere, in touch at the corners
        "valleys": lambda: (height * (u**2 + v**2), height * (u**2 + v**2)),
        # every second cell a peak and the others valleys, in phase
        "egg_box": lambda: (height * np.where((y + x) % 2 == 0, 1.0, -1.0),) * 2,
        # one cell wide, along y above and along x below: they touch in single cells
        "ridges": lambda: (height * (x % 3 == 1), height * (y % 3 == 1)),
        # one cell wide, without curvature along them
        "parallel_ridges": lambda: (height * (x % 4 == 1),) * 2,
        # a level table: flat contacts inside, edges around
        "plateau": lambda: raised(tuple(slice(n // 4, n - n // 4) for n in shape)),
    }


SHAPES = tuple(shapes((4, 4), 1.0))
"""Kinds of walls that `shapes` makes."""


def hard_walls(
    kind: str, cells: tuple[int, int], spacing: float, height: float, jrc: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return upper and lower wall (ny, nx), heights towards the other wall [m].

    Raises
    ------
    InputError
        If the kind does not exist.
    """
    shape = cells[0], cells[1]
    if kind == "self_affine":
        return wall_pair(jrc, shape, spacing, seed=seed, roll_off=None)
    if kind == "mated":
        upper, _ = wall_pair(jrc, shape, spacing, seed=seed, roll_off=None)
        return upper, -upper
    if kind not in SHAPES:
        known = ", ".join(SHAPES)
        meant = did_you_mean(kind, SHAPES)
        raise InputError(f"walls.kind = {kind!r}: must be one of {known}{meant}")
    return shapes(shape, height)[kind]()

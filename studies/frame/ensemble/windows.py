"""Joints of a study cut from scanned walls: windows of a scan, and the partner of a single wall."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.measured import FLAT
from jointclosure.walls.roughness import detrended
from jointclosure.walls.synthesis import synthetic_wall

PARTNERS = ("rotated", "mirrored", "synthetic", FLAT)
"""Partners of a single scanned wall: the wall itself, turned by 180 degrees in its plane or
mirrored in x, an independent synthetic wall with its slope and Hurst exponent, or a flat wall."""


class MeasuredWalls(NamedTuple):
    """Walls of a rock on the joint's grid, in their full scanned size.

    ``measured`` contains heights (y, x) [m] towards the other wall, NaN where missing, of "upper",
    "lower" or both, in equal shapes. ``partner`` is one of `PARTNERS` if there is only one wall,
    otherwise "". ``z2`` and ``hurst`` are those of that wall.
    """

    measured: dict[str, np.ndarray]
    partner: str
    spacing: float
    z2: float
    hurst: float


class Placed(NamedTuple):
    """Walls (y, x) [m] of a joint, and the cell of the scan where each begins, or (-1, -1)."""

    upper: np.ndarray
    lower: np.ndarray
    upper_origin: tuple[int, int]
    lower_origin: tuple[int, int]


class Cutter:
    """Cutter of the joints of a study, of ``shape`` (ny, nx), from scanned walls.

    ``order_seed`` is the seed of the order of windows. Realisation r has the r-th window, so that
    realisations have different windows, and adding realisations does not change the others.
    ``normalise`` is that of synthetic partners (`jointclosure.walls.synthesis.synthetic_wall`).
    """

    def __init__(
        self, walls: MeasuredWalls, shape: tuple[int, int], order_seed: int, normalise: str = "wall"
    ):
        self.walls, self.shape, self.normalise = walls, shape, normalise
        heights = list(walls.measured.values())
        self.windows = windows(np.sum(heights, axis=0), shape)
        self.orders = {
            side: generator(seed_of(order_seed, "windows", side)).permutation(len(self.windows))
            for side in ("measured", "partner")
        }

    def check(self, realizations: int) -> None:
        """Raise `InputError` if there are fewer windows than realisations."""
        count = len(self.windows)
        if realizations > count and self.walls.partner != "synthetic":
            raise InputError(
                f"study.realizations = {realizations}: must be at most {count}, the number of "
                f"different joints of {self.shape[0]} x {self.shape[1]} cells that the walls "
                "contain; or use a smaller grid, or synthetic for the other wall"
            )

    def joint(self, realization: int, seed: int) -> Placed:
        """Return the walls of a realisation, each plane-detrended, from its number and seed."""
        walls, origin = self.walls, self._origin("measured", realization)
        cut = {name: self._cut(name, origin) for name in walls.measured}
        origins = dict.fromkeys(cut, origin)
        for other in {"upper", "lower"} - set(walls.measured):
            origins[other] = (-1, -1)
            if walls.partner == "synthetic":
                # the name of the stream is a former term: another would give other walls
                random = generator(seed_of(seed, "matching"))
                cut[other] = synthetic_wall(
                    walls.z2, self.shape, walls.spacing, walls.hurst, random, self.normalise
                )
            elif walls.partner == FLAT:
                cut[other] = np.zeros(self.shape)
            else:
                origins[other] = self._origin("partner", realization)
                same = self._cut(next(iter(walls.measured)), origins[other])
                turned = same[::-1, ::-1] if walls.partner == "rotated" else same[:, ::-1]
                cut[other] = np.ascontiguousarray(turned)
        return Placed(cut["upper"], cut["lower"], origins["upper"], origins["lower"])

    def _origin(self, side: str, realization: int) -> tuple[int, int]:
        order = self.orders[side]
        y, x = self.windows[order[realization % len(order)]].tolist()
        return y, x

    def _cut(self, name: str, origin: tuple[int, int]) -> np.ndarray:
        (y, x), (ny, nx) = origin, self.shape
        return detrended(self.walls.measured[name][y : y + ny, x : x + nx])


def windows(wall: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return offsets (k, 2) of all windows of a shape without missing cells, row by row.

    Raises
    ------
    InputError
        If there is none; the message states the largest size that fits.
    """
    offsets = _full_windows(wall, *shape)
    if not len(offsets):
        size = min(wall.shape)
        while size > 0 and not len(_full_windows(wall, size, size)):
            size -= 1
        raise InputError(
            f"no room for {shape[0]} x {shape[1]} cells (y, x): the wall has {wall.shape[0]} x "
            f"{wall.shape[1]} at the grid's spacing, and its largest full square is {size} x {size}"
        )
    return offsets


def _full_windows(wall: np.ndarray, ny: int, nx: int) -> np.ndarray:
    if wall.shape[0] < ny or wall.shape[1] < nx:
        return np.empty((0, 2), int)
    holes = np.zeros((wall.shape[0] + 1, wall.shape[1] + 1), int)
    holes[1:, 1:] = np.cumsum(np.cumsum(~np.isfinite(wall), axis=0), axis=1)
    inside = holes[ny:, nx:] - holes[:-ny, nx:] - holes[ny:, :-nx] + holes[:-ny, :-nx]
    return np.argwhere(inside == 0)


def disjoint(offsets: np.ndarray, shape: tuple[int, int]) -> int:
    """Count windows that fit side by side, taken in their order.

    It is a lower bound of the largest number of disjoint windows.
    """
    count = 0
    while len(offsets):
        apart = np.abs(offsets - offsets[0])
        offsets = offsets[(apart[:, 0] >= shape[0]) | (apart[:, 1] >= shape[1])]
        count += 1
    return count

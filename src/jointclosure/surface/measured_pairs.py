"""Joints of scanned walls: windows of a scan, and what a single wall is met with."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.surface.measured import windows
from jointclosure.surface.roughness import detrended
from jointclosure.surface.synthesis import synthetic_wall

PARTNERS = ("rotated", "mirrored", "synthetic")
"""What a single wall is met with: itself, turned by 180 degrees in its plane or mirrored in x,
or a wall drawn with its slope and Hurst exponent, independent of it."""

_SYNTHETIC_STREAM = "matching"
"""The former word for it, kept as the name of the random stream: another draws other walls."""


class MeasuredWalls(NamedTuple):
    """Walls of a rock on the joint's grid, as large as they were scanned.

    ``measured`` holds heights (y, x) [m] towards the other wall, NaN where missing, of "upper",
    "lower" or both, of equal shapes; ``partner`` is one of `PARTNERS` where there is one wall,
    else "". ``z2`` and ``hurst`` are those of that wall.
    """

    measured: dict[str, np.ndarray]
    partner: str
    spacing: float
    z2: float
    hurst: float


class Placed(NamedTuple):
    """A joint's walls (y, x) [m], and the cell of the scan at which each begins, or (-1, -1)."""

    upper: np.ndarray
    lower: np.ndarray
    upper_origin: tuple[int, int]
    lower_origin: tuple[int, int]


class Cutter:
    """Cuts the joints of a study out of scanned walls.

    Parameters
    ----------
    walls : MeasuredWalls
    shape : (ny, nx)
        Cells of a joint.
    order_seed : int
        Of the order in which windows are taken: realisation r has the r-th of it, so that no two
        realisations have the same, and more realisations change none that there were.
    normalise : {"wall", "expectation"}
        Of synthetic partners, see `jointclosure.surface.synthesis.synthetic_wall`.

    Raises
    ------
    InputError
        No room for the shape.
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
        """Raise `InputError` where there are fewer windows than realisations."""
        count = len(self.windows)
        if realizations > count and self.walls.partner != "synthetic":
            raise InputError(
                f"study.realizations = {realizations}: the walls have room for {count} different "
                f"joints of {self.shape[0]} x {self.shape[1]} cells; at most that many, a smaller "
                "grid, or synthetic for the other wall"
            )

    def joint(self, realization: int, seed: int) -> Placed:
        """Walls of a realisation, each plane-detrended, from its number and seed."""
        names = list(self.walls.measured)
        origin = self._origin("measured", realization)
        cut = {name: self._cut(name, origin) for name in names}
        origins = dict.fromkeys(names, origin)
        for other in {"upper", "lower"} - set(names):
            if self.walls.partner == "synthetic":
                random = generator(seed_of(seed, _SYNTHETIC_STREAM))
                cut[other] = synthetic_wall(
                    self.walls.z2, self.shape, self.walls.spacing, self.walls.hurst, random,
                    self.normalise,
                )  # fmt: skip
                origins[other] = (-1, -1)
            else:
                origins[other] = self._origin("partner", realization)
                same = self._cut(names[0], origins[other])
                turned = same[::-1, ::-1] if self.walls.partner == "rotated" else same[:, ::-1]
                cut[other] = np.ascontiguousarray(turned)
        return Placed(cut["upper"], cut["lower"], origins["upper"], origins["lower"])

    def _origin(self, side: str, realization: int) -> tuple[int, int]:
        order = self.orders[side]
        y, x = self.windows[order[realization % len(order)]].tolist()
        return y, x

    def _cut(self, name: str, origin: tuple[int, int]) -> np.ndarray:
        y, x = origin
        ny, nx = self.shape
        return detrended(self.walls.measured[name][y : y + ny, x : x + nx])

"""Joints of scanned walls: windows of a scan, and the partner of a single wall."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.measured import FLAT, windows
from jointclosure.walls.roughness import detrended
from jointclosure.walls.synthesis import synthetic_wall

PARTNERS = ("rotated", "mirrored", "synthetic", FLAT)
"""Partners of a single scanned wall: the wall itself, turned by 180 degrees in its plane or
mirrored in x, an independent synthetic wall with its slope and Hurst exponent, or a flat wall."""

_SYNTHETIC_STREAM = "matching"
"""Name of the random stream of synthetic partners: a former term, kept because another name would
give other walls."""


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
    """Cutter of the joints of a study from scanned walls.

    Parameters
    ----------
    shape : (ny, nx)
        Cells of a joint.
    order_seed : int
        Seed of the order of windows. Realisation r has the r-th window, so that realisations
        have different windows, and adding realisations does not change the others.
    normalise : {"wall", "expectation"}
        For synthetic partners, see `jointclosure.walls.synthesis.synthetic_wall`.

    Raises
    ------
    InputError
        If no window of this shape fits.
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
            elif self.walls.partner == FLAT:
                cut[other], origins[other] = np.zeros(self.shape), (-1, -1)
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

"""Options of a registration of two scanned walls, and the orientations that it compares."""

from dataclasses import dataclass

import numpy as np

from jointclosure.inputs import check_one_of

LARGEST_HOLES = 0.15  # largest share of cells in holes of a scan that a joint has by default
SHIFTS = ("scanned", "mated")  # positions of the upper wall: as it was scanned, or of best fit
SPIKES = ("keep", "cut")  # what is done with spikes of a scan

ORIENTATIONS = {
    "common_frame": "z upwards on both scans",
    "turned_over": "the wall was turned over",
    "towards": "heights towards the lower wall, plan as it lies",
    "mirrored": "z upwards, mirrored",
}
"""Orientations of the upper wall's scan, each compared over the full circle."""
_SIGNS = (1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (1.0, 1.0, -1.0), (-1.0, 1.0, 1.0)
"""Signs by which each orientation multiplies x, y and z of the upper wall's scan."""
FLIPS = dict(zip(ORIENTATIONS, map(np.diag, _SIGNS), strict=True))
"""Orientations as diagonal matrices (3, 3) of their signs, by name."""


@dataclass(frozen=True, kw_only=True)
class RegistrationOptions:
    """Options of `jointclosure.walls.registration.registered`, which describes each of them.

    Raise `InputError` if ``orientation``, ``shift`` or ``spikes`` is not one of its allowed words.
    """

    orientation: str | None = None  # a key of `ORIENTATIONS`; None: the one that fits best
    shift: str | None = None  # one of `SHIFTS`; None: the best fit, if it is clear
    spikes: str = "cut"  # one of `SPIKES`
    largest_filled_share: float = LARGEST_HOLES
    unusual_values: bool = False

    def __post_init__(self) -> None:
        if self.orientation is not None:
            check_one_of("orientation", self.orientation, tuple(ORIENTATIONS))
        if self.shift is not None:
            check_one_of("shift", self.shift, SHIFTS)
        check_one_of("spikes", self.spikes, SPIKES)

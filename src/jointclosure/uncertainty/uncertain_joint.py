"""A joint with the sources of its uncertainty, and its variants."""

from collections.abc import Mapping
from contextlib import suppress
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.execution.workers import number_of_workers
from jointclosure.inputs import InputError
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.cycling import StepReport
from jointclosure.joint.simulation import simulate_walls
from jointclosure.uncertainty.sources import Source, sources_of
from jointclosure.uncertainty.variants import Variant, variants_of
from jointclosure.walls import Walls
from jointclosure.walls.scan_errors import ScanErrors

CELLS = 2_000_000  # of all joints that are simulated at the same time; each cell takes 1 kB


class UncertainJoint(NamedTuple):
    """A joint, the sources of its uncertainty, and the variants that follow from them.

    ``upper`` and ``lower`` are its walls (y, x) [m]. ``conditions`` are as `Conditions.checked`
    returns them, with the grid spacing. ``errors`` are those of scanned walls, None for exact ones.
    ``sources`` are by name. A joint without a range has no sources and no ``variants``. ``finest``
    are the walls (y, x) [m] to which the errors refer: by default ``upper`` and ``lower``, or walls
    on a finer grid if the scans do not resolve that grid
    (`jointclosure.walls.registered_pair.FineWalls`).
    """

    upper: np.ndarray
    lower: np.ndarray
    conditions: CheckedConditions
    errors: ScanErrors | None = None
    sources: Mapping[str, Source] = {}
    variants: tuple[Variant, ...] = ()
    finest: Walls | None = None

    @property
    def cells(self) -> int:
        """Number of cells of the largest variant of the joint."""
        return max(self.upper.size, self.errors.cells if self.errors else 0)

    def simulated(self, variant: Variant, report: StepReport | None = None) -> xr.Dataset | None:
        """Simulate a variant of the joint and return its history, or None if it is refused.

        A variant is refused if its values do not fit each other, or if it is foreseen to need more
        steps than allowed. A variant that fails on its way is returned, with its status.
        """
        with suppress(InputError):
            walls = variant.walls(*(self.finest or (self.upper, self.lower)), self.errors)
            return simulate_walls(*walls, variant.conditions, report)
        return None


def uncertain_joint(
    upper: np.ndarray,
    lower: np.ndarray,
    conditions: CheckedConditions,
    ranges: Mapping[str, tuple[float, float]] = {},
    errors: ScanErrors | None = None,
    finest: Walls | None = None,
) -> UncertainJoint:
    """Return a joint with its sources of uncertainty and variants, of which none is simulated yet.

    The arguments are as for the fields of `UncertainJoint`. ``ranges`` (lowest, highest) [SI] are
    stated for names of `jointclosure.uncertainty.sources.VARIED`. Raise `InputError` if one is not
    allowed.
    """
    sources = sources_of(conditions, upper.shape, ranges, errors)
    variants = tuple(variants_of(conditions, sources))
    return UncertainJoint(upper, lower, conditions, errors, sources, variants, finest)


def threads_for(cells: int, workers: int | None = None) -> int:
    """Return how many joints of so many ``cells`` are simulated at the same time, at least 1.

    They are ``workers``, by default the number of processors, but have at most `CELLS` together.
    Raise `InputError` for fewer than one worker.
    """
    return max(1, min(number_of_workers(workers), CELLS // cells))

"""Makers of the walls of an experiment's joints, from the settings of their surfaces."""

from collections.abc import Callable, Iterator

import numpy as np

from jointclosure.ensemble.settings import SurfaceSettings
from jointclosure.ensemble.surfaces import seeds_of, walls_of
from jointclosure.surface.misalignment import rotated_pair, tilted
from jointclosure.surface.roughness import z2_of_jrc
from jointclosure.surface.synthesis import spectrum_of

Walls = tuple[np.ndarray, np.ndarray]
"""Upper and lower wall (y, x), heights towards the other [m]."""


def misaligned(settings: SurfaceSettings, tilt: float, rotation: float) -> Iterator[Walls]:
    """Walls whose upper one is tilted and whose lower one is rotated [degrees]."""
    grid, surface = settings.grid, settings.surface
    wavelength = surface.mismatch_wavelength
    for seed in seeds_of(settings):
        upper, lower = rotated_pair(
            z2_of_jrc(settings.jrc, grid.spacing, surface.hurst, surface.jrc_relation),
            grid.shape,
            grid.spacing,
            spectrum_of(surface.hurst, surface.rule, surface.roll_off, grid.spacing),
            seed,
            np.inf if wavelength is None else wavelength,
            rotation,
        )
        yield tilted(upper, grid.spacing, tilt), lower


MAKERS: dict[str, Callable[..., Iterator[Walls]]] = {
    "synthetic": walls_of,
    "misaligned": misaligned,
}
"""By name: from the settings of a block of surfaces, the walls of each of its realisations."""

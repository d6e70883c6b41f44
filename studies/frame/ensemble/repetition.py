"""Repetition of one realisation of a study, from its settings."""

import xarray as xr

from jointclosure.engine.joints import close_surfaces
from jointclosure.engine.settings import ClosureSettings
from jointclosure.engine.surfaces import surfaces_of


def repeated(
    settings: ClosureSettings, realization: int, walls: xr.Dataset | None = None
) -> xr.Dataset:
    """Close one surface pair of a case again.

    Parameters
    ----------
    settings : ClosureSettings
    realization : int
        Number of the realisation, which must be in the block of the settings.
    walls : Dataset, optional
        Surface pair (realization, y, x) of this realisation; by default it is made
        from its seed.

    Returns
    -------
    Dataset
        As from `jointclosure.engine.joints.close_surfaces`, with one realisation.
    """
    if walls is None:
        one = settings.surfaces._replace(first_realization=realization, realizations=1)
        walls = next(surfaces_of(one))
    return next(close_surfaces(walls, settings))

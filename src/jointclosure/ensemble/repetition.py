"""One realisation of a study again, from its settings."""

import xarray as xr

from jointclosure.ensemble.closing import close_surfaces
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.surfaces import surfaces_of


def repeated(
    settings: ClosureSettings, realization: int, walls: xr.Dataset | None = None
) -> xr.Dataset:
    """Close one surface pair of a case again.

    Parameters
    ----------
    settings : ClosureSettings
    realization : int
        Its number; the settings' block has it.
    walls : Dataset, optional
        The surface pair (realization, y, x), one realisation; made from its seed
        when it is not given.

    Returns
    -------
    Dataset
        As a block of `jointclosure.ensemble.closing.close_surfaces`, of one realisation.
    """
    if walls is None:
        one = settings.surfaces._replace(first_realization=realization, realizations=1)
        walls = next(surfaces_of(one))
    return next(close_surfaces(walls, settings))

"""One realisation of a study again, from its settings."""

import xarray as xr

from jointclosure.ensemble.cases import Case
from jointclosure.ensemble.closing import close_surfaces, closing_arguments
from jointclosure.ensemble.surfaces import surfaces_of


def repeated(settings: dict, realization: int, walls: xr.Dataset | None = None) -> xr.Dataset:
    """Close one surface pair of a case again.

    Parameters
    ----------
    settings : dict
        As from `jointclosure.ensemble.settings.closure_settings`.
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
        one = {"first_realization": realization, "realizations": 1}
        walls = next(surfaces_of(settings["surfaces"] | one))
    case = Case(**settings["case"])
    return next(close_surfaces(walls, case, **closing_arguments(settings)))
